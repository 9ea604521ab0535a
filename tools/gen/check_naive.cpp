// Compares the naive oracle with the runtime's core, state by state: every atom's places and data, every candidate. The
// generator's own random numbers choose the steps, so that the test does not depend on a policy.
#include "runtime/core/final_state.hpp"
#include "tools/gen/comparison.hpp"

namespace bip::gen {

std::string check_naive(const Description& model, const rt::Image& image, std::uint64_t seed, std::uint64_t steps,
                        OracleCounts& counts) {
  if (rt::has_time(image)) return check_naive_time(model, image, seed, steps, counts);
  using Trouble = NaiveEngine::Trouble;
  NaiveEngine naive(model, 300, seed, atom_numbers(image));
  if (naive.too_large()) {
    ++counts.too_large;
    return "";
  }
  rt::Core core(image);
  Comparison compare(image, core, naive);
  Prng random(seed);
  core.seed_draws(seed);
  bool sound = core.initialize();
  for (std::uint64_t step = 0;; ++step) {
    std::string at = "oracle, state #" + std::to_string(step) + ": ";
    if (naive.trouble() == Trouble::Possible) return "";
    std::vector<Choice> choices;
    if (naive.trouble() == Trouble::None) choices = naive.candidates();
    if (naive.trouble() == Trouble::Possible) return "";
    bool fails = naive.trouble() == Trouble::Sure;
    if (fails == sound) return at + (sound ? "the oracle expects a fault" : "unexpected fault: " + core.fault().what);
    if (fails) return "";
    ++counts.states;
    std::string difference = compare.states();
    if (difference.empty()) difference = compare.candidates(choices);
    if (!difference.empty()) return at + difference;
    if (naive.is_final() != rt::is_final_state(core))
      return at + (naive.is_final() ? "the oracle says that it is final" : "the oracle says that it is not final");
    if (choices.empty() || step == steps) return "";
    std::uint64_t k = random.below(choices.size());
    for (const Choice& choice : choices) {
      if (naive.key_of(choice) != compare.key(k)) continue;
      naive.fire(choice);
      break;
    }
    sound = core.fire(k);
  }
}

}  // namespace bip::gen
