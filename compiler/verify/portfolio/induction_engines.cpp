// See induction_engines.hpp.
#include "compiler/verify/portfolio/induction_engines.hpp"

#include "compiler/verify/invariants/affine_bounds.hpp"
#include "compiler/verify/portfolio/bad_states.hpp"
#include "compiler/verify/invariants/houdini.hpp"
#include "compiler/verify/invariants/inductive_core.hpp"
#include "compiler/verify/invariants/local_lemmas.hpp"
#include "compiler/verify/invariants/pair_lemmas.hpp"
#include "compiler/verify/invariants/refine_invariants.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/symbolic/cnf.hpp"
#include "compiler/verify/symbolic/localized_ic3.hpp"
#include "compiler/verify/symbolic/mode_signals.hpp"
#include "compiler/verify/symbolic/property_signal.hpp"
#include "compiler/verify/symbolic/replay_steps.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

/// FactsOnly: without lemmas. Guesses: only with the lemmas that the caller proposes. Pairs: searches for lemmas about
/// two atoms each. FewFollowed: about at most kFewFollowed atoms. Localized: about at most the fraction kMostFollowed
/// of the atoms. Lemmas: about all.
enum class Effort : std::uint8_t { FactsOnly, Guesses, Pairs, FewFollowed, Localized, Lemmas };

/// IC3 follows all atoms of systems with fewer atoms than kFewAtoms.
constexpr std::size_t kFewAtoms = 40;
/// The promises of the rover's rules need at most 11. A question that needs more mostly needs as many as there are:
/// each round adds two or three neighbours.
constexpr std::size_t kFewFollowed = 16;
constexpr double kMostFollowed = 0.5;

// One attempt of either engine. `share` ends the attempt, `whole_` the question.
class Induction {
 public:
  Induction(ProofContext& context, TransitionSystem& machine, const CancellationToken& share,
            const CancellationToken& whole)
      : context_(context), whole_(whole), machine_(machine), image_(context.parts.image()) {
    problem_.system = &machine_;
    problem_.cancellation = share;
    problem_.report = [this](u32 frame, std::size_t lemmas) {
      result_.frames = frame;
      context_.report("induction", lemmas, "lemmas");
    };
  }

  /// `guesses`: with the effort Guesses the lemmas to try.
  EngineResult run(Effort effort, const LemmaSource* guesses = nullptr,
                   LemmaReduction reduction = LemmaReduction::None) {
    if (!is_usable()) return std::move(result_);
    BIP_ASSERT((effort == Effort::Guesses) == (guesses != nullptr), "lemmas are proposed to effort {}", effort);
    problem_.bad = machine_.aig.make_or(bad_states(context_.question, machine_, image_), machine_.lost);
    if (!confirm_ranges()) return std::move(result_);
    if (effort == Effort::FewFollowed || effort == Effort::Localized) {
      const auto atoms = static_cast<double>(context_.parts.system().atoms.size());
      localize(effort == Effort::FewFollowed ? kFewFollowed : static_cast<std::size_t>(kMostFollowed * atoms));
      return std::move(result_);
    }
    InductiveLemmas cached;
    if (context_.facts.proof && context_.induction != InductionStage::InvariantsRefined && refine(cached))
      return std::move(result_);
    if (effort == Effort::FactsOnly && !cached.is_enough) return std::move(result_);
    if (effort == Effort::Guesses) try_guesses(*guesses, reduction);
    else if (effort == Effort::Pairs) find_pairs();
    else find_lemmas(std::move(cached));
    return std::move(result_);
  }

 private:
  void give_up(const std::string& reason) {
    context_.induction = InductionStage::Unusable;
    result_.retry = Retry::Pointless;
    result_.reason = reason;
  }
  bool is_usable() {
    if (!machine_.unsupported.empty()) give_up(machine_.unsupported);
    else if (machine_.starts_with_fault) give_up({});
    return context_.induction != InductionStage::Unusable;
  }
  // The intervals of data, which the circuit's widths rest on, are invariants: a question to the solver for each.
  bool confirm_ranges() {
    if (context_.induction != InductionStage::Untried) return true;
    if (ranges_hold(machine_, problem_.cancellation)) context_.induction = InductionStage::RangesConfirmed;
    else if (!problem_.cancellation.is_over()) give_up("the ranges of data could not be confirmed");
    else result_.reason = "the time was too short to confirm the ranges of data";
    return context_.induction == InductionStage::RangesConfirmed;
  }

  [[nodiscard]] std::vector<std::vector<Signal>> structural_clauses() {
    if (!context_.facts.proof) return {};
    std::vector<std::vector<Signal>> clauses =
        mode_clauses(context_.parts.net(), *context_.facts.proof, machine_, image_);
    for (std::vector<Signal>& clause : affine_clauses(context_.facts.affine, machine_, image_))
      clauses.push_back(std::move(clause));
    return clauses;
  }

  // Invariants for these bad states: with cached equations first, with their lemmas these mostly suffice. True: proved.
  bool refine(InductiveLemmas& cached) {
    context_.report("invariants", context_.facts.proof->invariants.size(), "found");
    context_.induction = InductionStage::InvariantsRefined;
    if (std::optional<AffineInvariants> affine = cached_affine()) {
      if (is_proved_with(std::move(*affine), context_.cached.uses_bounds)) return true;
      problem_.invariants = structural_clauses();
      cached = houdini(problem_, lemmas_of(context_.cached, machine_));
    }
    if (cached.is_enough) return false;
    context_.facts.affine = {};
    return is_proved_with(
        find_affine_invariants(context_.parts.net(), machine_, image_, structural_clauses(), problem_.cancellation),
        false);
  }
  // The cached equations of this very system, as far as they hold. Nothing: all are to be found anew.
  std::optional<AffineInvariants> cached_affine() {
    if (!context_.is_cached_system() || context_.cached.equations.empty()) return std::nullopt;
    const Net& net = context_.parts.net();
    AffineInvariants affine =
        equations_that_hold(net, machine_, image_, equations_of(context_.cached), problem_.cancellation);
    context_.cache->counts.equations = affine.equations.size();
    if (!context_.cached.uses_bounds) return with_totals(machine_, image_, std::move(affine));
    return with_bounds(net, machine_, image_, structural_clauses(), problem_.cancellation, std::move(affine));
  }
  // First without the bounds, since a certificate is easier to check without; unless they are known to be necessary.
  bool is_proved_with(AffineInvariants affine, bool needs_bounds) {
    const Net& net = context_.parts.net();
    Proof& proof = *context_.facts.proof;
    for (const bool with_bounds : {false, true}) {
      if (with_bounds ? affine.bounds.empty() : needs_bounds && !affine.bounds.empty()) continue;
      context_.facts.affine = with_bounds ? affine : AffineInvariants{affine.equations, {}, affine.places};
      const std::vector<std::vector<Signal>> clauses = affine_clauses(context_.facts.affine, machine_, image_);
      if (!refine_invariants(net, machine_, image_, problem_.bad, clauses, problem_.cancellation, proof)) continue;
      if (context_.wants_minimal(ProofMethod::Induction, proof))
        minimize_invariants(net, machine_, image_, problem_.bad, clauses, whole_, proof);
      prove({});
      return true;
    }
    return false;
  }
  // Contract of a proof, for small systems: the lemmas are inductive and leave no bad state.
  [[nodiscard]] bool suffice(const std::vector<Cube>& lemmas) const {
    constexpr std::size_t kMaxBits = 200;
    if (lemmas.empty() || machine_.bits.size() > kMaxBits) return true;
    Ic3Problem problem = problem_;
    problem.cancellation = {};
    const InductiveLemmas checked = houdini(problem, lemmas);
    return checked.is_enough && checked.lemmas.size() == lemmas.size();
  }
  void prove(std::vector<Cube> lemmas) {
    BIP_ASSERT(suffice(lemmas), "{} lemmas are not inductive, or leave a bad state", lemmas.size());
    context_.count_reused(context_.facts.proof ? *context_.facts.proof : Proof());
    result_.outcome = Outcome::Holds;
    result_.evidence = InductiveProof{std::move(lemmas)};
  }

  void try_guesses(const LemmaSource& guesses, LemmaReduction reduction) {
    problem_.invariants = structural_clauses();
    try_cubes(guesses(machine_), reduction);
  }
  void find_pairs() {
    problem_.invariants = structural_clauses();
    try_cubes(find_pair_lemmas(problem_, context_.parts.system()), LemmaReduction::ByShape);
  }
  void try_cubes(std::vector<Cube> cubes, LemmaReduction reduction) {
    InductiveLemmas held = houdini(problem_, std::move(cubes));
    if (!held.is_enough) return;
    if (reduction == LemmaReduction::ByShape && !held.lemmas.empty()) {
      const std::vector<std::vector<Cube>> groups = group_by_shape(held.lemmas, machine_, context_.parts.system());
      held.lemmas.clear();
      for (const std::size_t row : inductive_core(problem_, groups))
        held.lemmas.insert(held.lemmas.end(), groups[row].begin(), groups[row].end());
    }
    prove(std::move(held.lemmas));
  }

  // Is it false by the ranges of data and the places of automata alone?
  [[nodiscard]] bool is_never(Signal states) {
    if (states == kFalse) return true;
    Solver solver;
    Cnf cnf(machine_.aig, solver);
    cnf.add_state(machine_);
    cnf.add({states});
    return solver.solve(problem_.cancellation) == Answer::Unsatisfiable;
  }

  void localize(std::size_t max_atoms) {
    // Rows of internal transitions mostly end by themselves, and few guards have faults. Otherwise the bad states, or
    // each step, would depend on all components.
    problem_.bad = violating_signal(context_.question.property, machine_, image_);
    if (!is_never(machine_.lost)) problem_.bad = machine_.aig.make_or(problem_.bad, machine_.lost);
    const bool has_no_fault = is_never(machine_.state_fault);
    const auto clauses = [&] {
      std::vector<std::vector<Signal>> known = structural_clauses();
      if (has_no_fault) known.push_back({negated(machine_.state_fault)});
      return known;
    };
    problem_.invariants = clauses();
    const Net& net = context_.parts.net();
    std::optional<InvariantRefiner> refiner;
    const ExcludeStates exclude = [&](Signal states) {
      if (!context_.facts.proof) return false;
      Proof& proof = *context_.facts.proof;
      const std::size_t before = proof.invariants.size();
      if (!refiner) refiner.emplace(net, machine_, image_, problem_.cancellation, proof);
      const bool is_excluded = refiner->exclude(states);
      if (proof.invariants.size() == before) return false;
      problem_.invariants = clauses();
      return is_excluded;
    };
    LocalizedAnswer found = run_localized_ic3(problem_, machine_, net.graph.atom_of_port, max_atoms, exclude);
    result_.frames = found.answer.frames;
    if (!problem_.cancellation.is_over()) result_.retry = Retry::Pointless;
    if (found.answer.end == Ic3End::Safe) prove(std::move(found.answer.lemmas));
  }

  void find_lemmas(InductiveLemmas cached) {
    problem_.invariants = structural_clauses();
    if (!cached.is_enough && context_.cached_lemmas == CachedLemmaUse::Try)
      cached = houdini(problem_, lemmas_of(context_.cached, machine_));
    if (context_.cache != nullptr) context_.cache->counts.lemmas = cached.lemmas.size();
    for (const Cube& cube : cached.lemmas) problem_.invariants.push_back(clause_of(cube, machine_));
    Ic3Answer answer;
    if (cached.is_enough) answer.end = Ic3End::Safe;
    else answer = run_ic3(problem_);
    result_.frames = answer.frames;
    switch (answer.end) {
      case Ic3End::Safe: {
        // What was assumed of cached lemmas is shown with the others.
        BIP_ASSERT(problem_.invariants.size() >= cached.lemmas.size(), "{} of {} invariants are cached lemmas",
                   cached.lemmas.size(), problem_.invariants.size());
        problem_.invariants.resize(problem_.invariants.size() - cached.lemmas.size());
        std::vector<Cube> lemmas = std::move(cached.lemmas);
        lemmas.insert(lemmas.end(), answer.lemmas.begin(), answer.lemmas.end());
        return prove(std::move(lemmas));
      }
      case Ic3End::Stopped:
        context_.cached_lemmas = cached.lemmas.empty() ? CachedLemmaUse::Try : CachedLemmaUse::Skip;
        return;
      case Ic3End::Reached: return confirm_counterexample(answer);
    }
  }

  // The circuit over-approximates what floats and C++ do: only what the engine can take is a counterexample.
  void confirm_counterexample(const Ic3Answer& answer) {
    if (!context_.parts.has_code()) {
      return give_up(context_.parts.is_searchable() ? "a way to it exists, but no code to replay it"
                     : context_.parts.system().code.has_cpp()
                         ? "a way to such a state exists if C++ gives the right values: it cannot be replayed"
                         : "a way to such a state exists if the right numbers are drawn: it cannot be replayed");
    }
    const SearchGoal goal = goal_of(context_.question);
    BIP_ASSERT(answer.end == Ic3End::Reached, "an answer that reaches nothing, after {} frames", answer.frames);
    const bool asks_errors = context_.question.what == QuestionKind::NoErrors;
    std::optional<std::vector<std::uint64_t>> choices = replay_steps(image_, machine_, answer.steps);
    if (choices && asks_errors && answer.bad_step != kNoRow && !reaches(image_, goal, *choices)) {
      // The last step is the one that ends in the error.
      rt::Core core(image_);
      bool is_there = core.initialize();
      for (std::uint64_t k : *choices) is_there = is_there && core.fire(k);
      if (is_there) {
        if (const std::optional<std::uint64_t> last = candidate_of(core, machine_.steps[answer.bad_step]))
          choices->push_back(*last);
      }
    }
    // A step that ends in an error in the state that it leads to.
    if (choices && !reaches(image_, goal, *choices)) choices.reset();
    if (!choices && asks_errors) choices = replay_to_fault(image_, machine_, answer.steps);
    if (!choices || !reaches(image_, goal, *choices))
      return give_up("a way that the abstraction allows does not exist in the engine");
    result_.retry = Retry::Pointless;
    result_.outcome = Outcome::Violated;
    result_.evidence = Counterexample{std::move(*choices)};
  }

  ProofContext& context_;
  const CancellationToken& whole_;
  TransitionSystem& machine_;
  const rt::Image& image_;
  Ic3Problem problem_;
  EngineResult result_;
};

bool is_inductive(const ProofContext& context) {
  return context.question.what != QuestionKind::NoLocalDeadlock && context.induction != InductionStage::Unusable;
}

bool asks_of_many(const ProofContext& context) {
  return context.question.what == QuestionKind::State && context.parts.system().atoms.size() >= kFewAtoms &&
         is_inductive(context);
}

EngineResult attempt_induction(ProofContext& context, const Budget& budget, const CancellationToken& cancellation,
                               Effort effort, const LemmaSource* guesses = nullptr,
                               LemmaReduction reduction = LemmaReduction::None) {
  if (cancellation.is_over() || !is_inductive(context)) return {};
  // The circuit is not part of the attempt's share: it is built once for all attempts.
  TransitionSystem* const machine = context.parts.transition_system(context.limits.megabytes, cancellation);
  if (machine == nullptr) return {};
  return Induction(context, *machine, cancellation.within(budget.seconds), cancellation)
      .run(effort, guesses, reduction);
}

}  // namespace

EngineResult try_lemmas(ProofContext& context, const Budget& budget, const CancellationToken& cancellation,
                        const LemmaSource& guesses, LemmaReduction reduction) {
  return attempt_induction(context, budget, cancellation, Effort::Guesses, &guesses, reduction);
}

const Engine kFewFollowedEngine{"localized IC3", asks_of_many,
                                [](ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
                                  return attempt_induction(context, budget, cancellation, Effort::FewFollowed);
                                }};
const Engine kLocalizedEngine{"localized IC3", asks_of_many,
                              [](ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
                                return attempt_induction(context, budget, cancellation, Effort::Localized);
                              }};
const Engine kAffineEngine{"affine invariants", is_inductive,
                           [](ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
                             return attempt_induction(context, budget, cancellation, Effort::FactsOnly);
                           }};
const Engine kPairLemmaEngine{"pair lemmas",
                              [](const ProofContext& context) {
                                return is_inductive(context) &&
                                       context.parts.system().atoms.size() <= kMostAtomsOfPairs;
                              },
                              [](ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
                                EngineResult found = attempt_induction(context, budget, cancellation, Effort::Pairs);
                                if (found.outcome == Outcome::Unknown) found.retry = Retry::Pointless;
                                return found;
                              }};
const Engine kIc3Engine{"IC3", is_inductive,
                        [](ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
                          return attempt_induction(context, budget, cancellation, Effort::Lemmas);
                        }};

}  // namespace bip::verify
