// Inline connectors (the paper's notation): type and instance at once; ports are named by what they connect, and the
// code may read exported data of the compound's components, whether they take part or not.
#include <algorithm>
#include <map>
#include <set>

#include "compiler/model/compound_builder.hpp"
#include "compiler/syntax/code_paths.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::model {

std::vector<DataRead> CompoundBuilder::data_reads(const syntax::CompoundItem& i, CompoundItem& row) {
  // All names that the clauses read or write, by key.
  std::map<std::string, const syntax::Path*> used;
  for (const syntax::Clause& c : i.inline_body->clauses) {
    syntax::for_each_path(c, [&](const syntax::Path& path) { used.try_emplace(path_key(path, b.sources), &path); });
  }
  std::set<std::string_view> own;
  for (const syntax::DataDecl& d : i.inline_body->data) {
    for (const syntax::Var& v : d.vars) own.insert(v.name.text);
  }
  std::vector<DataRead> reads;
  for (const auto& [key, path] : used) {
    if (path->parts.size() < 2) {
      if (const auto outer = outer_value(scope, *path); outer && !own.contains(key)) row.values.push_back(*outer);
      continue;
    }
    const auto is_of = [&key = key, this](const PortPath& port) { return key.starts_with(b.text(*port.path) + "."); };
    DataPath ref;
    if (std::any_of(row.ports.begin(), row.ports.end(), is_of) || !data_path(*path, ref, Lookup::Silent)) continue;
    reads.push_back({key, ref.type});
    row.data.push_back(ref);
  }
  return reads;
}

void build_inline_connector(ModelBuilder& b, const syntax::CompoundItem& item, const std::vector<PortPath>& paths,
                            const std::vector<std::uint32_t>& counts, const std::vector<DataRead>& reads,
                            const OuterBindings& values, ConnectorType& out) {
  ConnectorPorts ports;
  ports.data = values;
  std::uint32_t bind = 0;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const std::string key = b.text(*paths[k].path);
    BIP_ASSERT(counts.size() == paths.size(), "{} counts of {} ports", counts.size(), paths.size());
    auto& rows = ports.rows[key];
    if (!rows.empty()) {
      const auto first =
          std::find_if(paths.begin(), paths.end(), [&](const PortPath& p) { return b.text(*p.path) == key; });
      b.diags.report(Diag::kB2024, paths[k].range, key, item.name.text).label(first->range, "here first");
    }
    for (std::uint32_t n = 0; n < counts[k]; ++n) {
      std::string name = key;
      if (const std::size_t star = name.find("[*]"); star != std::string::npos)
        name.replace(star, 3, fmt::format("[{}]", n));
      rows.push_back(static_cast<std::uint32_t>(ports.params.size()));
      ports.params.push_back({name, paths[k].type, bind, b.loc(paths[k].range)});
      if (paths[k].type.is_valid())
        bind += static_cast<std::uint32_t>(b.model.port_types[paths[k].type].variables.size());
    }
  }
  for (const DataRead& read : reads) {
    ports.data[read.path] = {.load = Op::LoadBind,
                             .index = bind++,
                             .type = read.type,
                             .read_only = "exported data are read-only from outside",
                             .value = {},
                             .declared = {}};
  }
  ports.data_reads = reads;
  build_connector_body(b, *item.inline_body, ports, ConnectorForm::Inline, item.name.range, item.annotations, out);
}

ConnectorTypeId expand_inline_connector(Model& model, Diagnostics& diags, const CompoundItem& item,
                                        const std::vector<std::uint32_t>& counts, const std::vector<Value>& self) {
  ModelBuilder b{model, diags, *model.sources, {}};
  const std::vector<DataRead> reads = model.connector_types[item.type].data_reads;
  ConnectorType type{.name = model.connector_types[item.type].name, .loc = model.connector_types[item.type].loc};
  build_inline_connector(b, *item.syntax, item.ports, counts, reads, outer_bindings(model.code, item.values, &self),
                         type);
  return model.connector_types.push(std::move(type));
}

}  // namespace bip::model
