// See learn_lemmas.hpp.
#include "compiler/verify/scaling/learn_lemmas.hpp"

#include <algorithm>

#include "compiler/base/log.hpp"
#include "compiler/system/inner_priorities.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/invariants/affine_bounds.hpp"
#include "compiler/verify/invariants/houdini.hpp"
#include "compiler/verify/portfolio/bad_states.hpp"
#include "compiler/verify/symbolic/mode_signals.hpp"

namespace bip::verify {

namespace {

// From this size on templates are tried; so many at most.
constexpr std::uint32_t kSizeOfTemplates = 6;
constexpr std::size_t kMostTemplates = 4000;

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

LearnStep LemmaLearner::learn_at(std::uint32_t size, const CancellationToken& cancellation) {
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
  const std::optional<InstanceView> view = view_instance(*instance->system, *families_, system_, *dimensions_);
  if (!view) return LearnStep::Failed;
  const std::optional<Question> asked =
      question_at(question_, system_, *families_, *dimensions_, *instance->system, *view);
  if (!asked) return LearnStep::Skipped;
  TransitionSystem machine = build_transition_system(*instance->system, *instance->image, megabytes_);
  if (!machine.unsupported.empty() || machine.starts_with_fault || !ranges_hold(machine, cancellation))
    return LearnStep::Failed;
  Ic3Problem problem;
  problem.system = &machine;
  problem.bad = machine.aig.make_or(bad_states(*asked, machine, *instance->image), machine.lost);
  problem.invariants = found_at_once(*instance->system, *instance->image, machine, cancellation);
  problem.cancellation = cancellation;
  InductiveLemmas known = filter_patterns(problem, *view);
  // Lemmas that say nothing of the next size: templates are tried instead.
  if (size >= kSizeOfTemplates && known.lemmas.empty() && !has_templates_) {
    has_templates_ = add_templates(machine, *view, *dimensions_, kMostTemplates, patterns_);
    if (has_templates_) known = filter_patterns(problem, *view);
  }
  if (known.is_enough) {
    find_needed(problem, *view);
    return LearnStep::Enough;
  }
  for (const Cube& cube : known.lemmas) problem.invariants.push_back(clause_of(cube, machine));
  const Ic3Answer answer = run_ic3(problem);
  if (answer.end != Ic3End::Safe) return LearnStep::Failed;
  for (const Cube& cube : answer.lemmas) add_patterns(cube, machine, *view, *dimensions_, patterns_);
  BIP_LOG(Ic3, 1, "size {}: {} lemmas, {} patterns", size, answer.lemmas.size(), patterns_.size());
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

void LemmaLearner::find_needed(const Ic3Problem& problem, const InstanceView& view) {
  needed_.assign(patterns_.begin(), patterns_.end());
  const auto instances = [&](const std::vector<LemmaPattern>& patterns) {
    std::vector<Cube> cubes;
    for (PatternInstance& instance : instantiate(patterns, *problem.system, view, *dimensions_))
      cubes.push_back(std::move(instance.cube));
    return cubes;
  };
  std::stable_sort(needed_.begin(), needed_.end(), [&](const LemmaPattern& a, const LemmaPattern& b) {
    return literal_estimate(a, *large_view_) < literal_estimate(b, *large_view_);
  });
  // The most special ones first: several of them may do at this size what one does at all sizes.
  for (std::size_t k = 0; k < needed_.size() && !problem.cancellation.is_over();) {
    std::vector<LemmaPattern> fewer = needed_;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(k));
    if (houdini(problem, instances(fewer)).is_enough) needed_ = std::move(fewer);
    else ++k;
  }
}

std::vector<Cube> LemmaLearner::candidates(const TransitionSystem& machine, PatternChoice choice) const {
  if (!large_view_) return {};
  const std::vector<LemmaPattern> all(patterns_.begin(), patterns_.end());
  std::vector<Cube> cubes;
  for (PatternInstance& instance :
       instantiate(choice == PatternChoice::All ? all : needed_, machine, *large_view_, *dimensions_))
    cubes.push_back(std::move(instance.cube));
  return cubes;
}

}  // namespace bip::verify
