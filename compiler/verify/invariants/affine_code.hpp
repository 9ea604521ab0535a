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

#include "compiler/model/code.hpp"

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

class AffineCode {
 public:
  static constexpr std::size_t kMaxPaths = 32;
  explicit AffineCode(const CodeTable& code) : code_(code) {}

  /// What is 0 where the condition holds.
  void assume(ExprId condition, AffinePath& path) const;
  /// False: too many ways.
  [[nodiscard]] bool execute(StmtId body, std::vector<AffinePath>& paths) const;

 private:
  [[nodiscard]] std::optional<AffineForm> evaluate(ExprId expr, const AffinePath& path) const;
  [[nodiscard]] static std::optional<AffineForm> sum(const AffineForm& a, std::int64_t times, const AffineForm& b);

  const CodeTable& code_;
};

/// A variable as what it is by the others, where some form is 0.
struct Substitution {
  std::uint32_t variable = 0;
  AffineForm by;
};
/// To be applied one after the other. Of a form that gives no variable with factor 1 or -1 nothing is used.
[[nodiscard]] std::vector<Substitution> substitutions(const std::vector<AffineForm>& zeros);

}  // namespace bip::verify
