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

z3::expr Terms::fresh(Text type) const {
  const z3::sort sort = type == "bool" ? z_.bool_sort() : z_.bv_sort(is_exact(type) ? 32 : kVagueBits);
  return z3::expr(z_, Z3_mk_fresh_const(z_, "any", sort));
}

std::optional<int> Terms::value(const z3::expr& e) {
  if (is(e, true) || is(e, false)) return is(e, true) ? 1 : 0;
  return e.is_numeral() ? std::optional(static_cast<int>(static_cast<unsigned>(e.get_numeral_uint64()))) : std::nullopt;
}

z3::expr Terms::equals(const z3::expr& e, int value) {
  if (e.is_bool()) return value != 0 ? e : no(e);
  const std::optional<int> known = Terms::value(e);
  return known ? e.ctx().bool_val(*known == value) : e == e.ctx().bv_val(value, e.get_sort().bv_size());
}

z3::expr Terms::has(const Local& local, const Values& values, std::size_t first) const {
  z3::expr all = truth(true);
  for (std::size_t k = first; k < local.size(); ++k) all = values[k] ? both(all, equals(local[k], *values[k])) : all;
  return all;
}

z3::expr Terms::evaluate(const Tree& e, const Scope& s, const z3::expr& when, z3::expr& fault) const {
  if (e.is_string) {
    const auto found = m_.strings.find(e.text);
    return constant("string", found == m_.strings.end() ? 0 : found->second);
  }
  if (!e.is_list) {
    if (e.text == "true" || e.text == "false") return truth(e.text == "true");
    int value = 0;
    const auto [end, error] = std::from_chars(e.text.data(), e.text.data() + e.text.size(), value);
    return error == std::errc() && end == e.text.data() + e.text.size() ? constant("int", value) : fresh("float");
  }
  const Text op = e.head();
  if (op == "self" || op == "bind") {
    const std::size_t row = e.at(1).row();
    if (row >= (op == "self" ? s.self.size() : s.bind.size())) throw Rejected("a variable that there is not");
    return op == "self" ? s.self[row] : *s.bind[row];
  }
  if (op == "call") {
    for (std::size_t k = 2; k < e.items.size(); ++k) (void)evaluate(e.items[k], s, when, fault);
    const Tree& result = (*m_.functions.at(e.at(1).row()))["result"];
    return fresh(result.items.empty() ? "int" : result.at(1).text);
  }
  if (s.about && (op == "at" || op == "data" || op == "can-port" || op == "can")) return s.about(e);
  const z3::expr a = evaluate(e.at(1), s, when, fault);
  if (op == "to-float" || (op == "neg" && is_vague(a))) return fresh("float");
  if (op == "not") return no(a);
  if (op == "neg") return (-a).simplify();
  if (op == "bit-not") return (~a).simplify();
  if (op == "and" || op == "or") {
    const z3::expr b = evaluate(e.at(2), s, both(when, op == "and" ? a : no(a)), fault);
    return op == "and" ? both(a, b) : either(a, b);
  }
  const z3::expr b = evaluate(e.at(2), s, when, fault);
  if (is_vague(a)) return fresh(op == "add" || op == "sub" || op == "mul" || op == "div" ? "float" : "bool");
  if (op == "div" || op == "mod") {
    const z3::expr overflows = both(equals(a, std::numeric_limits<int>::min()), equals(b, -1));
    fault = either(fault, both(when, either(equals(b, 0), overflows)));
  }
  static const std::map<Text, Z3_ast (*)(Z3_context, Z3_ast, Z3_ast)> kOperations{
      {"add", Z3_mk_bvadd}, {"sub", Z3_mk_bvsub}, {"mul", Z3_mk_bvmul}, {"div", Z3_mk_bvsdiv}, {"mod", Z3_mk_bvsrem},
      {"bit-and", Z3_mk_bvand}, {"bit-or", Z3_mk_bvor}, {"bit-xor", Z3_mk_bvxor}, {"eq", Z3_mk_eq}, {"ne", Z3_mk_eq},
      {"lt", Z3_mk_bvslt}, {"le", Z3_mk_bvsle}, {"gt", Z3_mk_bvsgt}, {"ge", Z3_mk_bvsge}};
  const auto found = kOperations.find(op);
  if (found == kOperations.end()) throw NotCheckable("an expression `" + std::string(op) + "`");
  const Z3_ast made = found->second(z_, a, b);
  z_.check_error();
  const z3::expr result = z3::expr(z_, made).simplify();
  return op == "ne" ? no(result) : result;
}

z3::expr Terms::holds(const Tree& guard, const Scope& s, const z3::expr& when, z3::expr& fault) const {
  return guard.items.empty() ? truth(true) : evaluate(guard.at(1), s, when, fault);
}

void Terms::execute(const Tree& body, const Scope& s, const z3::expr& when, z3::expr& fault) const {
  for (std::size_t k = 1; k < body.items.size() && !is(when, false); ++k) {
    const Tree& statement = body.items[k];
    const Text head = statement.head();
    const z3::expr e = evaluate(statement.at(head == "set" || head == "set-bind" ? 2 : 1), s, when, fault);
    if (head == "if") {
      execute(statement["then"], s, both(when, e), fault);
      execute(statement["else"], s, both(when, no(e)), fault);
    } else if (head == "set" || head == "set-bind") {
      const std::size_t row = statement.at(1).row();
      if (row >= (head == "set" ? s.self.size() : s.bind.size())) throw Rejected("a variable that there is not");
      z3::expr& variable = head == "set" ? s.self[row] : *s.bind[row];
      variable = choose(when, e, variable);
    } else if (head != "do") {
      throw NotCheckable("a statement `" + std::string(head) + "`");
    }
  }
}

Local Terms::local(const Atom& atom, const std::function<z3::expr(std::size_t)>& others) const {
  const AtomType& type = m_.atom_types[atom.type];
  Local local;
  std::size_t arg = 0;
  z3::expr fault = truth(false);
  for (std::size_t k = 0; k < type.variables.size(); ++k) {
    local.push_back(type.variables[k].is_param ? evaluate(atom.args->at(++arg), {}, fault, fault) : others(k));
  }
  return local;
}

}  // namespace certcheck
