// Forward exploration of one atom in an environment that may do anything that its connectors' transfers can.
#include "compiler/verify/net/modes.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "compiler/system/system.hpp"
#include "compiler/verify/net/live_variables.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

enum class Follow : std::uint8_t { Observed, Booleans, Nothing };

class Explorer {
 public:
  Explorer(const System& system, ModeClass& row, const analysis::DataAccess& access, std::size_t limit)
      : code_(system.code), type_(system.atom_types[row.type]), access_(access), row_(row), limit_(limit) {}

  void forget_dead(std::vector<std::vector<std::uint8_t>> live) { live_ = std::move(live); }

  // False: more modes than the limit.
  bool run() {
    Mode start;
    start.places = type_.initial;
    std::sort(start.places.begin(), start.places.end());
    for (std::size_t k = 0; k < type_.variables.size(); ++k) {
      const DataVariable& variable = type_.variables[k];
      if (variable.is_param) {
        start.values.push_back(k < row_.args.size() && variable.type != Type::Float ? known(row_.args[k].int_value)
                                                                                    : AbstractValue{});
      } else {
        start.values.push_back(variable.type == Type::String ? known(empty_string()) : known(0));
      }
    }
    forget(start);
    execute(code_, type_.initial_action, start.values);
    forget(start);
    std::set<std::uint32_t> stable;
    if (!settle(start, stable)) return false;
    row_.initial.assign(stable.begin(), stable.end());
    row_.moves.resize(type_.ports.size() + (row_.uses == nullptr ? 0 : row_.uses->uses.size()));
    for (std::uint32_t mode = 0; mode < row_.modes.size(); ++mode) {
      if (!leave(mode)) return false;
    }
    finish();
    return true;
  }

 private:
  [[nodiscard]] std::int32_t empty_string() const {
    for (std::size_t k = 0; k < code_.strings.size(); ++k) {
      if (code_.strings[k].empty()) return static_cast<std::int32_t>(k);
    }
    return -1;
  }
  void forget(Mode& mode) const {
    for (std::size_t k = 0; k < mode.values.size(); ++k) {
      if (row_.followed[k] == 0) mode.values[k] = {};
    }
  }
  [[nodiscard]] bool leaves_from(const Mode& mode, const Transition& t) const {
    return std::all_of(t.from.begin(), t.from.end(), [&](std::uint32_t place) {
      return std::binary_search(mode.places.begin(), mode.places.end(), place);
    });
  }
  [[nodiscard]] AbstractValue guard_of(const Mode& mode, const Transition& t) const {
    return t.guard.is_valid() ? evaluate(code_, t.guard, mode.values, {}) : known(1);
  }
  // Nothing if a token lands on a marked place: the run ends there with an error.
  [[nodiscard]] std::optional<Mode> after(const Mode& mode, const Transition& t,
                                          const std::vector<std::uint32_t>* written,
                                          const PortUse* use = nullptr) const {
    std::set<std::uint32_t> places(mode.places.begin(), mode.places.end());
    for (std::uint32_t place : t.from) {
      BIP_ASSERT(places.contains(place), "the transition leaves place {}, which has no token", place);
      places.erase(place);
    }
    for (std::uint32_t place : t.to) {
      if (places.contains(place)) return std::nullopt;
    }
    places.insert(t.to.begin(), t.to.end());
    Mode next{{places.begin(), places.end()}, mode.values};
    if (written != nullptr) {
      for (std::uint32_t variable : *written) next.values[variable] = {};
    }
    if (use != nullptr) {
      for (const auto& [variable, value] : use->writes) next.values[variable] = value;
    }
    execute(code_, t.action, next.values);
    forget(next);
    return next;
  }
  // Can the use's guard be true?
  [[nodiscard]] bool allows(const PortUse& use, const Mode& mode) {
    if (!use.guard.is_valid()) return true;
    bind_.clear();
    for (const UseSource& source : use.bind)
      bind_.push_back(source.own_variable == UseSource::kOther ? source.value : mode.values[source.own_variable]);
    const AbstractValue guard = evaluate(code_, use.guard, {}, bind_);
    return !guard.is_known || guard.value != 0;
  }
  bool add(Mode mode, std::set<std::uint32_t>& stable) {
    for (std::size_t k = 0; !live_.empty() && k < mode.values.size(); ++k) {
      if (live_[mode.places[0]][k] == 0 && !type_.variables[k].is_param) mode.values[k] = {};
    }
    const auto [found, is_new] = numbers_.try_emplace(mode, static_cast<std::uint32_t>(row_.modes.size()));
    if (is_new) row_.modes.push_back(mode);
    stable.insert(found->second);
    return row_.modes.size() <= limit_;
  }
  // The stable modes after internal transitions.
  bool settle(const Mode& start, std::set<std::uint32_t>& stable) {
    std::set<Mode> seen{start};
    std::vector<Mode> todo{start};
    while (!todo.empty()) {
      const Mode mode = std::move(todo.back());
      todo.pop_back();
      bool surely_goes_on = false;
      for (const Transition& t : type_.transitions) {
        if (t.port != Transition::kInternal || !leaves_from(mode, t)) continue;
        const AbstractValue guard = guard_of(mode, t);
        if (guard.is_known && guard.value == 0) continue;
        surely_goes_on |= guard.is_known;
        std::optional<Mode> next = after(mode, t, nullptr);
        if (next && seen.insert(*next).second) todo.push_back(std::move(*next));
        if (seen.size() > limit_) return false;
      }
      if (!surely_goes_on && !add(mode, stable)) return false;
    }
    return true;
  }
  bool leave(std::uint32_t number) {
    for (const Transition& t : type_.transitions) {
      const Mode mode = row_.modes[number];
      if (t.port == Transition::kInternal || !leaves_from(mode, t)) continue;
      const AbstractValue guard = guard_of(mode, t);
      if (guard.is_known && guard.value == 0) continue;
      if (row_.uses == nullptr || row_.uses->is_plain[t.port] != 0) {
        if (!move(number, t.port, after(mode, t, &access_.written[t.port]))) return false;
      }
      for (std::size_t k = 0; row_.uses != nullptr && k < row_.uses->uses.size(); ++k) {
        const PortUse& use = row_.uses->uses[k];
        if (use.port != t.port) continue;
        if (++tries_ > kMaxTries) return false;
        if (allows(use, mode) && !move(number, type_.ports.size() + k, after(mode, t, nullptr, &use))) return false;
      }
    }
    return true;
  }
  bool move(std::uint32_t from, std::size_t port, const std::optional<Mode>& next) {
    if (!next) return true;
    std::set<std::uint32_t> stable;
    if (!settle(*next, stable)) return false;
    for (std::uint32_t to : stable) row_.moves[port].push_back({from, to});
    return true;
  }

  // A low port may be hidden inside its atom if a chain of rules that may hold leads from it to a port that may be
  // enabled.
  [[nodiscard]] bool may_be_hidden(const Mode& mode, std::uint32_t port, const std::vector<std::uint8_t>& may) const {
    std::vector<std::uint8_t> seen(type_.ports.size(), 0);
    std::vector<std::uint32_t> todo{port};
    while (!todo.empty()) {
      const std::uint32_t low = todo.back();
      todo.pop_back();
      for (const AtomPriority& rule : type_.priorities) {
        if (rule.low != AtomPriority::kAnyPort && rule.low != low) continue;
        if (rule.guard.is_valid()) {
          const AbstractValue guard = evaluate(code_, rule.guard, mode.values, {});
          if (guard.is_known && guard.value == 0) continue;
        }
        for (std::uint32_t high = 0; high < type_.ports.size(); ++high) {
          if (rule.high != AtomPriority::kAnyPort && rule.high != high) continue;
          if (may[high] != 0 && high != port) return true;
          if (seen[high] == 0) {
            seen[high] = 1;
            todo.push_back(high);
          }
        }
      }
    }
    return false;
  }

  void finish() {
    const std::size_t count = row_.modes.size();
    row_.is_sure.assign(type_.ports.size(), std::vector<std::uint8_t>(count, 0));
    row_.out.resize(count);
    row_.in.resize(count);
    for (std::uint32_t m = 0; m < count; ++m) {
      const Mode& mode = row_.modes[m];
      std::vector<std::uint8_t> may(type_.ports.size(), 0);
      for (const Transition& t : type_.transitions) {
        if (t.port == Transition::kInternal || !leaves_from(mode, t)) continue;
        const AbstractValue guard = guard_of(mode, t);
        if (guard.is_known && guard.value == 0) continue;
        may[t.port] = 1;
        if (guard.is_known) row_.is_sure[t.port][m] = 1;
      }
      if (type_.priorities.empty()) continue;
      for (std::uint32_t port = 0; port < type_.ports.size(); ++port) {
        if (row_.is_sure[port][m] != 0 && may_be_hidden(mode, port, may)) row_.is_sure[port][m] = 0;
      }
    }
    for (std::uint32_t port = 0; port < row_.moves.size(); ++port) {
      std::vector<Move>& moves = row_.moves[port];
      std::sort(moves.begin(), moves.end());
      moves.erase(std::unique(moves.begin(), moves.end()), moves.end());
      for (const Move& move : moves) {
        row_.out[move.from].push_back({port, move.to});
        row_.in[move.to].push_back({port, move.from});
      }
    }
    validate();
  }

  // What others of this class rely on.
  void validate() const {
    BIP_ASSERT(std::is_sorted(row_.initial.begin(), row_.initial.end()), "initial modes are not sorted");
    for (const std::uint32_t mode : row_.initial)
      BIP_ASSERT(mode < row_.modes.size(), "initial mode {} of {}", mode, row_.modes.size());
    for (std::uint32_t m = 0; m < row_.modes.size(); ++m) {
      const Mode& mode = row_.modes[m];
      BIP_ASSERT(std::is_sorted(mode.places.begin(), mode.places.end()), "places of mode {} are not sorted", m);
      BIP_ASSERT(mode.values.size() == type_.variables.size(), "mode {} has {} values", m, mode.values.size());
      for (std::size_t k = 0; k < mode.values.size(); ++k)
        BIP_ASSERT(row_.followed[k] != 0 || !mode.values[k].is_known, "variable {} of mode {} is not followed", k, m);
      // A port that is enabled in every state of a mode can move there, unless a token would land on a marked place.
      for (std::uint32_t port = 0; port < row_.is_sure.size(); ++port)
        BIP_ASSERT(row_.is_sure[port][m] == 0 || leaves_by(mode, port), "mode {} is sure of port {}", m, port);
    }
  }
  [[nodiscard]] bool leaves_by(const Mode& mode, std::uint32_t port) const {
    return std::any_of(type_.transitions.begin(), type_.transitions.end(),
                       [&](const Transition& t) { return t.port == port && leaves_from(mode, t); });
  }

  const CodeTable& code_;
  const AtomType& type_;
  const analysis::DataAccess& access_;
  ModeClass& row_;
  std::size_t limit_;
  std::map<Mode, std::uint32_t> numbers_;
  std::vector<std::vector<std::uint8_t>> live_;  // empty: all are
  std::vector<AbstractValue> bind_;              // scratch
  std::size_t tries_ = 0;
};

}  // namespace

ModeClass explore_modes(const System& system, AtomTypeId type, const std::vector<Value>& args,
                        const analysis::DataAccess& access) {
  const AtomType& atom_type = system.atom_types[type];
  BIP_ASSERT(access.observed.size() == atom_type.variables.size(), "data access of another type");
  for (const Follow follow : {Follow::Observed, Follow::Booleans, Follow::Nothing}) {
    ModeClass row;
    row.type = type;
    row.args = args;
    for (std::size_t k = 0; k < atom_type.variables.size(); ++k) {
      const DataVariable& variable = atom_type.variables[k];
      const bool is_exact = variable.type == Type::Int || variable.type == Type::Bool || variable.type == Type::String;
      const bool is_wanted = variable.is_param ||
                             (access.observed[k] != 0 && (follow == Follow::Observed ||
                                                          (follow == Follow::Booleans && variable.type == Type::Bool)));
      row.followed.push_back(is_exact && is_wanted && access.unfollowed[k] == 0 ? 1 : 0);
    }
    const std::size_t limit = follow == Follow::Nothing ? kMaxMarkings : kMaxModesWithData;
    if (Explorer(system, row, access, limit).run()) return row;
  }
  ModeClass row;
  row.type = type;
  row.args = args;
  row.is_too_large = true;
  return row;
}

ModeClass explore_modes(const System& system, const ModeClass& plain, const analysis::DataAccess& access,
                        const AtomUses& uses, UsesAs as) {
  BIP_ASSERT(!plain.is_too_large, "a class that is too large has no data that it follows");
  BIP_ASSERT(plain.uses == nullptr, "the class already distinguishes uses");
  ModeClass row;
  row.type = plain.type;
  row.args = plain.args;
  row.followed = plain.followed;
  if (as == UsesAs::Ports) {
    row.uses = &uses;
  } else {
    for (const PortUse& use : uses.uses) {
      for (const auto& [variable, value] : use.writes)
        row.followed[variable] = value.is_known ? 0 : row.followed[variable];
    }
  }
  Explorer explorer(system, row, access, kMaxModesWithUses);
  explorer.forget_dead(find_live_variables(system, row.type, access, uses));
  row.is_too_large = !explorer.run();
  return row;
}

std::vector<AbstractValue> constants_of(const ModeClass& row) {
  if (row.modes.empty()) return {};
  std::vector<AbstractValue> values = row.modes[0].values;
  for (const Mode& mode : row.modes) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (values[k] != mode.values[k]) values[k] = {};
    }
  }
  return values;
}

std::string mode_text(const System& system, const ModeClass& row, std::uint32_t mode) {
  BIP_ASSERT(mode < row.modes.size(), "mode {} of {}", mode, row.modes.size());
  const AtomType& type = system.atom_types[row.type];
  std::string text;
  for (std::uint32_t place : row.modes[mode].places) {
    if (!text.empty()) text += " + ";
    text += type.places[place];
  }
  if (text.empty()) text = "(nowhere)";
  bool has_data = false;
  for (std::size_t k = 0; k < type.variables.size(); ++k) {
    const AbstractValue& value = row.modes[mode].values[k];
    if (row.followed[k] == 0 || type.variables[k].is_param) continue;
    text += (has_data ? ", " : " (") + type.variables[k].name + " = ";
    has_data = true;
    if (!value.is_known) text += "?";
    else if (type.variables[k].type == Type::Bool) text += value.value != 0 ? "true" : "false";
    else if (type.variables[k].type == Type::String)
      text += '"' + (value.value < 0 ? "" : system.code.strings[static_cast<std::size_t>(value.value)]) + '"';
    else text += std::to_string(value.value);
  }
  return has_data ? text + ')' : text;
}

}  // namespace bip::verify
