// The type model: names resolved, types checked, code built. What needs an instance (array sizes, elements, values of
// arguments) is typed code over a compound's parameters here and is evaluated by system/.
#pragma once
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/model/types.hpp"
#include "compiler/syntax/syntax.hpp"

namespace bip {

using CompoundTypeId = Id<struct CompoundTypeTag>;

/// `a[i].p` inside a compound: a component or connector of the compound, then what it exports.
/// Index code reads Self = the compound's parameters, then the loop variables in scope.
struct ElementRef {
  std::uint32_t family = 0;  // row of CompoundType::components or ::connectors
  ExprId index;              // invalid: no index
  bool star = false;         // [*]: all elements
};
struct PortPath {
  bool is_connector = false;  // the family is a connector: its exported port
  ElementRef element;
  std::uint32_t port =
      0;  // component: row of the atom type's ports, then of its merged ones, or of the compound type's exports
  PortTypeId type;
  const syntax::Path* path = nullptr;
  SourceRange range;
};
struct DataPath {
  ElementRef element;          // a component
  std::uint32_t variable = 0;  // atom: variable; compound: row of data_exports
  Type type = Type::Int;
  SourceRange range;
  const syntax::Path* path = nullptr;
};

/// A name in a compound with one instance, or an array of instances, of one type.
struct ComponentFamily {
  std::string name;
  bool is_compound = false;
  AtomTypeId atom;
  CompoundTypeId compound;
  bool is_array = false;
  SourceRange range;
};
struct ConnectorFamily {
  std::string name;
  bool is_array = false;
  bool exports = false;
  std::string export_name{};
  PortTypeId export_type;
  SourceRange range;
};

/// A parameter of the compound or a variable of a loop that the code of an inline connector or a priority's guard
/// names: a constant of each element, so the code is built again with its value.
struct OuterValue {
  std::string name;
  std::uint32_t variable = 0;  // of Self where the item is declared
  Type type = Type::Int;
};

enum class ItemKind : std::uint8_t { Component, Connector, For, Priority, Property };
struct CompoundItem {
  ItemKind kind = ItemKind::Component;
  SourceRange range;
  std::uint32_t family = 0;          // Priority: row of CompoundType::priorities
  ExprId index;                      // array size (outside For), element (inside), invalid: neither
  std::vector<ExprId> args;          // Component: one a parameter, of the parameter's type
  ConnectorTypeId type;              // Connector
  std::vector<PortPath> ports;       // Connector: as written; a star path stands for several parameters
  std::vector<DataPath> data;        // Connector: one a data read of the type
  std::vector<OuterValue> values{};  // Connector: an inline one gets its type when they are known; Property: what its
                                     // text may name
  const syntax::CompoundItem* syntax = nullptr;
  double weight = 1;      // Connector: how likely its interactions are beside others (`@weight`)
  bool has_star = false;  // Connector: a path with [*]; an inline one gets its type when its ports are counted
  std::uint32_t loop_variable = 0;  // For: Self variable of the variable
  ExprId low, high;
  std::vector<CompoundItem> items;
};
/// One port of a pattern: by what the connector binds (`a.p`) or by the name of its parameter (`p`).
struct PatternPort {
  std::string param;  // empty: by path
  PortPath path;
  SourceRange range;
};
struct PatternPath {
  bool any_connector = false;
  ElementRef connector;
  bool any_interaction = false;
  std::vector<PatternPort> ports;
  SourceRange range;
};
struct PriorityRule {
  std::string name;
  PatternPath low, high;
  ExprId guard;  // reads Bind = data
  std::vector<DataPath> data;
  std::vector<std::string> data_names{};  // as the guard calls them
  std::vector<OuterValue> values{};
  const syntax::Expr* guard_syntax = nullptr;  // may be null
  SourceRange range;
  bool in_loop = false;  // an item of a `for` says when it is made
  syntax::Annotations annotations{};
};
struct PortExport {
  std::string name;
  std::vector<PortPath> targets;
  PortTypeId type;
  SourceRange range;
};
struct DataExport {
  std::string name;
  DataPath target;
  SourceRange range;
};
struct CompoundType {
  std::string name;
  std::vector<DataVariable> params;
  std::vector<ComponentFamily> components;
  std::vector<ConnectorFamily> connectors;
  std::vector<CompoundItem> items;
  std::vector<PriorityRule> priorities;
  std::vector<PortExport> exports;
  std::vector<DataExport> data_exports;
  const syntax::Decl* decl = nullptr;
  Loc loc{};
};

/// What a type name stands for.
struct TypeName {
  enum class Kind : std::uint8_t { Port, Connector, Atom, Compound } kind = Kind::Port;
  std::uint32_t row = 0;
  SourceRange range;
};

/// How large an expression is as a tree; sizes stop at a bound.
struct CodeShape {
  std::size_t size = 1;
  std::uint32_t depth = 1;
};

/// A package of the compilation and what it sees. In the tables of Model a name of the package that is compiled is `X`,
/// one of a package that it uses is `p.X`, whatever the text says; model/packages.hpp finds the one from the other.
struct PackageScope {
  std::string name;
  std::string prefix;               // of its names in the tables: "" or "p."
  FileId file;                      // a package is one file
  std::vector<std::uint32_t> uses;  // rows of Model::packages; not transitive
};

struct Model {
  const SourceMap* sources = nullptr;
  std::string package;                         // the one that is compiled
  std::vector<PackageScope> packages;          // a package comes after those it uses; the compiled one is the last
  std::vector<std::uint32_t> package_of_file;  // by FileId: row of packages
  std::vector<const syntax::Decl*> decls;      // of all packages, in that order
  std::vector<std::string> files;
  CodeTable code;
  std::vector<CodeShape> code_shapes;  // of the first rows of code.exprs, as far as they were asked for
  IndexVector<PortTypeId, PortType> port_types;
  IndexVector<ConnectorTypeId, ConnectorType> connector_types;  // typed ones, then those of inline connectors
  IndexVector<AtomTypeId, AtomType> atom_types;
  IndexVector<CompoundTypeId, CompoundType> compound_types;
  std::unordered_map<std::string, TypeName> type_names;
  std::unordered_map<std::string, PortTypeId> anonymous_port_types;    // by names and types of their variables
  std::unordered_map<std::string, std::pair<ExprId, Type>> constants;  // const data
  std::unordered_map<std::string, const syntax::Decl*> functions;      // with a body
  std::unordered_map<std::string, std::vector<const syntax::Decl*>> prototypes;  // `extern function`, in source order
  std::unordered_map<std::string, std::vector<const syntax::Decl*>>
      operators;  // by "operator +"; they know no packages
  std::unordered_map<std::string, Type> ffi_type_names;

  [[nodiscard]] Loc loc(SourceRange r) const { return sources->loc(r); }
};

namespace model {
/// True if `@SuppressWarning(name)` is among the annotations.
[[nodiscard]] bool is_suppressed(syntax::Annotations annotations, std::string_view name);
/// Names, types and all checks that need no instance. nullopt if there were errors. The syntax must outlive the model.
/// `packages`: a package after those it uses, the one that is compiled last.
[[nodiscard]] std::optional<Model> build_model(const std::vector<const syntax::Syntax*>& packages,
                                               const SourceMap& sources, Diagnostics& diags);
/// A package that uses no other.
[[nodiscard]] std::optional<Model> build_model(const syntax::Syntax& syntax, const SourceMap& sources,
                                               Diagnostics& diags);
/// The type of an inline connector whose paths with [*] stand for `counts[k]` ports, where its outer values are those
/// of `self`; it reads the same data as the item's.
[[nodiscard]] ConnectorTypeId expand_inline_connector(Model& model, Diagnostics& diags, const CompoundItem& item,
                                                      const std::vector<std::uint32_t>& counts,
                                                      const std::vector<Value>& self);
/// The guard of a rule whose outer values are those of `self`.
[[nodiscard]] ExprId priority_guard(Model& model, Diagnostics& diags, const PriorityRule& rule,
                                    const std::vector<Value>& self);
/// True if `define` gives the interaction of these parameters (sorted).
[[nodiscard]] bool is_interaction(const ConnectorType& type, const std::vector<std::uint32_t>& params);
/// The largest interaction within `params` (sorted); empty if there is none.
[[nodiscard]] std::vector<std::uint32_t> largest_interaction(const ConnectorType& type,
                                                             const std::vector<std::uint32_t>& params);
/// All interactions that `define` gives, each sorted; as many as interaction_count says.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> interactions_of(const ConnectorType& type,
                                                                      std::uint32_t node = 0);
/// How many interactions a `define` gives below a node, as a double: it may be 2^1000.
[[nodiscard]] double interaction_count(const ConnectorType& type, std::uint32_t node = 0);
/// True if a port of type `given` can be used where `wanted` is asked for.
[[nodiscard]] bool fits(const Model& model, PortTypeId given, PortTypeId wanted);
/// "of port type `T`", or what an anonymous one carries, for messages.
[[nodiscard]] std::string port_type_text(const Model& model, PortTypeId type);
/// Text of the tables, for --emit=model.
[[nodiscard]] std::string dump(const Model& model);
}  // namespace model

}  // namespace bip
