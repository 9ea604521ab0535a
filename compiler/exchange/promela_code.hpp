// Prints guards and actions as Promela text.
#pragma once
#include <functional>
#include <map>
#include <string>

#include "compiler/exchange/connector_tree.hpp"

namespace bip::exchange {

/// Names of what code reads and writes. An empty one: there is nothing to read.
struct Names {
  std::function<std::string(u32)> self, bind;
};

class PromelaCode {
 public:
  PromelaCode(const System& system, std::string& refusal) : system_(system), code_(system.code), refusal_(refusal) {}

  /// An expression in parentheses, or a name or number. No guard is `true`.
  [[nodiscard]] std::string text(ExprId expr, const Names& names);
  /// Statements, a line each, indented.
  [[nodiscard]] std::string statements(StmtId body, const Names& names, const std::string& indent);
  /// What the body leaves in Self, as expressions over what it read: for guards above an `up`.
  void substitute(StmtId body, const Names& names, std::map<u32, std::string>& self);
  /// The first refusal counts.
  void refuse(const std::string& what, const Loc& loc);
  void refuse(const std::string& what) { refuse(what, Loc{}); }

 private:
  [[nodiscard]] bool decides_nothing(const Stmt& store);
  [[nodiscard]] std::string division(const Expr& e, const std::string& a, const Names& names);

  const System& system_;
  const CodeTable& code_;
  std::string& refusal_;
};

}  // namespace bip::exchange
