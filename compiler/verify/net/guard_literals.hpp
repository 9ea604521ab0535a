// Guards whose data the modes do not know, as formulas over comparisons: each comparison of the same data is one
// variable, wherever it stands, so "request <= left" and "request > left" are never false together, whatever the
// numbers are.
//
// Exact are only `&&`, `||`, `!` and that of two ints one is less, equal or greater. Everything else about data is left
// open, so a formula has every state's values among its models, and more. Guards that can fault or call C++ have no
// literal. Cost: linear in the guards.
#pragma once
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "compiler/model/code.hpp"
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/solver/solver.hpp"

namespace bip::verify {

class GuardLiterals {
 public:
  struct Place {
    u32 atom = 0, variable = 0;
  };
  /// Which atom's data a LoadSelf or LoadBind reads; nothing: it is not an atom's, or not as it is now.
  using Locate = std::function<std::optional<Place>(const Expr&)>;

  GuardLiterals(const CodeTable& code, Solver& solver) : code_(code), solver_(solver) {}
  /// True in a state if and only if the guard is.
  [[nodiscard]] std::optional<Lit> literal(ExprId guard, const Locate& locate);

 private:
  using Key = std::vector<std::int64_t>;
  [[nodiscard]] bool add_key(ExprId id, const Locate& locate, Key& key) const;
  [[nodiscard]] Lit always();
  [[nodiscard]] std::optional<Lit> comparison(const Expr& e, const Locate& locate);
  [[nodiscard]] std::optional<Lit> joined(const Expr& e, const Locate& locate);

  const CodeTable& code_;
  Solver& solver_;
  Lit always_ = 0;
  std::map<Key, Lit> known_;
  std::map<std::pair<Key, Key>, std::array<Lit, 3>> orders_;  // less, equal, greater
};

}  // namespace bip::verify
