// See structural_engines.hpp.
#include "compiler/verify/portfolio/structural_engines.hpp"

#include "compiler/verify/net/port_uses.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

bool asks_for_deadlock(const ProofContext& context) {
  return context.parts.has_usable_net() && context.question.what == QuestionKind::DeadlockFreedom;
}

EngineResult prove_with_port_uses(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  EngineResult result;
  result.retry = Retry::Pointless;
  const Net& plain = context.parts.net();
  PortUses uses = find_port_uses(plain);
  if (!uses.has_some) return result;
  Net distinguishing = build_net(plain, uses, UsesAs::Ports);
  if (distinguishing.too_large_atom != kNoRow) return result;
  const CancellationToken share = cancellation.within(budget.seconds);
  Proof proof = prove_deadlock_freedom(
      distinguishing, share, [](const std::vector<u32>&) { return true; },
      invariants_of(context.cached, distinguishing, PortUseModes::Distinguished));
  if (proof.end != ProofEnd::Free) return result;
  if (context.wants_minimal(ProofMethod::PortUses, proof)) minimize_invariants(distinguishing, share, proof);
  context.count_reused(proof);
  InvariantProof evidence;
  if (context.limits.wants_certificate) {
    evidence.projection = project_proof(plain, distinguishing, proof);
    // No certificate has a form for this proof: the other engines may find one that has.
    if (!evidence.projection) return result;
  }
  BIP_ASSERT(distinguishing.mode_base.size() == plain.mode_base.size(), "{} atoms with port uses, {} without",
             distinguishing.mode_base.size() - 1, plain.mode_base.size() - 1);
  context.facts.proof = std::move(proof);
  evidence.distinguishing_net = std::move(distinguishing);
  result.outcome = Outcome::Holds;
  result.evidence = std::move(evidence);
  return result;
}

EngineResult prove_with_invariants(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  EngineResult result;
  result.retry = Retry::Pointless;
  const Net& net = context.parts.net();
  const std::vector<TokenInvariant> cached = invariants_of(context.cached, net, PortUseModes::Merged);
  if (context.question.what != QuestionKind::DeadlockFreedom) {
    context.facts.proof = find_reachable_modes(net, cached);
    return result;
  }
  context.report("invariants", 0, "candidates");
  const CancellationToken share = cancellation.within(budget.seconds);
  const auto is_reached = [&](const std::vector<u32>& candidate) {
    if (!context.parts.has_code()) return false;
    const SearchLimits limits{
        .cancellation = share, .megabytes = context.limits.megabytes, .only_walk = true, .report = {}};
    SearchResult found = search(net, context.parts.image(), goal_of(context.question), candidate, limits);
    if (found.end != SearchEnd::Found) return false;
    result.outcome = Outcome::Violated;
    result.evidence = Counterexample{std::move(found.choices)};
    return true;
  };
  Proof& proof = context.facts.proof.emplace(prove_deadlock_freedom(net, share, is_reached, cached));
  if (proof.end != ProofEnd::Free) return result;
  if (context.wants_minimal(ProofMethod::Invariants, proof)) minimize_invariants(net, share, proof);
  context.count_reused(proof);
  result.outcome = Outcome::Holds;
  result.evidence = InvariantProof{};
  return result;
}

}  // namespace

const Engine kPortUseEngine{"invariants with port uses", asks_for_deadlock, prove_with_port_uses};
const Engine kInvariantEngine{"invariants",
                              [](const ProofContext& context) {
                                return context.parts.has_usable_net() &&
                                       context.question.what != QuestionKind::NoLocalDeadlock;
                              },
                              prove_with_invariants};

}  // namespace bip::verify
