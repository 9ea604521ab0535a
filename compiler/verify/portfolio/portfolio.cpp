// See portfolio.hpp. The order is by cost: most models are decided before the next engine is asked.
#include "compiler/verify/portfolio/portfolio.hpp"

#include <algorithm>
#include <atomic>

#include "compiler/verify/portfolio/local_deadlock_search.hpp"
#include "compiler/verify/symbolic/replay_steps.hpp"
#include "compiler/verify/invariants/houdini.hpp"
#include "compiler/verify/symbolic/mode_signals.hpp"
#include "compiler/verify/invariants/refine_invariants.hpp"
#include "compiler/verify/evidence/counterexample_text.hpp"
#include "runtime/explore/explore.hpp"

namespace bip::verify {

namespace {
// The first search is a second's work at most: states times what is in one.
constexpr std::uint64_t kFirstStates = 20000, kFirstValues = 4000000;
// Lemmas and the visit of all states take turns, each turn longer: a share of the time that is left, at most so many
// seconds.
struct Turn {
  double share, seconds;
};
constexpr Turn kTurns[] = {{1.0 / 64, 1}, {1.0 / 12, 6}};
// Once all states are known to be fine, lemmas are a shorter evidence than they are, but not at any price.
constexpr double kLemmaSeconds = 4;
std::string state_count(std::uint64_t count) { return std::to_string(count) + (count == 1 ? " state" : " states"); }

// Empty if the steps end in none.
std::string fault_at(const rt::Image& image, const std::vector<std::uint64_t>& choices) {
  rt::Core core(image);
  bool goes_on = core.initialize();
  for (std::size_t k = 0; k < choices.size() && goes_on; ++k)
    goes_on = choices[k] < core.candidate_count() && core.fire(choices[k]);
  return goes_on ? std::string() : std::string(core.fault().what);
}
}  // namespace

bool Portfolio::ready() {
  if (!can_run_ || cannot_prepare_) return false;
  if (!is_ready_) is_ready_ = prepare_();
  cannot_prepare_ = !is_ready_;
  return is_ready_;
}

void Portfolio::add_reason(const std::string& reason) { d_.reason += (d_.reason.empty() ? "" : "; ") + reason; }

// With values that come from outside in the modes, where transfers say which they are. True: proved.
bool Portfolio::look_at_uses() {
  has_seen_uses_ = true;
  PortUses uses = find_port_uses(net_);
  if (!uses.has_some) return false;
  told_ = build_net(net_, uses, UsesAs::Ports);
  if (told_->too_large_atom == kNoRow) {
    const CancellationToken end = limits_.cancellation.within(limits_.cancellation.seconds_left() / 4);
    Proof proof = prove_deadlock_freedom(
        *told_, end, [](const std::vector<u32>&) { return true; }, invariants_of(known_, *told_, true));
    if (proof.end == ProofEnd::Free) {
      if (wants_needed(ProofMethod::Told, proof)) minimize_invariants(*told_, end, proof);
      note_found(ProofMethod::Told, *told_, proof);
      // What no certificate has a form for is left to the other engines where one is wanted.
      if (limits_.wants_certificate) evidence_ = find_evidence(net_, *told_, proof);
      if (evidence_ || !limits_.wants_certificate) {
        d_.proof = std::move(proof);
        d_.outcome = Outcome::Holds;
        return true;
      }
    }
  }
  told_.reset();
  return false;
}

// Modes, traps, one-token invariants; of deadlock-freedom they may be all that is needed.
void Portfolio::look_at_structure() {
  if (net_.too_large_atom != kNoRow) return;
  d_.has_structure = true;
  const std::vector<TokenInvariant> known = invariants_of(known_, net_, false);
  if (question_.what != QuestionKind::DeadlockFreedom) {
    d_.proof = find_reachable_modes(net_, known);
    return;
  }
  report_("invariants", 0, "candidates");
  // What was proved otherwise before is likely to be again.
  const bool is_for_later = known_.way == ProofMethod::Plain || known_.way == ProofMethod::Induction;
  if (!is_for_later && look_at_uses()) return;
  d_.proof = prove_deadlock_freedom(
      net_, limits_.cancellation,
      [&](const std::vector<u32>& candidate) {
        if (!ready()) return false;
        const SearchLimits limits{
            .cancellation = limits_.cancellation, .megabytes = limits_.megabytes, .only_walk = true, .report = {}};
        SearchResult found = search(net_, image_, goal_of(question_), candidate, limits);
        if (found.end != SearchEnd::Found) return false;
        d_.outcome = Outcome::Violated;
        d_.choices = std::move(found.choices);
        return true;
      },
      known);
  if (d_.proof.end != ProofEnd::Free) return;
  d_.outcome = Outcome::Holds;
  if (wants_needed(ProofMethod::Plain, d_.proof)) minimize_invariants(net_, limits_.cancellation, d_.proof);
  note_found(ProofMethod::Plain, net_, d_.proof);
}

Portfolio::Tried Portfolio::try_search(std::uint64_t states) {
  if (!limits_.may_search || is_exhausted_ || !ready()) return Tried::Open;
  const SearchLimits limits{.cancellation = limits_.cancellation,
                            .megabytes = limits_.megabytes,
                            .states = states,
                            .report = [&](std::uint64_t count) { report_("search", count, "states"); }};
  SearchResult found = search(net_, image_, goal_of(question_), d_.proof.candidate, limits);
  d_.states = found.states;
  if (question_.what != QuestionKind::NoErrors && !found.fault.empty()) d_.fault = found.fault;
  if (found.end == SearchEnd::Found) {
    d_.outcome = Outcome::Violated;
    d_.choices = std::move(found.choices);
    return Tried::Done;
  }
  if (found.end == SearchEnd::Exhausted) {
    d_.outcome = Outcome::Holds;
    d_.method = Method::Exhaustive;
    is_exhausted_ = true;
    return Tried::Done;
  }
  if (states == ~std::uint64_t{0}) {
    add_reason("the search met its limit of " + found.limit + " after " + state_count(found.states));
  }
  return Tried::Open;
}

// The explorer stores states in a tenth of the memory and visits many times as many a second.
Portfolio::Tried Portfolio::try_all_states(double seconds) {
  if (!limits_.may_search || is_exhausted_ || is_memory_over_ || !ready()) return Tried::Open;
  const bool asks_errors = question_.what == QuestionKind::NoErrors, asks_state = question_.what == QuestionKind::State;
  std::atomic<bool> is_found{false};
  const CancellationToken end = limits_.cancellation.within(seconds);
  rt::ExploreOptions options;
  options.threads = limits_.threads;
  // 0 would be no limit.
  options.bytes = std::max<std::size_t>(limits_.megabytes * 1000000, 1);
  options.on_progress = [&](const rt::ExploreProgress& so_far) {
    report_("search", so_far.states, "states");
    if ((asks_errors ? so_far.errors : asks_state ? so_far.matches : so_far.deadlocks) != 0) is_found = true;
  };
  if (asks_state) {
    options.predicate = goal_of(question_).state;
    options.predicate_reads = atoms_of(question_.property);
    options.predicate_connectors = connectors_of(question_.property);
  }
  options.is_stopped = [&] { return is_found || end.is_over(); };
  rt::ExploreReport all = rt::explore_states(image_, options);
  d_.states = all.states;
  if (!asks_errors && all.has_error && d_.fault.empty()) d_.fault = fault_at(image_, all.error);
  const bool has_bad = asks_errors ? all.has_error : asks_state ? all.has_match : all.has_deadlock;
  if (has_bad && all.are_paths_known) {
    d_.choices = std::move(asks_errors ? all.error : asks_state ? all.match : all.deadlock);
    if (reaches(image_, goal_of(question_), d_.choices)) {
      d_.outcome = Outcome::Violated;
      return Tried::Done;
    }
    d_.choices.clear();
    add_reason("a way that was found could not be replayed");
    return Tried::Open;
  }
  if (all.end == rt::ExploreEnd::Complete && !has_bad) {
    d_.outcome = Outcome::Holds;
    d_.method = Method::Exhaustive;
    is_exhausted_ = true;
    return Tried::Done;
  }
  // What a longer turn would do again.
  is_memory_over_ = all.end == rt::ExploreEnd::Memory;
  if (is_memory_over_ || is_stopped())
    add_reason(std::string("the search met its limit of ") + (is_memory_over_ ? "memory" : "time") + " after " +
               state_count(all.states));
  return Tried::Open;
}

// All states are fine: lemmas of a proof, or, for a certificate, the states themselves.
void Portfolio::look_for_evidence() {
  d_.reason.clear();
  if (d_.outcome == Outcome::Violated || !limits_.wants_few) return;
  const bool is_proved = try_induction(std::min(limits_.cancellation.seconds_left() / 2, kLemmaSeconds)) == Tried::Done;
  if (!is_proved && limits_.wants_certificate) {
    StateCollector states(system_, image_);
    const SearchLimits limits{.cancellation = limits_.cancellation,
                              .megabytes = limits_.megabytes,
                              .report = {},
                              .visit = [&](const rt::State& state) { states.add(state); }};
    if (states.can_tell() && search(net_, image_, {}, {}, limits).end == SearchEnd::Exhausted)
      d_.reached = states.rows();
    d_.is_only_counted = d_.reached.empty();
  }
  d_.reason.clear();
}

// Only a visit of all states decides it.
void Portfolio::look_for_stuck() {
  if (!can_run_) d_.reason = "the model calls C++, whose state cannot be searched";
  if (!ready()) return;
  const SearchLimits limits{.cancellation = limits_.cancellation,
                            .megabytes = limits_.megabytes,
                            .report = [&](std::uint64_t count) { report_("search", count, "states"); }};
  LocalDeadlockResult result = find_local_deadlock(net_, image_, limits);
  d_.states = result.search.states;
  d_.fault = result.search.fault;
  d_.method = Method::Exhaustive;
  switch (result.search.end) {
    case SearchEnd::Exhausted: d_.outcome = Outcome::Holds; break;
    case SearchEnd::Found:
      d_.outcome = Outcome::Violated;
      d_.choices = std::move(result.search.choices);
      d_.stuck = std::move(result.stuck);
      break;
    case SearchEnd::Limit:
      add_reason("the search met its limit of " + result.search.limit + " after " + state_count(d_.states));
      break;
  }
}

std::vector<std::vector<Signal>> Portfolio::linear_clauses() {
  std::vector<std::vector<Signal>> clauses;
  for (const AffineEquation& equation : d_.linear.equations)
    clauses.push_back({equation_signal(equation, *machine_, image_)});
  for (const VariableBound& bound : d_.linear.bounds) clauses.push_back({bound_signal(bound, *machine_, image_)});
  for (const PlaceValue& one : d_.linear.places) clauses.push_back(place_clause(one, *machine_, image_));
  return clauses;
}

std::vector<std::vector<Signal>> Portfolio::structural_clauses() {
  if (!d_.has_structure) return {};
  std::vector<std::vector<Signal>> clauses = mode_clauses(net_, d_.proof, *machine_, image_);
  for (std::vector<Signal>& fact : linear_clauses()) clauses.push_back(std::move(fact));
  return clauses;
}

// What was known of this very system, as far as it holds. Nothing: all are found anew.
std::optional<AffineInvariants> Portfolio::known_facts(const CancellationToken& cancellation) {
  if (memory_ == nullptr || !memory_->counts.is_whole || known_.equations.empty()) return std::nullopt;
  AffineInvariants facts = equations_that_hold(net_, *machine_, image_, equations_of(known_), cancellation);
  memory_->counts.equations = facts.equations.size();
  if (!known_.uses_bounds) return with_totals(*machine_, image_, std::move(facts));
  return with_bounds(net_, *machine_, image_, structural_clauses(), cancellation, std::move(facts));
}

// First without the bounds, a certificate is easier to check without; unless they are known to be needed.
bool Portfolio::is_proved_with(AffineInvariants facts, const Ic3Problem& problem, bool needs_bounds) {
  for (const bool with_bounds : {false, true}) {
    if (with_bounds ? facts.bounds.empty() : needs_bounds && !facts.bounds.empty()) continue;
    d_.linear = with_bounds ? facts : AffineInvariants{facts.equations, {}, facts.places};
    const std::vector<std::vector<Signal>> known = linear_clauses();
    if (!refine_invariants(net_, *machine_, image_, problem.bad, known, problem.cancellation, d_.proof)) continue;
    if (wants_needed(ProofMethod::Induction, d_.proof))
      minimize_invariants(net_, *machine_, image_, problem.bad, known, limits_.cancellation, d_.proof);
    note_found(ProofMethod::Induction, net_, d_.proof);
    d_.outcome = Outcome::Holds;
    d_.method = Method::Induction;
    return true;
  }
  return false;
}

Portfolio::Tried Portfolio::try_induction(double seconds, Effort effort) {
  if (is_stopped() || induction_failed_) return Tried::Open;
  if (!machine_) machine_ = build_transition_system(system_, image_);
  if (!machine_->unsupported.empty()) {
    induction_failed_ = true;
    add_reason(machine_->unsupported);
    return Tried::Open;
  }
  if (machine_->starts_with_fault) {
    induction_failed_ = true;
    return Tried::Open;
  }
  Ic3Problem problem;
  problem.machine = &*machine_;
  Signal bad = machine_->stuck;
  if (question_.what == QuestionKind::NoErrors) bad = machine_->error;
  if (question_.what == QuestionKind::State) bad = broken_signal(question_.property, *machine_, image_);
  problem.bad = machine_->circuit.make_or(bad, machine_->lost);
  problem.cancellation = limits_.cancellation.within(seconds);
  problem.report = [&](u32 frame, std::size_t lemmas) {
    d_.frames = frame;
    report_("induction", lemmas, "lemmas");
  };
  are_ranges_confirmed_ = are_ranges_confirmed_ || ranges_hold(*machine_, problem.cancellation);
  if (!are_ranges_confirmed_) {
    induction_failed_ = true;
    add_reason("the ranges of data could not be confirmed");
    return Tried::Open;
  }
  InductiveLemmas known;
  if (d_.has_structure && !is_strengthened_) {
    report_("invariants", d_.proof.invariants.size(), "found");
    is_strengthened_ = true;
    // Equations of an earlier proof first: with its lemmas they are mostly enough.
    if (std::optional<AffineInvariants> facts = known_facts(problem.cancellation)) {
      if (is_proved_with(std::move(*facts), problem, known_.uses_bounds)) return Tried::Done;
      problem.invariants = structural_clauses();
      known = houdini(problem, lemmas_of(known_, *machine_));
    }
    if (!known.is_enough) {
      d_.linear = {};
      if (is_proved_with(find_affine_invariants(net_, *machine_, image_, structural_clauses(), problem.cancellation),
                         problem, false))
        return Tried::Done;
    }
  }
  if (effort == Effort::Facts && !known.is_enough) return Tried::Open;
  problem.invariants = structural_clauses();
  if (!known.is_enough && !lemmas_mislead_) known = houdini(problem, lemmas_of(known_, *machine_));
  if (memory_ != nullptr) memory_->counts.lemmas = known.lemmas.size();
  for (const Cube& cube : known.lemmas) problem.invariants.push_back(clause_of(cube, *machine_));
  Ic3Answer answer;
  if (known.is_enough) answer.end = Ic3End::Safe;
  else answer = run_ic3(problem);
  d_.frames = answer.frames;
  if (answer.end == Ic3End::Safe) {
    d_.outcome = Outcome::Holds;
    d_.method = Method::Induction;
    d_.lemmas = std::move(known.lemmas);
    d_.lemmas.insert(d_.lemmas.end(), answer.lemmas.begin(), answer.lemmas.end());
    note_found(ProofMethod::Induction, net_, d_.proof);
    return Tried::Done;
  }
  if (answer.end == Ic3End::Stopped) {
    // True as they are, they may lead away from those that are enough: the next time without.
    lemmas_mislead_ = !known.lemmas.empty();
    return Tried::Open;
  }
  induction_failed_ = true;
  if (!ready()) {
    add_reason(can_run_ ? "a way to it exists, but no code to replay it"
                        : "a way to such a state exists if C++ gives the right values: it cannot be replayed");
    return Tried::Open;
  }
  std::optional<std::vector<std::uint64_t>> choices = replay_steps(image_, *machine_, answer.steps);
  if (choices && question_.what == QuestionKind::NoErrors && !reaches(image_, goal_of(question_), *choices) &&
      answer.bad_step != kNoRow) {
    std::vector<u32> steps = answer.steps;
    rt::Core core(image_);
    bool is_there = core.initialize();
    for (std::uint64_t k : *choices) is_there = is_there && core.fire(k);
    if (is_there) {
      if (const std::optional<std::uint64_t> last = candidate_of(core, machine_->steps[answer.bad_step]))
        choices->push_back(*last);
    }
  }
  // A step that ends in an error in the state that it leads to.
  if (choices && !reaches(image_, goal_of(question_), *choices)) choices.reset();
  if (!choices && question_.what == QuestionKind::NoErrors) choices = replay_to_fault(image_, *machine_, answer.steps);
  if (!choices || !reaches(image_, goal_of(question_), *choices)) {
    add_reason("a way that the abstraction allows does not exist in the engine");
    return Tried::Open;
  }
  d_.outcome = Outcome::Violated;
  d_.choices = std::move(*choices);
  return Tried::Done;
}

void Portfolio::decide_in_order() {
  look_at_structure();
  if (d_.outcome != Outcome::Unknown) return;
  // What each engine gets of the time that is left.
  if (try_search(std::min(kFirstStates, kFirstValues / (image_.atoms.size + image_.cell_count + 1) + 1)) == Tried::Done)
    return look_for_evidence();
  const double left = limits_.cancellation.seconds_left();
  if (try_induction(can_run_ ? left / 3 : left, Effort::Facts) == Tried::Done) return;
  // A few hundred thousand states are visited sooner than lemmas count to a hundred; other systems have few lemmas and
  // no end of states.
  for (const Turn& turn : kTurns) {
    const double seconds = std::min(left * turn.share, turn.seconds);
    if (is_stopped() || !can_run_ || !limits_.may_search) break;
    if (try_all_states(seconds) == Tried::Done) return look_for_evidence();
    if (try_induction(seconds) == Tried::Done) return;
  }
  if (try_induction(can_run_ ? left / 3 : left) == Tried::Done) return;
  if (d_.has_structure && question_.what == QuestionKind::DeadlockFreedom && !has_seen_uses_ && look_at_uses()) return;
  if (!is_stopped() && try_all_states(limits_.cancellation.seconds_left()) == Tried::Done) return look_for_evidence();
  // The search gave up for memory: what is left of the time belongs to the proof.
  if (!is_stopped() && try_induction(limits_.cancellation.seconds_left()) == Tried::Done) return;
  if (limits_.cancellation.is_cancelled()) d_.reason = "interrupted";
  else if (is_stopped() && d_.reason.empty()) d_.reason = "the time is over";
  else if (d_.reason.empty()) d_.reason = "no engine has an answer";
  if (!can_run_) add_reason("the model calls C++, whose state cannot be searched");
}

Decision Portfolio::decide(const Question& question, const PortfolioLimits& limits) {
  question_ = question;
  limits_ = limits;
  d_ = {};
  told_.reset();
  evidence_.reset();
  is_exhausted_ = induction_failed_ = is_strengthened_ = are_ranges_confirmed_ = has_seen_uses_ = is_memory_over_ =
      false;
  if (question.what == QuestionKind::NoLocalDeadlock) {
    look_for_stuck();
    return std::move(d_);
  }
  recall();
  if (try_known() == Tried::Open) decide_in_order();
  keep_found();
  return std::move(d_);
}

std::string imprecision_text(const TransitionSystem& machine, const System& system, std::size_t count) {
  std::string text;
  for (const Imprecision& one : machine.imprecisions) {
    if (count-- == 0) return text + "  …\n";
    text += "  ";
    if (one.loc.line != 0 && one.loc.file < system.files.size())
      text += system.files[one.loc.file] + ':' + std::to_string(one.loc.line) + ": ";
    text += one.what + '\n';
  }
  return text;
}

}  // namespace bip::verify
