// Lemmas about two components each, from the bad states that are left: no two customers hold the same ticket.
//
// A bad state that the lemmas so far allow is projected to two components. If no step enters that projection from
// outside, it is a lemma, from which literals are dropped as long as no step enters what remains (inductive
// generalisation of counterexamples, without frames). Its images, the same of each other two components of these types,
// are candidates for Houdini, so that what holds of all pairs is found of one. Until no bad state is left, or one of
// which no two components give a lemma.
//
// A. Bradley, Z. Manna: Checking Safety by Inductive Generalization of Counterexamples to Induction (FMCAD 2007);
// K. McMillan: Symmetry and Model Checking (invariants of index sets). Cost: for each bad state one query a pair, and
// for each lemma one a literal and Houdini with its images.
#pragma once
#include "compiler/system/system_ids.hpp"
#include "compiler/verify/symbolic/ic3.hpp"

namespace bip::verify {

/// Systems with more atoms have too many pairs.
inline constexpr std::size_t kMostAtomsOfPairs = 64;

/// Returns lemmas that are inductive together with the problem's invariants, as many as were found until no bad state
/// was left, no pair gave one more, or the time was over. `system` is that of the circuit.
[[nodiscard]] std::vector<Cube> find_pair_lemmas(const Ic3Problem& problem, const System& system);

}  // namespace bip::verify
