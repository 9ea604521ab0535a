// A day of model time (tests/models/test_day.py): a timed model that takes each step as soon as it can is a machine
// with finitely many states, so its steps repeat. The period is found in the first steps; from then on every step must
// be the one of a period before, exactly a period later, to the nanosecond, until the day is over.
//
//   day HOURS [STEPS]      (0: however many) linked with the C++ of a model, compiled with BIP_NO_MAIN
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <unordered_map>
#include <vector>

#include "bip/bip.hpp"

namespace model {
const bip::rt::Image& image();
}

namespace {

struct Taken {
  std::uint32_t name;
  std::int64_t at;
};

// The smallest period of the second half of `steps`; 0: none.
std::size_t period_of(const std::vector<Taken>& steps) {
  const std::size_t from = steps.size() / 2;
  for (std::size_t q = 1; q <= from / 2; ++q) {
    const std::int64_t length = steps[from + q].at - steps[from].at;
    bool repeats = true;
    for (std::size_t k = from; repeats && k + q < steps.size(); ++k)
      repeats = steps[k].name == steps[k + q].name && steps[k + q].at - steps[k].at == length;
    if (repeats) return q;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return 2;
  constexpr std::size_t kLook = 4096;
  const std::uint64_t most =
      argc == 3 && std::atoll(argv[2]) != 0 ? static_cast<std::uint64_t>(std::atoll(argv[2])) : UINT64_MAX;
  const auto day = static_cast<std::int64_t>(std::atof(argv[1]) * 3600e9);
  bip::Execution system(model::image(), {.seed = 1, .policy = bip::rt::Policy::First, .asap = true});
  std::unordered_map<std::string, std::uint32_t> names;
  std::vector<Taken> steps;
  Taken now{};
  system.on_step([&](const bip::Step& step) {
    now.name = names.try_emplace(step.interaction, static_cast<std::uint32_t>(names.size())).first->second;
  });
  while (steps.size() < kLook && system.step() == bip::Outcome::Stepped) steps.push_back({now.name, system.now()});
  if (steps.size() < kLook) {
    std::printf("ends after %zu steps\n", steps.size());
    return system.outcome() == bip::Outcome::Fault ? 1 : 0;
  }
  const std::size_t period = period_of(steps);
  if (period == 0) {
    std::printf("no period in %zu steps\n", kLook);
    return 1;
  }
  // The last period, a ring.
  std::vector<Taken> last(steps.end() - static_cast<std::ptrdiff_t>(period), steps.end());
  const std::int64_t length = steps.back().at - steps[steps.size() - 1 - period].at;
  std::uint64_t count = kLook;
  for (std::size_t k = 0; system.now() < day && count < most; k = (k + 1) % period, ++count) {
    if (length == 0 || system.step() != bip::Outcome::Stepped) {
      std::printf("stops after %llu steps\n%s", static_cast<unsigned long long>(count), system.fault().c_str());
      return 1;
    }
    if (now.name != last[k].name || system.now() - last[k].at != length) {
      std::printf("step %llu at %lld ns is not the one of a period before\n", static_cast<unsigned long long>(count),
                  static_cast<long long>(system.now()));
      return 1;
    }
    last[k].at = system.now();
  }
  std::printf("%.2f h in %llu steps, %zu a period of %lld ns, to the nanosecond\n",
              static_cast<double>(system.now()) / 3600e9, static_cast<unsigned long long>(count), period,
              static_cast<long long>(length));
  return 0;
}
