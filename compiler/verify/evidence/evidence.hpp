// Evidence: what an engine of the portfolio has found to confirm its verdict, in a form that others can check or
// replay. The proof cache stores it, the certificate writes it, the explanation prints it; each visits the variant, so
// a new kind of evidence does not compile before all three handle it.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "compiler/verify/evidence/project_proof.hpp"
#include "compiler/verify/invariants/affine_invariants.hpp"
#include "compiler/verify/symbolic/ic3.hpp"

namespace bip::verify {

/// Facts that hold in every reachable state, as far as they were looked for. Engines share them and add to them;
/// evidence refers to them.
struct StructuralFacts {
  std::optional<Proof> proof;  // absent: an atom has too many local states; else invariants, and the open candidate
  AffineInvariants affine;     // equations between data and places, bounds, values by place
};

/// Holds: the structural facts exclude every bad state.
struct InvariantProof {
  std::optional<Net> distinguishing_net;     // whose modes the facts are about, if port uses are distinguished
  std::optional<ProjectedProof> projection;  // the same in words that certificates have
};
/// Holds: these lemmas are inductive with the structural facts, and together they exclude every bad state.
struct InductiveProof {
  std::vector<Cube> lemmas;
};
/// Holds: these states are closed under steps, and none is bad.
struct ReachedStates {
  std::string rows;  // one row of the certificate per state
};
/// Holds: an exhaustive search met no bad state. Only another search can check that.
struct StateCount {
  enum class Listing : std::uint8_t { NotRequested, Impossible };
  Listing listing = Listing::NotRequested;  // why there are no ReachedStates
};
/// Holds: weights of local states whose sum over the components, interchangeable ones counted together, no step raises,
/// and which each bad state exceeds. Checked in integers.
struct CountingProof {
  struct Sum {
    std::int64_t initially = 0, in_bad_states = 0;  // at most; at least
    std::vector<std::string> weights;               // one line for each local state of weight > 0
  };
  std::vector<Sum> sums;  // one for each combination of bad local states; empty: none is reachable
  std::size_t local_states = 0;
  std::string rows;  // of the certificate, if one is wanted
};
/// Holds: regions of values that components cannot be in together exclude every bad state, by a sum that is checked in
/// integers.
struct RegionProof {
  std::size_t local_states = 0, neighbourhoods = 0, implications = 0;
  std::vector<std::string> reasons;  // some of the implications
  std::string rows;                  // of the certificate, if one is wanted
};
/// Violated: the numbers of the candidates taken from the initial state, which end in the bad state or in the fault.
struct Counterexample {
  std::vector<std::uint64_t> choices;
  std::vector<u32> deadlocked_atoms = {};  // rows; only of a local deadlock
};

/// monostate: no verdict.
using Evidence = std::variant<std::monostate, InvariantProof, InductiveProof, ReachedStates, StateCount, CountingProof,
                              RegionProof, Counterexample>;

/// Makes one visitor of several lambdas, one per kind of evidence.
template <class... Visitors>
struct EvidenceVisitor : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
EvidenceVisitor(Visitors...) -> EvidenceVisitor<Visitors...>;

/// Was every reachable state visited?
[[nodiscard]] inline bool is_exhaustive(const Evidence& evidence) {
  return std::holds_alternative<ReachedStates>(evidence) || std::holds_alternative<StateCount>(evidence);
}

}  // namespace bip::verify
