// Components of one array that a system treats alike: exchanging two of them, and their numbers, changes nothing.
//
// C. N. Ip, D. Dill: Better Verification Through Symmetry (1996), section 4 (scalarsets). Sufficient, not necessary.
#pragma once
#include <optional>
#include <set>

#include "compiler/verify/timed/localization.hpp"

namespace bip::verify {

/// What a step of a component does to those outside of the array.
struct OutsideStep {
  std::vector<Neighbours::Leaf> leaves;  // ports of atoms outside, sorted
  u32 port = 0;                          // of the component
  u32 top = 0;                           // row of the neighbour relation
};
struct LikeComponents {
  std::vector<u32> atoms;    // ascending
  std::vector<u32> outside;  // all others, ascending
  // Numbers: parameters that differ, and data that are copies of them for ever. By variable of the components' type.
  std::vector<std::uint8_t> is_number;
  std::vector<std::int32_t> numbers;             // by component; empty: there are none
  std::set<std::pair<u32, u32>> number_outside;  // atom, variable: holds a number, or another constant
};

/// Returns the components of the array that `atom` is in, if they are alike, else nothing; `reason` says why.
/// Connectors of one of them and atoms outside may have guards and transfers; in others all of them take part, by the
/// same port and without data.
[[nodiscard]] std::optional<LikeComponents> find_like_components(const System& system, const Neighbours& neighbours,
                                                                 u32 atom, std::string& reason);

/// Returns the steps of one of them in which atoms outside take part, but none of its like.
[[nodiscard]] std::vector<OutsideStep> outside_steps(const LikeComponents& like, const Neighbours& neighbours,
                                                     u32 atom);

}  // namespace bip::verify
