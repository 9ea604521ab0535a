// See split_by_history.hpp.
#include "compiler/verify/conflicts/split_by_history.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

using SplitPlace = SplitAtom::Place;

bool is_flat_rendezvous(const ConnectorType& type) {
  return !type.exports && !type.define[0].is_leaf && type.define[0].children.size() == type.params.size() &&
         std::none_of(type.define.begin(), type.define.end(), [](const DefineNode& node) { return node.trigger; });
}

// Its places with the histories that they can have, breadth first. Nothing: too many.
std::vector<SplitPlace> reachable_places(const AtomType& type,
                                         const std::vector<std::vector<std::uint32_t>>& connectors) {
  BIP_ASSERT(type.initial.size() == 1 && connectors.size() == type.ports.size(),
             "an automaton starts at {} places; {} ports of {}", type.initial.size(), connectors.size(),
             type.ports.size());
  std::vector<SplitPlace> places{{type.initial[0], HistoryMove::kNoHistory}};
  std::set<SplitPlace> seen(places.begin(), places.end());
  std::size_t transitions = 0;
  const auto reach = [&](const SplitPlace& place) {
    if (seen.insert(place).second) places.push_back(place);
  };
  for (std::size_t k = 0; k < places.size(); ++k) {
    const SplitPlace at = places[k];
    for (const Transition& t : type.transitions) {
      if (t.from[0] != at.place) continue;
      if (t.port == Transition::kInternal || connectors[t.port].size() < 2) {
        reach({t.to[0], at.history});
        ++transitions;
        continue;
      }
      for (const std::uint32_t connector : connectors[t.port]) reach({t.to[0], connector});
      transitions += connectors[t.port].size();
    }
    if (places.size() > SharedPorts::kMostPlaces || transitions > SharedPorts::kMostTransitions) return {};
  }
  return places;
}

void split_atom(SplitSystem& to, const SharedPorts& shared, const std::set<HistoryMove>& excluded, std::uint32_t atom) {
  System& system = to.system;
  const AtomType type = system.atom_types[system.atoms[AtomId(std::size_t{atom})].type];
  const std::vector<std::vector<std::uint32_t>>& connectors = shared.connectors[atom];
  SplitAtom& split = to.atoms[atom];
  split.places = reachable_places(type, connectors);
  if (split.places.empty()) return;

  AtomType made = type;
  made.invariants.clear();
  made.merged.clear();
  made.ports.clear();
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> port_rows;
  for (std::uint32_t port = 0; port < type.ports.size(); ++port) {
    std::vector<std::uint32_t> uses{HistoryMove::kNoHistory};
    if (connectors[port].size() > 1) uses = connectors[port];
    for (const std::uint32_t connector : uses) {
      port_rows[{port, connector}] = static_cast<std::uint32_t>(made.ports.size());
      split.ports.push_back({port, connector});
      made.ports.push_back(type.ports[port]);
    }
  }
  std::map<SplitPlace, std::uint32_t> place_rows;
  made.places.clear();
  made.final_places.clear();
  for (const SplitPlace& place : split.places) {
    const auto row = static_cast<std::uint32_t>(made.places.size());
    place_rows[place] = row;
    made.places.push_back(type.places[place.place]);
    if (std::binary_search(type.final_places.begin(), type.final_places.end(), place.place))
      made.final_places.push_back(row);
  }
  made.initial = {0};
  made.transitions.clear();
  for (std::uint32_t row = 0; row < split.places.size(); ++row) {
    const SplitPlace at = split.places[row];
    for (const Transition& t : type.transitions) {
      if (t.from[0] != at.place) continue;
      Transition moved = t;
      moved.from = {row};
      if (t.port == Transition::kInternal || connectors[t.port].size() < 2) {
        if (t.port != Transition::kInternal) moved.port = port_rows.at({t.port, HistoryMove::kNoHistory});
        moved.to = {place_rows.at({t.to[0], at.history})};
        made.transitions.push_back(std::move(moved));
        continue;
      }
      for (const std::uint32_t connector : connectors[t.port]) {
        if (excluded.contains({atom, at.place, at.history, connector})) continue;
        moved.port = port_rows.at({t.port, connector});
        moved.to = {place_rows.at({t.to[0], connector})};
        made.transitions.push_back(moved);
      }
    }
  }
  BIP_ASSERT(made.places.size() == split.places.size() && made.ports.size() == split.ports.size() &&
                 place_rows.size() == split.places.size(),
             "{} places and {} ports of an atom that is split into {} and {}", made.places.size(), made.ports.size(),
             split.places.size(), split.ports.size());
  system.atoms[AtomId(std::size_t{atom})].type = system.atom_types.push(std::move(made));
  for (std::uint32_t port = 0; port < type.ports.size(); ++port) {
    for (const std::uint32_t connector : connectors[port]) {
      const std::uint32_t use = connectors[port].size() > 1 ? connector : HistoryMove::kNoHistory;
      for (PortRef& ref : system.connectors[ConnectorId(std::size_t{connector})].ports) {
        // Ports that moved are not looked at again: an atom takes part in such a connector once.
        if (ref.kind == PortRef::Kind::Atom && ref.atom.value == atom && ref.port == port) {
          ref.port = port_rows.at({port, use});
          break;
        }
      }
    }
  }
}

}  // namespace

SharedPorts::SharedPorts(const System& system) : is_splittable(system.atoms.size(), 1) {
  for (std::size_t atom = 0; atom < system.atoms.size(); ++atom) {
    const AtomType& type = system.atom_types[system.atoms[AtomId(atom)].type];
    connectors.emplace_back(type.ports.size());
    if (!type.is_automaton() || !type.priorities.empty() || !type.clocks.empty()) is_splittable[atom] = 0;
  }
  for (const Choice& choice : system.choices) {
    for (const PortRef& ref : choice.ports) {
      if (ref.kind == PortRef::Kind::Atom) is_splittable[ref.atom.value] = 0;
    }
  }
  for (std::size_t row = 0; row < system.connectors.size(); ++row) {
    const Connector& connector = system.connectors[ConnectorId(row)];
    const bool is_flat = is_flat_rendezvous(system.connector_types[connector.type]) &&
                         std::all_of(connector.ports.begin(), connector.ports.end(),
                                     [](const PortRef& ref) { return ref.kind == PortRef::Kind::Atom; });
    std::set<std::uint32_t> atoms;
    for (const PortRef& ref : connector.ports) {
      if (ref.kind != PortRef::Kind::Atom) continue;
      connectors[ref.atom.value][ref.port].push_back(static_cast<std::uint32_t>(row));
      if (!is_flat || !atoms.insert(ref.atom.value).second) is_splittable[ref.atom.value] = 0;
    }
  }
  std::size_t in_all = 0;
  for (std::uint32_t atom = 0; atom < system.atoms.size(); ++atom) {
    const AtomType& type = system.atom_types[system.atoms[AtomId(std::size_t{atom})].type];
    std::size_t size = 0;
    bool has_shared = false;
    for (const Transition& t : type.transitions) {
      if (t.port != Transition::kInternal) size += connectors[atom][t.port].size();
    }
    for (const std::vector<std::uint32_t>& of_port : connectors[atom]) has_shared |= of_port.size() > 1;
    if (!has_shared || (in_all += is_splittable[atom] != 0 ? size : 0) > kMostInAll) is_splittable[atom] = 0;
  }
}

SplitSystem split_by_history(const System& system, const SharedPorts& shared, const std::set<HistoryMove>& excluded) {
  SplitSystem result{system, std::vector<SplitAtom>(system.atoms.size())};
  for (std::uint32_t atom = 0; atom < system.atoms.size(); ++atom) {
    if (shared.is_splittable[atom] != 0) split_atom(result, shared, excluded, atom);
  }
  BIP_ASSERT(result.system.connectors.size() == system.connectors.size(), "{} of {} connectors",
             result.system.connectors.size(), system.connectors.size());
  return result;
}

}  // namespace bip::verify
