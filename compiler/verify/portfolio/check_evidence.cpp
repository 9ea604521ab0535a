// See check_evidence.hpp.
#include "compiler/verify/portfolio/check_evidence.hpp"

#include <algorithm>

#include "compiler/verify/invariants/token_invariant_checker.hpp"

namespace bip::verify {

namespace {

bool do_invariants_hold(const Net& net, const std::vector<TokenInvariant>& invariants) {
  if (invariants.empty()) return true;
  Proof modes;
  ModeReachability reachable(net, Direction::Forward, nullptr);
  spread_from_initial(net, reachable, modes);
  return TokenInvariantChecker(net, reachable).those_that_hold(invariants).size() == invariants.size();
}

}  // namespace

bool is_evidence_sound(const SystemParts& parts, const Question& question, const Decision& decision) {
  const Net& net = net_of(decision, parts.net());
  const auto holds = [&] { return decision.outcome == Outcome::Holds; };
  const auto has_true_invariants = [&] { return do_invariants_hold(net, decision.invariants()); };
  return std::visit(EvidenceVisitor{
                        [&](const std::monostate&) { return decision.outcome == Outcome::Unknown; },
                        [&](const InvariantProof& evidence) {
                          return holds() && has_true_invariants() &&
                                 (!evidence.projection ||
                                  do_invariants_hold(evidence.projection->net, evidence.projection->proof.invariants));
                        },
                        [&](const InductiveProof&) { return holds() && has_true_invariants(); },
                        [&](const ReachedStates& evidence) { return holds() && evidence.rows.ends_with('\n'); },
                        [&](const StateCount&) { return holds(); },
                        [&](const CountingProof& evidence) {
                          return holds() &&
                                 std::all_of(evidence.sums.begin(), evidence.sums.end(),
                                             [](const auto& sum) { return sum.initially < sum.in_bad_states; });
                        },
                        [&](const RegionProof&) { return holds(); },
                        [&](const Counterexample& evidence) {
                          if (decision.outcome != Outcome::Violated) return false;
                          // Which atoms wait for ever is not to be seen in the last state alone.
                          if (question.what == QuestionKind::NoLocalDeadlock) return !evidence.deadlocked_atoms.empty();
                          return reaches(parts.image(), goal_of(question), evidence.choices);
                        },
                    },
                    decision.evidence);
}

}  // namespace bip::verify
