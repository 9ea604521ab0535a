// Time in the oracle. Conditions on clocks are comparisons of numbers at one instant; predictions of the engine about
// whole intervals are checked at every instant at which a truth value may change.
#include <algorithm>

#include "runtime/include/bip/assert.hpp"
#include "tools/gen/naive.hpp"

namespace bip::gen {

bool NaiveEngine::holds_at(const AtomState& state, const std::vector<ClockBound>& when, std::int64_t instant) {
  return std::all_of(when.begin(), when.end(), [&](const ClockBound& b) {
    const ClockValue& clock = state.clocks.at(b.clock);
    std::int64_t value = value_at(clock, instant);
    if (!b.minus.empty()) value -= value_at(state.clocks.at(b.minus), instant);
    const std::int64_t limit = (b.limit_name.empty() ? b.limit : state.vars.at(b.limit_name).i) * clock.unit;
    if (b.op == "<") return value < limit;
    if (b.op == "<=") return value <= limit;
    if (b.op == ">") return value > limit;
    if (b.op == ">=") return value >= limit;
    return value == limit;
  });
}

bool NaiveEngine::invariants_hold_at(std::int64_t instant) const {
  for (std::size_t a = 0; a < states_.size(); ++a) {
    const AtomState& state = states_[a];
    if (state.at_work != nullptr) continue;
    for (const Invariant& i : world_.atoms[a].type->invariants) {
      const std::set<std::string> places(i.places.begin(), i.places.end());
      const bool concerns =
          i.scope == "at" ? places == state.marking
                          : std::includes(state.marking.begin(), state.marking.end(), places.begin(), places.end());
      if (concerns && !i.when.empty() && !holds_at(state, i.when, instant)) return false;
    }
  }
  return true;
}

void NaiveEngine::set_clocks(AtomState& state, const Transition& t) {
  // Speeds first: a clock that is set has its new value whatever it ran at.
  for (const bool speeds : {true, false}) {
    for (const ClockSet& s : t.sets) {
      if (s.is_speed != speeds) continue;
      ClockValue& clock = state.clocks.at(s.clock);
      clock.value = s.is_speed ? value_at(clock, now_) : s.value * clock.unit;
      clock.since = now_;
      if (s.is_speed) clock.speed = s.value;
    }
  }
}

void NaiveEngine::begin_resume(std::size_t atom, const Transition& t) {
  AtomState& state = states_[atom];
  BIP_ASSERT(state.at_work == nullptr, "atom {} resumes while its action is at work", atom);
  if (!t.resumes) return;
  state.busy_until = holds_at(state, t.resume, now_) ? now_ : kForever;
  // Turning points of this condition are among all of them.
  for (const std::int64_t instant : turning_points()) {
    if (state.busy_until == kForever && holds_at(state, t.resume, instant)) state.busy_until = instant;
  }
}

// The action, and everything after it that is not for others to see.
void NaiveEngine::finish(std::size_t atom, const Transition& t) {
  AtomState& state = states_[atom];
  const AtomType& type = *world_.atoms[atom].type;
  Place code{.generator = &state.generator};
  execute(
      t.action, [&state](const std::string&, const std::string& name) -> Value& { return state.vars.at(name); }, code);
  if (!code.fault) set_clocks(state, t);
  if (code.fault || !invariants_hold(state, type)) return trouble(Trouble::Sure);
  settle(atom);
  if (t.port.empty() || trouble_ != Trouble::None) return;
  begin_resume(atom, t);
  find_enabled(state, type);
}

void NaiveEngine::advance(std::int64_t to) {
  BIP_ASSERT(to >= now_, "time goes back from {} to {}", now_, to);
  now_ = to;
  for (std::size_t a = 0; a < states_.size() && trouble_ == Trouble::None; ++a) {
    if (const Transition* work = states_[a].at_work; work != nullptr && states_[a].returns <= to) {
      states_[a].at_work = nullptr;
      finish(a, *work);
    } else {
      find_enabled(states_[a], *world_.atoms[a].type);
    }
  }
  if (trouble_ == Trouble::None) refuse_events();
}

void NaiveEngine::deliver(std::size_t atom, const std::string& port, std::vector<Value> values) {
  states_[atom].events[port].push_back(std::move(values));
  find_enabled(states_[atom], *world_.atoms[atom].type);
  refuse_events();
}

// What waits at a port of which no transition is possible, whatever the atom's priorities say.
void NaiveEngine::refuse_events() {
  for (std::size_t a = 0; a < states_.size(); ++a) {
    const AtomType& type = *world_.atoms[a].type;
    for (auto& [port, waiting] : states_[a].events) {
      const std::string& policy = find_named(type.ports, port)->event;
      if (waiting.empty() || policy == "remember") continue;
      AtomState alone = states_[a];
      AtomType without = type;
      without.rules.clear();
      find_enabled(alone, without);
      if (alone.enabled.contains(port)) continue;
      if (policy == "error") return trouble(Trouble::Sure);
      waiting.clear();
    }
  }
}

std::set<std::int64_t> NaiveEngine::turning_points() const {
  std::set<std::int64_t> result;
  const auto add = [&](std::int64_t instant) {
    if (instant > now_ && instant != kForever) result.insert(instant);
  };
  for (std::size_t a = 0; a < states_.size(); ++a) {
    const AtomState& state = states_[a];
    const auto turn = [&](const std::vector<ClockBound>& when) {
      for (const ClockBound& b : when) {
        const ClockValue& clock = state.clocks.at(b.clock);
        std::int64_t value = value_at(clock, now_), speed = clock.speed;
        if (!b.minus.empty())
          value -= value_at(state.clocks.at(b.minus), now_), speed -= state.clocks.at(b.minus).speed;
        if (speed == 0) continue;
        const std::int64_t limit = (b.limit_name.empty() ? b.limit : state.vars.at(b.limit_name).i) * clock.unit;
        // Somewhere around here the comparison turns.
        const std::int64_t near = now_ + (limit - value) / speed;
        for (std::int64_t instant = near - 2; instant <= near + 2; ++instant) add(instant);
      }
    };
    for (const Transition& t : world_.atoms[a].type->transitions) {
      turn(t.when);
      turn(t.resume);
    }
    for (const Invariant& i : world_.atoms[a].type->invariants) turn(i.when);
    add(state.busy_until);
    if (state.at_work != nullptr) add(state.returns);
  }
  BIP_ASSERT(result.empty() || *result.begin() > now_, "a turning point at {}, which is past", *result.begin());
  return result;
}

std::vector<std::set<std::string>> NaiveEngine::enabled_at(std::int64_t instant) {
  std::vector<std::set<std::string>> result;
  const std::int64_t before = now_;
  now_ = instant;
  for (std::size_t a = 0; a < states_.size(); ++a) {
    AtomState state = states_[a];
    find_enabled(state, *world_.atoms[a].type);
    std::set<std::string>& ports = result.emplace_back();
    for (const auto& [port, transition] : state.enabled) ports.insert(port);
  }
  now_ = before;
  return result;
}

std::int64_t NaiveEngine::limit(const std::vector<Choice>& choices, std::vector<std::int64_t>& ends) {
  ends.assign(choices.size(), kForever);
  // An action that has returned may find an invariant broken: time stands, and intervals are what guards say all the
  // same.
  std::int64_t last = invariants_hold_at(now_) ? kForever : now_;
  bool is_eager = false;
  const std::set<std::int64_t> turns = turning_points();
  for (const std::int64_t instant : turns) {
    if (last == kForever && !invariants_hold_at(instant)) last = instant - 1;
  }
  for (std::size_t k = 0; k < choices.size(); ++k) {
    Leaves leaves = choices[k].leaves;
    if (leaves.empty()) leaves.insert({choices[k].atom, choices[k].port});
    bool is_delayable = false;
    for (const auto& [atom, port] : leaves) {
      const AtomState& state = states_[static_cast<std::size_t>(atom)];
      const Transition& t = *state.enabled.at(port);
      is_eager |= t.urgency == "eager";
      is_delayable |= t.urgency == "delayable";
      for (const std::int64_t instant : turns) {
        if (instant <= ends[k] && !holds_at(state, t.when, instant)) ends[k] = instant - 1;
      }
    }
    if (is_delayable) last = std::min(last, ends[k]);
  }
  BIP_ASSERT(last >= now_, "the last instant {} is before {}", last, now_);
  if (!is_eager && last > now_ && is_before_eager()) return now_;
  return is_eager ? now_ : last;
}

// A tick later, an eager candidate that `<` or `>` has excluded up to now.
bool NaiveEngine::is_before_eager() {
  for (const WorldAtom& atom : world_.atoms) {
    for (const Transition& t : atom.type->transitions) {
      if (t.is_async) return false;
    }
  }
  NaiveEngine later = *this;
  later.advance(now_ + 1);
  if (later.trouble_ != Trouble::None) return false;
  const std::vector<Choice> choices = later.candidates();
  if (later.trouble_ == Trouble::Sure) return false;
  return std::any_of(choices.begin(), choices.end(), [&](const Choice& choice) {
    Leaves leaves = choice.leaves;
    if (leaves.empty()) leaves.insert({choice.atom, choice.port});
    bool is_eager = false, is_open = false, is_free = true;
    for (const auto& [row, port] : leaves) {
      const AtomState& state = later.states_[static_cast<std::size_t>(row)];
      const Transition& t = *state.enabled.at(port);
      is_free &= state.busy_until <= now_;
      is_eager |= t.urgency == "eager";
      for (const ClockBound& b : t.when) is_open |= (b.op == "<" || b.op == ">") && !holds_at(state, {b}, now_);
    }
    return is_free && is_eager && is_open;
  });
}

}  // namespace bip::gen
