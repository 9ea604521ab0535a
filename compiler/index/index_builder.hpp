// The state of `build_index`, shared by its files: first all declarations, then their types, then every use.
// Inside compiler/index only.
#pragma once
#include <map>
#include <string>
#include <unordered_map>

#include "compiler/index/index.hpp"

namespace bip::index {

/// The text of a range with a blank for each gap, cut where it becomes too long for one line.
[[nodiscard]] std::string one_line(const SourceMap& sources, SourceRange range);

class IndexBuilder {
 public:
  explicit IndexBuilder(const SourceMap& sources) : sources_(sources) {}
  Index run(std::span<const syntax::Syntax* const> files);

 private:
  using Key = std::pair<std::uint32_t, std::string_view>;  // parent and name; files count from kFileScope down
  struct File {
    const syntax::Syntax* syntax = nullptr;
    std::uint32_t scope = 0;
    SymbolId package;
    std::string name;               // "a.b", empty if it has none
    std::vector<std::size_t> used;  // rows of files_
  };
  struct DeclRow {
    const syntax::Decl* decl;
    SymbolId symbol;
    std::size_t file;
  };
  /// Where a name is looked for: innermost first.
  struct Scope {
    std::size_t file = 0;
    std::vector<SymbolId> owners;  // inline connector, compound
    std::vector<SymbolId> loop_variables;
  };

  // declare.cpp
  void declare_file(std::size_t row);
  void declare(const syntax::Decl& d, std::size_t file);
  void declare_atom(const syntax::Decl& d, SymbolId owner);
  void declare_ports(const syntax::PortDecl& p, SymbolId owner);
  void declare_items(std::span<const syntax::CompoundItem* const> items, SymbolId owner, syntax::Annotations marks);
  void declare_connector(const syntax::ConnectorBody& body, SymbolId owner);
  /// Visible: may be named from outside its parent as `a.name`.
  enum class Visibility : std::uint8_t { Hidden, Visible };
  void declare_data(const syntax::DataDecl& d, SymbolId owner, SymbolKind kind, Visibility visibility);
  void declare_params(std::span<const syntax::Param> params, SymbolId owner, Visibility visibility);
  SymbolId add(SymbolKind kind, const syntax::Name& name, SourceRange range, SymbolId owner,
               syntax::Annotations marks = {});

  // doc.cpp
  [[nodiscard]] std::string doc_above(std::uint32_t begin, std::uint32_t end) const;
  [[nodiscard]] std::string header(const syntax::Decl& d) const;

  // resolve_uses.cpp: types and the parts of atoms
  void link_types(const DeclRow& row);
  void link_items(std::span<const syntax::CompoundItem* const> items, SymbolId owner, std::size_t file);
  void link_exports(const DeclRow& row);
  void link_body(const syntax::ConnectorBody& body, SymbolId owner, std::size_t file);
  void set_type(SymbolId symbol, const syntax::TypeRef& type, SymbolId target);
  SymbolId use_type(const syntax::Path& path, std::size_t file);
  [[nodiscard]] SymbolId find(SymbolId owner, std::string_view name) const;
  /// As Index::member, without a walk over the members where the name is one of them.
  [[nodiscard]] SymbolId member(SymbolId owner, std::string_view name) const;
  [[nodiscard]] SymbolId find_in_files(std::string_view name, std::size_t file) const;
  void resolve(const DeclRow& row);
  void resolve_atom(const syntax::Decl& d, SymbolId owner, const Scope& scope);
  void use_member(SymbolId owner, const syntax::Name& name, UseKind kind = UseKind::Read);
  void use(SourceRange range, SymbolId symbol, UseKind kind = UseKind::Read);

  // resolve_code.cpp: expressions, actions, paths
  [[nodiscard]] SymbolId find_in_scope(std::string_view name, const Scope& scope) const;
  SymbolId path(const syntax::Path& p, const Scope& scope, UseKind last);
  void expr(const syntax::Expr* e, const Scope& scope);
  void stmts(std::span<const syntax::Stmt* const> list, const Scope& scope);
  void block(const syntax::Block& b, const Scope& scope) { stmts(b.stmts, scope); }

  // resolve_compound.cpp: connectors, items, priorities
  void resolve_connector(const syntax::ConnectorBody& body, SymbolId owner, const Scope& scope);
  void port_expr(const syntax::PortExpr& e, const Scope& scope);
  void resolve_items(std::span<const syntax::CompoundItem* const> items, SymbolId owner, Scope& scope);
  void resolve_pattern(const syntax::InteractionPattern& p, const Scope& scope);

  const SourceMap& sources_;
  Index out_;
  std::vector<File> files_;
  std::vector<DeclRow> decls_;
  struct KeyHash {
    std::size_t operator()(const Key& key) const {
      return std::hash<std::string_view>()(key.second) ^ (std::size_t{key.first} * 0x9E3779B97F4A7C15u);
    }
  };
  std::unordered_map<Key, SymbolId, KeyHash> names_;
  std::map<const syntax::CompoundItem*, SymbolId> loops_;
  std::size_t file_ = 0;  // that is being declared
};

}  // namespace bip::index
