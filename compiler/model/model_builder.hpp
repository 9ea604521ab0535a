// What the passes of build_model share. One ModelBuilder a model; each pass is a function in its own file.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "compiler/model/code_builder.hpp"

namespace bip::model {

struct ModelBuilder {
  Model& model;
  Diagnostics& diags;
  const SourceMap& sources;
  // Paper notation: the data that some instance initialises by name, by atom type name.
  std::unordered_map<std::string, std::unordered_set<std::string>> initialised_data;
  // Answers of find_type, by file and by the name as written: most types are named many times.
  std::unordered_map<std::uint32_t, std::unordered_map<std::string_view, const TypeName*>> found_types = {};

  [[nodiscard]] Loc loc(SourceRange r) const { return sources.loc(r); }
  [[nodiscard]] std::string text(const syntax::Path& p) const { return path_key(p, sources); }
  DiagnosticBuilder not_yet(SourceRange at, const std::string& what) { return diags.report(Diag::kB1900, at, what); }

  /// The port type that `type` names; reported if it is none.
  PortTypeId port_type(const syntax::TypeRef& type);
  /// The name of a declaration in the model's tables.
  [[nodiscard]] std::string key(const syntax::Decl& decl) const;
  /// What a type name means where it is written, or nullptr. That two used packages have it is reported.
  const TypeName* find_type(const syntax::Path& path);
  /// Where a type is declared, for labels; no range if there is none of this name. By key, or as written.
  [[nodiscard]] SourceRange declared(const std::string& type) const;
  [[nodiscard]] SourceRange declared(const syntax::Path& type);
  /// A port type without a name, for the paper's notation.
  PortTypeId anonymous_port_type(const std::vector<Variable>& variables);
  /// The value of a hidden parameter "initial x" that an instance does not give: the declared one, or the type's zero.
  ExprId initial_value(const ComponentFamily& family, const std::string& param, Type type);
  /// The row of a type name of the kind, or nullopt after a report.
  std::optional<std::uint32_t> type_row(const syntax::TypeRef& type, TypeName::Kind kind, const char* what);
};

/// Names of one namespace: reports the second of a kind.
class NameSpace {
 public:
  NameSpace(Diagnostics& diags, std::string owner) : diags_(diags), owner_(std::move(owner)) {}
  /// False if the name is taken (reported).
  bool declare(const syntax::Name& name, const char* what);
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  Diagnostics& diags_;
  std::string owner_;
  std::unordered_map<std::string, std::pair<SourceRange, const char*>> taken_;
};

/// Warns of names in `@SuppressWarning` that no warning has.
void check_suppressions(Diagnostics& diags, const syntax::Decl& decl);
/// "`a`, `b`", at most five, in alphabetical order.
[[nodiscard]] std::string quoted_list(std::vector<std::string> names);
/// Adds a help for each name similar to `wrong`.
void help_similar(DiagnosticBuilder d, std::string_view wrong, SourceRange at, std::vector<std::string> known);

void build_port_types(ModelBuilder& b);
void build_atom_types(ModelBuilder& b);
void build_connector_types(ModelBuilder& b);
void build_compound_types(ModelBuilder& b);
/// Warnings about an atom type as a whole: what cannot be reached, two transitions of one port, ports without one.
void check_atom(ModelBuilder& b, const AtomType& atom, const syntax::Decl& decl);
/// What its net cannot do, or does and must not.
void check_atom_net(ModelBuilder& b, const AtomType& atom, const syntax::Decl& decl);
/// Cycles of an atom type's priorities: an error without guards, else a warning.
void check_atom_priorities(ModelBuilder& b, const AtomType& atom, const syntax::Decl& decl);
/// The merged port that the port is part of, or null.
[[nodiscard]] const MergedPort* merged_with(const AtomType& atom, std::uint32_t port);

/// What a body of a connector is bound to: typed ones have parameters, inline ones paths.
struct ConnectorPorts {
  std::vector<ConnectorParam> params;
  std::unordered_map<std::string, std::vector<std::uint32_t>> rows;  // key in the body -> parameters ([*]: several)
  std::unordered_map<std::string, Binding> data;  // "battery.totalPwr" -> Bind after the port variables
  std::vector<DataRead> data_reads;
};
/// Warnings about the clauses of a connector: a `down` without effect, a guard that reads the connector's own data.
void check_clauses(ModelBuilder& b, const syntax::ConnectorBody& body, const ConnectorType& type,
                   syntax::Annotations annotations);
enum class ConnectorForm : std::uint8_t { Type, Inline };
/// Checks a connector's body and fills everything but name and params' origin.
void build_connector_body(ModelBuilder& b, const syntax::ConnectorBody& body, const ConnectorPorts& ports,
                          ConnectorForm form, SourceRange range, syntax::Annotations annotations, ConnectorType& out);

// ---- the `define` tree ---------------------------------------------------------------------------------------------
/// "p q r" with the parameters' names.
[[nodiscard]] std::string interaction_text(const ConnectorType& type, const std::vector<std::uint32_t>& params);

}  // namespace bip::model
