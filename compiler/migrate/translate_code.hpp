// C code that BIP2 can say: assignments, conditions, and expressions over numbers, truth values and strings.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compiler/migrate/bip2_names.hpp"
#include "compiler/migrate/variables.hpp"

namespace bip::migrate {

/// Keeps references to `names` and `variables`. All functions return nothing where BIP2 computes otherwise than C, or
/// cannot say it: calls, unknown names, numbers from truth values.
class CodeTranslator {
 public:
  CodeTranslator(const Bip2Names& names, const Variables& variables) : names_(names), variables_(variables) {}

  /// An expression of type `want`; Unknown: of any.
  [[nodiscard]] std::optional<std::string> value(const syntax::bip1::Expr& e, ValueKind want) const;
  /// Statements, each with its end.
  [[nodiscard]] std::optional<std::string> statements(const std::vector<syntax::bip1::Stmt>& list) const;

 private:
  struct Value {
    std::string text{};
    ValueKind kind = ValueKind::Unknown;
    std::string type{};  // of an object
  };
  [[nodiscard]] std::optional<Value> any(const syntax::bip1::Expr& e) const;
  [[nodiscard]] std::optional<Value> binary(const syntax::bip1::Expr& e) const;
  [[nodiscard]] std::optional<Value> comparison(const syntax::bip1::Expr& e) const;
  [[nodiscard]] std::optional<std::string> statement(const syntax::bip1::Stmt& s) const;
  [[nodiscard]] std::optional<std::string> if_stmt(const syntax::bip1::Stmt& s) const;
  [[nodiscard]] std::optional<std::string> assignment(const syntax::bip1::Stmt& s) const;

  const Bip2Names& names_;
  const Variables& variables_;
};

}  // namespace bip::migrate
