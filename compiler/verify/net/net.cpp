// See net.hpp.
#include "compiler/verify/net/net.hpp"

#include <algorithm>
#include <map>

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
    const System& system = *net_.system;
    add_atoms();
    if (net_.too_large_atom != kNoRow) return std::move(net_);
    for (const Choice& choice : system.choices) choice_rows_.push_back(choice.ports.empty() ? kNoRow : kUnmade);
    for (std::size_t row = 0; row < system.connectors.size(); ++row) add_connector(ConnectorId(row));
    add_parents();
    return std::move(net_);
  }

 private:
  static constexpr u32 kUnmade = kNoRow - 1;

  void add_atoms() {
    const System& system = *net_.system;
    std::map<std::pair<u32, std::vector<std::pair<std::int32_t, double>>>, u32> known_classes;
    // Where uses are told apart: by the class without, and by them.
    std::map<std::pair<u32, AtomUses>, u32> known_uses;
    u32 modes = 0, ports = 0;
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
      net_.port_base.push_back(ports);
      modes += static_cast<u32>(of_atom.modes.size());
      ports += static_cast<u32>(std::max(type.ports.size(), of_atom.moves.size()));
      net_.atom_of_mode.resize(modes, static_cast<u32>(row));
      net_.atom_of_port.resize(ports, static_cast<u32>(row));
      for (const Port& port : type.ports) {
        Node node;
        node.is_root = !port.exported;
        net_.nodes.push_back(node);
      }
      net_.nodes.resize(ports);
    }
    net_.mode_base.push_back(modes);
    net_.port_base.push_back(ports);
  }

  void add_class(std::size_t atom) {
    const ModeClass& plain = plain_->class_at(static_cast<u32>(atom));
    // Its pointer goes to the net's own uses.
    const AtomUses& uses = as_ == UsesAs::Ports ? net_.uses.of_atom[atom] : uses_->of_atom[atom];
    net_.classes.push_back(
        uses.uses.empty() ? plain : explore_modes(*net_.system, plain, net_.access[plain.type.value], uses, as_));
  }

  u32 node_of(const PortRef& ref) {
    if (ref.kind == PortRef::Kind::Atom) return net_.port_base[ref.atom.value] + ref.port;
    if (ref.kind == PortRef::Kind::Connector) return net_.root_of[ref.connector.value];
    u32& row = choice_rows_[ref.choice];
    if (row == kUnmade) {
      // No choice is among the ports of a choice.
      std::vector<Edge> edges;
      for (const PortRef& port : net_.system->choices[ref.choice].ports) edges.push_back({node_of(port), false});
      row = add(NodeKind::Any, edges);
    }
    return row;
  }
  u32 add(NodeKind kind, const std::vector<Edge>& edges) {
    Node node;
    node.kind = kind;
    node.first_child = static_cast<u32>(net_.child_edges.size());
    node.children = static_cast<u32>(edges.size());
    net_.child_edges.insert(net_.child_edges.end(), edges.begin(), edges.end());
    net_.nodes.push_back(node);
    return static_cast<u32>(net_.nodes.size() - 1);
  }
  // Rows of `define` are greater than their parent's, so backwards is bottom up.
  void add_connector(ConnectorId id) {
    const Connector& connector = net_.system->connectors[id];
    const ConnectorType& type = net_.system->connector_types[connector.type];
    std::vector<u32> made(type.define.size(), kNoRow);
    for (std::size_t row = type.define.size(); row-- > 0;) {
      const DefineNode& define = type.define[row];
      if (define.is_leaf) {
        const PortRef& ref = connector.ports[define.param];
        made[row] = ref.kind == PortRef::Kind::Atom ? net_.port_node(id, define.param) : node_of(ref);
        continue;
      }
      std::vector<Edge> edges;
      bool has_trigger = false;
      for (u32 child : define.children) {
        edges.push_back({made[child], type.define[child].trigger});
        has_trigger |= type.define[child].trigger;
      }
      made[row] = add(has_trigger ? NodeKind::Trigger : NodeKind::All, edges);
    }
    // A tree that is one leaf gets a group around it, so that the root is this connector's own.
    const u32 root = type.define[0].is_leaf ? add(NodeKind::All, {{made[0], false}}) : made[0];
    net_.nodes[root].connector = id.value;
    net_.nodes[root].is_root = !type.exports;
    net_.root_of.push_back(root);
  }

  void add_parents() {
    for (const Edge& edge : net_.child_edges) ++net_.nodes[edge.node].parents;
    u32 next = 0;
    for (Node& node : net_.nodes) {
      node.first_parent = next;
      next += node.parents;
      node.parents = 0;
    }
    net_.parent_edges.resize(next);
    for (u32 row = 0; row < net_.nodes.size(); ++row) {
      for (const Edge& edge : net_.children(row)) {
        Node& child = net_.nodes[edge.node];
        net_.parent_edges[child.first_parent + child.parents++] = {row, edge.is_trigger};
      }
    }
  }

  Net net_;
  const Net* plain_ = nullptr;
  const PortUses* uses_ = nullptr;
  UsesAs as_ = UsesAs::Ports;
  std::vector<u32> choice_rows_;
};

}  // namespace

Net build_net(const System& system) { return NetBuilder(system).build(); }
Net build_net(const Net& plain, const PortUses& uses, UsesAs as) { return NetBuilder(plain, uses, as).build(); }

std::string Net::mode_name(u32 mode) const {
  const u32 atom = atom_of_mode[mode];
  const std::string& path = system->atoms[AtomId(std::size_t{atom})].path;
  return (path.starts_with("ROOT.") ? path.substr(5) : path) + '@' +
         mode_text(*system, class_at(atom), mode - mode_base[atom]);
}

}  // namespace bip::verify
