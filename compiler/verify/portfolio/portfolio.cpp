// See portfolio.hpp. The table is the whole strategy: which engine is tried when, with how much of the time.
#include "compiler/verify/portfolio/portfolio.hpp"

#include <algorithm>

#include "compiler/system/system.hpp"
#include "compiler/verify/portfolio/cached_proof_engine.hpp"
#include "compiler/verify/portfolio/check_evidence.hpp"
#include "compiler/verify/portfolio/counting_engine.hpp"
#include "compiler/verify/portfolio/induction_engines.hpp"
#include "compiler/verify/portfolio/local_lemma_engine.hpp"
#include "compiler/verify/portfolio/region_engine.hpp"
#include "compiler/verify/portfolio/search_engines.hpp"
#include "compiler/verify/portfolio/search_symmetry.hpp"
#include "compiler/verify/portfolio/small_instance_engine.hpp"
#include "compiler/verify/portfolio/structural_engines.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

/// TimeLeft: when the attempt begins. TimeOfLongEngines: when the first attempt with such a share begins.
enum class ShareOf : std::uint8_t { TimeLeft, TimeOfLongEngines };
struct Share {
  ShareOf of = ShareOf::TimeLeft;
  double fraction = 1;
  double at_most = std::numeric_limits<double>::infinity();  // seconds
  double fraction_without_search = fraction;  // states cannot be searched: no other engine needs the rest
};
/// Attempt: what is cheap still has an answer when the time is over before it begins.
enum class WhenOver : std::uint8_t { Skip, Attempt };

struct PortfolioRow {
  const Engine* engine;
  Share share = {};
  WhenOver when_over = WhenOver::Skip;
  bool (*is_due)(ProofContext& context) = [](ProofContext&) { return true; };
};

// What the cache says was proved without port uses is likely to be again.
bool has_no_plainer_proof(ProofContext& context) {
  return context.cached.method != ProofMethod::Invariants && context.cached.method != ProofMethod::Induction;
}
// Where regions of values may have an answer, they have it sooner than ports distinguished by many numbers.
bool may_wait_for_regions(ProofContext& context) {
  return has_no_plainer_proof(context) && kRegionEngine.applies_to(context);
}
bool has_no_plainer_proof_nor_regions(ProofContext& context) {
  return has_no_plainer_proof(context) && !kRegionEngine.applies_to(context);
}
// Up to permutations of equal components the states may be few, however many components there are.
bool is_symmetric(ProofContext& context) {
  if (!context.is_symmetric) {
    context.is_symmetric = !context.limits.wants_certificate && context.parts.has_code() &&
                           has_symmetry(context.question, context.parts.image());
  }
  return *context.is_symmetric;
}
bool is_not_symmetric(ProofContext& context) { return !is_symmetric(context); }
// With a certificate no search permutes components; a proof by counting may, and looks for them itself.
bool may_have_like_components(ProofContext& context) {
  return context.limits.wants_certificate || is_symmetric(context);
}
bool takes_turns_with_search(ProofContext& context) {
  return context.limits.may_search && context.parts.is_searchable();
}

// A few hundred thousand states are visited sooner than lemmas count to a hundred; other systems have few lemmas and no
// end of states. So IC3 and the exhaustive search take turns, each turn longer.
constexpr Share kFirstTurn{ShareOf::TimeOfLongEngines, 1.0 / 64, 1},
    kSecondTurn{ShareOf::TimeOfLongEngines, 1.0 / 12, 6},
    kThird{ShareOf::TimeOfLongEngines, 1.0 / 3, std::numeric_limits<double>::infinity(), 1};

constexpr PortfolioRow kRows[] = {
    {&kLocalDeadlockEngine, {}, WhenOver::Attempt},
    {&kCachedProofEngine, {ShareOf::TimeLeft, 1.0 / 3}, WhenOver::Attempt},
    {&kPortUseEngine, {ShareOf::TimeLeft, 1.0 / 4}, WhenOver::Attempt, has_no_plainer_proof_nor_regions},
    {&kPortUseEngine, {ShareOf::TimeLeft, 1.0 / 12}, WhenOver::Attempt, may_wait_for_regions},
    {&kInvariantEngine, {}, WhenOver::Attempt},
    {&kFirstSearchEngine, {}, WhenOver::Attempt},
    {&kExhaustiveEngine, kFirstTurn, WhenOver::Skip, is_symmetric},
    {&kCountingEngine, {ShareOf::TimeLeft, 1.0 / 3, 20}, WhenOver::Skip, may_have_like_components},
    {&kRegionEngine, {ShareOf::TimeLeft, 1.0 / 6, 10}},
    {&kPortUseEngine, {ShareOf::TimeLeft, 1.0 / 4}, WhenOver::Skip, may_wait_for_regions},
    {&kFewFollowedEngine, {ShareOf::TimeOfLongEngines, 1.0 / 3}},
    {&kAffineEngine, kThird},
    {&kExhaustiveEngine, kFirstTurn},
    {&kIc3Engine, kFirstTurn, WhenOver::Skip, takes_turns_with_search},
    {&kLocalLemmaEngine, {ShareOf::TimeLeft, 2.0 / 3, 40}},
    {&kLocalizedEngine, {ShareOf::TimeOfLongEngines, 1.0 / 3}},
    {&kPairLemmaEngine, {ShareOf::TimeLeft, 1.0 / 3, 30}},
    {&kRegionEngine, {ShareOf::TimeLeft, 1.0 / 2}},
    {&kRandomRunsEngine, {ShareOf::TimeLeft, 1.0 / 8, 5}},
    {&kSmallInstanceEngine, {ShareOf::TimeLeft, 3.0 / 4}, WhenOver::Skip, is_not_symmetric},
    {&kSmallInstanceEngine, {ShareOf::TimeLeft, 1.0 / 4}, WhenOver::Skip, is_symmetric},
    {&kExhaustiveEngine, {ShareOf::TimeLeft, 2.0 / 3}, WhenOver::Skip, is_symmetric},
    {&kExhaustiveEngine, kSecondTurn},
    {&kIc3Engine, kSecondTurn, WhenOver::Skip, takes_turns_with_search},
    {&kIc3Engine, kThird},
    {&kPortUseEngine, {ShareOf::TimeLeft, 1.0 / 4}},
    {&kExhaustiveEngine, {}},
    // The search gave up for memory: what is left of the time belongs to the proof.
    {&kIc3Engine, {}},
};

// Once all states are known to be fine, lemmas are a shorter evidence than the states are, but not at any price.
constexpr double kLemmaSeconds = 4;

/// Runs the rows for one question.
class PortfolioRun {
 public:
  PortfolioRun(ProofContext& context, const CancellationToken& cancellation)
      : context_(context), cancellation_(cancellation) {}

  Decision run() {
    for (const PortfolioRow& row : kRows) {
      if (is_tried(row) && attempt(*row.engine, {seconds(row.share)})) break;
    }
    if (decision_.outcome == Outcome::Unknown) explain_unknown();
    else decision_.reason.clear();
    if (is_exhaustive(decision_.evidence)) improve_exhaustive_evidence();
    decision_.facts = std::move(context_.facts);
    return std::move(decision_);
  }

 private:
  [[nodiscard]] bool is_tried(const PortfolioRow& row) const {
    const bool has_given_up = std::find(given_up_.begin(), given_up_.end(), row.engine) != given_up_.end();
    if (has_given_up || (row.when_over == WhenOver::Skip && cancellation_.is_over())) return false;
    return row.engine->applies_to(context_) && row.is_due(context_);
  }
  double seconds(const Share& share) {
    double whole = cancellation_.seconds_left();
    if (share.of == ShareOf::TimeOfLongEngines) {
      if (!time_of_long_engines_) time_of_long_engines_ = whole;
      whole = *time_of_long_engines_;
    }
    const double fraction = context_.parts.is_searchable() ? share.fraction : share.fraction_without_search;
    BIP_ASSERT(fraction > 0 && fraction <= 1 && share.at_most > 0, "the share {} of {} s", fraction, whole);
    return std::min(whole * fraction, share.at_most);
  }
  // True: decided.
  bool attempt(const Engine& engine, const Budget& budget) {
    EngineResult found = engine.attempt(context_, budget, cancellation_);
    if (found.retry == Retry::Pointless) given_up_.push_back(&engine);
    if (found.states) {
      decision_.states = *found.states;
      decision_.permuted = std::move(found.permuted);
    }
    if (found.frames) decision_.frames = *found.frames;
    if (decision_.fault.empty()) decision_.fault = std::move(found.fault);
    if (found.outcome == Outcome::Unknown) {
      BIP_ASSERT(std::holds_alternative<std::monostate>(found.evidence), "evidence without verdict");
      add_reason(found.reason);
      return false;
    }
    BIP_ASSERT(decision_.outcome == Outcome::Unknown || decision_.outcome == found.outcome,
               "outcome {}, and {} of a later engine", decision_.outcome, found.outcome);
    decision_.engine = engine.name;
    decision_.outcome = found.outcome;
    decision_.evidence = std::move(found.evidence);
    return true;
  }
  void add_reason(const std::string& reason) {
    // Several engines may have the same one.
    if (decision_.reason.find(reason) == std::string::npos)
      decision_.reason += (decision_.reason.empty() ? "" : "; ") + reason;
  }
  void explain_unknown() {
    if (cancellation_.is_cancelled()) decision_.reason = "interrupted";
    else if (decision_.reason.empty() && context_.question.what != QuestionKind::NoLocalDeadlock)
      decision_.reason = cancellation_.is_over() ? "the time is over" : "no engine has an answer";
    if (!context_.parts.is_searchable())
      add_reason(context_.parts.system().code.has_cpp() ? "the model calls C++, whose state cannot be searched"
                                                        : "the model draws random numbers, which are not searched");
  }
  // All states are fine: lemmas of a proof (not of local deadlocks), or, for a certificate, the states themselves.
  void improve_exhaustive_evidence() {
    if (!context_.limits.wants_minimal_proof) return;
    if (kIc3Engine.applies_to(context_)) {
      const bool is_proved = attempt(kIc3Engine, {std::min(cancellation_.seconds_left() / 2, kLemmaSeconds)});
      decision_.reason.clear();
      BIP_ASSERT(decision_.outcome == Outcome::Holds, "IC3 contradicts the visit of all {} states", decision_.states);
      if (is_proved) return;
    }
    if (!context_.limits.wants_certificate) return;
    std::string rows = list_reached_states(context_, cancellation_);
    if (rows.empty()) decision_.evidence = StateCount{StateCount::Listing::Impossible};
    else decision_.evidence = ReachedStates{std::move(rows)};
  }

  ProofContext& context_;
  const CancellationToken& cancellation_;
  Decision decision_;
  std::vector<const Engine*> given_up_;
  std::optional<double> time_of_long_engines_;
};

}  // namespace

Decision Portfolio::decide(const Question& question, const PortfolioLimits& limits) {
  // Local deadlocks are decided by a visit of all states, which no cache makes shorter.
  ProofCache* const cache = question.what == QuestionKind::NoLocalDeadlock ? nullptr : cache_;
  ProofContext context{parts_, question, limits, report_, cache, {}, {}};
  context.small_instances = small_instances_;
  load_cached_proof(context);
  Decision decision = PortfolioRun(context, limits.cancellation).run();
  BIP_ASSERT(is_evidence_sound(parts_, question, decision), "evidence of the engine {}", decision.engine);
  store_proof(context, decision);
  return decision;
}

std::string imprecision_text(const TransitionSystem& machine, const System& system, std::size_t count) {
  std::string text;
  for (const Imprecision& imprecision : machine.imprecisions) {
    if (count-- == 0) return text + "  …\n";
    text += "  ";
    if (imprecision.loc.line != 0 && imprecision.loc.file < system.files.size())
      text += system.files[imprecision.loc.file] + ':' + std::to_string(imprecision.loc.line) + ": ";
    text += imprecision.what + '\n';
  }
  return text;
}

}  // namespace bip::verify
