// See cached_proof_engine.hpp.
#include "compiler/verify/portfolio/cached_proof_engine.hpp"

#include "compiler/verify/portfolio/induction_engines.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// A counterexample after fewer states is found again as fast as it is read.
constexpr std::uint64_t kCheapStates = 1000;

// The question as proofs are named by it.
std::string cache_key(const ProofContext& context) {
  std::string key;
  switch (context.question.what) {
    case QuestionKind::DeadlockFreedom: key = "deadlock"; break;
    case QuestionKind::NoErrors: key = "errors"; break;
    case QuestionKind::State: key = "state " + context.question.property.text; break;
    case QuestionKind::NoLocalDeadlock:
    case QuestionKind::Runs:
    case QuestionKind::Branching: BIP_UNREACHABLE("local deadlocks and properties of runs are not cached");
  }
  return (context.limits.wants_certificate ? "certified " : "") + key;
}

EngineResult replay_cached_steps(ProofContext& context) {
  const std::vector<std::uint64_t>& choices = context.cached.choices;
  if (choices.empty() || !context.parts.has_code() ||
      !reaches(context.parts.image(), goal_of(context.question), choices))
    return {};
  context.cache->counts.has_counterexample = true;
  EngineResult result;
  result.outcome = Outcome::Violated;
  result.evidence = Counterexample{choices};
  return result;
}

EngineResult check_cached_lemmas(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  const Net& net = context.parts.net();
  if (context.parts.has_usable_net())
    context.facts.proof = find_reachable_modes(net, invariants_of(context.cached, net, PortUseModes::Merged));
  EngineResult result = kIc3Engine.attempt(context, budget, cancellation);
  if (result.outcome != Outcome::Unknown) return result;
  // The other engines begin anew.
  context.facts = {};
  context.induction = context.induction == InductionStage::InvariantsRefined ? InductionStage::RangesConfirmed
                                                                             : InductionStage::Untried;
  return {};
}

EngineResult reuse_proof(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  switch (context.cached.method) {
    case ProofMethod::Steps: return replay_cached_steps(context);
    case ProofMethod::Induction: return check_cached_lemmas(context, budget, cancellation);
    case ProofMethod::None:
    case ProofMethod::Invariants:
    case ProofMethod::PortUses: break;
  }
  return {};
}

// Facts of a proof, in terms that outlive the run.
CachedProof cacheable(const ProofContext& context, const Decision& decision, ProofMethod method) {
  CachedProof result;
  result.method = method;
  const Net& net = net_of(decision, context.parts.net());
  for (const TokenInvariant& invariant : decision.invariants())
    result.invariants.push_back(cached_invariant(
        net, invariant, method == ProofMethod::PortUses ? PortUseModes::Distinguished : PortUseModes::Merged));
  for (const AffineEquation& equation : decision.facts.affine.equations) result.equations.push_back(equation.terms);
  result.uses_bounds = !decision.facts.affine.bounds.empty();
  return result;
}

}  // namespace

const Engine kCachedProofEngine{"cached proof", [](const ProofContext& context) { return context.is_cached_system(); },
                                reuse_proof};

void load_cached_proof(ProofContext& context) {
  if (context.cache == nullptr) return;
  context.cache->counts = {};
  if (context.parts.has_usable_net()) context.cached = context.cache->recall(context.parts.net(), cache_key(context));
}

void store_proof(const ProofContext& context, const Decision& decision) {
  if (context.cache == nullptr || !context.parts.has_usable_net()) return;
  const bool stores_all = context.cache->policy() == StorePolicy::All;
  const CachedProof proof =
      std::visit(EvidenceVisitor{
                     [](const std::monostate&) { return CachedProof(); },
                     [&](const InvariantProof& evidence) {
                       if (!stores_all && decision.candidates() <= kCheapCandidates) return CachedProof();
                       return cacheable(context, decision,
                                        evidence.distinguishing_net ? ProofMethod::PortUses : ProofMethod::Invariants);
                     },
                     [&](const InductiveProof& evidence) {
                       CachedProof result = cacheable(context, decision, ProofMethod::Induction);
                       for (const Cube& lemma : evidence.lemmas)
                         result.lemmas.push_back(cached_lemma(*context.parts.built_transition_system(), lemma));
                       return result;
                     },
                     // All states are to be visited again: there is nothing that could be checked faster.
                     [](const ReachedStates&) { return CachedProof(); },
                     [](const StateCount&) { return CachedProof(); },
                     // Its time is that of the steps by local states, which a check of the weights needs as well.
                     [](const CountingProof&) { return CachedProof(); },
                     [](const RegionProof&) { return CachedProof(); },
                     [&](const Counterexample& evidence) {
                       if (!stores_all && decision.states < kCheapStates && decision.frames == 0) return CachedProof();
                       CachedProof result;
                       result.method = ProofMethod::Steps;
                       result.choices = evidence.choices;
                       return result;
                     },
                 },
                 decision.evidence);
  if (proof.method == ProofMethod::None || (context.is_cached_system() && proof == context.cached)) return;
  context.cache->store(context.parts.net(), cache_key(context), proof);
}

}  // namespace bip::verify
