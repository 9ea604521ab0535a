// Bindings: from paths in a compound to atoms' ports, connectors' exported ports and data variables.
#include <algorithm>
#include <bit>

#include "compiler/model/code_builder.hpp"
#include "compiler/model/evaluate.hpp"
#include "compiler/system/instantiator.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::system {

namespace {
constexpr std::size_t kMaxConnectorDepth = 5000;
}

std::optional<std::uint32_t> Instantiator::find(const Instance& in, const ElementRef& ref, ElementKind kind,
                                                const std::vector<Value>& self, SourceRange at) {
  std::size_t index = 0;
  std::int64_t wanted = 0;
  if (ref.index.is_valid()) {
    const std::optional<Value> v = value(ref.index, self, at);
    if (!v) return std::nullopt;
    wanted = v->int_value;
    index = static_cast<std::size_t>(wanted);
  }
  const CompoundType& type = model.compound_types[in.type];
  BIP_ASSERT(ref.family < (kind == ElementKind::Connector ? in.connectors.size() : in.components.size()), "family {}",
             ref.family);
  const bool is_connector = kind == ElementKind::Connector;
  const std::size_t size = is_connector ? in.connectors[ref.family].size() : in.components[ref.family].size();
  if (wanted >= 0 && index < size) {
    const std::uint32_t row = is_connector ? in.connectors[ref.family][index] : in.components[ref.family][index].row;
    if (row != Element::kHole) return row;
  }
  const std::string& name = is_connector ? type.connectors[ref.family].name : type.components[ref.family].name;
  diags.report(Diag::kB4014, at, ref.index.is_valid() ? fmt::format("{}[{}]", name, wanted) : name,
               size == 0 ? fmt::format("`{}` has no elements here", name)
                         : fmt::format("the elements of `{}` here are 0 to {}", name, size - 1));
  return std::nullopt;
}

std::optional<PortRef> Instantiator::exported_port(std::uint32_t instance, std::uint32_t row, std::size_t depth) {
  BIP_ASSERT(row < model.compound_types[instances[instance].type].exports.size(), "export {}", row);
  const PortExport& e = model.compound_types[instances[instance].type].exports[row];
  // A merged one has the same row for all who bind it.
  const bool merges = e.targets.size() > 1 || (!e.targets.empty() && e.targets[0].element.star);
  if (const auto known = merged_exports.find({instance, row}); known != merged_exports.end()) return known->second;
  std::vector<PortRef> refs;
  const std::vector<Value> self = instances[instance].params;
  for (const PortPath& target : e.targets) {
    if (!resolve_port(instance, target, self, refs, depth + 1)) return std::nullopt;
  }
  if (refs.empty()) {
    diags.report(Diag::kB4014, e.range, e.name, "it stands for no port here");
    return std::nullopt;
  }
  // What a compound shows of a connector is only its maximal interactions.
  for (PortRef& ref : refs) {
    if (ref.kind == PortRef::Kind::Connector) ref.maximal_only = true;
  }
  if (!merges) return refs[0];
  const PortRef ref = choice_of(out.compounds[instances[instance].row].path + "." + e.name, refs);
  merged_exports[{instance, row}] = ref;
  return ref;
}

// A new row of the choices; those within it are taken apart, what occurs twice is kept once.
PortRef Instantiator::choice_of(const std::string& path, const std::vector<PortRef>& ports) {
  Choice row{.name = path, .ports = {}};
  const auto add = [&](const PortRef& ref) {
    if (std::find(row.ports.begin(), row.ports.end(), ref) == row.ports.end()) row.ports.push_back(ref);
  };
  for (const PortRef& ref : ports) {
    if (ref.kind != PortRef::Kind::Choice) {
      add(ref);
    } else {
      BIP_ASSERT(ref.choice < out.choices.size(), "choice {} of {}", ref.choice, out.choices.size());
      for (const PortRef& inner : std::vector<PortRef>(out.choices[ref.choice].ports)) add(inner);
    }
  }
  BIP_ASSERT(!row.ports.empty(), "`{}` has an alternative", row.name);
  if (row.ports.size() == 1) return row.ports[0];
  out.choices.push_back(std::move(row));
  PortRef ref;
  ref.kind = PortRef::Kind::Choice;
  ref.choice = static_cast<std::uint32_t>(out.choices.size() - 1);
  return ref;
}

// A port of an atom, or a merged one of its type.
PortRef Instantiator::atom_port(AtomId atom, std::uint32_t port) {
  const AtomType& type = model.atom_types[out.atoms[atom].type];
  const auto own = [&](std::uint32_t p) {
    return PortRef{.kind = PortRef::Kind::Atom, .atom = atom, .port = p, .connector = {}, .maximal_only = false};
  };
  BIP_ASSERT(port < type.ports.size() + type.merged.size(), "port {} of atom type {}", port, type.name);
  if (port < type.ports.size()) return own(port);
  const auto [known, is_new] = merged_ports.try_emplace({atom.value, port});
  if (is_new) {
    const MergedPort& merged = type.merged[port - type.ports.size()];
    std::vector<PortRef> refs;
    for (const std::uint32_t p : merged.ports) refs.push_back(own(p));
    known->second = choice_of(out.atoms[atom].path + "." + merged.name, refs);
  }
  return known->second;
}

bool Instantiator::resolve_port(std::uint32_t instance, const PortPath& path, const std::vector<Value>& self,
                                std::vector<PortRef>& to, std::size_t depth, std::vector<ShownPort>* shown) {
  std::vector<std::uint32_t> rows;
  if (path.element.star) {
    if (path.is_connector) {
      rows = instances[instance].connectors[path.element.family];
    } else {
      for (const Element& e : instances[instance].components[path.element.family]) rows.push_back(e.row);
    }
    std::erase(rows, Element::kHole);
  } else {
    const std::optional<std::uint32_t> row =
        find(instances[instance], path.element, path.is_connector ? ElementKind::Connector : ElementKind::Component,
             self, path.range);
    if (!row) return false;
    rows.push_back(*row);
  }
  const bool is_compound =
      !path.is_connector && model.compound_types[instances[instance].type].components[path.element.family].is_compound;
  for (const std::uint32_t row : rows) {
    if (path.is_connector) {
      const ConnectorId id = resolve_connector(instance, row, depth + 1);
      if (!id.is_valid()) return false;
      to.push_back({.kind = PortRef::Kind::Connector, .atom = {}, .port = 0, .connector = id, .maximal_only = false});
    } else if (is_compound) {
      const std::optional<PortRef> ref = exported_port(row, path.port, depth);
      if (!ref) return false;
      if (shown != nullptr) {
        shown->push_back({.param = static_cast<std::uint32_t>(to.size()),
                          .compound = instances[row].row,
                          .name = model.compound_types[instances[row].type].exports[path.port].name});
      }
      to.push_back(*ref);
    } else {
      to.push_back(atom_port(AtomId(row), path.port));
    }
  }
  return true;
}

ConnectorId Instantiator::resolve_connector(std::uint32_t instance, std::uint32_t pending, std::size_t depth) {
  {
    PendingConnector& p = instances[instance].pending[pending];
    if (p.id.is_valid() || p.failed) return p.id;
    if (depth > kMaxConnectorDepth) {
      diags.report(Diag::kB0008, p.item->syntax->name.range, kMaxConnectorDepth).label("connectors of connectors");
      return {};
    }
    if (p.in_progress) {
      diags.report(Diag::kB4002, p.item->syntax->name.range, p.name);
      return {};
    }
    p.in_progress = true;
  }
  const ConnectorId id = bind_connector(instance, pending, depth);
  PendingConnector& p = instances[instance].pending[pending];
  BIP_ASSERT(!id.is_valid() || id.value + 1 == out.connectors.size() || diags.has_errors(),
             "the last connector is the one that was bound");
  p.id = id;
  p.in_progress = false;
  p.failed = !id.is_valid();
  return id;
}

ConnectorId Instantiator::bind_connector(std::uint32_t instance, std::uint32_t pending, std::size_t depth) {
  const CompoundItem& item = *instances[instance].pending[pending].item;
  const std::vector<Value> self = instances[instance].pending[pending].self;
  BIP_ASSERT(instances[instance].pending[pending].in_progress, "a connector is bound once");
  Connector row{.path = {},
                .type = item.type,
                .parent = instances[instance].row,
                .ports = {},
                .data = {},
                .bound = false,
                .loc = model.loc(item.range)};
  std::vector<std::uint32_t> counts;
  for (const PortPath& path : item.ports) {
    const std::size_t before = row.ports.size();
    if (!resolve_port(instance, path, self, row.ports, depth, &row.shown)) return {};
    counts.push_back(static_cast<std::uint32_t>(row.ports.size() - before));
  }
  if ((item.has_star || !item.values.empty()) && item.syntax->inline_body != nullptr) {
    std::vector<std::uint32_t> variant = counts;
    for (const OuterValue& v : item.values) {
      const auto bits = v.type == Type::Float ? std::bit_cast<std::uint64_t>(self[v.variable].float_value)
                                              : static_cast<std::uint64_t>(self[v.variable].int_value);
      variant.push_back(static_cast<std::uint32_t>(bits));
      variant.push_back(static_cast<std::uint32_t>(bits >> 32));
    }
    auto [it, is_new] = expanded.try_emplace({&item, std::move(variant)});
    if (is_new) it->second = model::expand_inline_connector(model, diags, item, counts, self);
    if (diags.has_errors()) return {};
    row.type = it->second;
  }
  const ConnectorType& type = model.connector_types[row.type];
  if (row.ports.size() != type.params.size()) {
    diags.report(Diag::kB2022, item.syntax->name.range, model::counted(row.ports.size(), "port"), type.name,
                 type.params.size());
    return {};
  }
  if (item.has_star) {
    for (std::size_t k = 0, path = 0, used = 0; k < row.ports.size(); ++k, ++used) {
      while (used == counts[path]) used = 0, ++path;
      if (model::fits(model, item.ports[path].type, type.params[k].type)) continue;
      diags.report(Diag::kB2023, item.ports[path].range, model.sources->text(item.ports[path].range),
                   model::port_type_text(model, item.ports[path].type), type.params[k].name, type.name,
                   model::port_type_text(model, type.params[k].type));
      return {};
    }
  }
  BIP_ASSERT(item.data.size() == type.data_reads.size(), "connector type {} reads {} data, {} are bound", type.name,
             type.data_reads.size(), item.data.size());
  for (const DataPath& d : item.data) {
    const std::optional<DataRef> ref = resolve_data(instance, d, self);
    if (!ref) return {};
    row.data.push_back(*ref);
  }
  for (const PortRef& ref : row.ports) {
    BIP_ASSERT(ref.kind != PortRef::Kind::Atom || out.atoms.contains(ref.atom), "atom {} of {}", ref.atom,
               out.atoms.size());
    if (ref.kind == PortRef::Kind::Connector) out.connectors[ref.connector].bound = true;
    if (ref.kind != PortRef::Kind::Choice) continue;
    for (const PortRef& alternative : out.choices[ref.choice].ports) {
      if (alternative.kind == PortRef::Kind::Connector) out.connectors[alternative.connector].bound = true;
    }
  }
  row.path = out.compounds[instances[instance].row].path + "." + instances[instance].pending[pending].name;
  row.weight = item.weight;
  const ConnectorId id = out.connectors.push(std::move(row));
  if (!type.exports) check_components(id, item.syntax->name.range);
  return id;
}

std::optional<DataRef> Instantiator::resolve_data(std::uint32_t instance, const DataPath& path,
                                                  const std::vector<Value>& self) {
  const std::optional<std::uint32_t> row =
      find(instances[instance], path.element, ElementKind::Component, self, path.range);
  if (!row) return std::nullopt;
  const ComponentFamily& family = model.compound_types[instances[instance].type].components[path.element.family];
  BIP_ASSERT(family.is_compound || path.variable < model.atom_types[family.atom].variables.size(),
             "variable {} of `{}`", path.variable, family.name);
  if (!family.is_compound) return DataRef{AtomId(*row), path.variable};
  const DataExport& e = model.compound_types[instances[*row].type].data_exports[path.variable];
  const std::vector<Value> inner = instances[*row].params;
  return resolve_data(*row, e.target, inner);
}

// `define` always gives the interaction of all ports, so two ways to one atom would meet there.
void Instantiator::check_components(ConnectorId id, SourceRange at) {
  stamps.resize(out.atoms.size(), Element::kHole);
  std::vector<ConnectorId> todo{id};
  while (!todo.empty()) {
    const Connector& c = out.connectors[todo.back()];
    todo.pop_back();
    for (const PortRef& ref : c.ports) {
      if (ref.kind == PortRef::Kind::Choice) return check_alternatives(id, at);
      if (ref.kind == PortRef::Kind::Connector) {
        todo.push_back(ref.connector);
      } else if (stamps[ref.atom.value] == id.value) {
        diags.report(Diag::kB4007, at, out.atoms[ref.atom].path, out.connectors[id].path);
        return;
      } else {
        stamps[ref.atom.value] = id.value;
      }
    }
  }
}

}  // namespace bip::system
