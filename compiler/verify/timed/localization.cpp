// See localization.hpp.
#include "compiler/verify/timed/localization.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "compiler/base/log.hpp"
#include "compiler/verify/timed/localize_guard.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Member ports of a localized connector of which any subset may take part.
constexpr std::size_t kMaxLeaves = 5;

template <class T>
void sort_unique(std::vector<T>& rows) {
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
}

class Localizer {
 public:
  Localizer(const System& whole, const Neighbours& neighbours, const std::vector<std::vector<std::uint8_t>>& is_read,
            const VariableFacts& constant, const std::vector<u32>& members)
      : whole_(whole), neighbours_(neighbours), is_read_(is_read), constant_(constant) {
    local_.members = members;
  }

  LocalizedSystem run() {
    System& to = local_.system;
    to.files = whole_.files;
    to.code = whole_.code;
    to.port_types = whole_.port_types;
    to.compounds.push({.path = "ROOT", .type = "Part", .parent = {}});
    for (const u32 row : local_.members) {
      Atom atom = whole_.atoms[AtomId(std::size_t{row})];
      atom.type = to.atom_types.push(whole_.atom_types[atom.type]);
      atom.path = "ROOT.a" + std::to_string(to.atoms.size());
      atom.parent = CompoundId(std::size_t{0});
      atom.loc = {};
      new_atom_[row] = to.atoms.push(std::move(atom));
    }
    std::vector<u32> tops;
    for (const u32 row : local_.members)
      tops.insert(tops.end(), neighbours_.tops_of(row).begin(), neighbours_.tops_of(row).end());
    sort_unique(tops);
    std::vector<u32> inside, trees;
    for (const u32 row : tops) {
      const Neighbours::Top& top = neighbours_.tops()[row];
      const bool is_whole =
          std::all_of(top.atoms.begin(), top.atoms.end(), [&](u32 atom) { return new_atom_.count(atom) != 0; });
      if (is_whole) {
        trees.insert(trees.end(), top.tree.begin(), top.tree.end());
        continue;
      }
      localize_connector(top);
      if (!local_.obstacle.empty() || !local_.required.empty()) return std::move(local_);
    }
    // Copies in ascending order: a connector comes after those that it is bound to.
    sort_unique(trees);
    for (const u32 row : trees) copy_connector(ConnectorId(std::size_t{row}));
    for (const auto& [leaves, guards] : environment_) {
      for (const auto& [text, guard] : guards) add_environment_connector(leaves, guard);
    }
    if (!whole_.priorities.empty()) {
      for (AtomType& type : to.atom_types) {
        for (Transition& t : type.transitions) {
          if (t.port != Transition::kInternal && type.ports[t.port].exported) t.urgency = Urgency::Lazy;
        }
      }
    }
    BIP_ASSERT(local_.is_whole.size() == to.connectors.size(), "{} marks of {} connectors", local_.is_whole.size(),
               to.connectors.size());
    BIP_ASSERT(to.atoms.size() == local_.members.size() && to.connector_types.size() <= to.connectors.size(),
               "{} atoms of {} members", to.atoms.size(), local_.members.size());
    BIP_LOG(Time, 2, "localized to {} components, {} connectors", local_.members.size(), to.connectors.size());
    return std::move(local_);
  }

 private:
  // Adds the steps that the member ports of a connector with other components may take; reports what cannot be
  // localized.
  void localize_connector(const Neighbours::Top& top) {
    std::vector<Neighbours::Leaf> inside;
    for (const Neighbours::Leaf& leaf : top.leaves) {
      if (new_atom_.count(leaf.atom) != 0) inside.push_back(leaf);
    }
    const bool writes = std::any_of(top.written.begin(), top.written.end(), [&](const std::pair<u32, u32>& cell) {
      return new_atom_.count(cell.first) != 0 &&
             is_read_[whole_.atoms[AtomId(std::size_t{cell.first})].type.value][cell.second] != 0;
    });
    if (inside.empty()) return;
    BIP_ASSERT(inside.size() < top.leaves.size() || top.atoms.size() > inside.size(), "all of {} ports are inside",
               inside.size());
    if (writes || top.is_sync) {
      local_.required = top.atoms;
      return;
    }
    if (!top.is_plain && inside.size() > kMaxLeaves) {
      local_.obstacle = "`" + whole_.connectors[top.connector].path + "` has too many ports in it";
      return;
    }
    if (top.is_plain) {
      const LocalizedGuard guard = localize_guard(whole_, top, local_.system.code, constant_, inside);
      // A rendezvous of the same ports without a guard subsumes those with guards.
      std::map<std::vector<std::int64_t>, ExprId>& guards = environment_[inside];
      if (guard.text.empty()) guards.clear();
      if (guards.count({}) == 0) guards[guard.text] = guard.guard;
    }
    for (u32 bits = 1; !top.is_plain && bits < 1u << inside.size(); ++bits) {
      std::vector<Neighbours::Leaf> chosen;
      bool is_twice = false;
      for (std::size_t k = 0; k < inside.size(); ++k) {
        if ((bits >> k & 1) == 0) continue;
        is_twice = is_twice || (!chosen.empty() && chosen.back().atom == inside[k].atom);
        chosen.push_back(inside[k]);
      }
      if (!is_twice) environment_[chosen] = {{{}, ExprId()}};
    }
    for (const Neighbours::Leaf& leaf : inside) {
      AtomType& type = local_.system.atom_types[local_.system.atoms[new_atom_[leaf.atom]].type];
      for (Transition& t : type.transitions) {
        if (t.port == leaf.port) t.urgency = Urgency::Lazy;
      }
    }
  }

  PortRef translated(PortRef ref) {
    BIP_ASSERT(ref.kind != PortRef::Kind::Connector || new_connector_.contains(ref.connector.value),
               "connector {} is bound before it is copied", ref.connector);
    if (ref.kind == PortRef::Kind::Atom) ref.atom = new_atom_.at(ref.atom.value);
    else if (ref.kind == PortRef::Kind::Connector) ref.connector = new_connector_.at(ref.connector.value);
    else ref.choice = choice(ref.choice);
    return ref;
  }
  u32 choice(u32 row) {
    const auto [entry, is_new] = new_choice_.try_emplace(row, static_cast<u32>(local_.system.choices.size()));
    if (!is_new) return entry->second;
    const u32 number = entry->second;
    Choice copy = whole_.choices[row];
    local_.system.choices.emplace_back();
    // A choice contains no choices.
    for (PortRef& port : copy.ports) port = translated(port);
    BIP_ASSERT(std::none_of(copy.ports.begin(), copy.ports.end(),
                            [](const PortRef& port) { return port.kind == PortRef::Kind::Choice; }),
               "merged port {} has one inside", number);
    local_.system.choices[number] = std::move(copy);
    return number;
  }

  void copy_connector(ConnectorId id) {
    Connector connector = whole_.connectors[id];
    const auto [entry, is_new] = new_type_.try_emplace(connector.type.value);
    if (is_new) entry->second = local_.system.connector_types.push(whole_.connector_types[connector.type]);
    connector.type = entry->second;
    connector.path = "ROOT.c" + std::to_string(local_.system.connectors.size());
    connector.parent = CompoundId(std::size_t{0});
    connector.loc = {};
    connector.shown.clear();
    for (PortRef& port : connector.ports) port = translated(port);
    for (DataRef& data : connector.data) data.atom = new_atom_.at(data.atom.value);
    new_connector_[id.value] = local_.system.connectors.push(std::move(connector));
    local_.is_whole.push_back(1);
  }

  void add_environment_connector(std::vector<Neighbours::Leaf> leaves, ExprId guard) {
    for (Neighbours::Leaf& leaf : leaves) leaf.atom = new_atom_.at(leaf.atom).value;
    Clause clause;
    clause.guard = guard;
    add_rendezvous(local_.system, "cut", leaves, std::move(clause));
    local_.is_whole.push_back(0);
  }

  const System& whole_;
  const Neighbours& neighbours_;
  const std::vector<std::vector<std::uint8_t>>& is_read_;
  LocalizedSystem local_;
  const VariableFacts& constant_;
  std::map<std::vector<Neighbours::Leaf>, std::map<std::vector<std::int64_t>, ExprId>>
      environment_;  // the environment's steps by ports, then by guard text: each once
  std::map<u32, AtomId> new_atom_;
  std::map<u32, ConnectorId> new_connector_;
  std::map<u32, ConnectorTypeId> new_type_;
  std::map<u32, u32> new_choice_;
};

}  // namespace

Neighbours::Neighbours(const System& system) : of_atom_(system.atoms.size()) {
  for (std::size_t k = 0; k < system.connectors.size(); ++k) {
    if (!system.is_top(ConnectorId(k))) continue;
    Top top;
    top.connector = ConnectorId(k);
    walk(system, top);
    for (const u32 atom : top.atoms) of_atom_[atom].push_back(static_cast<u32>(tops_.size()));
    tops_.push_back(std::move(top));
  }
}

void Neighbours::walk(const System& system, Top& top) {
  std::set<u32> seen;
  std::vector<ConnectorId> todo{top.connector};
  const auto see_atom = [&](const PortRef& ref) {
    top.leaves.push_back({ref.atom.value, ref.port});
    top.atoms.push_back(ref.atom.value);
  };
  while (!todo.empty()) {
    const ConnectorId id = todo.back();
    todo.pop_back();
    if (!seen.insert(id.value).second) continue;
    top.tree.push_back(id.value);
    const Connector& connector = system.connectors[id];
    const ConnectorType& type = system.connector_types[connector.type];
    top.is_sync = top.is_sync || type.resume == ResumeMode::Sync;
    for (const DefineNode& node : type.define) {
      if (node.trigger) top.is_plain = false;
    }
    for (const PortRef& ref : connector.ports) {
      if (ref.kind == PortRef::Kind::Atom) {
        see_atom(ref);
        continue;
      }
      top.is_plain = false;
      if (ref.kind == PortRef::Kind::Connector) todo.push_back(ref.connector);
      for (std::size_t k = 0; ref.kind == PortRef::Kind::Choice && k < system.choices[ref.choice].ports.size(); ++k) {
        const PortRef& port = system.choices[ref.choice].ports[k];
        if (port.kind == PortRef::Kind::Atom) see_atom(port);
        else todo.push_back(port.connector);
      }
    }
    for (const DataRef& data : connector.data) top.atoms.push_back(data.atom.value);
    // A parameter's variables may be written by any clause.
    const auto write = [&](u32 bind) {
      for (std::size_t p = type.params.size(); p-- > 0;) {
        if (bind < type.params[p].first_bind) continue;
        const auto note = [&](const PortRef& ref) {
          if (ref.kind != PortRef::Kind::Atom) return;
          const std::vector<u32>& variables = system.atom_types[system.atoms[ref.atom].type].ports[ref.port].variables;
          const u32 variable = bind - type.params[p].first_bind;
          if (variable < variables.size()) top.written.emplace_back(ref.atom.value, variables[variable]);
        };
        const PortRef& ref = connector.ports[p];
        if (ref.kind == PortRef::Kind::Choice)
          std::for_each(system.choices[ref.choice].ports.begin(), system.choices[ref.choice].ports.end(), note);
        else note(ref);
        return;
      }
    };
    for (const Clause& clause : type.clauses) {
      for (const StmtId body : {clause.up, clause.down}) {
        model::for_each_assigned(system.code, body, Op::LoadBind, write);
      }
    }
  }
  sort_unique(top.leaves);
  sort_unique(top.atoms);
  sort_unique(top.tree);
  sort_unique(top.written);
}

void add_rendezvous(System& to, const std::string& name, const std::vector<Neighbours::Leaf>& leaves, Clause clause) {
  const std::string number = std::to_string(to.connectors.size());
  ConnectorType type;
  type.name = name + number;
  type.define.emplace_back();
  Connector connector;
  connector.path = "ROOT." + name + number;
  connector.parent = CompoundId(std::size_t{0});
  u32 binds = 0;
  for (const Neighbours::Leaf& leaf : leaves) {
    const AtomId atom{std::size_t{leaf.atom}};
    const PortTypeId port_type = to.atom_types[to.atoms[atom].type].ports[leaf.port].type;
    clause.params.push_back(static_cast<u32>(type.params.size()));
    type.define[0].children.push_back(static_cast<u32>(type.define.size()));
    type.define.push_back(
        {.is_leaf = true, .trigger = false, .param = static_cast<u32>(type.params.size()), .children = {}});
    type.params.push_back({.name = "p" + std::to_string(type.params.size()), .type = port_type, .first_bind = binds});
    binds += static_cast<u32>(to.port_types[port_type].variables.size());
    PortRef ref;
    ref.atom = atom;
    ref.port = leaf.port;
    connector.ports.push_back(ref);
  }
  if (clause.guard.is_valid() || clause.down.is_valid()) type.clauses.push_back(std::move(clause));
  BIP_ASSERT(connector.ports.size() == type.params.size() && type.define.size() == type.params.size() + 1,
             "{} ports of {} parameters", connector.ports.size(), type.params.size());
  connector.type = to.connector_types.push(std::move(type));
  to.connectors.push(std::move(connector));
}

Property localize(Property property, const std::vector<u32>& members) {
  for (PropertyNode& node : property.nodes) {
    if (node.kind != PropertyKind::At && node.kind != PropertyKind::Data) continue;
    BIP_ASSERT(std::binary_search(members.begin(), members.end(), node.owner), "atom {} is none of {} members",
               node.owner, members.size());
    node.owner = static_cast<u32>(std::lower_bound(members.begin(), members.end(), node.owner) - members.begin());
  }
  return property;
}

LocalizedSystem localize(const System& whole, const Neighbours& neighbours,
                         const std::vector<std::vector<std::uint8_t>>& is_read, const VariableFacts& constant,
                         const std::vector<u32>& members) {
  BIP_ASSERT(std::is_sorted(members.begin(), members.end()), "{} members", members.size());
  return Localizer(whole, neighbours, is_read, constant, members).run();
}

}  // namespace bip::verify
