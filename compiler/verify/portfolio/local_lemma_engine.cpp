// See local_lemma_engine.hpp.
#include "compiler/verify/portfolio/local_lemma_engine.hpp"

#include <algorithm>

#include "compiler/base/log.hpp"
#include "compiler/verify/invariants/local_lemmas.hpp"
#include "compiler/verify/portfolio/induction_engines.hpp"
#include "runtime/core/core.hpp"
#include "runtime/include/bip/prng.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Of 5,228 Houdini decided none in six seconds.
constexpr std::size_t kMostCandidates = 4'000;
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

EngineResult prove_by_local_lemmas(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  EngineResult none;
  none.retry = Retry::Pointless;
  if (!context.parts.has_code()) return none;
  const CancellationToken share = cancellation.within(budget.seconds);
  const LemmaSource candidates = [&](const TransitionSystem& machine) {
    // The samples of a bit are few bytes, but of all bits.
    if (machine.bits.size() * kSampledWords * sizeof(std::uint64_t) >
        context.limits.megabytes * (std::size_t{1} << 20) / 8)
      return std::vector<Cube>{};
    const SampledStates states = SamplingRun(context.parts.image(), machine).run(share);
    if (states.values.empty() || states.values[0].empty()) return std::vector<Cube>{};
    std::vector<Cube> cubes =
        find_local_candidates(machine, context.parts.net().graph.atom_of_port, states, kMostCandidates, share);
    BIP_LOG(Houdini, 1, "{} local candidates", cubes.size());
    return cubes;
  };
  EngineResult found = try_lemmas(context, {share.seconds_left()}, cancellation, candidates, LemmaReduction::ByShape);
  return found.outcome == Outcome::Unknown ? none : found;
}

}  // namespace

const Engine kLocalLemmaEngine{"local lemmas", has_neighbours, prove_by_local_lemmas};

}  // namespace bip::verify
