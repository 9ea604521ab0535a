// Atoms alone: expressions and actions with unknown values, internal transitions, what a port can lead to.
#include <limits>

#include "tools/certcheck/model.hpp"

namespace certcheck {

namespace {

Value of(bool b) { return {true, b ? 1 : 0}; }
std::int32_t wrap(std::int64_t v) { return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::uint64_t>(v))); }

}  // namespace

Value Model::evaluate(const Tree& e, const std::vector<Value>& self, const std::vector<Value>& bind) const {
  if (e.is_string) {
    const auto found = strings.find(e.text);
    return {true, found == strings.end() ? -1 : found->second};
  }
  if (!e.is_list) {
    if (e.text == "true" || e.text == "false") return of(e.text == "true");
    if (e.text.find_first_not_of("-0123456789") != std::string::npos) return {};
    return {true, static_cast<std::int32_t>(std::stoll(e.text))};
  }
  const std::string& op = e.head();
  if (op == "self" || op == "bind") {
    const std::vector<Value>& values = op == "self" ? self : bind;
    const std::size_t row = e.items.at(1).row();
    return row < values.size() ? values[row] : Value{};
  }
  if (op == "call" || op == "to-float") return {};
  const Value a = evaluate(e.items.at(1), self, bind);
  if (op == "not") return a.is_known ? of(a.value == 0) : a;
  if (op == "neg") return a.is_known ? Value{true, wrap(-std::int64_t{a.value})} : a;
  if (op == "bit-not") return a.is_known ? Value{true, ~a.value} : a;
  const Value b = evaluate(e.items.at(2), self, bind);
  if (op == "and" || op == "or") {
    const Value decisive = of(op == "or");
    if (a == decisive || b == decisive) return decisive;
    return a.is_known && b.is_known ? of(op == "and") : Value{};
  }
  if (!a.is_known || !b.is_known) return {};
  const std::int64_t x = a.value, y = b.value;
  if (op == "add") return {true, wrap(x + y)};
  if (op == "sub") return {true, wrap(x - y)};
  if (op == "mul") return {true, wrap(x * y)};
  if (op == "div" || op == "mod") {
    if (y == 0 || (x == std::numeric_limits<std::int32_t>::min() && y == -1)) return {};
    return {true, wrap(op == "div" ? x / y : x % y)};
  }
  if (op == "bit-and") return {true, a.value & b.value};
  if (op == "bit-or") return {true, a.value | b.value};
  if (op == "bit-xor") return {true, a.value ^ b.value};
  if (op == "eq") return of(x == y);
  if (op == "ne") return of(x != y);
  if (op == "lt") return of(x < y);
  if (op == "gt") return of(x > y);
  if (op == "le") return of(x <= y);
  if (op == "ge") return of(x >= y);
  return {};
}

void Model::execute(const Tree* body, std::size_t first, std::vector<Value>& self) const {
  if (body == nullptr) return;
  for (std::size_t k = first; k < body->items.size(); ++k) {
    const Tree& s = body->items[k];
    if (s.head() == "set") {
      self.at(s.items.at(1).row()) = evaluate(s.items.at(2), self, {});
    } else if (s.head() == "if") {
      const Value condition = evaluate(s.items.at(1), self, {});
      std::vector<Value> other = self;
      execute(s.find("then"), 1, self);
      execute(s.find("else"), 1, other);
      if (condition.is_known) {
        if (condition.value == 0) self = other;
        continue;
      }
      for (std::size_t v = 0; v < self.size(); ++v) {
        if (self[v] != other[v]) self[v] = {};
      }
    } else if (s.head() != "do") {
      throw NotCheckable("a statement `" + s.head() + "` in an atom");
    }
  }
}

namespace {

bool leaves(const LocalState& state, const Transition& t) {
  for (std::size_t place : t.from) {
    if (!state.places.contains(place)) return false;
  }
  return true;
}

void forget(LocalState& state, const std::vector<bool>& followed) {
  for (std::size_t k = 0; k < state.values.size(); ++k) {
    if (!followed[k]) state.values[k] = {};
  }
}

// False: a token would land on a marked place, where the run ends.
bool fire(const Model& model, const Transition& t, const std::vector<bool>& followed, LocalState& state) {
  for (std::size_t place : t.from) state.places.erase(place);
  for (std::size_t place : t.to) {
    if (state.places.contains(place)) return false;
  }
  state.places.insert(t.to.begin(), t.to.end());
  model.execute(t.action, 1, state.values);
  forget(state, followed);
  return true;
}

}  // namespace

std::set<LocalState> Model::settle(const AtomType& type, const LocalState& start, const std::vector<bool>& followed) const {
  std::set<LocalState> seen{start}, stable;
  std::vector<LocalState> todo{start};
  while (!todo.empty()) {
    const LocalState state = todo.back();
    todo.pop_back();
    bool must_go_on = false;
    for (const Transition& t : type.transitions) {
      if (!t.is_internal || !leaves(state, t)) continue;
      const Value guard = t.guard == nullptr ? of(true) : evaluate(*t.guard, state.values, {});
      if (guard == of(false)) continue;
      must_go_on = must_go_on || guard.is_known;
      LocalState next = state;
      if (fire(*this, t, followed, next) && seen.insert(next).second) todo.push_back(next);
      if (seen.size() > 100000) throw NotCheckable("internal transitions of `" + type.name + "` lead to too many states");
    }
    if (!must_go_on) stable.insert(state);
  }
  return stable;
}

std::set<LocalState> Model::initial_states(const Atom& atom, const std::vector<bool>& followed) const {
  const AtomType& type = atom_types[atom.type];
  LocalState start;
  start.places.insert(type.initial.begin(), type.initial.end());
  std::size_t next_arg = 0;
  for (std::size_t k = 0; k < type.slots.size(); ++k) {
    Value value = type.types[k] == "string" ? Value{true, -1} : of(false);
    if (const auto empty = strings.find(""); type.types[k] == "string" && empty != strings.end()) value.value = empty->second;
    if (type.is_param[k]) {
      if (next_arg >= atom.args.size()) throw Rejected("`" + atom.path + "` has too few args");
      value = evaluate(*atom.args[next_arg++], {}, {});
    }
    start.values.push_back(value);
  }
  forget(start, followed);
  execute(type.initial_action, 1, start.values);
  forget(start, followed);
  return settle(type, start, followed);
}

std::set<LocalState> Model::after(const AtomType& type, const LocalState& state, std::size_t port, const std::vector<bool>& followed) const {
  std::set<LocalState> result;
  for (const Transition& t : type.transitions) {
    if (t.is_internal || t.port != port || !leaves(state, t)) continue;
    if (t.guard != nullptr && evaluate(*t.guard, state.values, {}) == of(false)) continue;
    LocalState next = state;
    for (std::size_t slot : type.written[port]) next.values[slot] = {};
    if (fire(*this, t, followed, next)) result.merge(settle(type, next, followed));
  }
  return result;
}

bool Model::is_sure(const AtomType& type, const LocalState& state, std::size_t port) const {
  if (type.maybe_hidden[port]) return false;
  for (const Transition& t : type.transitions) {
    if (t.is_internal || t.port != port || !leaves(state, t)) continue;
    if (t.guard == nullptr || evaluate(*t.guard, state.values, {}) == of(true)) return true;
  }
  return false;
}

}  // namespace certcheck
