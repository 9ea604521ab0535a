// Checks a decision's evidence once more before it leaves the portfolio: a contract, evaluated in checked builds.
#pragma once
#include "compiler/verify/portfolio/decision.hpp"
#include "compiler/verify/portfolio/proof_context.hpp"

namespace bip::verify {

/// Does the evidence belong to the outcome, does every structural invariant hold by structure, is a counterexample
/// replayed by the engine? Lemmas are checked where they are found (induction_engines.cpp). Cost: a pass over the net
/// for each invariant, the replay.
[[nodiscard]] bool is_evidence_sound(const SystemParts& parts, const Question& question, const Decision& decision);

}  // namespace bip::verify
