// Helps for errors of names and types: what a person may have meant, with the edit.
#pragma once
#include <optional>
#include <string_view>
#include <vector>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/model/model.hpp"

namespace bip::model {

/// The native type that a word of another language names: `integer`, `boolean`, `String`.
[[nodiscard]] std::optional<Type> meant_type(std::string_view word);

/// For a name that is not declared and resembles none: words of other languages, variables of the port that it names
/// (`names` are those in scope), else a `data` line of the atom around it.
void help_unknown_name(DiagnosticBuilder d, const Model& model, const syntax::Path& path, std::string_view key,
                       const std::vector<std::string>& names);

/// For an expression of type `got` where `wanted` is needed, with literals and conditions.
void help_wrong_type(DiagnosticBuilder d, const SourceMap& sources, const syntax::Expr& e, Type wanted, Type got);

/// A parameter as it is written. Data that instances initialise are hidden parameters "initial x", parameters that
/// actions assign "given x".
[[nodiscard]] std::string_view shown_name(std::string_view param);

/// Which parameters of the instance `name` get no value from arguments by position, or which arguments are too many.
void help_arguments(DiagnosticBuilder d, const Model& model, const std::vector<const DataVariable*>& params,
                    SourceRange name, const std::vector<SourceRange>& given);

/// The declaration of a port of an atom type, for an edit of it; invalid if it is not found.
[[nodiscard]] SourceRange port_declaration(const Model& model, std::string_view atom, std::string_view port);

}  // namespace bip::model
