// The foreign function interface in the model: FFI types and their sub-typing, prototypes of C++ functions and
// operators, `@cpp`.
#pragma once
#include <string>
#include <vector>

#include "compiler/model/model_builder.hpp"

namespace bip::model {

/// The type of data that a name means: native, or an FFI type that is visible there. Anything else is reported.
[[nodiscard]] Type data_type(const Model& model, const syntax::TypeRef& type, Diagnostics& diags);
/// The same where only a native type may be: `what` is "a parameter".
[[nodiscard]] Type native_data_type(const Model& model, const syntax::TypeRef& type, const char* what,
                                    Diagnostics& diags);
/// True if `type` is `wanted` or refines it, at any distance.
[[nodiscard]] bool refines(const CodeTable& code, Type type, Type wanted);

/// One argument as overload resolution sees it.
struct Argument {
  Typed typed;
  bool is_variable = false;  // C++ may change it
  bool is_constant = false;  // it is named, and declared `const`
  SourceRange range;
  bool is_clock = false;  // its value, which is no variable
};
/// "int, List": the arguments' types.
[[nodiscard]] std::string types_text(const CodeTable& code, const std::vector<Argument>& args);
/// "int f(const List, int)".
[[nodiscard]] std::string prototype_text(const Model& model, const syntax::Decl& prototype);
/// The prototypes that fit and that no other fitting one is more specific than: none, one, or several in declaration
/// order.
[[nodiscard]] std::vector<const syntax::Decl*> best_prototypes(const Model& model,
                                                               const std::vector<const syntax::Decl*>& prototypes,
                                                               const std::vector<Argument>& args);
/// The row of the function as it is called with such arguments; added if it is new.
[[nodiscard]] std::uint32_t function_row(CodeTable& code, Function function);
/// True if the expression calls C++.
[[nodiscard]] bool calls_cpp(const CodeTable& code, ExprId expr);

/// Rows of all FFI types; what they refine; cycles are reported.
void declare_ffi_types(ModelBuilder& b);
/// Types of all prototypes, and `@cpp` of all packages.
void check_prototypes(ModelBuilder& b);
void collect_cpp(ModelBuilder& b, const std::vector<const syntax::Syntax*>& packages);

}  // namespace bip::model
