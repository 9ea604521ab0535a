// Guards, actions and transfers over ints as affine forms: after `n = n + step` the value of n is "n + 2", and where `a
// + b == 4` has been asked, "a + b - 4" is 0. Modulo 2^32, as the language's ints are, so nothing here depends on
// ranges.
//
// What is not affine is unknown. Both branches of an `if` are followed, up to kMaxPaths ways through a piece of code.
// After M. Karr: Affine Relationships Among Variables of a Program (1976).
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "compiler/model/abstract_interpreter.hpp"

namespace bip::verify {

/// Numbers of variables with their factors (not 0), and a constant.
struct AffineForm {
  static constexpr std::int64_t kMaxNumber = 1 << 24;
  std::map<std::uint32_t, std::int64_t> factors;
  std::int64_t constant = 0;
};
using AffineValues = std::vector<std::optional<AffineForm>>;

/// One way through code: what variables are, over what they were; and forms that are 0.
struct AffinePath {
  AffineValues self, bind;
  std::vector<AffineForm> zeros;
};

struct AffinePaths {
  std::vector<AffinePath>& all;
  bool are_too_many = false;
};

/// The domain of affine forms; a state is a set of paths.
class AffineCode : public AbstractInterpreter<AffineCode, std::optional<AffineForm>, const AffinePath, AffinePaths> {
 public:
  static constexpr std::size_t kMaxPaths = 32;
  using AbstractInterpreter::AbstractInterpreter;

  /// What is 0 where the condition holds.
  void assume(ExprId condition, AffinePath& path);
  /// False: too many ways.
  [[nodiscard]] bool execute(StmtId body, std::vector<AffinePath>& paths);

 private:
  friend AbstractInterpreter;
  using Form = std::optional<AffineForm>;
  [[nodiscard]] Form evaluate(ExprId id, const AffinePath& path) {
    // Nothing but ints is affine: what is below other expressions need not be computed.
    return code_.exprs[id].type == Type::Int ? AbstractInterpreter::evaluate(id, path) : std::nullopt;
  }
  [[nodiscard]] Form constant(const Expr& e);
  [[nodiscard]] Form load(const Expr& e, const AffinePath& path);
  [[nodiscard]] Form call(const Expr&, const AffinePath&) { return std::nullopt; }
  [[nodiscard]] Form logic(const Expr&, const AffinePath&) { return std::nullopt; }
  [[nodiscard]] Form unary(const Expr& e, const Form& a, const AffinePath&);
  [[nodiscard]] Form binary(const Expr& e, const Form& a, const Form& b, const AffinePath&);
  [[nodiscard]] bool goes_on(const AffinePaths& paths) const { return !paths.are_too_many; }
  void store(const Stmt& s, AffinePaths& paths);
  void branch(const Stmt& s, AffinePaths& paths);
  void run_call(const Stmt&, AffinePaths&) {}
  [[nodiscard]] static Form sum(const AffineForm& a, std::int64_t times, const AffineForm& b);
};

/// A variable as what it is by the others, where some form is 0.
struct Substitution {
  std::uint32_t variable = 0;
  AffineForm by;
};
/// To be applied one after the other. Of a form that gives no variable with factor 1 or -1 nothing is used.
[[nodiscard]] std::vector<Substitution> substitutions(const std::vector<AffineForm>& zeros);

}  // namespace bip::verify
