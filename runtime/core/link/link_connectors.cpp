// Linking, second part: interactions (what can be a candidate, in canonical order), the availability network and the
// watch lists. See tables.hpp.
#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/core/link/plan_builder.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

namespace {

// Connectors for which a priority rule names interactions: which one is a candidate must be known before it fires.
std::vector<bool> named_by_priorities(const Image& image) {
  std::vector<bool> named(image.connectors.size, false);
  for (const Priority& rule : image.priorities) {
    for (const Pattern* pattern : {&rule.low, &rule.high}) {
      if (!pattern->any_connector && !pattern->any_interaction) named[pattern->connector] = true;
    }
  }
  return named;
}

struct Shape {
  bool one_level = true;  // the root group holds atom ports only
  bool trigger = false;
  bool guard = false;
};
Shape shape_of(const Image& image, const ConnectorType& type, u32 first_port_ref) {
  Shape shape;
  for (const DefineNode& node : type.define) shape.trigger |= node.trigger;
  shape.one_level = !type.define[0].is_leaf && type.define[0].children.size == type.params.size;
  for (u32 child : type.define[0].children) {
    if (!shape.one_level) break;
    const DefineNode& node = type.define[child];
    shape.one_level = node.is_leaf && image.port_refs[first_port_ref + node.param].atom != kNone;
  }
  // An `up` that may fault runs while interactions are computed, like a guard.
  for (const Clause& clause : type.clauses) shape.guard |= clause.guard != kNone || clause.may_fault;
  return shape;
}

// The value of a group, or a root that is a leaf, with every port disabled.
std::int32_t group_start(const ConnectorType& type, u32 row) {
  const Span<u32>& children = type.define[row].children;
  const bool by_trigger =
      std::any_of(children.begin(), children.end(), [&](u32 child) { return type.define[child].trigger; });
  return by_trigger || children.size == 0 ? -1 : -static_cast<std::int32_t>(children.size);
}

}  // namespace

// A vector for each type would cost more than the rows.
static void link_clause_order(Tables& tables) {
  const Image& image = *tables.image;
  std::vector<u32>& first = tables.clause_order.first;
  std::vector<u32>& rows = tables.clause_order.items;
  first.reserve(std::size_t{image.connector_types.size} + 1);
  for (const ConnectorType& type : image.connector_types) {
    first.push_back(static_cast<u32>(rows.size()));
    for (u32 row = 0; row < type.clauses.size; ++row) rows.push_back(row);
    std::sort(rows.begin() + first.back(), rows.end(), [&](u32 a, u32 b) {
      const Span<u32>&x = type.clauses[a].params, &y = type.clauses[b].params;
      const auto order = std::lexicographical_compare_three_way(x.begin(), x.end(), y.begin(), y.end());
      return order != 0 ? order < 0 : a < b;
    });
  }
  if (rows.empty()) first = {};
  else first.push_back(static_cast<u32>(rows.size()));
}

void link_interactions(Tables& tables, MaximalProgress progress) {
  const Image& image = *tables.image;
  const std::vector<bool> named = named_by_priorities(image);
  link_clause_order(tables);
  const bool any_exports = std::any_of(image.connector_types.begin(), image.connector_types.end(),
                                       [](const ConnectorType& type) { return type.exports; });
  if (any_exports) tables.interaction_of_connector.assign(image.connectors.size, InteractionId());
  std::size_t ports = 0;
  for (const Connector& connector : image.connectors) {
    const ConnectorType& type = image.connector_types[connector.type];
    ports += type.exports ? 0 : type.params.size;
  }
  tables.flat_ports.reserve(ports);
  InteractionPacker interactions(tables.interactions);
  PlanBuilder plans(tables);
  for (u32 connector = 0; connector < image.connectors.size; ++connector) {
    const Connector row = image.connectors[connector];
    const ConnectorType& type = image.connector_types[row.type];
    if (type.exports) continue;
    if (!tables.interaction_of_connector.empty())
      tables.interaction_of_connector[connector] = InteractionId(tables.interactions.size());
    const Shape shape = shape_of(image, type, row.ports);
    InteractionInfo interaction;
    interaction.row = connector;
    interaction.first = static_cast<u32>(tables.flat_ports.size());
    // A group under a trigger that may be chosen in several ways is listed when maximal progress is off, or by name.
    const bool listed = shape.trigger && (progress == MaximalProgress::Off || named[connector]);
    const bool is_ruled = tables.inner_rules.of_connector(connector) != kNone;
    if (shape.one_level && !shape.trigger && !is_ruled) {
      interaction.kind = InteractionKind::Flat;
      interaction.searched = shape.guard;
    } else if (shape.one_level && !shape.guard && !listed && !is_ruled) {
      interaction.kind = InteractionKind::Star;
    } else {
      interaction.kind = InteractionKind::Planned;
      interaction.searched = shape.guard || progress == MaximalProgress::Off || named[connector];
      plans.add(interaction);
    }
    if (interaction.kind != InteractionKind::Planned) {
      // Parameter order, for it is the order of firing.
      interaction.count = type.params.size & InteractionInfo::kMostPorts;
      for (u32 param = 0; param < type.params.size; ++param) {
        const PortRef& ref = image.port_refs[row.ports + param];
        tables.flat_ports.push_back(tables.instance(ref.atom, ref.port));
      }
      if (interaction.kind == InteractionKind::Flat) interaction.ref = plans.clause_of_all(row.type);
    }
    tables.any_searched |= interaction.searched;
    interactions.add(interaction);
  }
  BIP_ASSERT(tables.flat_ports.size() <= ports, "{} ports of flat connectors, at most {}", tables.flat_ports.size(),
             ports);
  tables.connector_interactions = static_cast<u32>(tables.interactions.size());

  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const AtomType& type = tables.atom_type(atom);
    for (u32 port = 0; port < type.ports.size; ++port) {
      if (type.ports[port].exported) continue;
      InteractionInfo interaction;
      interaction.kind = InteractionKind::Port;
      interaction.row = tables.instance(atom, port);
      interaction.first = static_cast<u32>(tables.flat_ports.size());
      interactions.add(interaction);
    }
  }
  interactions.finish();
}

std::int32_t Tables::start_of(InteractionId interaction) const {
  if (!interaction_start.empty()) return interaction_start[interaction.value];
  const InteractionInfo info = interactions[interaction];
  if (info.kind == InteractionKind::Planned) return group_start(connector_type(info.row), 0);
  return info.kind == InteractionKind::Flat && info.count != 0 ? -static_cast<std::int32_t>(info.count) : -1;
}

void link_network(Tables& tables) {
  const Image& image = *tables.image;
  // A node for each group that is not the root of an interaction's connector.
  std::vector<u32> root_node(image.connectors.size);
  const u32 interaction_count = static_cast<u32>(tables.interactions.size());
  std::vector<std::int32_t>& starts = tables.inner_start;
  NetworkEdges edges;
  auto& [from_ports, from_nodes] = edges;
  from_ports.reserve(interaction_count - tables.connector_interactions + image.port_refs.size);
  for (const InteractionId port : tables.interactions_of_ports())
    from_ports.push_back({tables.interactions[port].row, Tables::node_of(port)});

  // A choice is available if one of its ports is: a node that counts them.
  const u32 first_choice = interaction_count;
  starts.assign(image.choices.size, -1);

  std::vector<u32> first_group(image.connectors.size);
  std::vector<u32> group;  // by define node of the connector at hand
  for (u32 connector = 0; connector < image.connectors.size; ++connector) {
    const Connector instance = image.connectors[connector];
    const ConnectorType& type = image.connector_types[instance.type];
    group.assign(type.define.size, kNone);
    first_group[connector] = interaction_count + static_cast<u32>(starts.size());
    for (u32 i = 0; i < type.define.size; ++i) {
      // A root that is a leaf counts as a group of one.
      if (type.define[i].is_leaf && i != 0) continue;
      if (i == 0 && tables.interaction_of(connector).is_valid()) {
        group[i] = Tables::node_of(tables.interaction_of(connector));
      } else {
        group[i] = interaction_count + static_cast<u32>(starts.size());
        starts.push_back(group_start(type, i));
      }
    }
    BIP_ASSERT(group[0] != kNone, "connector {} has no node", connector);
    root_node[connector] = group[0];
    const auto bind = [&](u32 param, u32 node) {
      const PortRef ref = image.port_refs[instance.ports + param];
      if (ref.choice != kNone) from_nodes.push_back({first_choice + ref.choice, node});
      else if (ref.atom != kNone) from_ports.push_back({tables.instance(ref.atom, ref.port), node});
      else from_nodes.push_back({root_node[ref.connector], node});
    };
    for (u32 i = 0; i < type.define.size; ++i) {
      const DefineNode& node = type.define[i];
      if (node.is_leaf) {
        if (i == 0) bind(node.param, group[0]);
        continue;
      }
      bool has_trigger = false;
      for (u32 child : node.children) has_trigger |= type.define[child].trigger;
      for (u32 child : node.children) {
        if (has_trigger && !type.define[child].trigger) continue;
        if (type.define[child].is_leaf) bind(type.define[child].param, group[i]);
        else from_nodes.push_back({group[child], group[i]});
      }
    }
  }
  for (u32 choice = 0; choice < image.choices.size; ++choice) {
    for (const PortRef& ref : image.choices[choice].ports) {
      if (ref.atom != kNone) from_ports.push_back({tables.instance(ref.atom, ref.port), first_choice + choice});
      else from_nodes.push_back({root_node[ref.connector], first_choice + choice});
    }
  }
  BIP_ASSERT(std::all_of(from_nodes.begin(), from_nodes.end(),
                         [&](const Csr::Pair& pair) {
                           return pair.from < tables.node_count() && pair.to < tables.node_count();
                         }),
             "an edge beyond {} nodes", tables.node_count());
  link_plan_choices(tables, first_group);
  contract_network(tables, edges);
  tables.port_out = Csr::build(tables.port_atom.size(), from_ports);
  tables.node_out = Csr::build(tables.node_count(), from_nodes);
}

// Interactions that read an atom, from which on comparing its data costs less than to look at those.
static constexpr u32 kFewWatching = 8;

// Must the interactions that read the atom be marked after each of its transitions, even if its data are the same? What
// guards of priority rules do is not examined.
static bool is_watched_by_calls(const Tables& tables, u32 atom) {
  const Image& image = *tables.image;
  if (tables.atom_watch[atom].size < kFewWatching) return true;
  if (image.ffi == nullptr) return false;
  const Span<Var>& variables = tables.atom_type(atom).variables;
  if (tables.atom_rules[atom].size != 0 ||
      std::any_of(variables.begin(), variables.end(), [](const Var& v) { return is_ffi(v.type); }))
    return true;
  const auto calls = [&](u32 connector) {
    const Span<Clause>& clauses = tables.connector_type(connector).clauses;
    return std::any_of(clauses.begin(), clauses.end(),
                       [](const Clause& clause) { return clause.may_fault || clause.guard_may_fault; });
  };
  const Span<InteractionId> watching = tables.atom_watch[atom];
  return std::any_of(watching.begin(), watching.end(), [&](InteractionId interaction) {
    const InteractionInfo info = tables.interactions[interaction];
    if (info.kind != InteractionKind::Planned) return calls(info.row);
    const Plan& plan = tables.plans[info.plan()];
    if (!plan.witnesses.empty()) return true;
    const auto uses = tables.plan_uses.begin() + plan.first_use;
    return std::any_of(uses, uses + plan.use_count, [&](const PlanUse& use) { return calls(use.connector); });
  });
}

void link_watches(Tables& tables) {
  const Image& image = *tables.image;
  std::vector<InteractionsBy::Pair> ports, atoms;
  std::vector<Csr::Pair> atom_rules;
  // Bound rows beyond the parameters' variables are data of components that take part: whose they are is found by their
  // cells.
  std::vector<VariableId> bases;
  for (u32 atom = 0; atom < image.atoms.size; ++atom) bases.push_back(tables.atoms[atom].first_cell);
  const bool sorted = std::is_sorted(bases.begin(), bases.end());
  const auto atom_of = [&](VariableId row) {
    if (sorted) return static_cast<u32>(std::upper_bound(bases.begin(), bases.end(), row) - bases.begin()) - 1;
    u32 best = 0;
    for (u32 i = 0; i < bases.size(); ++i) {
      if (bases[i] <= row && bases[best] <= bases[i]) best = i;
    }
    return best;
  };
  BIP_ASSERT(bases.empty() || bases[0].value == 0 || !sorted, "the first atom's data begin at {}", bases[0]);
  const auto watch_reads = [&](u32 connector, InteractionId interaction) {
    const Connector row = image.connectors[connector];
    for (u32 i = tables.first_read(connector); i < row.bind_count; ++i)
      atoms.push_back({atom_of(image.binds[row.binds + i].variable()), interaction});
  };
  const auto watch_data = [&](u32 instance, InteractionId interaction) {
    const u32 atom = tables.port_atom[instance];
    const Port& port = tables.atom_type(atom).ports[instance - tables.port_base(atom)];
    if (port.variables.size != 0) atoms.push_back({atom, interaction});
  };
  for (const InteractionId interaction : tables.interactions_of_connectors()) {
    const InteractionInfo info = tables.interactions[interaction];
    if (!info.searched) continue;
    if (info.kind == InteractionKind::Flat) {
      // Its counter tells of flips; only the guard looks at data.
      for (u32 i = 0; i < info.count; ++i) watch_data(tables.flat_ports[info.first + i], interaction);
      watch_reads(info.row, interaction);
      continue;
    }
    const Plan& plan = tables.plans[info.plan()];
    for (u32 i = 0; i < plan.node_count; ++i) {
      const PlanNode& node = tables.plan_nodes[plan.first_node + i];
      if (node.kind != NodeKind::Leaf) continue;
      ports.push_back({node.ref, interaction});
      if (plan.guarded) watch_data(node.ref, interaction);
    }
    for (const PlanWitness& witness : plan.witnesses) {
      for (const u32 rule : tables.inner_rules.groups[witness.group].rules) {
        const Priority& row = image.priorities[rule];
        for (u32 k = 0; row.guard != kNone && k < row.bind_count; ++k)
          atoms.push_back({atom_of(image.binds[row.binds + k].variable()), interaction});
      }
    }
    if (!plan.guarded) continue;
    for (u32 i = 0; i < plan.use_count; ++i) watch_reads(tables.plan_uses[plan.first_use + i].connector, interaction);
  }
  for (u32 rule = 0; rule < image.priorities.size; ++rule) {
    const Priority& row = image.priorities[rule];
    if (row.guard == kNone) continue;
    for (u32 i = 0; i < row.bind_count; ++i)
      atom_rules.push_back({atom_of(image.binds[row.binds + i].variable()), rule});
  }
  InteractionsBy::unique_in_order(tables.port_atom.size(), ports);
  InteractionsBy::unique_in_order(image.atoms.size, atoms);
  Csr::unique_in_order(image.atoms.size, atom_rules);
  tables.any_port_watch = !ports.empty();
  tables.port_watch = InteractionsBy::build(tables.port_atom.size(), ports);
  tables.atom_watch = InteractionsBy::build(image.atoms.size, atoms);
  tables.atom_rules = Csr::build(image.atoms.size, atom_rules);
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    if (tables.atom_watch[atom].size != 0 || tables.atom_rules[atom].size != 0)
      tables.atoms[atom].watched = is_watched_by_calls(tables, atom) ? kWatchedByCalls : kWatchedByData;
  }
}

}  // namespace bip::rt
