// Expressions and statements. Recursion follows the trees of the .bsys, whose depth its readers bound.
#include "tools/certcheck/terms.hpp"

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

z3::expr Terms::fresh(const std::string& type) const {
  const z3::sort sort = type == "bool" ? z_.bool_sort() : z_.bv_sort(is_exact(type) ? 32 : kVagueBits);
  return z3::expr(z_, Z3_mk_fresh_const(z_, "any", sort));
}

z3::expr Terms::evaluate(const Tree& e, const Variables& v, const z3::expr& when, z3::expr& fault) const {
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
  if (op == "self" || op == "bind") {
    const auto& read = op == "self" ? v.self : v.bind;
    return read ? read(e.items.at(1).row()) : throw Rejected("a variable that there is not");
  }
  if (op == "call") {
    for (std::size_t k = 2; k < e.items.size(); ++k) (void)evaluate(e.items[k], v, when, fault);
    const Tree* result = m_.functions.at(e.items.at(1).row())->find("result");
    return fresh(result == nullptr ? "int" : result->items.at(1).text);
  }
  if (v.about && (op == "at" || op == "data" || op == "can-port" || op == "can")) return v.about(e);
  const z3::expr a = evaluate(e.items.at(1), v, when, fault);
  if (op == "to-float" || (op == "neg" && is_vague(a))) return fresh("float");
  if (op == "not") return no(a);
  if (op == "neg") return (-a).simplify();
  if (op == "bit-not") return (~a).simplify();
  if (op == "and" || op == "or") {
    const z3::expr b = evaluate(e.items.at(2), v, both(when, op == "and" ? a : no(a)), fault);
    return op == "and" ? both(a, b) : either(a, b);
  }
  const z3::expr b = evaluate(e.items.at(2), v, when, fault);
  if (is_vague(a)) return fresh(op == "add" || op == "sub" || op == "mul" || op == "div" ? "float" : "bool");
  if (op == "div" || op == "mod") {
    const z3::expr least = z_.bv_val(std::numeric_limits<int>::min(), 32), minus = z_.bv_val(-1, 32);
    fault = either(fault, both(when, (b == z_.bv_val(0, 32) || (a == least && b == minus)).simplify()));
  }
  using Binary = z3::expr (*)(const z3::expr&, const z3::expr&);
  static const std::map<std::string, Binary> operations{
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
  if (found == operations.end()) throw NotCheckable("an expression `" + op + "`");
  return found->second(a, b).simplify();
}

void Terms::execute(const Tree* body, std::size_t first, const Variables& v, const z3::expr& when, z3::expr& fault) const {
  for (std::size_t k = first; body != nullptr && k < body->items.size() && !is(when, false); ++k) {
    const Tree& s = body->items[k];
    if (s.head() == "if") {
      const z3::expr holds = evaluate(s.items.at(1), v, when, fault);
      execute(s.find("then"), 1, v, both(when, holds), fault);
      execute(s.find("else"), 1, v, both(when, no(holds)), fault);
    } else if (s.head() == "do") {
      (void)evaluate(s.items.at(1), v, when, fault);
    } else {
      const std::size_t row = s.items.at(1).row();
      const z3::expr value = evaluate(s.items.at(2), v, when, fault);
      if (s.head() == "set") v.set_self(row, choose(when, value, v.self(row)));
      else if (s.head() == "set-bind" && v.set_bind) v.set_bind(row, choose(when, value, v.bind(row)));
      else throw NotCheckable("a statement `" + s.head() + "`");
    }
  }
}

}  // namespace certcheck
