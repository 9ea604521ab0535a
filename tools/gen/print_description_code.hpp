// Text of expressions, statements and paths, shared by both notations' printers.
#pragma once
#include <functional>
#include <string>

#include "tools/gen/description.hpp"

namespace bip::gen {

/// How a name is written: an inline connector writes the bound path where a connector type writes its parameter.
using NameText = std::function<std::string(const std::string& scope, const std::string& name)>;
[[nodiscard]] std::string plain_name(const std::string& scope, const std::string& name);

/// In a guard of the paper's notation `=` compares; elsewhere it assigns.
enum class Spelling : std::uint8_t { Bip2, Paper, PaperGuard };

[[nodiscard]] std::string text_of(const Expr& expr, const NameText& names, Spelling spelling);
/// `{ … }` on one line.
[[nodiscard]] std::string text_of(const Body& body, const NameText& names, Spelling spelling);
[[nodiscard]] std::string text_of(const PortPath& path);
[[nodiscard]] std::string join(const std::vector<std::string>& items, const char* separator);

/// What a package holds. Names that other packages may declare are marked by a `$` before them (print_packages.cpp).
[[nodiscard]] std::string print_types(const std::vector<PortType>& types);
[[nodiscard]] std::string print_parts(const Description& model);
[[nodiscard]] std::string print_compounds(const Description& model);

/// An atom type or a compound type in the paper's notation.
[[nodiscard]] std::string print_paper(const AtomType& atom);
[[nodiscard]] std::string print_paper(const Description& model, const CompoundType& compound);

}  // namespace bip::gen
