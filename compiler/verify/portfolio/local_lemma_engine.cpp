// See local_lemma_engine.hpp.
#include "compiler/verify/portfolio/local_lemma_engine.hpp"

#include <algorithm>

#include "compiler/base/log.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/invariants/local_houdini.hpp"
#include "compiler/verify/invariants/local_lemmas.hpp"
#include "compiler/verify/portfolio/induction_engines.hpp"
#include "compiler/verify/symbolic/mode_signals.hpp"
#include "runtime/core/core.hpp"
#include "runtime/include/bip/prng.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Their number is linear in the connectors: a sliding window of 480 cells has 67,000.
constexpr std::size_t kMostCandidates = 100'000;
// Of 5,228 that were not filtered Houdini decided none in six seconds.
constexpr std::size_t kMostUnfiltered = 4'000;
constexpr double kSecondsOfUnfiltered = 6;
// So many words of 64 states are sampled; each interaction is fired about so often in all.
constexpr std::size_t kSampledWords = 64;
constexpr std::size_t kFirings = 16;
// Of more candidates those that were fired least are not looked for.
constexpr std::uint64_t kMostCompared = 64;

bool has_neighbours(const ProofContext& context) {
  return context.limits.may_search && context.parts.is_searchable() && kIc3Engine.applies_to(context);
}

// A run that comes round: every other step fires an interaction that was fired least so far. Drawn by equal chance,
// what a protocol repeats until it is heard is nearly all that happens.
class SamplingRun {
 public:
  SamplingRun(const rt::Image& image, const TransitionSystem& machine)
      : image_(image), machine_(machine), core_(image), fired_(core_.tables().interactions.size(), 0) {
    result_.values.resize(machine.bits.size());
  }

  SampledStates run(const CancellationToken& cancellation) {
    const std::size_t samples = kSampledWords * 64;
    const std::size_t stride = std::max<std::size_t>(1, kFirings * fired_.size() / samples);
    rt::Prng prng(1);
    bool goes_on = false;
    for (std::size_t step = 0; step < samples * stride && !cancellation.is_over(); ++step) {
      if (!goes_on && !core_.initialize()) break;
      if (step % stride == 0) add_sample(step / stride);
      goes_on = core_.candidate_count() != 0 && take_step(step % 2 == 0, prng);
    }
    return std::move(result_);
  }

 private:
  bool take_step(bool is_least_fired, rt::Prng& prng) {
    const std::uint64_t count = core_.candidate_count();
    std::uint64_t chosen = prng.below(count);
    if (is_least_fired) {
      const std::uint64_t first = chosen;
      u32 least = fired_[core_.position(chosen).interaction];
      for (std::uint64_t k = 1; k < std::min(count, kMostCompared) && least != 0; ++k) {
        const std::uint64_t other = (first + k) % count;
        if (const u32 fired = fired_[core_.position(other).interaction]; fired < least) {
          least = fired;
          chosen = other;
        }
      }
    }
    const rt::EnabledSet::Position at = core_.position(chosen);
    ++fired_[at.interaction];
    return core_.take(at);
  }
  void add_sample(std::size_t sample) {
    for (u32 row = 0; row < machine_.bits.size(); ++row) {
      const StateBit& bit = machine_.bits[row];
      const bool value = bit.is_place
                             ? core_.is_marked(bit.atom, bit.row)
                             : (core_.cell(image_.atoms[bit.atom].variable(bit.row)).bits >> bit.position & 1) != 0;
      if (sample % 64 == 0) result_.values[row].push_back(value ? ~std::uint64_t{0} : 0);
      // What follows of the word repeats the first state until it is sampled.
      std::uint64_t& word = result_.values[row].back();
      BIP_ASSERT(result_.values[row].size() == sample / 64 + 1, "sample {} is in word {}", sample,
                 result_.values[row].size() - 1);
      const std::uint64_t mask = std::uint64_t{1} << (sample % 64);
      word = value ? word | mask : word & ~mask;
    }
  }

  const rt::Image& image_;
  const TransitionSystem& machine_;
  rt::Core core_;
  IndexVector<rt::InteractionId, u32> fired_;
  SampledStates result_;
};

// What place invariants with one token exclude.
std::vector<Exclusion> find_exclusions(ProofContext& context) {
  std::vector<Exclusion> exclusions;
  if (!context.facts.proof) return exclusions;
  const Net& net = context.parts.net();
  const Proof& proof = *context.facts.proof;
  TransitionSystem* const machine = context.parts.transition_system(context.limits.megabytes, {});
  BIP_ENSURE(machine != nullptr, "without a limit of time the transition system is built");
  const ModeSignals modes = mode_signals(net, proof, *machine, context.parts.image());
  for (const TokenInvariant& invariant : proof.invariants) {
    bool is_one_token = invariant.kind != InvariantKind::Trap && invariant.total == 1;
    for (std::size_t k = 0; k < invariant.modes.size(); ++k)
      is_one_token = is_one_token && weight_of(invariant, k) == 1;
    if (!is_one_token) continue;
    Exclusion& exclusion = exclusions.emplace_back();
    for (const u32 mode : invariant.modes) {
      const u32 atom = net.atom_of_mode[mode];
      if (modes.modes[mode] != kFalse)
        exclusion.signals.push_back({atom, mode - net.mode_base[atom], modes.modes[mode]});
    }
  }
  return exclusions;
}

LocalQuestions local_questions(ProofContext& context, const TransitionSystem& machine) {
  LocalQuestions questions;
  questions.system = &machine;
  questions.atom_of_port = context.parts.net().graph.atom_of_port;
  questions.exclusions = find_exclusions(context);
  const System& system = context.parts.system();
  for (const Atom& atom : system.atoms) questions.type_of_atom.push_back(atom.type.value);
  const rt::Tables tables = rt::link(context.parts.image(), rt::MaximalProgress::On);
  for (const SystemStep& step : machine.steps) {
    questions.kind_of_step.push_back(
        tables.is_of_connector(step.interaction)
            ? system.connectors[ConnectorId(std::size_t{tables.connector_of(step.interaction)})].type.value
            : kNoRow);
  }
  return questions;
}

// A literal of no sampled state is a candidate by itself. If it is refuted, others with it are candidates.
std::vector<Cube> find_local_lemmas(ProofContext& context, const TransitionSystem& machine, const SampledStates& states,
                                    const CancellationToken& cancellation) {
  const LocalQuestions questions = local_questions(context, machine);
  std::vector<std::uint8_t> is_possible(2 * machine.bits.size(), 0);
  for (;;) {
    const std::vector<Cube> cubes =
        find_local_candidates(machine, questions.atom_of_port, states, is_possible, kMostCandidates, cancellation);
    std::vector<Cube> kept = keep_locally_inductive(questions, cubes, cancellation);
    if (cancellation.is_over()) return {};
    bool is_new = false;
    std::size_t at = 0;
    for (const Cube& cube : cubes) {
      const bool is_kept = at < kept.size() && kept[at] == cube;
      if (is_kept) ++at;
      if (is_kept || cube.size() != 1) continue;
      is_possible[cube[0]] = 1;
      is_new = true;
    }
    BIP_ASSERT(at == kept.size(), "{} of {} lemmas are candidates", at, kept.size());
    if (!is_new) return kept;
  }
}

// First with candidates that were filtered by parts; then, if they are few, with all of them.
EngineResult prove_by_local_lemmas(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  EngineResult none;
  none.retry = Retry::Pointless;
  if (!context.parts.has_code()) return none;
  const CancellationToken share = cancellation.within(budget.seconds);
  SampledStates states;
  const LemmaSource filtered = [&](const TransitionSystem& machine) {
    // The samples of a bit are few bytes, but of all bits.
    if (machine.bits.size() * kSampledWords * sizeof(std::uint64_t) <=
        context.limits.megabytes * (std::size_t{1} << 20) / 8)
      states = SamplingRun(context.parts.image(), machine).run(share);
    if (states.values.empty() || states.values[0].empty()) return std::vector<Cube>{};
    return find_local_lemmas(context, machine, states, share);
  };
  EngineResult found = try_lemmas(context, {share.seconds_left()}, cancellation, filtered, LemmaReduction::ByShape);
  if (found.outcome != Outcome::Unknown) return found;
  if (states.values.empty() || states.values[0].empty()) return none;
  const LemmaSource unfiltered = [&](const TransitionSystem& machine) {
    const std::vector<std::uint8_t> is_possible(2 * machine.bits.size(), 0);
    return find_local_candidates(machine, context.parts.net().graph.atom_of_port, states, is_possible, kMostUnfiltered,
                                 share);
  };
  found = try_lemmas(context, {std::min(share.seconds_left(), kSecondsOfUnfiltered)}, cancellation, unfiltered,
                     LemmaReduction::ByShape);
  return found.outcome == Outcome::Unknown ? none : found;
}

}  // namespace

const Engine kLocalLemmaEngine{"local lemmas", has_neighbours, prove_by_local_lemmas};

}  // namespace bip::verify
