// Takes the types of used packages that no instance needs out of a System: `use std.sync` brings a dozen connector
// types, of which a model has one. The compiled file's own types stay, used or not. Linear in the tables; ids keep
// their order.
#include "compiler/system/instantiator.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::system {
namespace {

/// Which rows stay, and their numbers then.
template <class Id, class Row>
class Renumbering {
 public:
  Renumbering(const IndexVector<Id, Row>& rows, std::uint32_t own_file) : keep_(rows.size()), ids_(rows.size()) {
    for (std::size_t k = 0; k < rows.size(); ++k) keep_[k] = rows[Id(k)].loc.file == own_file;
  }
  void need(Id id) {
    BIP_ASSERT(!id.is_valid() || id.value < keep_.size(), "row {} of {}", id, keep_.size());
    if (id.is_valid()) keep_[id.value] = true;
  }
  void shrink(IndexVector<Id, Row>& rows) {
    BIP_ASSERT(rows.size() == keep_.size(), "{} rows, {} were counted", rows.size(), keep_.size());
    IndexVector<Id, Row> kept;
    for (std::size_t k = 0; k < keep_.size(); ++k)
      if (keep_[k]) ids_[k] = kept.push(std::move(rows[Id(k)]));
    rows = std::move(kept);
  }
  void renumber(Id& id) const {
    BIP_ASSERT(!id.is_valid() || ids_[id.value].is_valid(), "type {} was dropped but is used", id);
    if (id.is_valid()) id = ids_[id.value];
  }

 private:
  std::vector<bool> keep_;
  std::vector<Id> ids_;
};

/// All port types that a kind of type names.
template <class Type, class F>
void each_port_type(Type& type, F f) {
  if constexpr (requires { type.merged; }) {
    for (auto& port : type.ports) f(port.type);
    for (auto& port : type.merged) f(port.type);
  } else {
    for (auto& param : type.params) f(param.type);
    f(type.export_type);
  }
}

}  // namespace

void drop_unused_types(System& system, std::uint32_t own_file) {
  Renumbering atom_types(system.atom_types, own_file);
  Renumbering connector_types(system.connector_types, own_file);
  Renumbering port_types(system.port_types, own_file);
  for (const Atom& atom : system.atoms) atom_types.need(atom.type);
  for (const Connector& connector : system.connectors) connector_types.need(connector.type);
  atom_types.shrink(system.atom_types);
  connector_types.shrink(system.connector_types);
  const auto need = [&](PortTypeId id) { port_types.need(id); };
  for (const AtomType& type : system.atom_types) each_port_type(type, need);
  for (const ConnectorType& type : system.connector_types) each_port_type(type, need);
  port_types.shrink(system.port_types);
  const auto renumber = [&](PortTypeId& id) { port_types.renumber(id); };
  for (AtomType& type : system.atom_types) each_port_type(type, renumber);
  for (ConnectorType& type : system.connector_types) each_port_type(type, renumber);
  for (Atom& atom : system.atoms) atom_types.renumber(atom.type);
  for (Connector& connector : system.connectors) connector_types.renumber(connector.type);
}

}  // namespace bip::system
