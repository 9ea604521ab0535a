// The answer of a portfolio to one question.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/verify/evidence/evidence.hpp"
#include "compiler/verify/portfolio/question.hpp"

namespace bip::verify {

struct Decision {
  Outcome outcome = Outcome::Unknown;
  Evidence evidence;                  // Holds, Violated: what confirms it
  StructuralFacts facts;              // hold, whatever the outcome; the evidence may rest on them
  std::uint64_t states = 0;           // visited by the last search
  std::vector<std::string> permuted;  // groups of equal components that the last search permuted: `states` are fewer
  u32 frames = 0;                     // of IC3
  std::string fault;                  // a run-time error that a search met and that was not asked about
  std::string reason;                 // Unknown
  const char* engine = nullptr;       // name of the engine with the verdict; null: none

  /// Returns how many candidates for a bad state the solver proposed before the invariants excluded all or one stayed.
  [[nodiscard]] std::uint64_t candidates() const { return facts.proof ? facts.proof->candidates : 0; }
  /// Returns the local states, by atom, of a candidate that no invariant excludes; empty: there is none.
  [[nodiscard]] std::vector<u32> open_candidate() const {
    return facts.proof ? facts.proof->candidate : std::vector<u32>();
  }
  /// Returns the invariants of structure that were found.
  [[nodiscard]] const std::vector<TokenInvariant>& invariants() const {
    static const std::vector<TokenInvariant> none;
    return facts.proof ? facts.proof->invariants : none;
  }
  /// Returns null unless Violated.
  [[nodiscard]] const Counterexample* counterexample() const { return std::get_if<Counterexample>(&evidence); }
};

/// Returns the net whose modes the decision's facts are about. `plain`: the portfolio's.
[[nodiscard]] inline const Net& net_of(const Decision& decision, const Net& plain) {
  const auto* proof = std::get_if<InvariantProof>(&decision.evidence);
  return proof != nullptr && proof->distinguishing_net ? *proof->distinguishing_net : plain;
}

}  // namespace bip::verify
