// Code and atoms over Z3 terms: bits as the language has them; floats that are not constants and what C++ gives are any
// value. An atom's state may be all constants, and then so is what it does: the same functions serve single modes and
// all states at once. Recursion follows the trees of the .bsys, whose depth its reader bounds.
#pragma once
#include <bit>
#include <functional>
#include <limits>
#include <span>

#include "tools/certcheck/checked_model.hpp"

namespace certcheck {

using z3::expr;

[[nodiscard]] inline bool is(const expr& e, bool value) {
  return Z3_get_bool_value(e.ctx(), e) == (value ? Z3_L_TRUE : Z3_L_FALSE);
}
// Connectives that fold constants; `simplify` of large terms is slow.
[[nodiscard]] inline expr both(const expr& a, const expr& b) {
  return is(a, true) || is(b, false) ? b : is(b, true) || is(a, false) ? a : a && b;
}
[[nodiscard]] inline expr either(const expr& a, const expr& b) {
  return is(a, false) || is(b, true) ? b : is(b, false) || is(a, true) ? a : a || b;
}
[[nodiscard]] inline expr no(const expr& a) {
  return is(a, true) || is(a, false) ? a.ctx().bool_val(is(a, false)) : a.is_not() ? a.arg(0) : !a;
}
[[nodiscard]] inline expr choose(const expr& when, const expr& yes, const expr& otherwise) {
  return z3::eq(yes, otherwise) || is(when, true) ? yes
         : is(when, false)                        ? otherwise
                                                  : z3::ite(when, yes, otherwise).simplify();
}
/// Of a term that is a constant; nothing of all others.
[[nodiscard]] inline std::optional<int> value_of(const expr& e) {
  if (is(e, true) || is(e, false)) return is(e, true) ? 1 : 0;
  return e.is_numeral() ? std::optional(static_cast<int>(static_cast<unsigned>(e.get_numeral_uint64()))) : std::nullopt;
}
[[nodiscard]] inline expr equals(const expr& e, int value) {
  if (e.is_bool()) return value != 0 ? e : no(e);
  const std::optional<int> known = value_of(e);
  return known ? e.ctx().bool_val(*known == value) : e == e.ctx().bv_val(value, e.get_sort().bv_size());
}

/// An atom's state, by variable.
using Local = std::vector<expr>;
/// What it can do: its transitions (internal ones: false) and ports, after the atom's priorities.
struct Offer {
  Local transitions, ports;
};
/// What code reads and writes, terms that the caller keeps; `about` is for claims (at …), (can …).
struct Scope {
  std::span<expr> self;
  std::vector<expr*> bind;
  std::function<expr(const Tree&)> about;
};
/// A priority: its guard, and which things are low and high in it.
struct Rule {
  expr guard;
  Local low, high;
};

class Terms {
 public:
  Terms(const Model& model, z3::context& z) : m_(model), z_(z), solver_(z, "QF_BV") {}

  /// What `may_be` takes for granted from now on; what speaks of one atom alone may say so.
  void assume(const expr& e, std::size_t atom = kNone) {
    if (is(e, true)) return;
    solver_.add(e);
    if (atom != kNone) assumed_[atom].push_back(e);
  }
  /// Throws where the solver gives up.
  [[nodiscard]] bool may_be(const expr& e) { return is(e, true) || (!is(e, false) && can_solve(solver_, e)); }
  /// With what is assumed of some atoms alone, which is much quicker, and false only where it is without, too.
  [[nodiscard]] bool may_be(const expr& e, const std::map<std::size_t, Local>& alone) {
    expr whole = e;
    for (const auto& [atom, local] : alone)
      for (const expr& fact : assumed_[atom]) whole = both(whole, fact);
    z3::solver few(z_, "QF_BV");
    return is(whole, true) || (!is(whole, false) && can_solve(few, whole));
  }

  /// All values that the atoms can have where `e` holds, one by one, as constants.
  void each_solution(const expr& e, const std::map<std::size_t, Local>& atoms,
                     const std::function<void(const std::map<std::size_t, Local>&)>& visit) {
    solver_.push();
    solver_.add(e);
    for (z3::check_result answer = solver_.check(); answer != z3::unsat; answer = solver_.check()) {
      if (answer == z3::unknown) throw NotCheckable("the solver gives up");
      const z3::model model = solver_.get_model();
      expr other = truth(false);
      std::map<std::size_t, Local> solution = atoms;
      for (auto& [atom, local] : solution) {
        for (expr& value : local) {
          const expr term = value;
          value = model.eval(term, true);
          if (!z3::eq(value, term)) other = either(other, term != value);
        }
      }
      visit(solution);
      solver_.add(other);
    }
    solver_.pop();
  }

  [[nodiscard]] expr truth(bool b) const { return z_.bool_val(b); }
  /// Do all of them, does one of them?
  template <class Range, class Of>
  [[nodiscard]] expr all(const Range& range, const Of& of) const {
    expr result = truth(true);
    for (auto item = range.begin(); item != range.end() && !is(result, false); ++item) result = both(result, of(*item));
    return result;
  }
  template <class Range, class Of>
  [[nodiscard]] expr some(const Range& range, const Of& of) const {
    return no(all(range, [&](const auto& item) { return no(of(item)); }));
  }
  /// A constant of its own, of a type of variables.
  [[nodiscard]] expr fresh(Text type) const {
    return expr(z_, Z3_mk_fresh_const(z_, "any",
                                      type == "bool" ? z_.bool_sort() : z_.bv_sort(is_exact(type) ? 32 : kVagueBits)));
  }
  /// An int, a bool or the row of a string.
  [[nodiscard]] expr constant(Text type, int value) const {
    return type == "bool" ? truth(value != 0) : z_.bv_val(value, 32);
  }
  /// From variable `first` on, the given values.
  [[nodiscard]] expr has(const Local& local, const Values& values, std::size_t first = 0) const {
    expr result = truth(true);
    for (std::size_t k = first; k < local.size(); ++k)
      result = values[k] ? both(result, equals(local[k], *values[k])) : result;
    return result;
  }
  /// A run ends with an error where `fault` holds then.
  [[nodiscard]] expr evaluate(const Tree& e, const Scope& s, const expr& when, expr& fault) const {
    if (e.is_string) {
      const auto found = m_.strings.find(e.text);
      return constant("string", found == m_.strings.end() ? 0 : found->second);
    }
    if (!e.is_list) {
      if (e.text == "true" || e.text == "false") return truth(e.text == "true");
      const auto reads = [&, end = e.text.data() + e.text.size()](auto& value) {
        const auto [last, error] = std::from_chars(e.text.data(), end, value);
        return error == std::errc() && last == end;
      };
      int value = 0;
      double number = 0;
      return reads(value) ? constant("int", value) : reads(number) ? real(number) : fresh("float");
    }
    const Text op = e.head();
    if (op == "self" || op == "bind") return variable(e, s, op == "self");
    if (op == "call") {
      for (std::size_t k = 2; k < e.items.size(); ++k) (void)evaluate(e.items[k], s, when, fault);
      const Tree& result = (*m_.functions.at(e.at(1).row()))["result"];
      return fresh(result.items.empty() ? "int" : result.at(1).text);
    }
    if (s.about && (op == "at" || op == "data" || op == "can-port" || op == "can")) return s.about(e);
    const expr a = evaluate(e.at(1), s, when, fault);
    if (op == "to-float") return value_of(a) ? real(*value_of(a)) : unknown("float", op, a, a);
    if (op == "neg" && is_vague(a)) return real_of(a) ? real(-*real_of(a)) : unknown("float", op, a, a);
    if (op == "not") return no(a);
    if (op == "neg") return (-a).simplify();
    if (op == "bit-not") return (~a).simplify();
    const expr b = evaluate(e.at(2), s, op == "and" ? both(when, a) : op == "or" ? both(when, no(a)) : when, fault);
    if (op == "and") return both(a, b);
    if (op == "or") return either(a, b);
    if (is_vague(a)) return compute(op, a, b);
    if (op == "div" || op == "mod") {
      const expr overflows = both(equals(a, std::numeric_limits<int>::min()), equals(b, -1));
      fault = either(fault, both(when, either(equals(b, 0), overflows)));
    }
    // Comparisons of constants need no solver: most of the work where states are listed.
    if (const auto x = value_of(a), y = value_of(b); x && y) {
      if (const std::optional<bool> known = compare(op, *x, *y)) return truth(*known);
    }
    static const std::map<Text, Z3_ast (*)(Z3_context, Z3_ast, Z3_ast)> kOperations{
        {"add", Z3_mk_bvadd},  {"sub", Z3_mk_bvsub},     {"mul", Z3_mk_bvmul},   {"div", Z3_mk_bvsdiv},
        {"mod", Z3_mk_bvsrem}, {"bit-and", Z3_mk_bvand}, {"bit-or", Z3_mk_bvor}, {"bit-xor", Z3_mk_bvxor},
        {"eq", Z3_mk_eq},      {"ne", Z3_mk_eq},         {"lt", Z3_mk_bvslt},    {"le", Z3_mk_bvsle},
        {"gt", Z3_mk_bvsgt},   {"ge", Z3_mk_bvsge}};
    const auto found = kOperations.find(op);
    if (found == kOperations.end()) throw NotCheckable("an expression " + quoted(op));
    const Z3_ast made = found->second(z_, a, b);
    z_.check_error();
    const expr result = expr(z_, made).simplify();
    return op == "ne" ? no(result) : result;
  }
  /// Of (guard EXPR); an empty list holds.
  [[nodiscard]] expr holds(const Tree& guard, const Scope& s, const expr& when, expr& fault) const {
    return guard.items.empty() ? truth(true) : evaluate(guard.at(1), s, when, fault);
  }
  /// The statements of a list after its head.
  void execute(const Tree& body, const Scope& s, const expr& when, expr& fault) const {
    for (std::size_t k = 1; k < body.items.size() && !is(when, false); ++k) {
      const Tree& statement = body.items[k];
      const Text head = statement.head();
      const bool sets = head == "set" || head == "set-bind";
      const expr e = evaluate(statement.at(sets ? 2 : 1), s, when, fault);
      if (head == "if") {
        execute(statement["then"], s, both(when, e), fault);
        execute(statement["else"], s, both(when, no(e)), fault);
      } else if (sets) {
        expr& target = variable(statement, s, head == "set");
        target = choose(when, e, target);
      } else if (head != "do") {
        throw NotCheckable("a statement " + quoted(head));
      }
    }
  }
  /// Parameters as the system says, and the others.
  [[nodiscard]] Local local(const Atom& atom, const Values& others) const {
    Local local;
    std::size_t arg = 0;
    expr fault = truth(false);
    for (const Variable& variable : m_.atom_types[atom.type].variables) {
      const std::optional<int> value = others[local.size()];
      const expr other = value ? constant(variable.type, *value) : fresh(variable.type);
      local.push_back(variable.is_param ? evaluate(atom.args->at(++arg), {}, fault, fault) : other);
    }
    return local;
  }
  [[nodiscard]] Local initial(const Atom& atom, expr& fault) const {
    const AtomType& type = m_.atom_types[atom.type];
    Values first;
    for (const Variable& variable : type.variables)
      first.push_back(is_exact(variable.type) ? std::optional(0) : std::nullopt);
    Local start = local(atom, first);
    take(type, type.initial, start, truth(true), fault);
    return start;
  }
  [[nodiscard]] Offer offer(const AtomType& type, Local& local, expr& fault) const {
    const std::size_t count = type.ports.size();
    Offer offer{{}, Local(count, truth(false))};
    for (const Transition& t : type.transitions) {
      expr& going = offer.transitions.emplace_back(t.port == kNone ? truth(false) : marked(local, t.from));
      if (t.port == kNone) continue;
      going = both(going, holds(*t.guard, own(type, local), going, fault));
      // Two transitions of a port at a time are an error.
      fault = either(fault, both(offer.ports[t.port], going));
      offer.ports[t.port] = either(offer.ports[t.port], going);
    }
    std::vector<Rule> rules;
    for (const Tree* row : type.priorities) {
      Rule& rule = rules.emplace_back(Rule{holds((*row)["guard"], own(type, local), truth(true), fault), {}, {}});
      const Tree &low = (*row)["low"].at(1), &high = (*row)["high"].at(1);
      const auto fits = [&](const Tree& side, const Tree& other, std::size_t port) {
        return truth(side.text != "any" ? port == side.row() : other.text == "any" || port != other.row());
      };
      for (std::size_t port = 0; port < count; ++port) rule.low.push_back(fits(low, high, port));
      for (std::size_t port = 0; port < count; ++port) rule.high.push_back(fits(high, low, port));
    }
    // Ports above themselves are an error.
    if (!rules.empty()) fault = either(fault, hide(rules, offer.ports));
    return offer;
  }
  /// Hides what is low in a rule whose high thing is on, or a rule's that one leads to: by things that may be off. Is
  /// there a circle of them?
  [[nodiscard]] expr hide(const std::vector<Rule>& rules, Local& on) const {
    const std::size_t count = rules.size();
    std::vector<Local> leads(count, Local(count, truth(false)));
    Local hides;
    expr circle = truth(false);
    for (std::size_t r = 0; r < count; ++r) {
      expr above = truth(false);
      for (std::size_t k = 0; k < on.size(); ++k) {
        above = either(above, both(rules[r].high[k], on[k]));
        for (std::size_t s = 0; s < count && is(rules[r].high[k], true); ++s) {
          if (is(rules[s].low[k], true)) leads[r][s] = both(rules[r].guard, rules[s].guard);
        }
      }
      hides.push_back(both(rules[r].guard, above));
    }
    for (std::size_t by = 0; by < count; ++by) {
      for (std::size_t r = 0; r < count; ++r) {
        for (std::size_t s = 0; s < count && !is(leads[r][by], false); ++s)
          leads[r][s] = either(leads[r][s], both(leads[r][by], leads[by][s]));
      }
    }
    for (std::size_t r = 0; r < count; ++r) {
      expr hidden = hides[r];
      for (std::size_t s = 0; s < count; ++s) hidden = either(hidden, both(leads[r][s], hides[s]));
      for (std::size_t k = 0; k < on.size(); ++k) on[k] = both(on[k], no(both(hidden, rules[r].low[k])));
      circle = either(circle, leads[r][r]);
    }
    return circle;
  }
  /// An internal transition can be taken.
  [[nodiscard]] expr goes_on(const AtomType& type, Local& local) const {
    expr ignored = truth(false);
    return some(type.transitions, [&](const Transition& t) {
      return t.port != kNone ? truth(false)
                             : both(marked(local, t.from), holds(*t.guard, own(type, local), truth(true), ignored));
    });
  }
  /// Takes the transition and the internal ones that follow, from where `when` holds. Where those do not come to an end
  /// nothing is known, not even whether that is an error.
  void take(const AtomType& type, const Transition& first, Local& local, const expr& when, expr& fault) const {
    move(type, first, local, when, fault);
    Local now = local;
    expr active = when;
    for (int round = 0; !is(active, false); ++round) {
      expr any = truth(false);
      Local next = now;
      const bool is_lost = round > (is(active, true) ? kMaxClear : kMaxInternals);
      if (is_lost) fault = either(fault, both(active, fresh("bool")));
      for (std::size_t k = 0; k < now.size() && is_lost; ++k) now[k] = fresh(type.variables[k].type);
      for (const Transition& t : type.transitions) {
        if (t.port != kNone || is_lost) continue;
        const expr there = both(active, marked(now, t.from));
        const expr on = is(there, false) ? there : both(there, holds(*t.guard, own(type, now), there, fault));
        if (is(on, false)) continue;
        Local moved = now;
        move(type, t, moved, on, fault);
        if (is(any, false)) next = std::move(moved);
        else merge(on, moved, next);
        fault = either(fault, both(any, on));
        any = either(any, on);
      }
      merge(both(active, no(any)), now, local);
      active = any;
      now = std::move(next);
    }
  }
  /// Fires a port of the offer. If that is for sure, and in one way only, it is known where an automaton is before.
  void fire(const AtomType& type, const Offer& offer, std::size_t port, Local& now, Local& local, const expr& when,
            expr& fault) const {
    Rows ways;
    for (std::size_t t = 0; t < type.transitions.size(); ++t) {
      if (type.transitions[t].port == port && !is(offer.transitions[t], false)) ways.push_back(t);
    }
    const bool is_sure = ways.size() == 1 && is(when, true);
    for (std::size_t p = 0; p < type.places && is_sure && type.is_automaton; ++p)
      now[p] = truth(p == type.transitions[ways[0]].from[0]);
    const Local before = local;
    for (std::size_t t : ways) {
      const expr on = is_sure ? when : both(when, offer.transitions[t]);
      if (is(on, false)) continue;
      Local next = before;
      take(type, type.transitions[t], next, on, fault);
      merge(on, next, local);
    }
  }

 private:
  // Floats and C++ objects are terms of this width, which no other term has: constants, or of unknown value.
  static constexpr unsigned kVagueBits = 64;
  // Internal transitions in a row: in general, and where it is clear which.
  static constexpr int kMaxInternals = 24, kMaxClear = 100000;

  static bool can_solve(z3::solver& solver, const expr& e) {
    solver.push();
    solver.add(e);
    const z3::check_result answer = solver.check();
    solver.pop();
    return answer != z3::unknown ? answer == z3::sat : throw NotCheckable("the solver gives up");
  }
  template <class Number>
  static std::optional<bool> compare(Text op, Number a, Number b) {
    if (op == "eq" || op == "ne") return (a == b) == (op == "eq");
    if (op == "lt" || op == "ge") return op == "lt" ? a < b : a >= b;
    if (op == "gt" || op == "le") return op == "gt" ? a > b : a <= b;
    return std::nullopt;
  }
  // A float that is known, by its bits.
  [[nodiscard]] expr real(double value) const { return z_.bv_val(std::bit_cast<std::uint64_t>(value), kVagueBits); }
  static std::optional<double> real_of(const expr& e) {
    return is_vague(e) && e.is_numeral() ? std::optional(std::bit_cast<double>(e.get_numeral_uint64())) : std::nullopt;
  }
  // The same operation on the same terms has the same value, whatever that is: of a guard and its negation one holds.
  [[nodiscard]] expr unknown(Text type, Text op, const expr& a, const expr& b) const {
    const auto found = unknown_.find({op, a.id(), b.id()});
    if (found != unknown_.end()) return found->second.back();
    return unknown_.emplace(std::tuple(op, a.id(), b.id()), Local{a, b, fresh(type)}).first->second.back();
  }
  [[nodiscard]] expr compute(Text op, const expr& of_a, const expr& of_b) const {
    const std::optional<double> a = real_of(of_a), b = real_of(of_b);
    const bool is_sum = op == "add" || op == "sub", is_number = is_sum || op == "mul" || op == "div";
    if (!a || !b) return unknown(is_number ? "float" : "bool", op, of_a, of_b);
    if (is_sum) return real(op == "add" ? *a + *b : *a - *b);
    if (is_number) return real(op == "mul" ? *a * *b : *a / *b);
    const std::optional<bool> result = compare(op, *a, *b);
    return result ? truth(*result) : throw NotCheckable("an operation " + quoted(op) + " of floats");
  }
  static bool is_vague(const expr& e) { return e.is_bv() && e.get_sort().bv_size() == kVagueBits; }
  static Scope own(const AtomType& type, Local& local) { return {std::span(local).subspan(type.places), {}, {}}; }
  // (self ROW), (set-bind ROW EXPR)
  static expr& variable(const Tree& e, const Scope& s, bool is_self) {
    const std::size_t row = e.at(1).row();
    if (row >= (is_self ? s.self.size() : s.bind.size())) throw Rejected("a variable that there is not");
    return is_self ? s.self[row] : *s.bind[row];
  }
  [[nodiscard]] expr marked(const Local& local, const Rows& places) const {
    return all(places, [&](std::size_t place) { return local[place]; });
  }
  static void merge(const expr& when, const Local& from, Local& into) {
    for (std::size_t k = 0; k < into.size(); ++k) into[k] = choose(when, from[k], into[k]);
  }

  void move(const AtomType& type, const Transition& t, Local& local, const expr& when, expr& fault) const {
    // An automaton is where the transition leads to, and nowhere else.
    if (type.is_automaton) std::fill_n(local.begin(), type.places, truth(false));
    for (std::size_t place : t.from) local[place] = truth(false);
    for (std::size_t place : t.to) {
      fault = either(fault, both(when, local[place]));
      local[place] = truth(true);
    }
    execute(*t.action, own(type, local), when, fault);
    for (const Tree* row : type.invariants) {
      const Rows places = (*row)["places"].rows();
      const Text scope = row->at(3).text;
      expr applies = scope == "always" ? when : both(when, marked(local, places));
      for (std::size_t p = 0; p < type.places && scope == "at"; ++p)
        applies = contains(places, p) ? applies : both(applies, no(local[p]));
      fault = either(fault, both(applies, no(holds((*row)["guard"], own(type, local), applies, fault))));
    }
  }

  const Model& m_;
  z3::context& z_;
  z3::solver solver_;
  std::map<std::size_t, std::vector<expr>> assumed_;  // by atom
  // By operation and its terms, which are kept with the value: else their numbers would be given to others.
  mutable std::map<std::tuple<Text, unsigned, unsigned>, Local> unknown_;
};

}  // namespace certcheck
