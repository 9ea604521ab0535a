// `a[i].p` inside a compound: which family, which element, which port or datum.
#include "compiler/model/compound_builder.hpp"
#include "compiler/model/suggest.hpp"

namespace bip::model {

namespace {

std::vector<std::string> port_names(const ModelBuilder& b, const ComponentFamily& family) {
  std::vector<std::string> names;
  if (family.atom.is_valid()) {
    const AtomType& atom = b.model.atom_types[family.atom];
    for (std::uint32_t p = 0; p < atom.ports.size(); ++p) {
      if (atom.ports[p].exported && merged_with(atom, p) == nullptr) names.push_back(atom.ports[p].name);
    }
    for (const MergedPort& m : atom.merged) names.push_back(m.name);
  } else if (family.compound.is_valid()) {
    for (const PortExport& e : b.model.compound_types[family.compound].exports) names.push_back(e.name);
  }
  return names;
}

const std::string& type_name(const ModelBuilder& b, const ComponentFamily& family) {
  return family.is_compound ? b.model.compound_types[family.compound].name : b.model.atom_types[family.atom].name;
}

}  // namespace

bool CompoundBuilder::element(const syntax::PathPart& part, bool is_array, ElementRef& ref, const std::string& what) {
  if (is_array && part.index == nullptr && !part.star) {
    b.diags.report(Diag::kB4011, part.name.range, what)
        .help(fmt::format("write `{}[0]`, or `{}[*]` for all", part.name.text, part.name.text), part.name.range,
              std::string(part.name.text) + "[0]");
    return false;
  }
  if (!is_array && (part.index != nullptr || part.star)) {
    b.diags.report(Diag::kB4012, part.name.range, what);
    return false;
  }
  ref.star = part.star;
  if (part.index != nullptr)
    ref.index = CodeBuilder(b.model, b.diags, scope).expr_as(part.index, Type::Int, "the index");
  return true;
}

bool CompoundBuilder::port_path(const syntax::Path& path, PortPath& ref) {
  ref.path = &path;
  ref.range = path.range;
  const std::string name(path.parts[0].name.text);
  const auto connector = connectors.find(name);
  // A connector stands for the port that it exports: `moduleTick[i]`.
  const bool is_short =
      path.parts.size() == 1 && connector != connectors.end() && out.connectors[connector->second].exports;
  if (path.parts.size() > 2) return deep_port_path(path, ref);
  if (path.parts.size() == 1 && !is_short) {
    auto d = b.diags.report(Diag::kB2017, path.range, b.text(path));
    if (const auto c = components.find(name); c != components.end()) {
      if (const auto ports = port_names(b, out.components[c->second]); !ports.empty())
        d.note(fmt::format("the ports of `{}`: {}", name, quoted_list(ports)));
    } else if (connector != connectors.end()) {
      d.note(fmt::format("connector `{}` exports no port", name));
    }
    return false;
  }
  if (const auto c = components.find(name); c != components.end()) return component_port(path, c->second, ref);
  if (connector != connectors.end()) return connector_port(path, connector->second, ref);
  std::vector<std::string> known;
  for (const auto& [key, row] : components) known.push_back(key);
  for (const auto& [key, row] : connectors) known.push_back(key);
  const syntax::Name& first = path.parts[0].name;
  help_similar(b.diags.report(Diag::kB1030, first.range, name, out.name), name, first.range, known);
  return false;
}

bool CompoundBuilder::component_port(const syntax::Path& path, std::uint32_t row, PortPath& ref) {
  const ComponentFamily& family = out.components[row];
  const syntax::Name& port = path.parts[1].name;
  ref.element.family = row;
  if (!element(path.parts[0], family.is_array, ref.element, fmt::format("component `{}`", family.name))) return false;
  if (!family.atom.is_valid() && !family.compound.is_valid()) return false;
  if (family.is_compound) {
    const auto& exports = b.model.compound_types[family.compound].exports;
    for (std::uint32_t p = 0; p < exports.size(); ++p) {
      if (exports[p].name != port.text) continue;
      ref.port = p, ref.type = exports[p].type;
      bound_ports[row][p] = true;
      return true;
    }
  } else {
    const AtomType& atom = b.model.atom_types[family.atom];
    const auto& ports = atom.ports;
    for (std::uint32_t m = 0; m < atom.merged.size(); ++m) {
      if (atom.merged[m].name != port.text) continue;
      ref.port = static_cast<std::uint32_t>(ports.size()) + m, ref.type = atom.merged[m].type;
      bound_ports[row][ref.port] = true;
      return true;
    }
    for (std::uint32_t p = 0; p < ports.size(); ++p) {
      if (ports[p].name != port.text) continue;
      const MergedPort* merged = merged_with(atom, p);
      if (!ports[p].exported || merged != nullptr) {
        auto d = b.diags.report(Diag::kB2018, port.range, port.text, type_name(b, family));
        const SourceRange at = port_declaration(b.model, type_name(b, family), port.text);
        if (merged == nullptr && at.is_valid())
          d.help("declare it with `export port`", {at.file, at.begin, at.begin}, "export ");
        else d.help(fmt::format("it is exported as `{}`", merged->name), port.range, merged->name);
        return false;
      }
      ref.port = p, ref.type = ports[p].type;
      bound_ports[row][p] = true;
      return true;
    }
  }
  const std::vector<std::string> ports = port_names(b, family);
  auto d = b.diags.report(Diag::kB2019, port.range, family.name, type_name(b, family), port.text);
  if (!ports.empty()) d.note(fmt::format("its ports: {}", quoted_list(ports)));
  help_similar(d, port.text, port.range, ports);
  return false;
}

bool CompoundBuilder::connector_port(const syntax::Path& path, std::uint32_t row, PortPath& ref) {
  const std::string name = out.connectors[row].name;
  ref.is_connector = true;
  ref.element.family = row;
  if (!element(path.parts[0], out.connectors[row].is_array, ref.element, fmt::format("connector `{}`", name)))
    return false;
  const syntax::CompoundItem& item = *connector_items[row];
  if (item.inline_body != nullptr && out.connectors[row].exports && connector_states[row] != BuildState::Done) {
    // Its type is known only after its body: build it now, on a scratch row.
    if (connector_states[row] == BuildState::Building) {
      b.diags.report(Diag::kB4002, path.range, name);
      return false;
    }
    if (chain >= kMaxNesting) {
      b.diags.report(Diag::kB0008, path.range, kMaxNesting)
          .label("a chain of connectors, each used before it is declared");
      return false;
    }
    ++chain;
    CompoundItem scratch;
    connector_item(item, scratch);
    --chain;
  }
  const ConnectorFamily& family = out.connectors[row];
  ref.type = family.export_type;
  if (path.parts.size() > 1 && (!family.exports || family.export_name != path.parts[1].name.text)) {
    const syntax::Name& port = path.parts[1].name;
    auto d = b.diags.report(Diag::kB2020, port.range, name, port.text);
    if (family.exports) d.help(fmt::format("it exports `{}`", family.export_name), port.range, family.export_name);
    else d.note("it exports no port");
    return false;
  }
  bound_connectors[row] = true;
  return true;
}

std::optional<std::pair<std::uint32_t, Type>> exported_data(const Model& model, const ComponentFamily& family,
                                                            std::string_view name) {
  if (family.atom.is_valid()) {
    const auto& variables = model.atom_types[family.atom].variables;
    for (std::uint32_t s = 0; s < variables.size(); ++s) {
      if (variables[s].exported && variables[s].name == name) return std::pair{s, variables[s].type};
    }
  } else if (family.compound.is_valid()) {
    const auto& rows = model.compound_types[family.compound].data_exports;
    for (std::uint32_t r = 0; r < rows.size(); ++r) {
      if (rows[r].name == name) return std::pair{r, rows[r].target.type};
    }
  }
  return std::nullopt;
}

bool CompoundBuilder::data_path(const syntax::Path& path, DataPath& ref, Lookup lookup) {
  ref.range = path.range;
  ref.path = &path;
  const auto c = components.find(std::string(path.parts[0].name.text));
  if (path.parts.size() > 1 && c != components.end()) {
    const ComponentFamily& family = out.components[c->second];
    if (const auto data = deep_data(family, path.parts.subspan(1))) {
      ref.element.family = c->second;
      ref.variable = data->first, ref.type = data->second;
      return element(path.parts[0], family.is_array, ref.element, fmt::format("component `{}`", family.name));
    }
  }
  if (lookup == Lookup::Reported)
    b.diags.report(Diag::kB1031, path.range, b.text(path), out.name)
        .help("only data declared with `export data` are seen from outside");
  return false;
}

}  // namespace bip::model
