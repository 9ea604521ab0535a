// C code that BIP2 cannot say becomes a function of C++, and its variables the parameters.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/migrate/bip2_names.hpp"
#include "compiler/migrate/variables.hpp"

namespace bip::migrate {

class CppFunctions {
 public:
  /// `names` gives names of functions and types; it must outlive this.
  explicit CppFunctions(Bip2Names& names) : names_(names) {}

  /// The type of a variable, by what the source calls it. Types that BIP2 does not have become extern types.
  [[nodiscard]] VariableType type(std::string_view bip1);

  /// A statement that calls a new function with this body; it ends with `; `.
  [[nodiscard]] std::optional<std::string> action(const std::string& owner, std::string_view code,
                                                  const Variables& variables, const std::string& place);
  /// A call of a new function that computes this expression.
  [[nodiscard]] std::optional<std::string> value(const std::string& owner, std::string_view code,
                                                 const Variables& variables, const VariableType& result,
                                                 const std::string& place);
  /// Why the last call returned nothing.
  [[nodiscard]] const std::string& reason() const { return reason_; }

  void add_header(std::string_view code, const std::string& place);
  [[nodiscard]] bool is_empty() const { return definitions_.empty() && headers_.empty() && types_.empty(); }
  /// `extern …` lines of BIP2.
  [[nodiscard]] std::vector<std::string> declarations() const;
  /// The two files of C++.
  [[nodiscard]] std::string header(const std::string& model) const;
  [[nodiscard]] std::string source(const std::string& model, const std::string& header_name) const;

 private:
  struct Used {
    std::string name;  // as C code has it, with dots
    const Variable* variable;
    bool is_written = false;
  };
  struct Body {
    std::string text;
    std::vector<Used> used;
  };
  [[nodiscard]] static Body find_variables(std::string_view code, const Variables& variables);
  [[nodiscard]] std::optional<std::string> add(const std::string& owner, const Body& body, const std::string& cpp_body,
                                               const VariableType* result, bool is_constant, const std::string& place);

  Bip2Names& names_;
  std::map<std::string, std::string> types_;  // C++ to BIP2
  std::vector<std::string> type_order_;
  std::vector<std::string> prototypes_, cpp_declarations_, definitions_, headers_;
  bool has_own_types_ = false;  // of the model's headers
  std::string reason_;
};

}  // namespace bip::migrate
