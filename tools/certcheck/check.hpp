// Is this certificate a proof?
#pragma once
#include "tools/certcheck/certificate.hpp"

namespace certcheck {

/// From which mode to which.
using Moves = std::vector<std::pair<std::size_t, std::size_t>>;
/// Components of one class that can be in the same modes are a group: modes may overlap, and which one a move meets is judged for those.
struct ModeMoves {
  Rows group_of;                                   // by atom
  std::vector<std::vector<Moves>> by_port;         // by group, and port of its type
  std::vector<std::set<std::size_t>> first;        // by atom: modes that it can begin in
};
using Values = std::vector<int>;  // by atom: its places, then its slots

/// Says how much was checked; throws Rejected or NotCheckable.
[[nodiscard]] std::string check(const Model& model, const std::string& certificate);

/// Modes are closed: what a port can lead to from one is one; what an atom begins in is a reachable one (modes.cpp).
[[nodiscard]] ModeMoves check_modes(const Model& model, const Certificate& certificate);
/// Reachable modes and sets are kept by every step (structure.cpp).
void check_structure(const Model& model, const Certificate& certificate);
/// All states of a diagram (reached.cpp).
[[nodiscard]] std::set<Values> reached_states(const Model& model, const Certificate& certificate);

}  // namespace certcheck
