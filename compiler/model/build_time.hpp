// Conditions that speak of clocks: from an expression of the source to a condition on data and bounds (model/time.hpp).
#pragma once
#include <optional>

#include "compiler/model/model_builder.hpp"

namespace bip::model {

/// A condition of an atom, taken apart: `data && when`.
struct TimedCondition {
  ExprId data{};  // invalid: true
  TimeGuard when{};
};

/// Builds an atom type's clocks and conditions. The scope must know the clocks; hidden variables are added to `atom`.
class TimeBuilder {
 public:
  TimeBuilder(ModelBuilder& b, AtomType& atom, Scope& scope) : builder_(b), atom_(atom), scope_(scope) {}

  /// A clock and its hidden variables. All variables of data must be there.
  void add_clock(const syntax::Name& name, const syntax::Name& unit);
  /// Null is true. `what` is what the condition is for: "the guard".
  TimedCondition condition(const syntax::Expr* e, const std::string& what);
  Resume resume(bool present, const syntax::Expr* e, SourceRange at);
  /// The first clock that the expression reads, or null.
  [[nodiscard]] const syntax::Expr* clock_in(const syntax::Expr* e) const;

 private:
  struct Linear;
  void conjunct(const syntax::Expr* e, const std::string& what, TimedCondition& out);
  void bound(const syntax::Expr* e, TimedCondition& out);
  enum class Sign : std::uint8_t { Plus, Minus };
  [[nodiscard]] static Sign opposite(Sign sign) { return sign == Sign::Plus ? Sign::Minus : Sign::Plus; }
  bool collect(const syntax::Expr* e, Sign sign, Linear& out);
  void set_limit(const syntax::Expr* e, ExprId limit, std::int64_t unit, Bound& bound, TimeGuard& out);
  void check_satisfiable(const TimeGuard& when, const syntax::Expr* e);
  [[nodiscard]] bool is_constant(ExprId e) const;
  ExprId make(Op op, Type type, ExprId left, ExprId right, SourceRange at);

  ModelBuilder& builder_;
  AtomType& atom_;
  Scope& scope_;
  std::vector<std::uint32_t> limit_variables_;  // hidden variables for limits, shared by all conditions
};

/// What `@async` says, all ports of `atom` being there.
[[nodiscard]] Async build_async(ModelBuilder& b, const syntax::Transition& t, const AtomType& atom);

/// "clock of milliseconds", for messages.
[[nodiscard]] const char* unit_name(std::int64_t ticks);

}  // namespace bip::model
