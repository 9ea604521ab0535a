// Expressions and statements. Recursion follows the trees of the .bsys, whose depth its readers bound.
#include "tools/certcheck/terms.hpp"

#include <charconv>
#include <limits>

namespace certcheck {

namespace {
// Floats and C++ objects are terms of this width, so that it shows that nothing is known of them.
constexpr unsigned kVagueBits = 64;
bool is_vague(const z3::expr& e) { return e.is_bv() && e.get_sort().bv_size() == kVagueBits; }
}  // namespace

z3::expr both(const z3::expr& a, const z3::expr& b) { return is(a, true) || is(b, false) ? b : is(b, true) || is(a, false) ? a : a && b; }
z3::expr either(const z3::expr& a, const z3::expr& b) { return is(a, false) || is(b, true) ? b : is(b, false) || is(a, true) ? a : a || b; }
z3::expr no(const z3::expr& a) { return is(a, true) || is(a, false) ? a.ctx().bool_val(is(a, false)) : !a; }
z3::expr choose(const z3::expr& when, const z3::expr& yes, const z3::expr& otherwise) {
  return z3::eq(yes, otherwise) || is(when, true) ? yes : is(when, false) ? otherwise : z3::ite(when, yes, otherwise).simplify();
}

void Terms::assume(const z3::expr& e, std::size_t atom) {
  if (is(e, true)) return;
  solver_.add(e);
  if (atom != kNone) assumed_[atom].push_back(e);
}

bool Terms::may_be(const z3::expr& e) {
  if (is(e, true) || is(e, false)) return is(e, true);
  solver_.push();
  solver_.add(e);
  const z3::check_result answer = solver_.check();
  solver_.pop();
  if (answer == z3::unknown) throw NotCheckable("the solver gives up");
  return answer == z3::sat;
}

bool Terms::may_be_alone(const z3::expr& e, const std::map<std::size_t, Local>& atoms) {
  if (is(e, true) || is(e, false)) return is(e, true);
  z3::solver few(z_, "QF_BV");
  few.add(e);
  for (const auto& [atom, local] : atoms) {
    for (const z3::expr& one : assumed_[atom]) few.add(one);
  }
  return few.check() != z3::unsat;
}

z3::expr Terms::fresh(std::string_view type) const {
  const z3::sort sort = type == "bool" ? z_.bool_sort() : z_.bv_sort(is_exact(type) ? 32 : kVagueBits);
  return z3::expr(z_, Z3_mk_fresh_const(z_, "any", sort));
}

std::optional<int> Terms::value(const z3::expr& e) {
  if (is(e, true) || is(e, false)) return is(e, true) ? 1 : 0;
  return e.is_numeral() ? std::optional(static_cast<int>(static_cast<unsigned>(e.get_numeral_uint64()))) : std::nullopt;
}

z3::expr Terms::evaluate(const Tree& e, const Variables& v, const z3::expr& when, z3::expr& fault) const {
  if (e.is_string) {
    const auto found = m_.strings.find(e.text);
    return z_.bv_val(found == m_.strings.end() ? 0 : found->second, 32);
  }
  if (!e.is_list) {
    if (e.text == "true" || e.text == "false") return truth(e.text == "true");
    int value = 0;
    const auto [end, error] = std::from_chars(e.text.data(), e.text.data() + e.text.size(), value);
    return error == std::errc() && end == e.text.data() + e.text.size() ? z_.bv_val(value, 32) : fresh("float");
  }
  const std::string_view op = e.head();
  if (op == "self" || op == "bind") {
    const auto& read = op == "self" ? v.self : v.bind;
    return read ? read(e.at(1).row()) : throw Rejected("a variable that there is not");
  }
  if (op == "call") {
    for (std::size_t k = 2; k < e.items.size(); ++k) (void)evaluate(e.items[k], v, when, fault);
    const Tree& result = (*m_.functions.at(e.at(1).row()))["result"];
    return fresh(result.items.empty() ? "int" : result.at(1).text);
  }
  if (v.about && (op == "at" || op == "data" || op == "can-port" || op == "can")) return v.about(e);
  const z3::expr a = evaluate(e.at(1), v, when, fault);
  if (op == "to-float" || (op == "neg" && is_vague(a))) return fresh("float");
  if (op == "not") return no(a);
  if (op == "neg") return (-a).simplify();
  if (op == "bit-not") return (~a).simplify();
  if (op == "and" || op == "or") {
    const z3::expr b = evaluate(e.at(2), v, both(when, op == "and" ? a : no(a)), fault);
    return op == "and" ? both(a, b) : either(a, b);
  }
  const z3::expr b = evaluate(e.at(2), v, when, fault);
  if (is_vague(a)) return fresh(op == "add" || op == "sub" || op == "mul" || op == "div" ? "float" : "bool");
  if (op == "div" || op == "mod") {
    const z3::expr least = z_.bv_val(std::numeric_limits<int>::min(), 32), minus = z_.bv_val(-1, 32);
    fault = either(fault, both(when, (b == z_.bv_val(0, 32) || (a == least && b == minus)).simplify()));
  }
  using Binary = z3::expr (*)(const z3::expr&, const z3::expr&);
  static const std::map<std::string_view, Binary> operations{
      {"div", [](const z3::expr& x, const z3::expr& y) { return x / y; }},
      {"mod", [](const z3::expr& x, const z3::expr& y) { return z3::srem(x, y); }},
      {"eq", [](const z3::expr& x, const z3::expr& y) { return x == y; }},
      {"ne", [](const z3::expr& x, const z3::expr& y) { return x != y; }},
      {"lt", [](const z3::expr& x, const z3::expr& y) { return x < y; }},
      {"gt", [](const z3::expr& x, const z3::expr& y) { return x > y; }},
      {"le", [](const z3::expr& x, const z3::expr& y) { return x <= y; }},
      {"ge", [](const z3::expr& x, const z3::expr& y) { return x >= y; }},
      {"add", [](const z3::expr& x, const z3::expr& y) { return x + y; }},
      {"sub", [](const z3::expr& x, const z3::expr& y) { return x - y; }},
      {"mul", [](const z3::expr& x, const z3::expr& y) { return x * y; }},
      {"bit-and", [](const z3::expr& x, const z3::expr& y) { return x & y; }},
      {"bit-or", [](const z3::expr& x, const z3::expr& y) { return x | y; }},
      {"bit-xor", [](const z3::expr& x, const z3::expr& y) { return x ^ y; }}};
  const auto found = operations.find(op);
  if (found == operations.end()) throw NotCheckable("an expression `" + std::string(op) + "`");
  return found->second(a, b).simplify();
}

z3::expr Terms::holds(const Tree& guard, const Variables& v, const z3::expr& when, z3::expr& fault) const {
  return guard.items.empty() ? truth(true) : evaluate(guard.at(1), v, when, fault);
}

void Terms::execute(const Tree& body, const Variables& v, const z3::expr& when, z3::expr& fault) const {
  for (std::size_t k = 1; k < body.items.size() && !is(when, false); ++k) {
    const Tree& s = body.items[k];
    if (s.head() == "if") {
      const z3::expr holds = evaluate(s.at(1), v, when, fault);
      execute(s["then"], v, both(when, holds), fault);
      execute(s["else"], v, both(when, no(holds)), fault);
    } else if (s.head() == "do") {
      (void)evaluate(s.at(1), v, when, fault);
    } else {
      const std::size_t row = s.at(1).row();
      const z3::expr value = evaluate(s.at(2), v, when, fault);
      if (s.head() == "set") v.set_self(row, choose(when, value, v.self(row)));
      else if (s.head() == "set-bind" && v.set_bind) v.set_bind(row, choose(when, value, v.bind(row)));
      else throw NotCheckable("a statement `" + std::string(s.head()) + "`");
    }
  }
}

}  // namespace certcheck
