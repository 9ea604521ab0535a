// Names of components and connectors in a compound: one family a name, an array if it is declared with an index.
#include <algorithm>

#include "compiler/model/compound_builder.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::model {

void CompoundBuilder::declare_families(std::span<const syntax::CompoundItem* const> items, NameSpace& names,
                                       ItemPlace place) {
  for (const syntax::CompoundItem* i : items) {
    if (i->kind == syntax::ItemKind::For) {
      declare_families(i->items, names, ItemPlace::Loop);
      continue;
    }
    const std::string name(i->name.text);
    const bool is_property = i->kind == syntax::ItemKind::Property;
    if (i->kind == syntax::ItemKind::Priority || is_property) {
      if (i->index == nullptr && place == ItemPlace::Loop)
        b.diags.report(Diag::kB4010, i->name.range, name)
            .help(fmt::format("write `{}[i]` with the loop's variable", name), i->name.range,
                  fmt::format("{}[i]", name));
      // One item of a loop stands for many.
      if (is_property || loop_priorities.insert(name).second)
        names.declare(i->name, is_property ? "property" : "priority");
      continue;
    }
    const bool is_component = i->kind == syntax::ItemKind::Component;
    auto& rows = is_component ? components : connectors;
    // Elements of one array may be declared by several items: of loops, and connectors, whose index is never a size,
    // anywhere.
    if (const auto known = rows.find(name);
        known != rows.end() && i->index != nullptr && (place == ItemPlace::Loop || !is_component)) {
      if (is_component && out.components[known->second].is_array) continue;
      if (!is_component && out.connectors[known->second].is_array) {
        // Its exported port is compared with that of the first item when both are built.
        if (i->inline_body == nullptr) (void)b.type_row(i->type, TypeName::Kind::Connector, "connector type");
        continue;
      }
    }
    if (place == ItemPlace::Loop && i->index == nullptr)
      b.diags.report(Diag::kB4010, i->name.range, name)
          .help(fmt::format("write `{}[i]` with the loop's variable", name), i->name.range, fmt::format("{}[i]", name));
    if (!names.declare(i->name, is_component ? "component" : "connector")) continue;
    if (is_component) {
      ComponentFamily family{
          .name = name, .atom = {}, .compound = {}, .is_array = i->index != nullptr, .range = i->name.range};
      const TypeName* known = b.find_type(i->type.name);
      if (known != nullptr && known->kind == TypeName::Kind::Atom) {
        family.atom = AtomTypeId(known->row);
        const AtomType& atom = b.model.atom_types[family.atom];
        bound_ports.emplace_back(atom.ports.size() + atom.merged.size());
      } else if (known != nullptr && known->kind == TypeName::Kind::Compound) {
        family.is_compound = true;
        const CompoundTypeId id(known->row);
        const bool too_deep = all.depth > kMaxNesting || all.heights[id.value] + 1 > kMaxNesting;
        if (too_deep) {
          b.diags.report(Diag::kB0008, i->type.name.range, kMaxNesting).label("compounds in compounds");
        } else if (!all.ensure(id)) {
          const std::string& inner = b.model.compound_types[id].name;
          b.diags.report(Diag::kB4001, i->type.name.range, out.name,
                         inner == out.name ? "" : fmt::format(" through `{}`", inner));
        } else {
          family.compound = id;
          height = std::max(height, all.heights[id.value] + 1);
        }
        bound_ports.emplace_back(family.compound.is_valid() ? b.model.compound_types[id].exports.size() : 0);
      } else {
        b.type_row(i->type, TypeName::Kind::Atom, "component type");
        bound_ports.emplace_back();
      }
      BIP_ASSERT(bound_ports.size() == out.components.size() + 1, "ports of {} of {} components", bound_ports.size(),
                 out.components.size() + 1);
      rows[name] = static_cast<std::uint32_t>(out.components.size());
      out.components.push_back(std::move(family));
    } else {
      ConnectorFamily family{.name = name, .is_array = i->index != nullptr, .export_type = {}, .range = i->name.range};
      if (i->inline_body != nullptr) {
        family.exports = i->inline_body->exported.present;
        family.export_name = std::string(i->inline_body->exported.name.text);
      } else if (const auto row = b.type_row(i->type, TypeName::Kind::Connector, "connector type")) {
        const ConnectorType& type = b.model.connector_types[ConnectorTypeId(*row)];
        family.exports = type.exports;
        family.export_name = type.export_name;
        family.export_type = type.export_type;
      }
      BIP_ASSERT(connector_items.size() == out.connectors.size(), "{} items of {} connectors", connector_items.size(),
                 out.connectors.size());
      rows[name] = static_cast<std::uint32_t>(out.connectors.size());
      out.connectors.push_back(std::move(family));
      connector_items.push_back(i);
      bound_connectors.push_back(false);
    }
  }
}

}  // namespace bip::model
