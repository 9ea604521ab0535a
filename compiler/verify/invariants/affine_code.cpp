// See affine_code.hpp. Recursion follows the code's trees, whose depth the parser and .bsys reader bound.
#include "compiler/verify/invariants/affine_code.hpp"

#include <algorithm>
#include <iterator>

namespace bip::verify {

namespace {
std::optional<AffineForm> at(const AffineValues& values, std::uint32_t index) {
  return index < values.size() ? values[index] : std::nullopt;
}
bool is_small(std::int64_t value) { return value >= -AffineForm::kMaxNumber && value <= AffineForm::kMaxNumber; }
}  // namespace

// a + times * b
std::optional<AffineForm> AffineCode::sum(const AffineForm& a, std::int64_t times, const AffineForm& b) {
  AffineForm result = a;
  const auto add = [&](std::int64_t& to, std::int64_t value) {
    to += times * value;
    return is_small(to);
  };
  bool fits = add(result.constant, b.constant);
  for (const auto& [variable, factor] : b.factors) fits = add(result.factors[variable], factor) && fits;
  std::erase_if(result.factors, [](const auto& term) { return term.second == 0; });
  return fits ? std::optional(std::move(result)) : std::nullopt;
}

AffineCode::Form AffineCode::constant(const Expr& e) {
  return e.op == Op::ConstInt && is_small(e.int_value) ? Form(AffineForm{{}, e.int_value}) : std::nullopt;
}

AffineCode::Form AffineCode::load(const Expr& e, const AffinePath& path) {
  return at(e.op == Op::LoadSelf ? path.self : path.bind, e.index);
}

AffineCode::Form AffineCode::unary(const Expr& e, const Form& a, const AffinePath&) {
  return e.op == Op::Neg && a ? sum({}, -1, *a) : std::nullopt;
}

AffineCode::Form AffineCode::binary(const Expr& e, const Form& a, const Form& b, const AffinePath&) {
  if (!a || !b) return std::nullopt;
  switch (e.op) {
    case Op::Add: return sum(*a, 1, *b);
    case Op::Sub: return sum(*a, -1, *b);
    case Op::Mul:
      if (!a->factors.empty() && !b->factors.empty()) return std::nullopt;
      return a->factors.empty() ? sum({}, a->constant, *b) : sum({}, b->constant, *a);
      BIP_LEAF_OPS(BIP_OP_CASE)
      BIP_UNARY_OPS(BIP_OP_CASE)
      BIP_DIVISION_OPS(BIP_OP_CASE)
      BIP_BITWISE_OPS(BIP_OP_CASE)
      BIP_LOGIC_OPS(BIP_OP_CASE)
      BIP_COMPARISON_OPS(BIP_OP_CASE)
      break;
  }
  return std::nullopt;
}

void AffineCode::assume(ExprId condition, AffinePath& path) {
  if (!condition.is_valid()) return;
  const Expr& e = code_.exprs[condition];
  if (e.op == Op::And) {
    assume(e.a, path);
    assume(e.b, path);
  } else if (e.op == Op::Eq && code_.exprs[e.a].type == Type::Int) {
    const std::optional<AffineForm> a = evaluate(e.a, path), b = evaluate(e.b, path);
    if (!a || !b) return;
    if (std::optional<AffineForm> difference = sum(*a, -1, *b)) path.zeros.push_back(std::move(*difference));
  }
}

bool AffineCode::execute(StmtId body, std::vector<AffinePath>& paths) {
  AffinePaths state{paths};
  AbstractInterpreter::execute(body, state);
  return !state.are_too_many;
}

// Statement by statement, on all ways so far.
void AffineCode::branch(const Stmt& s, AffinePaths& paths) {
  std::vector<AffinePath> others = paths.all;
  for (AffinePath& path : paths.all) assume(s.value, path);
  paths.are_too_many = !execute(s.then_body, paths.all) || !execute(s.else_body, others);
  if (paths.are_too_many) return;
  std::move(others.begin(), others.end(), std::back_inserter(paths.all));
  paths.are_too_many = paths.all.size() > kMaxPaths;
}

void AffineCode::store(const Stmt& s, AffinePaths& paths) {
  for (AffinePath& path : paths.all) {
    AffineValues& values = s.op == StmtOp::StoreSelf ? path.self : path.bind;
    Form value = evaluate(s.value, path);
    if (s.index < values.size()) values[s.index] = std::move(value);
  }
}

std::vector<Substitution> substitutions(const std::vector<AffineForm>& zeros) {
  std::vector<Substitution> result;
  for (AffineForm form : zeros) {
    const auto add = [&](std::int64_t times, const AffineForm& by) {
      form.constant += times * by.constant;
      for (const auto& [variable, factor] : by.factors) form.factors[variable] += times * factor;
    };
    for (const Substitution& known : result) {
      const auto found = form.factors.find(known.variable);
      if (found == form.factors.end()) continue;
      const std::int64_t times = found->second;
      form.factors.erase(found);
      add(times, known.by);
    }
    std::erase_if(form.factors, [](const auto& term) { return term.second == 0; });
    if (!is_small(form.constant) ||
        !std::all_of(form.factors.begin(), form.factors.end(), [](const auto& term) { return is_small(term.second); }))
      continue;
    const auto given = std::find_if(form.factors.begin(), form.factors.end(),
                                    [](const auto& term) { return term.second == 1 || term.second == -1; });
    if (given == form.factors.end()) continue;
    Substitution substitution{given->first, {}};
    const std::int64_t sign = given->second;
    form.factors.erase(given);
    substitution.by.constant = -sign * form.constant;
    for (const auto& [variable, factor] : form.factors) substitution.by.factors[variable] = -sign * factor;
    result.push_back(std::move(substitution));
  }
  return result;
}

}  // namespace bip::verify
