// Prints guards and actions as Promela text.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "compiler/exchange/exchange.hpp"
#include "compiler/system/system.hpp"

namespace bip::exchange {

/// Names of the variables that code reads and writes; "": a merged port that does not take part has no variable.
using NameOf = std::function<std::string(u32)>;
struct Names {
  NameOf self, bind;
};

class PromelaCode {
 public:
  PromelaCode(const System& system, std::string& refusal) : system_(system), code_(system.code), refusal_(refusal) {}

  /// Returns an expression in parentheses, a name or a number; `true` for no guard. Refuses what Promela cannot
  /// express.
  [[nodiscard]] std::string text(ExprId expr, const Names& names);
  /// Returns the statements from `body` on, one line each, indented.
  [[nodiscard]] std::string statements(StmtId body, const Names& names, const std::string& indent);
  /// Replaces each value in `self` by what the body leaves there, as an expression over the values before: for guards
  /// above an `up`.
  void substitute(StmtId body, const Names& names, std::map<u32, std::string>& self);
  /// Records why the model is refused, and where, if it is the first reason.
  void refuse(const std::string& what, const Loc& loc);
  void refuse(const std::string& what) { refuse(what, Loc{}); }

 private:
  [[nodiscard]] bool decides_nothing(const Stmt& store);
  [[nodiscard]] std::string assignment(const Stmt& s, const NameOf& target, const Names& names,
                                       const std::string& indent);
  void refuse_evaluation(const Stmt& s, const Names& names);
  [[nodiscard]] std::string division(const Expr& e, const std::string& a, const Names& names);

  const System& system_;
  const CodeTable& code_;
  std::string& refusal_;
};

}  // namespace bip::exchange
