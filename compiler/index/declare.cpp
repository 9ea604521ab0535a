// First pass: creates a symbol for each declared name, with its scope.
//
// A name that is declared several times in one scope (overloads of a function, elements of an array, an error) is one
// symbol with several declarations.
#include <algorithm>

#include "compiler/index/index_builder.hpp"
#include "compiler/syntax/interaction_count.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::index {

using namespace syntax;

namespace {

// Scopes of files are numbered down from the top, those of symbols up from 0: they never meet.
constexpr std::uint32_t kFileScope = 0xfffffff0u;

SymbolKind kind_of(DeclKind kind) {
  switch (kind) {
    case DeclKind::ConstData: return SymbolKind::Constant;
    case DeclKind::ExternType: return SymbolKind::ExternType;
    case DeclKind::ExternFunction:
    case DeclKind::ExternOperator:
    case DeclKind::Function: return SymbolKind::Function;
    case DeclKind::PortType: return SymbolKind::PortType;
    case DeclKind::ConnectorType: return SymbolKind::ConnectorType;
    case DeclKind::AtomType: return SymbolKind::AtomType;
    case DeclKind::CompoundType: return SymbolKind::CompoundType;
  }
  return SymbolKind::Constant;
}

}  // namespace

SymbolId IndexBuilder::add(SymbolKind kind, const Name& name, SourceRange range, SymbolId owner, Annotations marks) {
  if (name.text.empty()) return {};
  if (kind == SymbolKind::ExternType && syntax::is_native_type(name.text)) return {};
  BIP_ASSERT(!owner.is_valid() || owner.value < out_.symbols.size(), "owner {} of `{}` is not declared yet",
             owner.value, name.text);
  for (const Annotation& mark : marks) range.begin = std::min(range.begin, mark.range.begin);
  const Key key{owner.is_valid() ? owner.value : files_[file_].scope, name.text};
  if (const auto known = names_.find(key); known != names_.end()) {
    use(name.range, known->second, UseKind::Declaration);
    return known->second;
  }
  Symbol symbol{.kind = kind,
                .name = name.text,
                .name_range = name.range,
                .range = range,
                .parent = owner,
                .type = {},
                .type_text = {},
                .members = {},
                .detail = {},
                .doc = {}};
  symbol.doc = doc_above(range.begin, range.end);
  const SymbolId id = out_.symbols.push(std::move(symbol));
  BIP_ASSERT(id.value < kFileScope - files_.size(), "symbol {} has the number of a file's scope", id.value);
  names_.emplace(key, id);
  if (owner.is_valid()) {
    out_.symbols[owner].members.push_back(id);
  } else {
    out_.file_symbols.push_back(id);
  }
  use(name.range, id, UseKind::Declaration);
  return id;
}

void IndexBuilder::declare_file(std::size_t row) {
  file_ = row;
  File& file = files_[row];
  BIP_ASSERT(row < kFileScope, "file {} has no scope of its own", row);
  file.scope = kFileScope - static_cast<std::uint32_t>(row);
  const Package& package = *file.syntax->package;
  for (const PathPart& part : package.name.parts)
    file.name += (file.name.empty() ? "" : ".") + std::string(part.name.text);
  if (!package.name.parts.empty()) {
    // Not in `names_`: a package and a type of it may have one name.
    Symbol symbol{.kind = SymbolKind::Package,
                  .name = sources_.text(package.name.range),
                  .name_range = package.name.range,
                  .range = package.range,
                  .parent = {},
                  .type = {},
                  .type_text = {},
                  .members = {},
                  .detail = "package " + file.name,
                  .doc = {}};
    std::uint32_t begin = package.name.range.begin;
    for (const Annotation& mark : package.annotations) begin = std::min(begin, mark.range.begin);
    symbol.doc = doc_above(begin, begin);
    file.package = out_.symbols.push(std::move(symbol));
    out_.file_symbols.push_back(file.package);
    use(package.name.range, file.package, UseKind::Declaration);
  }
  for (const Decl* d : package.decls) declare(*d, row);
}

void IndexBuilder::declare(const Decl& d, std::size_t file) {
  if (d.kind == DeclKind::ConstData) {
    for (const DataDecl& data : d.data) declare_data(data, {}, SymbolKind::Constant, Visibility::Visible);
    decls_.push_back({&d, {}, file});
    return;
  }
  // An operator has no name that anyone could ask for.
  const SymbolId id =
      d.kind == DeclKind::ExternOperator ? SymbolId() : add(kind_of(d.kind), d.name, d.range, {}, d.annotations);
  decls_.push_back({&d, id, file});
  if (!id.is_valid()) return;
  if (out_.symbols[id].name_range.begin == d.name.range.begin) out_.symbols[id].detail = header(d);
  declare_params(d.params, id, d.kind == DeclKind::PortType ? Visibility::Visible : Visibility::Hidden);
  if (d.kind == DeclKind::ConnectorType && d.connector != nullptr) {
    declare_connector(*d.connector, id);
    out_.symbols[id].interactions = syntax::interaction_count(*d.connector, d.params.size());
  }
  if (d.kind == DeclKind::AtomType) declare_atom(d, id);
  if (d.kind != DeclKind::CompoundType) return;
  for (const DataDecl& data : d.data) declare_data(data, id, SymbolKind::Data, Visibility::Visible);
  declare_items(d.items, id, {});
  for (const CompoundPriority& p : d.priorities) add(SymbolKind::Priority, p.name, p.range, id, p.annotations);
  for (const CompoundExport& e : d.exports) {
    const SymbolId made =
        add(e.is_data ? SymbolKind::ExportedData : SymbolKind::ExportedPort, e.name, e.range, id, e.annotations);
    if (made.is_valid()) out_.symbols[made].is_visible = true;
  }
}

void IndexBuilder::declare_params(std::span<const Param> params, SymbolId owner, Visibility visibility) {
  for (const Param& p : params) {
    SourceRange range = p.name.range;
    if (p.type.is_written()) range.begin = std::min(range.begin, p.type.name.range.begin);
    const SymbolId id = add(SymbolKind::Parameter, p.name, range, owner);
    if (id.is_valid()) out_.symbols[id].is_visible = visibility == Visibility::Visible;
    if (id.is_valid() && p.type.is_written()) out_.symbols[id].type_text = sources_.text(p.type.name.range);
  }
}

void IndexBuilder::declare_data(const DataDecl& d, SymbolId owner, SymbolKind kind, Visibility visibility) {
  for (const Var& v : d.vars) {
    const SymbolId id = add(kind, v.name, d.range, owner, d.annotations);
    if (!id.is_valid()) continue;
    Symbol& symbol = out_.symbols[id];
    symbol.is_visible = visibility == Visibility::Visible;
    if (d.type.is_written()) symbol.type_text = sources_.text(d.type.name.range);
    symbol.detail = (kind == SymbolKind::Constant ? "const data " : "data ") + std::string(symbol.type_text) + " " +
                    std::string(v.name.text);
    if (d.exported) symbol.detail.insert(0, "export ");
    if (v.init != nullptr) symbol.detail += " = " + one_line(sources_, v.init->range);
  }
}

void IndexBuilder::declare_ports(const PortDecl& p, SymbolId owner) {
  const bool is_exported = p.role == PortRole::Exported;
  for (const PortItem& item : p.items) {
    const SymbolId id = add(SymbolKind::Port, item.name, p.range, owner, p.annotations);
    if (!id.is_valid()) continue;
    Symbol& symbol = out_.symbols[id];
    symbol.is_visible = is_exported && p.merged_as.text.empty();
    symbol.detail = p.role == PortRole::External ? "extern port " : is_exported ? "export port " : "port ";
    if (p.type.is_written()) symbol.detail += std::string(sources_.text(p.type.name.range)) + " ";
    symbol.detail += std::string(item.name.text) + "(";
    for (const Name& v : item.vars) symbol.detail += (&v == item.vars.data() ? "" : ", ") + std::string(v.text);
    symbol.detail += ")";
  }
  if (p.merged_as.text.empty()) return;
  // `export port T p() as p` is one name inside and outside.
  const SymbolId merged = add(SymbolKind::ExportedPort, p.merged_as, p.range, owner, p.annotations);
  if (merged.is_valid()) out_.symbols[merged].is_visible = true;
}

void IndexBuilder::declare_atom(const Decl& d, SymbolId owner) {
  for (const DataDecl& data : d.data)
    declare_data(data, owner, SymbolKind::Data,
                 data.exported || d.notation == Notation::Paper ? Visibility::Visible : Visibility::Hidden);
  for (const PortDecl& p : d.ports) declare_ports(p, owner);
  for (const ClockDecl& c : d.clocks) {
    for (const Name& n : c.names) add(SymbolKind::Clock, n, c.range, owner, c.annotations);
  }
  for (const Name& place : d.places) {
    const SymbolId id = add(SymbolKind::Place, place, place.range, owner);
    if (id.is_valid())
      out_.symbols[id].detail = (d.notation == Notation::Paper ? "state " : "place ") + std::string(place.text);
  }
  for (const AtomPriority& p : d.atom_priorities) add(SymbolKind::Priority, p.name, p.range, owner);
  for (const Invariant& i : d.invariants) add(SymbolKind::Invariant, i.name, i.range, owner);
}

void IndexBuilder::declare_connector(const ConnectorBody& body, SymbolId owner) {
  for (const DataDecl& data : body.data) declare_data(data, owner, SymbolKind::Data, Visibility::Hidden);
  if (!body.exported.present) return;
  const SymbolId id =
      add(SymbolKind::ExportedPort, body.exported.name, body.exported.range, owner, body.exported.annotations);
  if (id.is_valid()) out_.symbols[id].is_visible = true;
}

void IndexBuilder::declare_items(std::span<const CompoundItem* const> items, SymbolId owner, Annotations marks) {
  for (const CompoundItem* item : items) {
    if (item->kind == ItemKind::For) {
      // Two loops may both count with `i`: a loop's variable is known in its body only, so it is not in `names_`.
      Symbol symbol{.kind = SymbolKind::LoopVariable,
                    .name = item->name.text,
                    .name_range = item->name.range,
                    .range = item->name.range,
                    .parent = owner,
                    .type = {},
                    .type_text = "int",
                    .members = {},
                    .detail = {},
                    .doc = {}};
      symbol.detail = "for " + std::string(item->name.text) + " in " + one_line(sources_, item->low->range) + ".." +
                      one_line(sources_, item->high->range);
      const SymbolId id = out_.symbols.push(std::move(symbol));
      use(item->name.range, id, UseKind::Declaration);
      loops_.emplace(item, id);
      declare_items(item->items, owner, item->annotations);
      continue;
    }
    if (item->kind == ItemKind::Property) continue;
    if (item->kind == ItemKind::Priority) {
      add(SymbolKind::Priority, item->name, item->range, owner, item->annotations);
      continue;
    }
    const bool is_component = item->kind == ItemKind::Component;
    const SymbolId id = add(is_component ? SymbolKind::Component : SymbolKind::Connector, item->name, item->range,
                            owner, item->annotations.empty() ? marks : item->annotations);
    if (!id.is_valid()) continue;
    Symbol& symbol = out_.symbols[id];
    if (item->type.is_written()) symbol.type_text = sources_.text(item->type.name.range);
    if (is_component && symbol.name_range.begin == item->name.range.begin) {
      std::uint32_t end = item->name.range.end;
      if (item->index != nullptr) end = item->index->range.end + 1;
      symbol.detail = "component " + std::string(symbol.type_text) + " " +
                      one_line(sources_, {item->name.range.file, item->name.range.begin, end});
    }
    if (item->inline_body != nullptr) declare_connector(*item->inline_body, id);
  }
}

}  // namespace bip::index
