// Inline connectors (the paper's notation): type and instance at once; ports are named by what they connect, and the
// code may read exported data of the components that take part.
#include <algorithm>
#include <set>

#include "compiler/model/compound_builder.hpp"

namespace bip::model {

namespace {

// Keys of all names that the clauses read or write.
struct NameCollector {
  const SourceMap& sources;
  std::set<std::string> names{};

  void expr(const syntax::Expr* e) {
    if (e == nullptr) return;
    if (e->kind == syntax::ExprKind::Path) names.insert(path_key(e->path, sources));
    for (const syntax::Expr* operand : e->operands) expr(operand);
  }
  void stmts(std::span<const syntax::Stmt* const> list) {
    for (const syntax::Stmt* s : list) {
      expr(s->value);
      stmts(s->then_body);
      stmts(s->else_body);
    }
  }
};

}  // namespace

void build_inline_connector(Builder& b, const std::vector<ComponentFamily>& components, const syntax::CompoundItem& item, const std::vector<PortPath>& paths,
                            const std::vector<std::uint32_t>& counts, std::vector<DataPath>& data, ConnectorType& out) {
  ConnectorPorts ports;
  std::uint32_t bind = 0;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const std::string key = b.text(*paths[k].path);
    auto& rows = ports.rows[key];
    if (!rows.empty()) {
      const auto first = std::find_if(paths.begin(), paths.end(), [&](const PortPath& p) { return b.text(*p.path) == key; });
      b.diags.report(Diag::kB2024, paths[k].range, key, item.name.text).label(first->range, "here first");
    }
    for (std::uint32_t n = 0; n < counts[k]; ++n) {
      std::string name = key;
      if (const std::size_t star = name.find("[*]"); star != std::string::npos) name.replace(star, 3, fmt::format("[{}]", n));
      rows.push_back(static_cast<std::uint32_t>(ports.params.size()));
      ports.params.push_back({name, paths[k].type, bind, b.loc(paths[k].range)});
      if (paths[k].type.is_valid()) bind += static_cast<std::uint32_t>(b.model.port_types[paths[k].type].variables.size());
    }
  }
  NameCollector used{b.sources};
  for (const syntax::Clause& c : item.inline_body->clauses) {
    used.expr(c.guard);
    used.stmts(c.up.stmts);
    used.stmts(c.down.stmts);
    used.stmts(c.action.stmts);
  }
  data.clear();
  for (const PortPath& path : paths) {
    if (path.is_connector || path.element.star) continue;
    const syntax::Path component{path.path->parts.subspan(0, 1), path.path->parts[0].name.range};
    const std::string prefix = b.text(component) + ".";
    for (const std::string& name : used.names) {
      if (!name.starts_with(prefix) || ports.data.contains(name)) continue;
      const auto found = exported_data(b.model, components[path.element.family], std::string_view(name).substr(prefix.size()));
      if (!found) continue;
      ports.data[name] = {.load = Op::LoadBind, .index = bind++, .type = found->second, .read_only = "exported data are read-only from outside", .value = {}, .declared = {}};
      ports.data_reads.push_back({name, found->second});
      data.push_back({path.element, found->first, found->second, path.range});
    }
  }
  build_connector_body(b, *item.inline_body, ports, true, item.name.range, item.annotations, out);
}

ConnectorTypeId expand_inline_connector(Model& model, Diagnostics& diags, const CompoundType& compound, const CompoundItem& item,
                                        const std::vector<std::uint32_t>& counts, std::vector<DataPath>& data) {
  Builder b{model, diags, *model.sources, {}};
  ConnectorType type{.name = model.connector_types[item.type].name, .params = {}, .data_reads = {}, .slots = {}, .define = {}, .clauses = {}, .export_name = {}, .export_type = {}, .export_slots = {}, .loc = model.connector_types[item.type].loc};
  build_inline_connector(b, compound.components, *item.syntax, item.ports, counts, data, type);
  return model.connector_types.push(std::move(type));
}

}  // namespace bip::model
