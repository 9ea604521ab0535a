// The declarations of a model beside its types: constants, functions of its own, and the C++ functions that its code
// calls.
#include "tools/gen/ffi_prototypes.hpp"
#include "tools/gen/make.hpp"

namespace bip::gen {

std::vector<Var> make_constants(CodeMaker& code, Prng& random) {
  std::vector<Var> constants;
  static const std::vector<Ty> kTypes = {Ty::Int, Ty::Int, Ty::Bool, Ty::Float, Ty::String};
  for (int k = 0, n = random.between(1, 4); k < n; ++k) {
    Var var{"N" + std::to_string(k), random.pick(kTypes), false, {}};
    // Some of a constant before it.
    const Var* before = constants.empty() ? nullptr : &constants.back();
    var.init = code.literal(var.type);
    if (before != nullptr && before->type == Ty::Int && var.type == Ty::Int && random.percent(60)) {
      var.init = binary(random.percent(50) ? "+" : "*", constant(*before), int_literal(random.between(1, 9)), Ty::Int);
    }
    constants.push_back(std::move(var));
  }
  return constants;
}

std::vector<InlineFunction> make_functions(CodeMaker& code, Prng& random) {
  std::vector<InlineFunction> functions;
  static const std::vector<Ty> kTypes = {Ty::Int, Ty::Int, Ty::Bool, Ty::Float};
  static const char kLetters[] = {'i', 'b', 'f', 's'};
  for (int k = 0, n = random.between(1, 3); k < n; ++k) {
    InlineFunction function{"f" + std::to_string(k), random.pick(kTypes), {}, {}};
    std::vector<Known> known;
    for (int p = 0, m = random.between(1, 3); p < m; ++p) {
      const Ty type = random.pick(kTypes);
      function.params.push_back({kLetters[static_cast<int>(type)] + std::to_string(p), type, false, {}});
      known.push_back({"$", function.params.back().name, type, false});
    }
    function.body = code.expression(function.result, known, random.between(1, 3));
    functions.push_back(std::move(function));
  }
  return functions;
}

Expr constant(const Var& var) {
  Expr e;
  e.kind = ExprKind::Constant;
  e.type = var.type;
  e.text = var.name;
  e.args.push_back(*var.init);
  return e;
}

/// A call of the result's type; a literal if there is none.
Expr CodeMaker::call(Ty type, const std::vector<Known>& known, int depth) {
  const auto& all = ffi_functions();
  std::vector<std::size_t> fitting;
  for (std::size_t row = 0; row < all.size(); ++row) {
    const FfiPrototype& f = all[row];
    bool fits = f.is_pure() && f.result == type && (style_->ffi || f.is_library) && (!f.may_fault || style_->faults);
    for (const FfiParam& p : f.params) fits = fits && (style_->objects || (p.type != Ty::Pair && p.type != Ty::Wide));
    if (fits) fitting.push_back(row);
  }
  if (fitting.empty()) return literal(type);
  Expr e;
  e.kind = ExprKind::Call;
  e.type = type;
  e.row = static_cast<int>(fitting[random_->below(fitting.size())]);
  const FfiPrototype& f = all[static_cast<std::size_t>(e.row)];
  e.text = f.name;
  for (const FfiParam& p : f.params) {
    Expr arg = expression(p.type, known, depth - 1);
    // The prototype that was meant must be the most specific one: no int where a float is wanted.
    const bool is_overloaded = e.text == "sort_of";
    if (is_overloaded && arg.type != p.type)
      arg = p.type == Ty::Pair ? pair_of(literal(Ty::Int), literal(Ty::Int)) : literal(p.type);
    e.args.push_back(std::move(arg));
  }
  return e;
}

Expr CodeMaker::pair_of(Expr a, Expr b) {
  Expr e;
  e.kind = ExprKind::Call;
  e.type = Ty::Pair;
  e.text = "make_two";
  while (ffi_functions()[static_cast<std::size_t>(++e.row)].name != e.text) continue;
  e.args = {std::move(a), std::move(b)};
  return e;
}

Expr CodeMaker::inline_call(const InlineFunction& function, const std::vector<Known>& known, int depth) {
  Expr e;
  e.kind = ExprKind::Inline;
  e.type = function.result;
  e.text = function.name;
  for (const Var& param : function.params) e.args.push_back(expression(param.type, known, depth - 1));
  e.args.push_back(function.body);
  return e;
}

/// A statement that calls C++; nothing if no variable fits what it changes.
std::optional<Stmt> CodeMaker::call_statement(const std::vector<Known>& known, int depth) {
  const auto& all = ffi_functions();
  const std::size_t row = random_->below(all.size());
  const FfiPrototype& f = all[row];
  if (f.is_pure() || f.is_operator) return std::nullopt;
  Stmt stmt;
  stmt.is_call = true;
  stmt.value.kind = ExprKind::Call;
  stmt.value.type = f.result;
  stmt.value.text = f.name;
  stmt.value.row = static_cast<int>(row);
  for (const FfiParam& p : f.params) {
    if (!p.by_reference) {
      stmt.value.args.push_back(expression(p.type, known, depth));
      continue;
    }
    std::vector<const Known*> fitting;
    for (const Known& k : known) {
      if (k.writable && k.type == p.type) fitting.push_back(&k);
    }
    if (fitting.empty()) return std::nullopt;
    stmt.value.args.push_back(name_of(*random_->pick(fitting)));
  }
  return stmt;
}

}  // namespace bip::gen
