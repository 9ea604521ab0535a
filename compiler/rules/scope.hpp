// Resolves the names of a .rules file and types its conditions. Internal to compiler/rules.
#pragma once
#include "compiler/diag/diagnostics.hpp"
#include "compiler/rules/rules.hpp"

namespace bip::rules {

enum class Type : std::uint8_t { Bool, Int, Float, Text, None };

class NameScope {
 public:
  NameScope(const std::vector<genom::Module>& modules, genom::Constraints& constraints, Diagnostics& diags)
      : modules_(modules), constraints_(constraints), diags_(diags) {}

  [[nodiscard]] std::optional<genom::ServiceRef> service(const Path& path);
  [[nodiscard]] std::optional<genom::PosterRef> poster(const Path& path);
  [[nodiscard]] std::optional<genom::TaskRef> task(const Path& path);
  [[nodiscard]] std::optional<std::size_t> module(const Name& name);
  [[nodiscard]] const genom::Service& at(genom::ServiceRef s) const { return modules_[s.module].services[s.service]; }
  [[nodiscard]] std::string text(genom::ServiceRef s) const {
    return modules_[s.module].name.text + "." + at(s).name.text;
  }
  void parameter(const ParameterDecl& decl);
  void value(const ValueDecl& decl);
  /// Request: as the request comes. Run: while the subject runs.
  enum class Moment : std::uint8_t { Request, Run };
  /// What a rule is about: nothing if it is `when`.
  using Subject = std::optional<genom::ServiceRef>;
  /// A condition of a rule about `subject`; false if it was reported. `moment`: when it is evaluated.
  [[nodiscard]] bool condition(const Expr& e, Subject subject, Moment moment, genom::Condition& into);

 private:
  [[nodiscard]] Type convert(const Expr& e, Subject subject, Moment moment, genom::Condition& into);
  [[nodiscard]] Type combine(const Expr& e, Subject subject, Moment moment, genom::Condition& into);
  [[nodiscard]] Type total(const Expr& e, Subject subject, genom::Condition& into);
  [[nodiscard]] Type failure(const Expr& e, genom::Condition& into);
  [[nodiscard]] Type silence(const Expr& e, genom::Condition& into);
  [[nodiscard]] Type missed(const Expr& e, genom::Condition& into);
  [[nodiscard]] Type parameter_of(const Expr& e, std::optional<genom::ServiceRef> s, Moment moment,
                                  genom::Condition& into);
  /// A value of a poster, with or without poster and module before it; None if there is none, and nothing is reported.
  [[nodiscard]] Type value_of(const Expr& e, genom::Condition& into);
  [[nodiscard]] bool is_poster(const Expr& e);
  [[nodiscard]] std::vector<std::string> written(const Name& name, genom::ValueType type,
                                                 const std::vector<std::string>& values);
  [[nodiscard]] bool sees_itself(const Expr& e, genom::ServiceRef seen, Subject subject);

  const std::vector<genom::Module>& modules_;
  genom::Constraints& constraints_;
  Diagnostics& diags_;
};

}  // namespace bip::rules
