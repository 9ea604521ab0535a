// Code and atoms over Z3 terms: bits as the language has them; floats that are not constants and what C++ gives are any
// value. An atom's state may be all constants, and then so is what it does: the same functions serve single modes and
// all states at once. Recursion follows the trees of the .bsys, whose depth its reader bounds.
#pragma once
#include <bit>
#include <cmath>
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
  return e.is_bv() && e.is_numeral() ? std::optional(static_cast<int>(static_cast<unsigned>(e.get_numeral_uint64())))
                                     : std::nullopt;
}
[[nodiscard]] inline expr equals(const expr& e, int value) {
  if (e.is_bool()) return value != 0 ? e : no(e);
  const std::optional<int> known = value_of(e);
  return known ? e.ctx().bool_val(*known == value) : e == e.ctx().bv_val(value, e.get_sort().bv_size());
}

/// An atom's state, by variable.
using Local = std::vector<expr>;
/// What it can do: its transitions (internal ones: false) and ports, after the atom's priorities. With time, by port:
/// has it two transitions, an eager one, a delayable one; one that is not there any more a tick later; one that was not
/// there a tick before, because of a bound with `>`?
struct Offer {
  Local transitions, ports, twice, eager, delayable, ends, opens;
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
  Terms(const Model& model, z3::context& z)
      : model_(model), z3_(z), solver_(model.is_timed ? z3::solver(z) : z3::solver(z, "QF_BV")) {}

  /// The argument of an atom may be any value.
  void let(const Tree* arg, const expr& value) { args_.emplace(arg, value); }
  /// What is assumed between the two is forgotten then.
  void begin() { solver_.push(); }
  void end() { solver_.pop(); }
  /// What `may_be` takes for granted from now on; what speaks of one atom alone may say so.
  void assume(const expr& e, std::size_t atom = kNone) {
    if (is(e, true)) return;
    solver_.add(e);
    if (atom != kNone) assumed_[atom].push_back(e);
  }
  /// Throws where the solver gives up.
  [[nodiscard]] bool may_be(const expr& e) { return is(e, true) || (!is(e, false) && can_solve(solver_, e)); }
  /// With what is assumed of some atoms alone, which is much quicker, and false only where it is without, too.
  [[nodiscard]] bool may_be(const expr& e, const std::set<std::size_t>& alone) {
    expr whole = e;
    if (model_.is_timed) return may_be(e);
    for (std::size_t atom : alone)
      for (const expr& fact : assumed_[atom]) whole = both(whole, fact);
    z3::solver few(z3_, "QF_BV");
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

  [[nodiscard]] expr truth(bool b) const { return z3_.bool_val(b); }
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
    const z3::sort sort = type == "bool"    ? z3_.bool_sort()
                          : type == "clock" ? z3_.int_sort()
                                            : z3_.bv_sort(is_exact(type) ? 32 : kVagueBits);
    return expr(z3_, Z3_mk_fresh_const(z3_, "any", sort));
  }
  /// An int, a bool or the row of a string.
  [[nodiscard]] expr constant(Text type, int value) const {
    return type == "bool" ? truth(value != 0) : z3_.bv_val(value, 32);
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
      const auto found = model_.strings.find(e.text);
      return constant("string", found == model_.strings.end() ? 0 : found->second);
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
      Local args;
      for (std::size_t k = 2; k < e.items.size(); ++k) args.push_back(evaluate(e.items[k], s, when, fault));
      const Tree &function = *model_.functions.at(e.at(1).row()), &result = function["result"];
      if (function.has_word("draw", 3)) return drawn(function.at(2).text, result.at(1).text, args, when, fault);
      return fresh(result.items.empty() ? "int" : result.at(1).text);
    }
    static const std::vector<Text> kLeaves{"at", "data", "can-port", "can", "happens", "happens-port"};
    if (s.about && contains(kLeaves, op)) return s.about(e);
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
    const Z3_ast made = found->second(z3_, a, b);
    z3_.check_error();
    const expr result = expr(z3_, made).simplify();
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
    for (const Variable& variable : model_.atom_types[atom.type].variables) {
      const std::optional<int> value = others[local.size()];
      const expr other = value ? constant(variable.type, *value) : fresh(variable.type);
      const auto any = variable.is_param ? args_.find(&atom.args->at(++arg)) : args_.end();
      local.push_back(any != args_.end()  ? any->second
                      : variable.is_param ? evaluate(atom.args->at(arg), {}, fault, fault)
                                          : other);
    }
    forget_settings(model_.atom_types[atom.type], local);
    return local;
  }
  [[nodiscard]] Local initial(const Atom& atom, expr& fault) const {
    const AtomType& type = model_.atom_types[atom.type];
    Values first;
    for (const Variable& variable : type.variables)
      first.push_back(is_exact(variable.type) ? std::optional(0) : std::nullopt);
    Local start = local(atom, first);
    for (std::size_t k = type.first_clock; k < type.waits; ++k) start[k] = z3_.int_val(0);
    take(type, type.initial, start, truth(true), fault);
    if (type.is_timed)
      start[type.waits] = constant("int", type.initial.resume->items.empty() ? 0 : count_of(type.transitions) + 1);
    return start;
  }
  /// Do the bounds on clocks of a list hold, so many ticks from now?
  [[nodiscard]] expr in_time(const AtomType& type, const Tree& list, const Local& local, int later, const expr& when,
                             expr& fault) const {
    expr result = truth(true);
    each_bound(type, list, local, when, fault, [&](Text op, const expr& clock, bool runs, const expr& limit) {
      const expr value = runs && later != 0 ? (clock + z3_.int_val(later)).simplify() : clock;
      const expr holds = op == "lt"   ? value < limit
                         : op == "le" ? value <= limit
                         : op == "gt" ? value > limit
                         : op == "ge" ? value >= limit
                         : op == "eq" ? value == limit
                                      : throw Rejected("a bound " + quoted(op));
      result = both(result, holds.simplify());
    });
    return result;
  }
  /// Does what the atom waits for hold, so many ticks from now? In a state whose `waits` is a constant.
  [[nodiscard]] expr may_resume(const AtomType& type, Local& local, int later, expr& fault) const {
    const auto row = static_cast<std::size_t>(value_of(local[type.waits]).value_or(0));
    const Tree& resume =
        row == 0 || row > type.transitions.size() ? *type.initial.resume : *type.transitions[row - 1].resume;
    const expr guard = holds(resume["guard"], own(type, local), truth(true), fault);
    return both(guard, in_time(type, resume, local, later, guard, fault));
  }
  /// Do the invariants of its places let time be, so many ticks from now?
  [[nodiscard]] expr may_be_then(const AtomType& type, const Local& local, int later, expr& fault) const {
    return all(type.invariants, [&](const Tree* row) {
      const expr applies = is_in_scope(type, *row, local, truth(true));
      return either(no(applies), in_time(type, *row, local, later, applies, fault));
    });
  }
  [[nodiscard]] Offer offer(const AtomType& type, Local& local, expr& fault) const {
    const std::size_t count = type.ports.size();
    const Local none(count, truth(false));
    Offer offer{{}, none, none, none, none, none, none};
    const expr is_idle = type.is_timed ? equals(local[type.waits], 0) : truth(true);
    for (const Transition& t : type.transitions) {
      expr& going = offer.transitions.emplace_back(t.port == kNone ? truth(false) : marked(local, t.from));
      if (t.port == kNone) continue;
      going = both(both(is_idle, going), holds(*t.guard, own(type, local), going, fault));
      going = both(going, in_time(type, *t.row, local, 0, going, fault));
      // Two transitions of a port at a time are an error; with time where it fires.
      const expr is_twice = both(offer.ports[t.port], going);
      if (!type.is_timed) fault = either(fault, is_twice);
      offer.ports[t.port] = either(offer.ports[t.port], going);
      if (!type.is_timed || is(going, false)) continue;
      offer.twice[t.port] = either(offer.twice[t.port], is_twice);
      if (t.is_eager) offer.eager[t.port] = either(offer.eager[t.port], going);
      if (t.is_delayable) offer.delayable[t.port] = either(offer.delayable[t.port], going);
      const expr ends = both(going, no(in_time(type, *t.row, local, 1, going, fault)));
      offer.ends[t.port] = either(offer.ends[t.port], ends);
      each_bound(type, *t.row, local, going, fault, [&](Text op, const expr& clock, bool runs, const expr& limit) {
        if (op == "gt" && runs)
          offer.opens[t.port] = either(offer.opens[t.port], both(going, (clock == limit + 1).simplify()));
      });
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
  /// Fires a port of the offer; `waits` says which transition it was. If that is for sure, and in one way only, it is
  /// known where an automaton is before.
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
      if (type.is_timed) next[type.waits] = constant("int", static_cast<int>(t) + 1);
      merge(on, next, local);
    }
    fault = either(fault, both(when, offer.twice[port]));
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
  [[nodiscard]] expr real(double value) const { return z3_.bv_val(std::bit_cast<std::uint64_t>(value), kVagueBits); }
  static std::optional<double> real_of(const expr& e) {
    return is_vague(e) && e.is_numeral() ? std::optional(std::bit_cast<double>(e.get_numeral_uint64())) : std::nullopt;
  }
  // What a distribution of std.chance can give; the first argument is the generator, which nothing else reads. Numbers
  // that it cannot have are errors, perhaps: where they are constants the compiler has looked at them.
  [[nodiscard]] expr drawn(Text name, Text type, const Local& args, const expr& when, expr& fault) const {
    if (name == "uniform" && type == "int") {
      const expr value = fresh(type), &low = args.at(1), &high = args.at(2);
      fault = either(fault, both(when, (high < low).simplify()));
      return choose((low <= value && value <= high).simplify(), value, low);
    }
    std::vector<std::optional<double>> numbers;
    for (const expr& arg : args) numbers.push_back(real_of(arg));
    const auto is_within = [&](std::size_t k, double least, double most) {
      return numbers.at(k) && *numbers[k] >= least && *numbers[k] <= most;
    };
    constexpr double kMost = std::numeric_limits<double>::max(), kLeast = std::numeric_limits<double>::denorm_min();
    const bool is_table = name == "table", is_normal = name == "normal" && args.size() == 3;
    bool is_sound = name == "flip"          ? is_within(1, 0, 1)
                    : name == "exponential" ? is_within(1, kLeast, kMost)
                    : is_normal             ? is_within(1, -kMost, kMost) && is_within(2, 0, kMost)
                    : name == "uniform"     ? is_within(1, -kMost, kMost) && is_within(2, *numbers[1], kMost)
                                            : is_table;
    std::optional<expr> value;
    double total = 0;
    for (std::size_t k = 1; k + 1 < args.size() && is_table; k += 2) {
      is_sound = is_sound && is_within(k + 1, 0, kMost);
      total += numbers[k + 1].value_or(0);
      if (numbers[k + 1] == 0.0) continue;
      value = value ? choose(fresh("bool"), args[k], *value) : args[k];
    }
    if (!is_sound || (is_table && total <= 0)) fault = either(fault, both(when, fresh("bool")));
    if (is_table) return value ? *value : fresh(type);
    if (name == "flip" && (numbers.at(1) == 0.0 || numbers[1] == 1.0)) return truth(numbers[1] == 1.0);
    return fresh(type);
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
    for (std::size_t k = 0; k < type.clocks.size(); ++k) {
      const Clock& clock = type.clocks[k];
      expr& value = local[type.first_clock + k];
      const expr &is_set = local[clock.first_slot + 1], &to = local[clock.first_slot];
      if (!z3::eq(local[clock.first_slot + 2], real(1)))
        throw NotCheckable("clock " + quoted(clock.name) + " runs at another speed than 1");
      if (!is(is_set, false)) value = choose(is_set, ticks_of(to, clock, when, fault), value);
    }
    forget_settings(type, local);
    for (const Tree* row : type.invariants) {
      const expr applies = is_in_scope(type, *row, local, when);
      fault = either(fault, both(applies, no(holds((*row)["guard"], own(type, local), applies, fault))));
    }
  }

  // What code sets clocks to: nothing yet.
  void forget_settings(const AtomType& type, Local& local) const {
    for (const Clock& clock : type.clocks) {
      local[clock.first_slot] = real(0);
      local[clock.first_slot + 1] = truth(false);
      local[clock.first_slot + 2] = real(1);
    }
  }
  static int count_of(const std::vector<Transition>& rows) { return static_cast<int>(rows.size()); }
  [[nodiscard]] expr is_in_scope(const AtomType& type, const Tree& invariant, const Local& local,
                                 const expr& when) const {
    const Rows places = invariant["places"].rows();
    const Text scope = invariant.at(3).text;
    expr applies = scope == "always" ? when : both(when, marked(local, places));
    for (std::size_t p = 0; p < type.places && scope == "at"; ++p)
      applies = contains(places, p) ? applies : both(applies, no(local[p]));
    return applies;
  }
  // A float in a clock's unit, to the nearest tick: constants, perhaps by cases. Not a number: nothing.
  [[nodiscard]] std::optional<expr> ticks_of(const expr& e, const Clock& clock) const {
    constexpr std::int64_t kMost = std::int64_t{1} << 62;
    constexpr double kExact = 9007199254740992.0;
    const std::optional<double> value = real_of(e);
    if (!value) throw NotCheckable("clock " + quoted(clock.name) + " meets a value that is not followed");
    if (std::isnan(*value)) return std::nullopt;
    const double exact = *value * static_cast<double>(clock.unit);
    if (!(std::fabs(exact) <= static_cast<double>(kMost))) return z3_.int_val(exact > 0 ? kMost : -kMost);
    const bool is_whole = std::fabs(*value) <= kExact && std::floor(*value) == *value;
    return z3_.int_val(is_whole ? static_cast<std::int64_t>(*value) * clock.unit : std::int64_t{std::llround(exact)});
  }
  // What a clock is set to. Beyond what one can be: an error.
  [[nodiscard]] expr ticks_of(const expr& e, const Clock& clock, const expr& when, expr& fault) const {
    if (e.is_app() && e.decl().decl_kind() == Z3_OP_ITE)
      return z3::ite(e.arg(0), ticks_of(e.arg(1), clock, both(when, e.arg(0)), fault),
                     ticks_of(e.arg(2), clock, both(when, no(e.arg(0))), fault));
    const std::optional<expr> value = ticks_of(e, clock);
    const bool is_far = !value || std::fabs(real_of(e).value_or(0) * static_cast<double>(clock.unit)) > 0x1p62;
    if (is_far) fault = either(fault, when);
    return is_far ? fresh("clock") : *value;
  }
  // (bound OP CLOCK [(minus CLOCK)] TICKS|(slot SLOT)): its operator, the clock's value, less the other's; does that
  // change with time; the limit. What compares with no number never holds.
  void each_bound(const AtomType& type, const Tree& list, const Local& local, const expr& when, expr& fault,
                  const std::function<void(Text, const expr&, bool, const expr&)>& visit) const {
    if (is(when, false)) return;
    Local measured = local;
    expr ends = truth(false);
    execute(list["measure"], own(type, measured), truth(true), ends);
    fault = either(fault, both(when, ends));
    for (const Tree* bound : list.all("bound")) {
      const Tree &minus = (*bound)["minus"], &slot = (*bound)["slot"];
      const std::size_t row = bound->at(2).row();
      expr value = local[type.first_clock + row];
      if (!minus.items.empty()) value = (value - local[type.first_clock + minus.at(1).row()]).simplify();
      const std::optional<expr> limit = slot.items.empty()
                                            ? z3_.int_val(bound->items.back().ticks())
                                            : ticks_of(measured[type.places + slot.at(1).row()], type.clocks[row]);
      if (limit) visit(bound->at(1).text, value, minus.items.empty(), *limit);
      else visit("lt", z3_.int_val(0), false, z3_.int_val(0));
    }
  }

  const Model& model_;
  z3::context& z3_;
  z3::solver solver_;
  std::map<std::size_t, std::vector<expr>> assumed_;  // by atom
  std::map<const Tree*, expr> args_;
  // By operation and its terms, which are kept with the value: else their numbers would be given to others.
  mutable std::map<std::tuple<Text, unsigned, unsigned>, Local> unknown_;
};

}  // namespace certcheck
