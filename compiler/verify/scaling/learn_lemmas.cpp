// See learn_lemmas.hpp.
#include "compiler/verify/scaling/learn_lemmas.hpp"

#include <algorithm>
#include <utility>

#include "compiler/base/log.hpp"
#include "compiler/system/inner_priorities.hpp"
#include "compiler/system/system_ids.hpp"
#include "compiler/verify/invariants/affine_bounds.hpp"
#include "compiler/verify/invariants/houdini.hpp"
#include "compiler/verify/invariants/inductive_core.hpp"
#include "compiler/verify/portfolio/bad_states.hpp"
#include "compiler/verify/symbolic/mode_signals.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// From this size on templates are tried; so many at most.
constexpr std::uint32_t kSizeOfTemplates = 5;
constexpr std::size_t kMostTemplates = 4000;
// How much larger the instance is for which patterns are left out.
constexpr std::uint32_t kSizesAbove = 2;

// What holds at any size and needs no candidate: reachable modes, equations, values at places.
std::vector<std::vector<Signal>> found_at_once(const System& system, const rt::Image& image, TransitionSystem& machine,
                                               const CancellationToken& cancellation) {
  if (!system::first_inner_priority(system).empty()) return {};
  const Net net = build_net(system);
  if (net.too_large_atom != kNoRow) return {};
  std::vector<std::vector<Signal>> clauses = mode_clauses(net, find_reachable_modes(net), machine, image);
  const AffineInvariants affine = find_affine_invariants(net, machine, image, clauses, cancellation);
  for (std::vector<Signal>& clause : affine_clauses(affine, machine, image)) clauses.push_back(std::move(clause));
  return clauses;
}

}  // namespace

LemmaLearner::LemmaLearner(const System& system, const Question& question, const SmallInstances& instances,
                           std::size_t megabytes)
    : system_(system),
      question_(question),
      instances_(instances),
      megabytes_(megabytes),
      families_(find_families(system)) {}

LearnStep LemmaLearner::build_at(std::uint32_t size, const CancellationToken& cancellation, SizedProblem& sized) {
  if (!families_) return LearnStep::Failed;
  const std::optional<SmallInstance> instance = instances_(size);
  if (!instance) return LearnStep::Skipped;
  if (!dimensions_) {
    const std::optional<IndexFamilies> small = find_families(*instance->system);
    if (!small) return LearnStep::Failed;
    dimensions_ = find_dimensions(*families_, system_, *small, *instance->system);
    if (!dimensions_ || dimensions_->count == 0) return LearnStep::Failed;
    large_view_ = view_instance(system_, *families_, system_, *dimensions_);
    if (!large_view_) return LearnStep::Failed;
  }
  std::optional<InstanceView> view = view_instance(*instance->system, *families_, system_, *dimensions_);
  if (!view) return LearnStep::Failed;
  sized.view = std::move(*view);
  const std::optional<Question> asked =
      question_at(question_, system_, *families_, *dimensions_, *instance->system, sized.view);
  if (!asked) return LearnStep::Skipped;
  sized.machine = build_transition_system(*instance->system, *instance->image, megabytes_);
  TransitionSystem& machine = sized.machine;
  if (!machine.unsupported.empty() || machine.starts_with_fault || !ranges_hold(machine, cancellation))
    return LearnStep::Failed;
  BIP_ASSERT(sized.view.lengths.size() == dimensions_->count, "{} lengths of {} dimensions", sized.view.lengths.size(),
             dimensions_->count);
  sized.problem.system = &machine;
  sized.problem.bad = machine.aig.make_or(bad_states(*asked, machine, *instance->image), machine.lost);
  sized.problem.invariants = found_at_once(*instance->system, *instance->image, machine, cancellation);
  sized.problem.cancellation = cancellation;
  return LearnStep::Grown;
}

LearnStep LemmaLearner::learn_at(std::uint32_t size, const CancellationToken& cancellation) {
  auto at_size = std::make_unique<SizedProblem>();
  SizedProblem& sized = *at_size;
  if (const LearnStep built = build_at(size, cancellation, sized); built != LearnStep::Grown) return built;
  Ic3Problem& problem = sized.problem;
  const std::set<LemmaPattern> learnt = patterns_;
  InductiveLemmas known = filter_patterns(problem, sized.view);
  // Lemmas that say too little of the next size: templates are tried beside them.
  if (!known.is_enough && size >= kSizeOfTemplates && !has_templates_) {
    has_templates_ = true;
    std::set<LemmaPattern> held = std::exchange(patterns_, learnt);
    if (add_templates(sized.machine, sized.view, *dimensions_, kMostTemplates, patterns_)) {
      InductiveLemmas with_templates = filter_patterns(problem, sized.view);
      BIP_LOG(Ic3, 1, "size {}: templates are {}", size, with_templates.is_enough ? "enough" : "not enough");
      if (with_templates.is_enough || known.lemmas.empty()) known = std::move(with_templates);
      else patterns_ = std::move(held);
    } else {
      patterns_ = std::move(held);
    }
  }
  if (known.is_enough) {
    enough_at_ = std::move(at_size);
    choose_size_above(size, cancellation);
    return LearnStep::Enough;
  }
  for (const Cube& cube : known.lemmas) problem.invariants.push_back(clause_of(cube, sized.machine));
  const Ic3Answer answer = run_ic3(problem);
  BIP_LOG(Ic3, 1, "size {}: {} lemmas, {} patterns held", size, answer.lemmas.size(), patterns_.size());
  if (answer.end != Ic3End::Safe) return LearnStep::Failed;
  for (const Cube& cube : answer.lemmas) add_patterns(cube, sized.machine, sized.view, *dimensions_, patterns_);
  return LearnStep::Grown;
}

// Returns what holds of the patterns' instances, and keeps the patterns of which some instance does.
InductiveLemmas LemmaLearner::filter_patterns(const Ic3Problem& problem, const InstanceView& view) {
  if (patterns_.empty()) return {};
  const std::vector<LemmaPattern> patterns(patterns_.begin(), patterns_.end());
  const std::vector<PatternInstance> guesses = instantiate(patterns, *problem.system, view, *dimensions_);
  std::vector<Cube> cubes;
  cubes.reserve(guesses.size());
  for (const PatternInstance& guess : guesses) cubes.push_back(guess.cube);
  InductiveLemmas known = houdini(problem, std::move(cubes));
  const std::set<Cube> held(known.lemmas.begin(), known.lemmas.end());
  patterns_.clear();
  for (const PatternInstance& guess : guesses) {
    if (!held.contains(guess.cube)) continue;
    for (const u32 row : guess.patterns) patterns_.insert(patterns[row]);
  }
  return known;
}

// Patterns are left out at a size above the one that they were learnt from, if they are enough there, too: at this one,
// patterns of a few elements may happen to cover all.
void LemmaLearner::choose_size_above(std::uint32_t size, const CancellationToken& cancellation) {
  auto above = std::make_unique<SizedProblem>();
  if (build_at(size + kSizesAbove, cancellation, *above) != LearnStep::Grown) return;
  const std::set<LemmaPattern> before = patterns_;
  if (filter_patterns(above->problem, above->view).is_enough) enough_at_ = std::move(above);
  else patterns_ = before;
}

// By unsat cores first; of what they leave, block by block: the greatest inductive subset grows with the candidates, so
// a block of patterns without which the rest is enough can go as a whole.
std::vector<LemmaPattern> LemmaLearner::needed(PatternChoice choice) const {
  BIP_ASSERT(enough_at_ != nullptr && enough_at_->problem.system == &enough_at_->machine,
             "{} patterns before they are enough", patterns_.size());
  std::vector<LemmaPattern> result(patterns_.begin(), patterns_.end());
  if (choice == PatternChoice::All) return result;
  std::stable_sort(result.begin(), result.end(), [&](const LemmaPattern& a, const LemmaPattern& b) {
    const double cost_a = literal_estimate(a, *large_view_), cost_b = literal_estimate(b, *large_view_);
    return choice == PatternChoice::Cheapest ? cost_a < cost_b : cost_a > cost_b;
  });
  const Ic3Problem& problem = enough_at_->problem;
  const auto cubes_of = [&](const std::vector<LemmaPattern>& patterns) {
    std::vector<Cube> cubes;
    for (PatternInstance& instance : instantiate(patterns, *problem.system, enough_at_->view, *dimensions_))
      cubes.push_back(std::move(instance.cube));
    return cubes;
  };
  // What of a pattern's instances does not hold at this size is no part of its group.
  const std::vector<Cube> held = houdini(problem, cubes_of(result)).lemmas;
  const std::set<Cube> holds(held.begin(), held.end());
  std::vector<std::vector<Cube>> groups;
  for (const LemmaPattern& pattern : result) {
    groups.push_back(cubes_of({pattern}));
    std::erase_if(groups.back(), [&](const Cube& cube) { return !holds.contains(cube); });
  }
  std::vector<LemmaPattern> of_core;
  for (std::size_t row : inductive_core(problem, groups)) of_core.push_back(result[row]);
  BIP_LOG(Ic3, 1, "{} of {} patterns are in a core", of_core.size(), result.size());
  result = std::move(of_core);
  // What is preferred less goes first.
  std::reverse(result.begin(), result.end());
  for (std::size_t block = (result.size() + 1) / 2; block > 0; block = block == 1 ? 0 : (block + 1) / 2) {
    for (std::size_t k = 0; k < result.size() && !problem.cancellation.is_over();) {
      std::vector<LemmaPattern> fewer = result;
      const auto begin = fewer.begin() + static_cast<std::ptrdiff_t>(k);
      fewer.erase(begin, begin + static_cast<std::ptrdiff_t>(std::min(block, result.size() - k)));
      if (!fewer.empty() && houdini(problem, cubes_of(fewer)).is_enough) result = std::move(fewer);
      else k += block;
    }
  }
  BIP_LOG(Ic3, 1, "{} of them are needed", result.size());
  return result;
}

std::vector<Cube> LemmaLearner::candidates(const TransitionSystem& machine, PatternChoice choice) {
  BIP_ASSERT(enough_at_ && large_view_, "patterns before they are enough");
  std::vector<LemmaPattern> patterns = needed(choice);
  std::sort(patterns.begin(), patterns.end());
  std::vector<Cube> cubes;
  // The same patterns by another choice have been tried.
  if (!tried_.insert(patterns).second) return cubes;
  for (PatternInstance& instance : instantiate(patterns, machine, *large_view_, *dimensions_))
    cubes.push_back(std::move(instance.cube));
  return cubes;
}

}  // namespace bip::verify
