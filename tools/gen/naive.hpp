// The naive oracle: a literal implementation of compiler/docs/language_meaning.md, without optimisation. Every
// interaction is enumerated in every state, priorities are a search through the relation, values are copied. It shares
// no code with the compiler or the runtime.
#pragma once
#include <deque>

#include "tools/gen/naive_world.hpp"

namespace bip::gen {

/// An enabled interaction with one choice of values, `up` done. connector -1: one port of an atom.
struct Choice {
  int connector = -1;
  int atom = -1;
  std::string port;
  std::vector<int> params;      // sorted
  std::map<int, Choice> parts;  // by parameter
  Values own;
  const Clause* clause = nullptr;
  Leaves leaves;
};

class NaiveEngine {
 public:
  /// Sure: code of an action failed, so every engine must stop here. Possible: a guard or `up` would fail if an engine
  /// evaluates it, which it need not.
  enum class Trouble : std::uint8_t { None, Possible, Sure };

  /// numbers: by the path of an atom, its number in the image, which its generator depends on.
  NaiveEngine(const Description& model, std::size_t limit, std::uint64_t seed,
              const std::map<std::string, std::uint64_t>& numbers);

  /// More interactions than the limit: not for this oracle.
  [[nodiscard]] bool too_large() const { return too_large_; }
  [[nodiscard]] Trouble trouble() const { return trouble_; }
  /// The maximal enabled interactions of connectors that export no port, and the enabled internal ports.
  [[nodiscard]] std::vector<Choice> candidates();
  void fire(Choice choice);
  /// Each atom is at `final` places only.
  [[nodiscard]] bool is_final() const;
  /// `ROOT.c: ROOT.a.p ROOT.b.q` with the leaves sorted; `ROOT.a.p` for an internal port.
  [[nodiscard]] std::string key_of(const Choice& choice) const;

  struct ClockValue {
    std::int64_t value = 0, since = 0;  // ns
    std::int64_t speed = 1, unit = 1'000'000'000;
  };
  struct AtomState {
    std::set<std::string> marking;
    Values vars;  // parameters too
    std::map<std::string, const Transition*> enabled;
    std::map<std::string, ClockValue> clocks;
    std::uint64_t generator = 0;
    std::int64_t busy_until = 0;
    const Transition* at_work = nullptr;                           // its action has not taken effect
    std::int64_t returns = 0;                                      // when it does
    std::map<std::string, std::deque<std::vector<Value>>> events;  // that wait, by port
  };
  // ---- time (naive_time.cpp): language_meaning.md, section 7: conditions are evaluated at instants, never as
  // intervals
  static constexpr std::int64_t kForever = INT64_MAX;
  [[nodiscard]] std::int64_t now() const { return now_; }
  void advance(std::int64_t to);
  void deliver(std::size_t atom, const std::string& port, std::vector<Value> values);
  /// The instants after now at which a bound, an atom that is busy or an action at work may make a difference: between
  /// two of them nothing changes.
  [[nodiscard]] std::set<std::int64_t> turning_points() const;
  /// Of each atom the ports that are enabled at the instant if nothing happens before.
  [[nodiscard]] std::vector<std::set<std::string>> enabled_at(std::int64_t instant);
  /// The last instant to which time may pass; ends: of each choice the last instant at which it is possible without a
  /// gap.
  [[nodiscard]] std::int64_t limit(const std::vector<Choice>& choices, std::vector<std::int64_t>& ends);
  [[nodiscard]] std::int64_t clock_value(std::size_t atom, const std::string& clock) const {
    return value_at(states_[atom].clocks.at(clock), now_);
  }

  [[nodiscard]] const World& world() const { return world_; }
  [[nodiscard]] const std::vector<AtomState>& states() const { return states_; }

 private:
  void initialise(std::size_t atom);
  void settle(std::size_t atom);
  void fire_transition(std::size_t atom, const std::string& port);
  void find_enabled(AtomState& state, const AtomType& type);
  [[nodiscard]] std::vector<Choice> choices_of(int connector);
  [[nodiscard]] std::vector<Choice> options_of(const WorldPort& port);
  void hide_dominated(AtomState& state, const AtomType& type);
  [[nodiscard]] bool invariants_hold(AtomState& state, const AtomType& type);
  static std::int64_t value_at(const ClockValue& clock, std::int64_t instant) {
    return clock.value + clock.speed * (instant - clock.since);
  }
  [[nodiscard]] static bool holds_at(const AtomState& state, const std::vector<ClockBound>& when, std::int64_t instant);
  [[nodiscard]] bool invariants_hold_at(std::int64_t instant) const;
  [[nodiscard]] bool is_before_eager();
  void set_clocks(AtomState& state, const Transition& t);
  void finish(std::size_t atom, const Transition& t);
  void begin_resume(std::size_t atom, const Transition& t);
  void refuse_events();
  void complete(Choice choice, std::vector<Choice>& result);
  [[nodiscard]] Lookup lookup_in(Choice& choice);
  void fire_part(Choice& choice);
  enum class RuleSide : std::uint8_t { Low, High };
  [[nodiscard]] bool matches(const WorldRule& rule, RuleSide side, const Node& node) const;
  [[nodiscard]] std::vector<bool> active_rules();
  /// All enabled choices of the top-level connectors of a compound; of all that export no port if it is -1.
  [[nodiscard]] std::vector<Choice> offered_in(int compound);
  /// Those choices above which no enabled one is.
  [[nodiscard]] std::vector<Choice> unhidden(std::vector<Choice> choices, const std::vector<Choice>& enabled);
  void trouble(Trouble t) { trouble_ = std::max(trouble_, t); }

  const Description& model_;
  World world_;
  std::vector<AtomState> states_;
  std::vector<Node> nodes_;  // of all top-level connectors
  bool too_large_ = false;
  int depth_ = 0;  // internal transitions in a row
  std::int64_t now_ = 0;
  Trouble trouble_ = Trouble::None;
};

}  // namespace bip::gen
