// See net.hpp.
#include "compiler/verify/net/net.hpp"

#include <algorithm>
#include <map>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class NetBuilder {
 public:
  explicit NetBuilder(const System& system) {
    net_.system = &system;
    net_.access = analysis::analyze_data_access(system);
  }
  NetBuilder(const Net& plain, const PortUses& uses, UsesAs as) : plain_(&plain), uses_(&uses), as_(as) {
    net_.system = plain.system;
    net_.access = plain.access;
    if (as == UsesAs::Ports) net_.uses = uses;
  }

  Net build() {
    add_atoms();
    // A net with too many modes is not usable; its graph is valid nevertheless.
    if (net_.too_large_atom == kNoRow)
      leaves_.of_param = [this](ConnectorId connector, u32 param) { return net_.leaf_of(connector, param); };
    net_.graph = analysis::build_connector_graph(*net_.system, leaves_);
    BIP_ASSERT(net_.graph.port_base.size() == net_.mode_base.size(), "{} atoms with leaves, {} with modes",
               net_.graph.port_base.size(), net_.mode_base.size());
    return std::move(net_);
  }

 private:
  void add_atoms() {
    const System& system = *net_.system;
    std::map<std::pair<u32, std::vector<std::pair<std::int32_t, double>>>, u32> known_classes;
    // Where uses are told apart: by the class without, and by them.
    std::map<std::pair<u32, AtomUses>, u32> known_uses;
    u32 modes = 0;
    for (std::size_t row = 0; row < system.atoms.size(); ++row) {
      const Atom& atom = system.atoms[AtomId(row)];
      const auto next = static_cast<u32>(net_.classes.size());
      u32 number = 0;
      if (plain_ == nullptr) {
        std::pair<u32, std::vector<std::pair<std::int32_t, double>>> key{atom.type.value, {}};
        for (const Value& value : atom.args) key.second.emplace_back(value.int_value, value.float_value);
        number = known_classes.try_emplace(std::move(key), next).first->second;
        if (number == next)
          net_.classes.push_back(explore_modes(system, atom.type, atom.args, net_.access[atom.type.value]));
      } else {
        number = known_uses.try_emplace({plain_->class_of[row], uses_->of_atom[row]}, next).first->second;
        if (number == next) add_class(row);
      }
      net_.class_of.push_back(number);
      const ModeClass& of_atom = net_.classes[number];
      if (of_atom.is_too_large && net_.too_large_atom == kNoRow) net_.too_large_atom = static_cast<u32>(row);
      const AtomType& type = system.atom_types[atom.type];
      net_.mode_base.push_back(modes);
      modes += static_cast<u32>(of_atom.modes.size());
      leaves_.of_atom.push_back(static_cast<u32>(std::max(type.ports.size(), of_atom.moves.size())));
      net_.atom_of_mode.resize(modes, static_cast<u32>(row));
    }
    net_.mode_base.push_back(modes);
    BIP_ASSERT(net_.atom_of_mode.size() == modes, "{} modes with an atom of {}", net_.atom_of_mode.size(), modes);
    BIP_ASSERT(net_.class_of.size() == system.atoms.size(), "{} atoms with a class", net_.class_of.size());
  }

  void add_class(std::size_t atom) {
    const ModeClass& plain = plain_->class_at(static_cast<u32>(atom));
    // Its pointer goes to the net's own uses.
    const AtomUses& uses = as_ == UsesAs::Ports ? net_.uses.of_atom[atom] : uses_->of_atom[atom];
    net_.classes.push_back(
        uses.uses.empty() ? plain : explore_modes(*net_.system, plain, net_.access[plain.type.value], uses, as_));
  }

  Net net_;
  const Net* plain_ = nullptr;
  const PortUses* uses_ = nullptr;
  UsesAs as_ = UsesAs::Ports;
  analysis::ConnectorLeaves leaves_;
};

}  // namespace

Net build_net(const System& system) { return NetBuilder(system).build(); }
Net build_net(const Net& plain, const PortUses& uses, UsesAs as) { return NetBuilder(plain, uses, as).build(); }

u32 Net::leaf_of(ConnectorId connector, std::size_t param) const {
  const PortRef& ref = system->connectors[connector].ports[param];
  BIP_ASSERT(ref.kind == PortRef::Kind::Atom, "parameter {} of connector {} is not bound to an atom's port", param,
             connector);
  const bool has_uses = !uses.of_param.empty() && !uses.of_param[connector.value].empty();
  const u32 use = has_uses ? uses.of_param[connector.value][param] : 0;
  BIP_ASSERT(use == 0 || uses.of_atom[ref.atom.value].uses[use - 1].port == ref.port, "use {} is one of another port",
             use);
  return use == 0 ? ref.port : static_cast<u32>(class_at(ref.atom.value).is_sure.size()) + use - 1;
}

u32 Net::port_node(ConnectorId connector, std::size_t param) const {
  const PortRef& ref = system->connectors[connector].ports[param];
  return graph.port_base[ref.atom.value] + leaf_of(connector, param);
}

std::string Net::mode_name(u32 mode) const {
  BIP_ASSERT(mode < mode_count(), "mode {} of {}", mode, mode_count());
  const u32 atom = atom_of_mode[mode];
  const std::string& path = system->atoms[AtomId(std::size_t{atom})].path;
  return (path.starts_with("ROOT.") ? path.substr(5) : path) + '@' +
         mode_text(*system, class_at(atom), mode - mode_base[atom]);
}

}  // namespace bip::verify
