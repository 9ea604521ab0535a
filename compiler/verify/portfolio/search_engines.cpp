// See search_engines.hpp.
#include "compiler/verify/portfolio/search_engines.hpp"

#include <atomic>

#include "compiler/base/log.hpp"
#include "compiler/system/system_ids.hpp"
#include "compiler/verify/evidence/reached_states.hpp"
#include "compiler/verify/net/unread_data.hpp"
#include "compiler/verify/portfolio/local_deadlock_search.hpp"
#include "compiler/verify/portfolio/random_runs.hpp"
#include "compiler/verify/portfolio/search_symmetry.hpp"
#include "runtime/explore/explore.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// The first search is at most a second of work: states times the values of one.
constexpr std::uint64_t kFirstStates = 20000, kFirstValues = 4000000;

std::string limit_reason(const std::string& limit, std::uint64_t states) {
  return "the search met its limit of " + limit + " after " + std::to_string(states) +
         (states == 1 ? " state" : " states");
}

bool may_search(const ProofContext& context) {
  return context.limits.may_search && context.parts.is_searchable() &&
         context.question.what != QuestionKind::NoLocalDeadlock;
}

SearchLimits search_limits(const ProofContext& context, const CancellationToken& cancellation) {
  return {.cancellation = cancellation,
          .megabytes = context.limits.megabytes,
          .report = [&context](std::uint64_t count) { context.report("search", count, "states"); }};
}

// A certificate speaks of all data.
std::vector<rt::VariableId> unread_cells(const ProofContext& context) {
  if (context.limits.wants_certificate) return {};
  const Question& question = context.question;
  return find_unread_cells(context.parts.system(), context.parts.image(),
                           question.what == QuestionKind::State ? data_of(question.property) : std::vector<DataRef>());
}

EngineResult search_first(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  EngineResult result;
  if (!context.parts.has_code()) return result;
  const rt::Image& image = context.parts.image();
  SearchLimits limits = search_limits(context, cancellation.within(budget.seconds));
  limits.unread_cells = unread_cells(context);
  limits.states = std::min(kFirstStates, kFirstValues / (image.atoms.size + image.cell_count + 1) + 1);
  const std::vector<u32> candidate = context.facts.proof ? context.facts.proof->candidate : std::vector<u32>();
  SearchResult found = search(context.parts.net(), image, goal_of(context.question), candidate, limits);
  result.states = found.states;
  if (context.question.what != QuestionKind::NoErrors) result.fault = std::move(found.fault);
  switch (found.end) {
    case SearchEnd::Found:
      result.outcome = Outcome::Violated;
      result.evidence = Counterexample{std::move(found.choices)};
      break;
    case SearchEnd::Exhausted:
      result.outcome = Outcome::Holds;
      result.evidence = StateCount{};
      break;
    // The exhaustive search goes on: no reason to report.
    case SearchEnd::Limit: break;
  }
  return result;
}

EngineResult run_some(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  EngineResult result;
  // The next attempt would make the same runs.
  result.retry = Retry::Pointless;
  if (!context.parts.has_code()) return result;
  SearchResult found = run_at_random(context.parts.image(), goal_of(context.question),
                                     {.cancellation = cancellation.within(budget.seconds)});
  if (context.question.what != QuestionKind::NoErrors) result.fault = std::move(found.fault);
  if (found.end != SearchEnd::Found) return result;
  result.outcome = Outcome::Violated;
  result.evidence = Counterexample{std::move(found.choices)};
  return result;
}

void note_permuted(const std::vector<std::string>& groups, EngineResult& result) {
  result.permuted = groups;
  for ([[maybe_unused]] const std::string& group : groups)
    BIP_LOG(Portfolio, 1, "states up to permutations of {}", group);
}

EngineResult search_all(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  EngineResult result;
  if (!context.parts.has_code()) return result;
  const rt::Image& image = context.parts.image();
  const Question& question = context.question;
  const bool asks_errors = question.what == QuestionKind::NoErrors, asks_state = question.what == QuestionKind::State;
  std::atomic<bool> is_found{false};
  const CancellationToken share = cancellation.within(budget.seconds);
  rt::ExploreOptions options;
  options.threads = context.limits.threads;
  options.unread_cells = unread_cells(context);
  // 0 would be no limit.
  options.bytes = std::max<std::size_t>(context.limits.megabytes * 1000000, 1);
  options.on_progress = [&](const rt::ExploreProgress& so_far) {
    context.report("search", so_far.states, "states");
    if ((asks_errors ? so_far.errors : asks_state ? so_far.matches : so_far.deadlocks) != 0) is_found = true;
  };
  if (asks_state) {
    options.predicate = goal_of(question).state;
    options.predicate_reads = atoms_of(question.property);
    options.predicate_connectors = connectors_of(question.property);
  }
  options.is_stopped = [&] { return is_found || share.is_over(); };
  // A certificate lists the states themselves.
  if (!context.limits.wants_certificate) use_symmetry(question, image, options);
  rt::ExploreReport all = rt::explore_states(image, options);
  result.states = all.states;
  note_permuted(all.groups, result);
  if (!asks_errors && all.has_error) result.fault = fault_of(image, all.error);
  const bool has_bad = asks_errors ? all.has_error : asks_state ? all.has_match : all.has_deadlock;
  BIP_ASSERT(!has_bad || all.states > 0, "a bad state among {} states", all.states);
  if (has_bad && all.are_paths_known) {
    std::vector<std::uint64_t> choices = std::move(asks_errors ? all.error : asks_state ? all.match : all.deadlock);
    if (!reaches(image, goal_of(question), choices)) {
      result.reason = "a way that was found could not be replayed";
      return result;
    }
    result.outcome = Outcome::Violated;
    result.evidence = Counterexample{std::move(choices)};
    return result;
  }
  if (all.end == rt::ExploreEnd::Complete && !has_bad) {
    result.outcome = Outcome::Holds;
    result.evidence = StateCount{};
    return result;
  }
  const bool is_memory_over = all.end == rt::ExploreEnd::Memory;
  // A longer attempt would fill the memory with the same states.
  if (is_memory_over) result.retry = Retry::Pointless;
  if (is_memory_over || cancellation.is_over())
    result.reason = limit_reason(is_memory_over ? "memory" : "time", all.states);
  return result;
}

EngineResult search_local_deadlock(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  EngineResult result;
  // Who waits for whom is read from the net.
  if (!context.parts.inner_priority().empty()) {
    result.reason = context.parts.inner_priority();
    return result;
  }
  if (!context.parts.has_code()) return result;
  const Net& net = context.parts.net();
  const rt::Image& image = context.parts.image();
  SearchLimits limits = search_limits(context, cancellation.within(budget.seconds));
  const bool may_permute = !context.limits.wants_certificate && has_symmetry(image);
  // Without symmetry, all components that wait are known: so for as long as that is cheap.
  if (may_permute) limits.states = kFirstStates;
  LocalDeadlockResult found = find_local_deadlock(net, image, limits);
  if (may_permute && found.search.end == SearchEnd::Limit && found.search.states >= limits.states) {
    limits.states = ~std::uint64_t{0};
    found = find_local_deadlock(net, image, limits, SymmetryUse::Permute);
    note_permuted(found.permuted, result);
  }
  result.states = found.search.states;
  result.fault = std::move(found.search.fault);
  switch (found.search.end) {
    case SearchEnd::Exhausted:
      result.outcome = Outcome::Holds;
      result.evidence = StateCount{};
      break;
    case SearchEnd::Found:
      BIP_ASSERT(!found.stuck.empty(), "a local deadlock of no atom after {} steps", found.search.choices.size());
      result.outcome = Outcome::Violated;
      result.evidence = Counterexample{std::move(found.search.choices), std::move(found.stuck)};
      break;
    case SearchEnd::Limit: result.reason = limit_reason(found.search.limit, found.search.states); break;
  }
  return result;
}

}  // namespace

const Engine kFirstSearchEngine{"first search", may_search, search_first};
const Engine kRandomRunsEngine{"random runs", may_search, run_some};
const Engine kExhaustiveEngine{"exhaustive search", may_search, search_all};
const Engine kLocalDeadlockEngine{"local deadlock search",
                                  [](const ProofContext& context) {
                                    return context.question.what == QuestionKind::NoLocalDeadlock &&
                                           context.parts.is_searchable();
                                  },
                                  search_local_deadlock};

std::string list_reached_states(ProofContext& context, const CancellationToken& cancellation) {
  // The search itself takes its share beside.
  StateCollector states(context.parts.system(), context.parts.image(), context.limits.megabytes * 500'000);
  if (!states.is_listable()) return {};
  const SearchLimits limits{.cancellation = cancellation,
                            .megabytes = context.limits.megabytes,
                            .report = {},
                            .visit = [&](const rt::State& state) { states.add(state); }};
  const SearchResult all = search(context.parts.net(), context.parts.image(), {}, {}, limits);
  return all.end == SearchEnd::Exhausted ? states.rows() : std::string();
}

}  // namespace bip::verify
