// Atoms and code over Z3 terms. Recursion follows the trees of the .bsys, whose depth its readers bound.
#include "tools/certcheck/symbolic.hpp"

#include <algorithm>
#include <limits>

namespace certcheck {

namespace {
constexpr int kMaxInternals = 24;
// Floats and C++ objects are terms of this width, so that it shows that nothing is known of them.
constexpr unsigned kFloatBits = 64;
bool is_vague(const z3::expr& e) { return e.is_bv() && e.get_sort().bv_size() == kFloatBits; }
bool is_exact(const std::string& type) { return type == "int" || type == "bool" || type == "string"; }
bool is_automaton(const AtomType& type) {
  return type.initial.size() == 1 && std::all_of(type.transitions.begin(), type.transitions.end(), [](const Transition& t) { return t.from.size() == 1 && t.to.size() == 1; });
}
bool is(const z3::expr& e, bool value) { return value ? e.is_true() : e.is_false(); }
z3::expr choose(const z3::expr& when, const z3::expr& yes, const z3::expr& no) { return z3::eq(yes, no) || is(when, true) ? yes : is(when, false) ? no : z3::ite(when, yes, no).simplify(); }
}  // namespace

z3::expr Symbolic::fresh(const std::string& type) {
  const z3::sort sort = type == "bool" ? z_.bool_sort() : z_.bv_sort(is_exact(type) ? 32 : kFloatBits);
  return z3::expr(z_, Z3_mk_fresh_const(z_, "any", sort));
}

z3::expr Symbolic::evaluate(const Tree& e, const Variables& v, const z3::expr& when, z3::expr& fault) {
  if (e.is_string) {
    const auto found = m_.strings.find(e.text);
    return z_.bv_val(found == m_.strings.end() ? 0 : found->second, 32);
  }
  if (!e.is_list) {
    if (e.text == "true" || e.text == "false") return truth(e.text == "true");
    if (e.text.find_first_not_of("-0123456789") != std::string::npos) return fresh("float");
    return z_.bv_val(static_cast<int>(std::stoll(e.text)), 32);
  }
  const std::string& op = e.head();
  if (op == "self") return v.self(e.items.at(1).row());
  if (op == "bind") return v.bind(e.items.at(1).row());
  if (op == "call") {
    for (std::size_t k = 2; k < e.items.size(); ++k) (void)evaluate(e.items[k], v, when, fault);
    const Tree* result = m_.functions.at(e.items.at(1).row())->find("result");
    return fresh(result == nullptr ? "int" : result->items.at(1).text);
  }
  if (op == "at" || op == "data" || op == "can-port" || op == "can") return about_state(e);
  const z3::expr a = evaluate(e.items.at(1), v, when, fault);
  if (op == "to-float" || (op == "neg" && is_vague(a))) return fresh("float");
  if (op == "not") return !a;
  if (op == "neg") return -a;
  if (op == "bit-not") return ~a;
  if (op == "and" || op == "or") {
    const z3::expr b = evaluate(e.items.at(2), v, (when && (op == "and" ? a : !a)).simplify(), fault);
    return op == "and" ? (a && b).simplify() : (a || b).simplify();
  }
  const z3::expr b = evaluate(e.items.at(2), v, when, fault);
  if (is_vague(a)) return fresh(op == "add" || op == "sub" || op == "mul" || op == "div" ? "float" : "bool");
  if (op == "div" || op == "mod") {
    const z3::expr least = z_.bv_val(std::numeric_limits<int>::min(), 32), minus = z_.bv_val(-1, 32);
    fault = (fault || (when && (b == z_.bv_val(0, 32) || (a == least && b == minus)))).simplify();
    return op == "div" ? a / b : z3::srem(a, b);
  }
  if (op == "eq") return (a == b).simplify();
  if (op == "ne") return (a != b).simplify();
  if (op == "lt") return (a < b).simplify();
  if (op == "gt") return (a > b).simplify();
  if (op == "le") return (a <= b).simplify();
  if (op == "ge") return (a >= b).simplify();
  if (op == "add") return (a + b).simplify();
  if (op == "sub") return (a - b).simplify();
  if (op == "mul") return (a * b).simplify();
  if (op == "bit-and") return a & b;
  if (op == "bit-or") return a | b;
  if (op == "bit-xor") return a ^ b;
  throw NotCheckable("an expression `" + op + "`");
}

// What a claim says of the state that is looked at.
z3::expr Symbolic::about_state(const Tree& e) {
  const std::string& path = e.items.at(1).text;
  const auto row_of = [&](const std::vector<std::string>& names) {
    const auto found = std::find(names.begin(), names.end(), e.items.at(2).text);
    if (found == names.end()) throw Rejected("the claim names `" + e.items[2].text + "`, which there is not");
    return static_cast<std::size_t>(found - names.begin());
  };
  for (std::size_t c = 0; e.head() == "can" && c < m_.connectors.size(); ++c) {
    if (m_.connectors[c].path == path) return connector_can(c);
  }
  for (std::size_t a = 0; e.head() != "can" && a < m_.atoms.size(); ++a) {
    if (m_.atoms[a].path != path) continue;
    const AtomType& type = m_.atom_types[m_.atoms[a].type];
    if (e.head() == "at") return now_[a].marks.at(row_of(type.places));
    if (e.head() == "data") return own(type, now_[a]).self(row_of(type.slots));
    return on_.at(m_.first_port[a] + row_of(type.ports));
  }
  throw Rejected("the claim names `" + path + "`, which there is not");
}

void Symbolic::execute(const Tree* body, std::size_t first, const Variables& v, const z3::expr& when, z3::expr& fault) {
  for (std::size_t k = first; body != nullptr && k < body->items.size() && !is(when, false); ++k) {
    const Tree& s = body->items[k];
    if (s.head() == "if") {
      const z3::expr holds = evaluate(s.items.at(1), v, when, fault);
      execute(s.find("then"), 1, v, (when && holds).simplify(), fault);
      execute(s.find("else"), 1, v, (when && !holds).simplify(), fault);
    } else if (s.head() == "do") {
      (void)evaluate(s.items.at(1), v, when, fault);
    } else {
      const std::size_t row = s.items.at(1).row();
      const z3::expr value = evaluate(s.items.at(2), v, when, fault);
      if (s.head() == "set") v.set_self(row, choose(when, value, v.self(row)));
      else if (s.head() == "set-bind") v.set_bind(row, choose(when, value, v.bind(row)));
      else throw NotCheckable("a statement `" + s.head() + "`");
    }
  }
}

State Symbolic::any_state(const std::string& name) {
  State state;
  for (std::size_t a = 0; a < m_.atoms.size(); ++a) {
    const AtomType& type = m_.atom_types[m_.atoms[a].type];
    state.emplace_back();
    for (std::size_t p = 0; p < type.places.size(); ++p) state[a].marks.push_back(z_.bool_const((name + std::to_string(a) + "@" + std::to_string(p)).c_str()));
    std::size_t arg = 0;
    z3::expr no = truth(false);
    for (std::size_t k = 0; k < type.slots.size(); ++k) {
      const std::string slot = name + std::to_string(a) + "." + std::to_string(k);
      if (type.is_param[k]) state[a].slots.push_back(evaluate(*m_.atoms[a].args.at(arg++), {}, no, no));
      else state[a].slots.push_back(type.types[k] == "bool" ? z_.bool_const(slot.c_str()) : z_.bv_const(slot.c_str(), is_exact(type.types[k]) ? 32 : kFloatBits));
    }
  }
  return state;
}

State Symbolic::initial_state(z3::expr& fault) {
  State state = any_state("i");
  z3::expr lost = truth(false);
  for (std::size_t a = 0; a < m_.atoms.size(); ++a) {
    const AtomType& type = m_.atom_types[m_.atoms[a].type];
    for (std::size_t p = 0; p < type.places.size(); ++p) state[a].marks[p] = truth(std::find(type.initial.begin(), type.initial.end(), p) != type.initial.end());
    for (std::size_t k = 0; k < type.slots.size(); ++k) {
      if (!type.is_param[k]) state[a].slots[k] = is_exact(type.types[k]) ? zero(type.types[k]) : fresh(type.types[k]);
    }
    execute(type.initial_action, 1, own(type, state[a]), truth(true), fault);
    invariants(type, state[a], truth(true), fault);
    internals(type, state[a], fault, lost);
  }
  if (!is(lost, false)) throw NotCheckable("internal transitions at the beginning go on for too long");
  return state;
}

Variables Symbolic::own(const AtomType& type, Local& local) {
  Variables v;
  v.self = [this, &type, &local](std::size_t k) { return is_exact(type.types.at(k)) ? local.slots.at(k) : fresh(type.types[k]); };
  v.set_self = [&local](std::size_t k, const z3::expr& value) { local.slots.at(k) = value; };
  return v;
}

z3::expr Symbolic::marked(const Local& local, const std::vector<std::size_t>& places) {
  z3::expr all = truth(true);
  for (std::size_t place : places) all = is(all, true) ? local.marks.at(place) : (all && local.marks.at(place)).simplify();
  return all;
}

void Symbolic::merge(const z3::expr& when, const Local& from, Local& into) {
  for (std::size_t p = 0; p < into.marks.size(); ++p) into.marks[p] = choose(when, from.marks[p], into.marks[p]);
  for (std::size_t k = 0; k < into.slots.size(); ++k) into.slots[k] = choose(when, from.slots[k], into.slots[k]);
}

void Symbolic::invariants(const AtomType& type, Local& local, const z3::expr& when, z3::expr& fault) {
  for (const Tree* row : type.invariants) {
    const std::string& scope = row->items.at(3).text;
    std::vector<std::size_t> places;
    if (const Tree* named = row->find("places")) {
      for (std::size_t k = 1; k < named->items.size(); ++k) places.push_back(named->items[k].row());
    }
    z3::expr here = scope == "always" ? when : when && marked(local, places);
    for (std::size_t p = 0; scope == "at" && p < type.places.size(); ++p) {
      if (std::find(places.begin(), places.end(), p) == places.end()) here = here && !local.marks[p];
    }
    const z3::expr holds = evaluate(row->find("guard")->items.at(1), own(type, local), here, fault);
    fault = (fault || (here && !holds)).simplify();
  }
}

void Symbolic::move(const AtomType& type, const Transition& t, Local& local, const z3::expr& when, z3::expr& fault) {
  for (std::size_t place : t.from) local.marks.at(place) = truth(false);
  for (std::size_t place : t.to) {
    fault = (fault || (when && local.marks.at(place))).simplify();
    local.marks[place] = truth(true);
  }
  execute(t.action, 1, own(type, local), when, fault);
  invariants(type, local, when, fault);
}

void Symbolic::internals(const AtomType& type, Local& local, z3::expr& fault, z3::expr& lost) {
  const bool alone = is_automaton(type);
  Local now = local;
  z3::expr active = truth(true);
  for (int round = 0;; ++round) {
    z3::expr any = truth(false);
    std::optional<Local> next;
    for (const Transition& t : type.transitions) {
      if (!t.is_internal) continue;
      const z3::expr there = (active && marked(now, t.from)).simplify();
      if (is(there, false)) continue;
      const z3::expr on = t.guard == nullptr ? there : (there && evaluate(*t.guard, own(type, now), there, fault)).simplify();
      if (is(on, false)) continue;
      fault = (fault || (any && on)).simplify();
      any = (any || on).simplify();
      Local moved = now;
      if (alone) std::fill(moved.marks.begin(), moved.marks.end(), truth(false));
      move(type, t, moved, on, fault);
      if (next) merge(on, moved, *next);
      else next = std::move(moved);
    }
    merge((active && !any).simplify(), now, local);
    active = any;
    if (is(active, false)) return;
    if (round == kMaxInternals) {
      lost = lost || active;
      return;
    }
    now = std::move(*next);
  }
}

void Symbolic::look(const State& state) {
  now_ = state;
  going_.assign(state.size(), {});
  on_.assign(m_.atom_of_port.size(), truth(false));
  all_.clear();
  is_complete_ = false;
  state_fault_ = guard_fault_ = truth(false);
  for (std::size_t a = 0; a < state.size(); ++a) {
    const AtomType& type = m_.atom_types[m_.atoms[a].type];
    for (const Transition& t : type.transitions) {
      z3::expr going = truth(false);
      if (!t.is_internal) {
        going = marked(now_[a], t.from);
        if (t.guard != nullptr) going = (going && evaluate(*t.guard, own(type, now_[a]), going, *state_fault_)).simplify();
        z3::expr& port = on_[m_.first_port[a] + t.port];
        if (!is(port, false) && !is(going, false)) state_fault_ = *state_fault_ || (port && going);
        port = is(port, false) ? going : is(going, false) ? port : port || going;
      }
      going_[a].push_back(going);
    }
    if (!type.priorities.empty()) hide_ports(a);
  }
}

void Symbolic::hide_ports(std::size_t a) {
  const AtomType& type = m_.atom_types[m_.atoms[a].type];
  const std::size_t ports = type.exported.size();
  std::vector<std::vector<z3::expr>> above(ports, std::vector<z3::expr>(ports, truth(false)));
  for (const Tree* row : type.priorities) {
    const Tree* guard = row->find("guard");
    const z3::expr holds = guard == nullptr ? truth(true) : evaluate(guard->items.at(1), own(type, now_[a]), truth(true), *state_fault_);
    const Tree& low = row->find("low")->items.at(1);
    const Tree& high = row->find("high")->items.at(1);
    for (std::size_t l = 0; l < ports; ++l) {
      for (std::size_t h = 0; h < ports; ++h) {
        const bool fits = (low.text == "any" ? high.text == "any" || l != high.row() : l == low.row()) && (high.text == "any" ? low.text == "any" || h != low.row() : h == high.row());
        if (fits) above[l][h] = (above[l][h] || holds).simplify();
      }
    }
  }
  std::vector<z3::expr> covered(ports, truth(false)), cycle(ports, truth(true));
  for (std::size_t round = 0; round < ports; ++round) {
    std::vector<z3::expr> covers(ports, truth(false)), cycles(ports, truth(false));
    for (std::size_t l = 0; l < ports; ++l) {
      for (std::size_t h = 0; h < ports; ++h) {
        covers[l] = (covers[l] || (above[l][h] && (on_[m_.first_port[a] + h] || covered[h]))).simplify();
        cycles[l] = (cycles[l] || (above[l][h] && cycle[h])).simplify();
      }
    }
    covered = covers;
    cycle = cycles;
  }
  for (std::size_t p = 0; p < ports; ++p) {
    state_fault_ = (*state_fault_ || cycle[p]).simplify();
    z3::expr& port = on_[m_.first_port[a] + p];
    port = (port && !covered[p]).simplify();
  }
}

void Symbolic::fire(std::size_t port, Local& local, const z3::expr& when, z3::expr& fault, z3::expr& lost) {
  const std::size_t a = m_.atom_of_port[port];
  const AtomType& type = m_.atom_types[m_.atoms[a].type];
  const Local before = local;
  for (std::size_t t = 0; t < type.transitions.size(); ++t) {
    const z3::expr& on = going_[a][t];
    if (type.transitions[t].is_internal || type.transitions[t].port != port - m_.first_port[a] || is(on, false)) continue;
    Local next = before;
    if (is_automaton(type)) std::fill(next.marks.begin(), next.marks.end(), truth(false));
    z3::expr f = truth(false), l = truth(false);
    move(type, type.transitions[t], next, truth(true), f);
    internals(type, next, f, l);
    if (!is(f, false)) fault = fault || (when && on && f);
    if (!is(l, false)) lost = lost || (when && on && l);
    merge((when && on).simplify(), next, local);
  }
}

}  // namespace certcheck
