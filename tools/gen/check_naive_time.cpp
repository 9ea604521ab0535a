// Compares timed models with the oracle: states, clocks and candidates at every instant. For the engine's intervals: no
// truth value changes before the predicted instant, time may pass exactly as far as predicted, and each candidate is
// possible exactly until the predicted instant. The generator's random numbers choose delays, events and steps, so that
// the test does not depend on a policy.
#include "tools/gen/comparison.hpp"

namespace bip::gen {
namespace {

using Trouble = NaiveEngine::Trouble;
constexpr std::int64_t kForever = NaiveEngine::kForever;

class TimedComparison {
 public:
  TimedComparison(const Description& model, const rt::Image& image, std::uint64_t seed)
      : image_(image),
        naive_(model, 300, seed, atom_numbers(image)),
        core_(image),
        compare_(image, core_, naive_),
        random_(seed) {
    core_.seed_draws(seed);
  }
  [[nodiscard]] bool too_large() const { return naive_.too_large(); }

  std::string run(std::uint64_t steps, OracleCounts& counts) {
    bool sound = core_.initialize();
    for (std::uint64_t step = 0;; ++step) {
      const std::string at = fmt::format("oracle, state #{} at {} ns: ", step, naive_.now());
      if (naive_.trouble() == Trouble::Possible) return "";
      if (naive_.trouble() == Trouble::None) choices_ = naive_.candidates();
      if (naive_.trouble() == Trouble::Possible) return "";
      const bool fails = naive_.trouble() == Trouble::Sure;
      if (fails == sound)
        return at + (sound ? "the oracle expects a fault" : "unexpected fault: " + core_.fault().what);
      if (fails) return "";
      ++counts.states;
      std::string difference = compare_.states();
      if (difference.empty()) difference = compare_.candidates(choices_);
      if (difference.empty()) difference = intervals();
      if (naive_.trouble() == Trouble::Possible) return "";
      if (!difference.empty()) return at + difference;
      if (step == steps || !move(sound)) return "";
    }
  }

 private:
  // What the engine says of instants to come.
  std::string intervals() {
    std::vector<std::int64_t> ends, wanted;
    last_ = core_.time().wait_limit(ends);
    const std::int64_t limit = naive_.limit(choices_, wanted);
    if (last_ != limit) return fmt::format("time may pass to {}, the oracle says {}", last_, limit);
    for (std::uint64_t k = 0; k < ends.size(); ++k) {
      for (std::size_t c = 0; c < choices_.size(); ++c) {
        if (naive_.key_of(choices_[c]) == compare_.key(k) && wanted[c] != ends[k])
          return fmt::format("{} is possible until {}, the oracle says {}", compare_.key(k), ends[k], wanted[c]);
      }
    }
    const std::vector<std::set<std::string>> before = naive_.enabled_at(naive_.now());
    for (const std::int64_t instant : naive_.turning_points()) {
      if (instant >= core_.time().next_change()) break;
      const std::vector<std::set<std::string>> then = naive_.enabled_at(instant);
      if (then != before)
        return fmt::format("the next change is at {}, the oracle knows one at {}", core_.time().next_change(), instant);
    }
    for (std::size_t a = 0; a < naive_.states().size(); ++a) {
      if (naive_.states()[a].at_work != nullptr && naive_.states()[a].returns < core_.time().next_change())
        return "an action returns before the next change";
    }
    return "";
  }

  // A step, an event, or time passes. False: nothing is possible, now or later.
  bool move(bool& sound) {
    const std::int64_t next = core_.time().next_change();
    const bool may_wait = last_ > naive_.now() && (last_ != kForever || next != kForever || !choices_.empty());
    if (!core_.events().ports().empty() && random_.percent(20)) return deliver(sound);
    if (!choices_.empty() && (!may_wait || random_.percent(60))) return fire(sound);
    if (!may_wait) return !core_.events().ports().empty() && deliver(sound);
    std::int64_t to = std::min(next, last_);
    if (to == kForever) to = naive_.now() + 20'000'000;
    // To the very end, which is where things go wrong, or somewhere before.
    if (random_.percent(40))
      to = naive_.now() + 1 + static_cast<std::int64_t>(random_.next() % static_cast<std::uint64_t>(to - naive_.now()));
    sound = core_.time().advance(to);
    naive_.advance(to);
    return true;
  }

  bool fire(bool& sound) {
    const std::uint64_t k = random_.below(choices_.size());
    for (const Choice& choice : choices_) {
      if (naive_.key_of(choice) != compare_.key(k)) continue;
      naive_.fire(choice);
      break;
    }
    sound = core_.time().take(core_.position(k));
    return true;
  }

  bool deliver(bool& sound) {
    const auto row = static_cast<std::uint32_t>(random_.below(core_.events().ports().size()));
    const rt::EventPortRow& port = core_.events().ports()[row];
    const rt::Atom& atom = image_.atoms[port.atom];
    const rt::Port& declared = image_.atom_types[atom.type].ports[port.port];
    std::vector<rt::Cell> cells;
    std::vector<Value> values;
    for (const rt::Var& var : image_.port_types[declared.type].vars) {
      Value value;
      rt::Cell cell{0};
      const int number = random_.between(-3, 9);
      switch (var.type) {
        case rt::CellType::Int: value.type = Ty::Int, cell.bits = static_cast<std::uint32_t>(value.i = number); break;
        case rt::CellType::Bool: value.type = Ty::Bool, cell.i = value.i = number & 1; break;
        case rt::CellType::Float: value.type = Ty::Float, cell.f = value.f = 0.5 * number; break;
        case rt::CellType::String: value.type = Ty::String, cell.i = 0; break;
      }
      cells.push_back(cell);
      values.push_back(std::move(value));
    }
    sound = core_.events().deliver(row, cells.data());
    std::size_t a = 0;
    while (naive_.world().atoms[a].path != atom.path()) ++a;
    naive_.deliver(a, declared.name, std::move(values));
    return true;
  }

  const rt::Image& image_;
  NaiveEngine naive_;
  rt::Core core_;
  Comparison compare_;
  Prng random_;
  std::vector<Choice> choices_;
  std::int64_t last_ = 0;
};

}  // namespace

std::string check_naive_time(const Description& model, const rt::Image& image, std::uint64_t seed, std::uint64_t steps,
                             OracleCounts& counts) {
  auto comparison = std::make_unique<TimedComparison>(model, image, seed);
  if (!comparison->too_large()) return comparison->run(steps, counts);
  ++counts.too_large;
  return "";
}

}  // namespace bip::gen
