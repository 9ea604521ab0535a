// Is this certificate a proof?
#pragma once
#include "tools/certcheck/certificate.hpp"

namespace certcheck {

/// By class and port of its type: from which mode to which it may lead.
using Moves = std::vector<std::vector<std::vector<std::pair<std::size_t, std::size_t>>>>;

/// Says how much was checked; throws Rejected or NotCheckable.
[[nodiscard]] std::string check(const Model& model, const std::string& certificate);

/// Modes are closed: what a port can lead to from one is one (local.cpp). Throws Rejected.
[[nodiscard]] Moves check_modes(const Model& model, const Certificate& certificate);
/// Modes that an atom can begin in, each among its reachable ones; by atom.
[[nodiscard]] std::vector<std::set<std::size_t>> check_first_modes(const Model& model, const Certificate& certificate);
/// Reachable modes and sets are kept by every step (structure.cpp).
void check_structure(const Model& model, const Certificate& certificate);
/// Facts are true at first and kept by every step, and no state of all is bad (induction.cpp).
void check_states(const Model& model, const Certificate& certificate);
/// The states of a diagram, one by one: the first one is among them, and where steps lead to; none of them is bad (reached.cpp). Says how many.
[[nodiscard]] std::string check_reached(const Model& model, const Certificate& certificate);

}  // namespace certcheck
