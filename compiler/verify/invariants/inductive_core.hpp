// Which groups of lemmas a proof needs: a subset of groups that is inductive and excludes all bad states, by unsat
// cores.
//
// Begins with the groups that exclude the bad states, and adds for each of them those that a step into one of its cubes
// contradicts, until nothing is missing. One query per group that is needed, and a few more that look for a core among
// the groups that the caller prefers; where deleting groups one by one takes a run of Houdini for each. The result need
// not be minimal.
//
// The same notion for IC3's clauses: E. Ghassabani, A. Gacek, M. Whalen: Efficient Generation of Inductive Validity
// Cores for Safety Properties (FSE 2016), section 4.
#pragma once
#include "compiler/verify/symbolic/ic3.hpp"

namespace bip::verify {

/// Returns the rows of the groups, ascending; those that come first are preferred. Requires that all groups together
/// are inductive with the problem's invariants and exclude all bad states. All groups if the time is over, or if that
/// is not so.
[[nodiscard]] std::vector<std::size_t> inductive_core(const Ic3Problem& problem,
                                                      const std::vector<std::vector<Cube>>& groups);

}  // namespace bip::verify
