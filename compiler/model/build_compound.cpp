// Compound types: families of names first, then items, priorities, exports. A compound is built after those it
// contains.
#include <algorithm>

#include "compiler/model/compound_builder.hpp"
#include "compiler/model/packages.hpp"
#include "compiler/model/ffi_declarations.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::model {

// A component of the paper's notation that an instance does not initialise keeps its declared value.
ExprId ModelBuilder::initial_value(const ComponentFamily& family, const std::string& param, Type type) {
  const Scope empty{.names = {}, .owner = "an initial value"};
  CodeBuilder code(model, diags, empty);
  if (!family.atom.is_valid() || !param.starts_with("initial ")) return code.poison(type);
  for (const syntax::Decl* decl : model.decls) {
    if (decl->kind != syntax::DeclKind::AtomType || !model.atom_types[family.atom].name.ends_with(decl->name.text) ||
        key(*decl) != model.atom_types[family.atom].name)
      continue;
    for (const syntax::DataDecl& d : decl->data) {
      for (const syntax::Var& v : d.vars) {
        if (v.init != nullptr && "initial " + std::string(v.name.text) == param)
          return code.expr_as(v.init, type, fmt::format("`{}`", v.name.text));
      }
    }
  }
  return code.poison(type);
}

bool CompoundBuilders::ensure(CompoundTypeId id) {
  BuildState& state = states[id.value];
  BIP_ASSERT(states.size() == decls.size() && heights.size() == decls.size(), "{} states of {} compounds",
             states.size(), decls.size());
  if (state != BuildState::Untouched) return state == BuildState::Done;
  state = BuildState::Building;
  CompoundType out;  // built aside: rows move while others are built
  CompoundBuilder builder{*this, b, *decls[id.value], out};
  ++depth;
  builder.build();
  --depth;
  BIP_ASSERT(states[id.value] == BuildState::Building, "compound {} at depth {}", id, depth);
  heights[id.value] = builder.height;
  b.model.compound_types[id] = std::move(out);
  states[id.value] = BuildState::Done;
  return true;
}

void CompoundBuilder::build() {
  out.name = b.key(decl);
  out.decl = &decl;
  out.loc = b.loc(decl.name.range);
  scope.owner = fmt::format("compound type `{}`", out.name);
  NameSpace names(b.diags, scope.owner);
  for (const syntax::Param& p : decl.params) {
    names.declare(p.name, "parameter");
    const Type type = native_data_type(b.model, p.type, "a parameter of a component", b.diags);
    scope.names[std::string(p.name.text)] = {.load = Op::LoadSelf,
                                             .index = static_cast<std::uint32_t>(out.params.size()),
                                             .type = type,
                                             .read_only = "a parameter keeps its value",
                                             .value = {},
                                             .declared = p.name.range};
    out.params.push_back({std::string(p.name.text), type, true, false, b.loc(p.name.range)});
  }
  for (const syntax::DataDecl& d : decl.data) b.not_yet(d.range, "data of a compound");
  declare_families(decl.items, names, ItemPlace::Body);
  connector_states.assign(out.connectors.size(), BuildState::Untouched);
  for (const syntax::CompoundItem* i : decl.items) out.items.push_back(item(*i));
  for (const syntax::CompoundPriority& p : decl.priorities) {
    names.declare(p.name, "priority");
    build_priority(p);
  }
  for (const syntax::CompoundPriority& p : decl.priorities) check_top_level(p);
  for (const syntax::CompoundItem* i : decl.items) check_top_level(*i);
  build_exports();
  if (b.diags.has_errors()) return;
  warn_unbound();
  warn_modified(out.items);
}

void CompoundBuilder::pattern(const syntax::InteractionPattern& p, PatternPath& row) {
  row.any_connector = p.any_connector;
  row.any_interaction = p.any_interaction;
  row.range = p.range;
  if (p.any_connector) return;
  const syntax::PathPart& part = p.connector.parts[0];
  const auto it = connectors.find(std::string(part.name.text));
  if (it == connectors.end() || p.connector.parts.size() != 1) {
    std::vector<std::string> known;
    for (const auto& [name, family] : connectors) known.push_back(name);
    auto d = b.diags.report(Diag::kB3001, p.connector.range, b.text(p.connector), out.name);
    help_similar(d, part.name.text, p.connector.range, known);
    if (p.connector.parts.size() > 1 || components.contains(std::string(part.name.text)))
      d.note("a priority of a compound orders connectors: `priority NAME c < d`, or their interactions: `c:a.p < d:*`");
    return;
  }
  row.connector.family = it->second;
  element(part, out.connectors[it->second].is_array, row.connector, fmt::format("connector `{}`", part.name.text));
  std::unordered_map<std::string, SourceRange> named;
  for (const syntax::Path& path : p.ports) {
    if (const auto [first, is_new] = named.try_emplace(b.text(path), path.range); !is_new)
      b.diags.report(Diag::kB3015, path.range, b.text(path)).label(first->second, "here first");
    PatternPort& port = row.ports.emplace_back();
    port.range = path.range;
    if (path.parts.size() == 1) {
      port.param = std::string(path.parts[0].name.text);
    } else {
      port_path(path, port.path);
    }
  }
}

// A rule is about top-level connectors: those that no other connector of the compound binds.
void CompoundBuilder::check_top_level(const syntax::CompoundPriority& p) {
  for (const syntax::InteractionPattern* side : {&p.low, &p.high}) {
    if (side->any_connector) continue;
    const auto it = connectors.find(std::string(side->connector.parts[0].name.text));
    if (it == connectors.end() || !bound_connectors[it->second]) continue;
    b.diags.report(Diag::kB3002, side->connector.range, side->connector.parts[0].name.text)
        .help("order the interactions of the connector that binds it");
  }
}

void CompoundBuilder::check_top_level(const syntax::CompoundItem& i) {
  if (i.priority != nullptr) check_top_level(*i.priority);
  for (const syntax::CompoundItem* inner : i.items) check_top_level(*inner);
}

void CompoundBuilder::build_priority(const syntax::CompoundPriority& p) {
  PriorityRule row{.name = std::string(p.name.text),
                   .low = {},
                   .high = {},
                   .guard = {},
                   .data = {},
                   .range = p.range,
                   .annotations = p.annotations};
  pattern(p.low, row.low);
  pattern(p.high, row.high);
  if (p.low.any_connector && p.high.any_connector)
    b.diags.report(Diag::kB3003, p.high.range)
        .label(p.low.range, "and here")
        .help("name the interactions of one side: `connector:*` or `connector:port,port`");
  if (p.guard != nullptr) {
    // Every exported datum of every component is in scope; those that are read become Bind rows.
    Scope data{.names = {}, .owner = fmt::format("priority `{}`", p.name.text)};
    struct AtomTypeReader {
      CompoundBuilder& self;
      Scope& data;
      PriorityRule& row;
      void visit(const syntax::Expr* e) {
        for (const syntax::Expr* operand : e->operands) visit(operand);
        DataPath ref;
        const std::string name = e->kind == syntax::ExprKind::Path ? self.b.text(e->path) : std::string();
        if (name.empty() || data.names.contains(name)) return;
        if (const auto outer = outer_value(self.scope, e->path)) {
          row.values.push_back(*outer);
          data.names.merge(outer_bindings(self.b.model.code, {&*outer, 1}, nullptr));
          return;
        }
        if (e->path.parts.size() < 2) return;
        // `pack.age.N` is a constant of a package, unless a component is called `pack`.
        const bool of_package = !self.components.contains(std::string(e->path.parts[0].name.text)) &&
                                !visible_keys(self.b.model, self.b.model.constants, name, e->path.range.file).empty();
        if (of_package) return;
        if (!self.data_path(e->path, ref, CompoundBuilder::Lookup::Reported)) {
          data.names[name] = {.read_only = "unknown", .value = {}, .declared = {}};
          return;
        }
        data.names[name] = {.load = Op::LoadBind,
                            .index = static_cast<std::uint32_t>(row.data.size()),
                            .type = ref.type,
                            .read_only = "a guard",
                            .value = {},
                            .declared = {}};
        row.data.push_back(ref);
        row.data_names.push_back(name);
      }
    };
    AtomTypeReader{*this, data, row}.visit(p.guard);
    row.guard = CodeBuilder(b.model, b.diags, data).guard(p.guard);
    row.guard_syntax = p.guard;
  }
  out.priorities.push_back(std::move(row));
}

void CompoundBuilder::build_exports() {
  NameSpace names(b.diags, fmt::format("the exports of compound type `{}`", out.name));
  for (const syntax::CompoundExport& e : decl.exports) {
    names.declare(e.name, e.is_data ? "data" : "port");
    if (e.is_data) {
      DataExport row{.name = std::string(e.name.text), .target = {}, .range = e.range};
      if (data_path(e.targets[0], row.target, Lookup::Reported)) out.data_exports.push_back(std::move(row));
      continue;
    }
    PortExport row{.name = std::string(e.name.text), .targets = {}, .type = {}, .range = e.range};
    for (const syntax::Path& path : e.targets) {
      PortPath target;
      if (!port_path(path, target)) continue;
      merge_target(e, row, target);
    }
    if (!row.targets.empty()) out.exports.push_back(std::move(row));
  }
}

void CompoundBuilder::merge_target(const syntax::CompoundExport& e, PortExport& row, const PortPath& target) {
  if (row.targets.empty()) {
    row.type = target.type;
  } else if (row.type.is_valid() && target.type.is_valid() && !fits(b.model, target.type, row.type)) {
    b.diags
        .report(Diag::kB2027, target.range, b.text(*target.path), port_type_text(b.model, target.type),
                b.text(*row.targets[0].path), port_type_text(b.model, row.type))
        .label(row.targets[0].range, "merged with this one");
  }
  for (const PortPath& other : row.targets) {
    if (b.text(*other.path) != b.text(*target.path)) continue;
    b.diags.report(Diag::kB2028, target.range, b.text(*target.path), e.name.text).label(other.range, "here, too");
    return;
  }
  BIP_ASSERT(target.path != nullptr && !target.path->parts.empty(), "a merged port of no path");
  row.targets.push_back(target);
}

void CompoundBuilder::warn_unbound() {
  std::vector<const syntax::CompoundItem*> todo(decl.items.begin(), decl.items.end());
  for (std::size_t n = 0; n < todo.size(); ++n) {
    const syntax::CompoundItem& i = *todo[n];
    todo.insert(todo.end(), i.items.begin(), i.items.end());
    if (i.kind == syntax::ItemKind::Component && !is_suppressed(i.annotations, "unboundcomponentport")) {
      const ComponentFamily& family = out.components[components[std::string(i.name.text)]];
      const auto& bound = bound_ports[components[std::string(i.name.text)]];
      BIP_ASSERT(bound_ports.size() == out.components.size() && bound_connectors.size() == out.connectors.size(),
                 "ports of {} of {} components", bound_ports.size(), out.components.size());
      for (std::size_t p = 0; p < bound.size(); ++p) {
        if (bound[p]) continue;
        if (family.is_compound) {
          b.diags.report(Diag::kB2025, i.name.range, b.model.compound_types[family.compound].exports[p].name,
                         family.name);
          continue;
        }
        const AtomType& atom = b.model.atom_types[family.atom];
        const bool merged = p >= atom.ports.size();
        if (!merged && (!atom.ports[p].exported || merged_with(atom, static_cast<std::uint32_t>(p)) != nullptr))
          continue;
        b.diags.report(Diag::kB2025, i.name.range,
                       merged ? atom.merged[p - atom.ports.size()].name : atom.ports[p].name, family.name);
      }
    } else if (i.kind == syntax::ItemKind::Connector && !is_suppressed(i.annotations, "unboundconnectorport")) {
      const std::uint32_t family = connectors[std::string(i.name.text)];
      if (out.connectors[family].exports && !bound_connectors[family])
        b.diags.report(Diag::kB2026, i.name.range, i.name.text);
    }
  }
}

void build_compound_types(ModelBuilder& b) {
  CompoundBuilders all{
      .b = b, .decls = {}, .atom_decls = {}, .connector_decls = {}, .modified = {}, .states = {}, .heights = {}};
  for (const syntax::Decl* decl : b.model.decls) {
    if (decl->kind == syntax::DeclKind::AtomType) all.atom_decls.push_back(decl);
    if (decl->kind == syntax::DeclKind::ConnectorType) all.connector_decls.push_back(decl);
    if (decl->kind != syntax::DeclKind::CompoundType) continue;
    all.decls.push_back(decl);
    all.states.push_back(BuildState::Untouched);
    all.heights.push_back(0);
    b.model.compound_types.push({.name = b.key(*decl),
                                 .params = {},
                                 .components = {},
                                 .connectors = {},
                                 .items = {},
                                 .priorities = {},
                                 .exports = {},
                                 .data_exports = {},
                                 .decl = decl});
  }
  for (std::size_t i = 0; i < all.decls.size(); ++i) all.ensure(CompoundTypeId(i));
}

}  // namespace bip::model
