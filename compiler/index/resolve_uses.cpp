// Second and third pass: the types of what was declared, then the uses in atoms and declarations of a file.
#include "compiler/index/index_builder.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::index {

using namespace syntax;

namespace {

// An export of an export of an export …: each round knows one level more. Deeper ones stay without a type.
constexpr int kMaxExportLevels = 64;

}  // namespace

SymbolId IndexBuilder::find(SymbolId owner, std::string_view name) const {
  const auto known = names_.find({owner.value, name});
  return known == names_.end() ? SymbolId() : known->second;
}

SymbolId IndexBuilder::member(SymbolId owner, std::string_view name) const {
  const SymbolId type = out_.symbols[owner].type;
  const SymbolId found = find(type.is_valid() ? type : owner, name);
  if (found.is_valid() && (!type.is_valid() || out_.symbols[found].is_visible)) return found;
  return out_.member(owner, name);
}

SymbolId IndexBuilder::find_in_files(std::string_view name, std::size_t file) const {
  BIP_ASSERT(file < files_.size(), "there is no file {}", file);
  if (const auto own = names_.find({files_[file].scope, name}); own != names_.end()) return own->second;
  for (const std::size_t row : files_[file].used) {
    if (const auto used = names_.find({files_[row].scope, name}); used != names_.end()) return used->second;
  }
  return {};
}

void IndexBuilder::use(SourceRange range, SymbolId symbol, UseKind kind) {
  BIP_ASSERT(!symbol.is_valid() || symbol.value < out_.symbols.size(), "a use of symbol {}, which is not there",
             symbol.value);
  if (symbol.is_valid() && range.is_valid()) out_.uses.push_back({range, symbol, kind});
}

void IndexBuilder::use_member(SymbolId owner, const Name& name, UseKind kind) {
  if (name.text.empty() || name.text == "*") return;
  use(name.range, find(owner, name.text), kind);
}

SymbolId IndexBuilder::use_type(const Path& path, std::size_t file) {
  if (path.parts.empty()) return {};
  const Name& last = path.parts.back().name;
  if (path.parts.size() == 1) {
    const SymbolId found = find_in_files(last.text, file);
    use(last.range, found);
    return found;
  }
  const Name& before = path.parts[path.parts.size() - 2].name;
  const SourceRange qualifier{path.range.file, path.parts.front().name.range.begin, before.range.end};
  const auto in = [&](std::size_t row) -> SymbolId {
    if (files_[row].name != sources_.text(qualifier)) return {};
    const auto known = names_.find({files_[row].scope, last.text});
    if (known == names_.end()) return {};
    use(qualifier, files_[row].package);
    use(last.range, known->second);
    return known->second;
  };
  if (const SymbolId own = in(file); own.is_valid()) return own;
  for (const std::size_t row : files_[file].used) {
    if (const SymbolId used = in(row); used.is_valid()) return used;
  }
  return {};
}

void IndexBuilder::set_type(SymbolId symbol, const TypeRef& type, SymbolId target) {
  if (!symbol.is_valid()) return;
  Symbol& row = out_.symbols[symbol];
  if (!row.type.is_valid()) row.type = target;
  if (row.type_text.empty() && type.is_written()) row.type_text = sources_.text(type.name.range);
}

void IndexBuilder::link_body(const ConnectorBody& body, SymbolId owner, std::size_t file) {
  for (const DataDecl& d : body.data) {
    const SymbolId type = use_type(d.type.name, file);
    for (const Var& v : d.vars) set_type(find(owner, v.name.text), d.type, type);
  }
  if (!body.exported.present) return;
  const SymbolId port = find(owner, body.exported.name.text);
  set_type(port, body.exported.type, use_type(body.exported.type.name, file));
  for (const Name& v : body.exported.vars) {
    use_member(owner, v);
    if (const SymbolId datum = find(owner, v.text); datum.is_valid() && port.is_valid())
      out_.symbols[port].members.push_back(datum);
  }
}

void IndexBuilder::link_items(std::span<const CompoundItem* const> items, SymbolId owner, std::size_t file) {
  for (const CompoundItem* item : items) {
    if (item->kind == ItemKind::For) {
      link_items(item->items, owner, file);
      continue;
    }
    if (item->kind == ItemKind::Priority || item->kind == ItemKind::Property) continue;
    const SymbolId symbol = find(owner, item->name.text);
    set_type(symbol, item->type, use_type(item->type.name, file));
    if (item->inline_body != nullptr && symbol.is_valid()) link_body(*item->inline_body, symbol, file);
  }
}

void IndexBuilder::link_types(const DeclRow& row) {
  const Decl& d = *row.decl;
  const SymbolId owner = row.symbol;
  use_type(d.result.name, row.file);
  for (const Path& refined : d.refines) use_type(refined, row.file);
  for (const Param& p : d.params) {
    const SymbolId type = use_type(p.type.name, row.file);
    if (owner.is_valid()) set_type(find(owner, p.name.text), p.type, type);
  }
  for (const DataDecl& data : d.data) {
    const SymbolId type = use_type(data.type.name, row.file);
    for (const Var& v : data.vars)
      set_type(owner.is_valid() ? find(owner, v.name.text) : find_in_files(v.name.text, row.file), data.type, type);
  }
  if (!owner.is_valid()) return;
  if (d.connector != nullptr) link_body(*d.connector, owner, row.file);
  for (const PortDecl& p : d.ports) {
    const SymbolId type = use_type(p.type.name, row.file);
    if (!p.merged_as.text.empty()) set_type(find(owner, p.merged_as.text), p.type, type);
    for (const PortItem& item : p.items) {
      const SymbolId port = find(owner, item.name.text);
      set_type(port, p.type, type);
      for (const Name& v : item.vars) {
        use_member(owner, v);
        const SymbolId datum = find(owner, v.text);
        if (datum.is_valid() && port.is_valid()) out_.symbols[port].members.push_back(datum);
      }
    }
  }
  link_items(d.items, owner, row.file);
}

void IndexBuilder::link_exports(const DeclRow& row) {
  if (!row.symbol.is_valid()) return;
  for (const CompoundExport& e : row.decl->exports) {
    const SymbolId made = find(row.symbol, e.name.text);
    if (!made.is_valid() || e.targets.empty() || out_.symbols[made].type.is_valid() ||
        !out_.symbols[made].type_text.empty())
      continue;
    SymbolId target = find(row.symbol, e.targets.front().parts.front().name.text);
    for (const PathPart& part : e.targets.front().parts.subspan(1)) {
      if (target.is_valid()) target = member(target, part.name.text);
    }
    if (!target.is_valid()) continue;
    const Symbol from = out_.symbols[target];
    out_.symbols[made].type = from.type;
    out_.symbols[made].type_text = from.type_text;
    if (out_.symbols[made].members.empty()) out_.symbols[made].members = from.members;
  }
}

void IndexBuilder::resolve_atom(const Decl& d, SymbolId owner, const Scope& scope) {
  const auto members = [&](std::span<const Name> names) {
    for (const Name& n : names) use_member(owner, n);
  };
  members(d.initial.to);
  block(d.initial.action, scope);
  expr(d.initial.resume, scope);
  for (const FinalPlaces& f : d.finals) members(f.places);
  for (const Transition& t : d.transitions) {
    use_member(owner, t.port);
    for (const Annotation& mark : t.annotations) {
      if (mark.name.text != "weight") continue;
      for (const AnnotationArg& weight : mark.args) use_member(owner, weight.key);
    }
    members(t.from);
    members(t.to);
    expr(t.guard, scope);
    block(t.action, scope);
    expr(t.resume, scope);
  }
  for (const AtomPriority& p : d.atom_priorities) {
    use_member(owner, p.low);
    use_member(owner, p.high);
    expr(p.guard, scope);
  }
  for (const Invariant& i : d.invariants) {
    members(i.places);
    expr(i.expr, scope);
  }
}

void IndexBuilder::resolve(const DeclRow& row) {
  const Decl& d = *row.decl;
  Scope scope{.file = row.file, .owners = {}, .loop_variables = {}};
  if (row.symbol.is_valid()) scope.owners.push_back(row.symbol);
  for (const DataDecl& data : d.data) {
    for (const Var& v : data.vars) expr(v.init, scope);
  }
  expr(d.body, scope);
  if (!row.symbol.is_valid()) return;
  if (d.connector != nullptr) resolve_connector(*d.connector, row.symbol, scope);
  if (d.kind == DeclKind::AtomType) resolve_atom(d, row.symbol, scope);
  if (d.kind != DeclKind::CompoundType) return;
  resolve_items(d.items, row.symbol, scope);
  for (const CompoundPriority& p : d.priorities) {
    resolve_pattern(p.low, scope);
    resolve_pattern(p.high, scope);
    expr(p.guard, scope);
  }
  for (const CompoundExport& e : d.exports) {
    for (const Path& target : e.targets) path(target, scope, UseKind::Read);
  }
}

Index IndexBuilder::run(std::span<const Syntax* const> files) {
  std::map<std::string, std::size_t> by_name;
  // A guess: growing would hash all names again.
  constexpr std::size_t kBytesPerName = 40;
  std::size_t bytes = 0;
  for (const Syntax* syntax : files) bytes += syntax == nullptr ? 0 : sources_.text(syntax->file).size();
  names_.reserve(bytes / kBytesPerName);
  for (const Syntax* syntax : files) {
    if (syntax == nullptr || syntax->package == nullptr) continue;
    files_.emplace_back().syntax = syntax;
    declare_file(files_.size() - 1);
    by_name.emplace(files_.back().name, files_.size() - 1);
  }
  for (File& file : files_) {
    for (const Path& used : file.syntax->package->uses) {
      const auto known = by_name.find(std::string(sources_.text(used.range)));
      if (known == by_name.end()) continue;
      file.used.push_back(known->second);
      use(used.range, files_[known->second].package);
    }
  }
  for (const DeclRow& row : decls_) link_types(row);
  for (int level = 0; level < kMaxExportLevels; ++level) {
    for (const DeclRow& row : decls_) link_exports(row);
    bool is_known = true;
    for (const Symbol& s : out_.symbols) is_known &= s.kind != SymbolKind::ExportedPort || s.type.is_valid();
    if (is_known) break;
  }
  for (const DeclRow& row : decls_) resolve(row);
  return std::move(out_);
}

}  // namespace bip::index
