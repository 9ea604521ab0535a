// Linking, second part: interactions (what can be a candidate, in canonical order), plans (connectors with their
// hierarchy expanded), the availability network and the watch lists. See tables.hpp.
#include <algorithm>
#include <numeric>

#include "bip/assert.hpp"
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
Shape shape_of(const Tables& tables, u32 connector) {
  const ConnectorType& type = tables.connector_type(connector);
  Shape shape;
  for (const DefineNode& node : type.define) shape.trigger |= node.trigger;
  shape.one_level = !type.define[0].is_leaf && type.define[0].children.size == type.params.size;
  for (u32 child : type.define[0].children) {
    shape.one_level &= type.define[child].is_leaf && tables.port_ref(connector, type.define[child].param).atom != kNone;
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

// Groups of inner rules that decide about the connector's interactions, or about those of connectors below it, those
// of outer compounds first.
std::vector<u32> groups_below(const Tables& tables, u32 top) {
  const Image& image = *tables.image;
  std::vector<u32> groups;
  if (tables.inner_rules.groups.empty()) return groups;
  std::vector<bool> seen(image.connectors.size, false);
  std::vector<u32> todo{top};
  const auto visit = [&](const PortRef& ref) {
    if (ref.connector != kNone) todo.push_back(ref.connector);
  };
  while (!todo.empty()) {
    const u32 connector = todo.back();
    todo.pop_back();
    if (seen[connector]) continue;
    seen[connector] = true;
    const u32 group = tables.inner_rules.of_connector(connector);
    if (group != kNone && std::find(groups.begin(), groups.end(), group) == groups.end()) {
      groups.push_back(group);
      for (u32 member : tables.inner_rules.groups[group].members) todo.push_back(member);
    }
    for (u32 param = 0; param < tables.connector_type(connector).params.size; ++param) {
      const PortRef ref = tables.port_ref(connector, param);
      visit(ref);
      if (ref.choice == kNone) continue;
      for (const PortRef& port : image.choices[ref.choice].ports) visit(port);
    }
  }
  const auto key = [&](u32 group) { return std::pair(tables.inner_rules.groups[group].depth, group); };
  std::sort(groups.begin(), groups.end(), [&](u32 a, u32 b) { return key(a) < key(b); });
  return groups;
}

// The plan of an interaction that is Planned: the connector with what lies below.
void add_plan(Tables& tables, InteractionInfo& info) {
  // What is still to be added, last first: a define node of a use, below a node of the plan.
  struct Todo {
    u32 use, define, parent;
    bool trigger;
    const PortRef* alternative = nullptr;  // one of the ports of the choice `parent`, not a define node
  };
  std::vector<Todo> todo;
  std::vector<u32> all_params;
  Plan plan;
  plan.connector = info.row;
  plan.first_node = static_cast<u32>(tables.plan_nodes.size());
  plan.first_use = static_cast<u32>(tables.plan_uses.size());
  const auto add_use = [&](u32 connector, u32 link) {
    const ConnectorType& type = tables.connector_type(connector);
    for (const Clause& clause : type.clauses) plan.guarded |= clause.guard != kNone || clause.may_fault;
    all_params.resize(type.params.size);
    std::iota(all_params.begin(), all_params.end(), 0u);
    const u32 clause_row =
        tables.clause_of(tables.image->connectors[connector].type, {all_params.data(), type.params.size});
    tables.plan_uses.push_back({connector, 0, static_cast<u32>(tables.plan_params.size()), link, clause_row});
    tables.plan_params.resize(tables.plan_params.size() + type.params.size, kNone);
    const u32 use = static_cast<u32>(tables.plan_uses.size()) - 1 - plan.first_use;
    todo.push_back({use, 0, link, false, nullptr});
  };
  // Members of groups of inner rules get trees of their own, once the connector's is complete: what they offer decides
  // what is hidden.
  std::vector<std::pair<u32, u32>> witnesses;  // group and connector, last first
  for (u32 group : groups_below(tables, info.row)) {
    for (u32 member : tables.inner_rules.groups[group].members) witnesses.emplace_back(group, member);
  }
  std::reverse(witnesses.begin(), witnesses.end());
  add_use(info.row, kNone);
  while (!todo.empty() || !witnesses.empty()) {
    if (todo.empty()) {
      const auto [group, member] = witnesses.back();
      witnesses.pop_back();
      const u32 root = static_cast<u32>(tables.plan_nodes.size()) - plan.first_node;
      plan.witnesses.push_back({group, member, static_cast<u32>(tables.plan_uses.size()) - plan.first_use, root});
      add_use(member, kNone);
    }
    const Todo next = todo.back();
    todo.pop_back();
    PlanUse& use = tables.plan_uses[plan.first_use + next.use];
    const DefineNode& define = tables.connector_type(use.connector).define[next.define];
    const bool is_group = next.alternative == nullptr && !define.is_leaf;
    const u32 row = static_cast<u32>(tables.plan_nodes.size()) - plan.first_node;
    PlanNode node;
    node.trigger = next.trigger;
    node.parent = next.parent;
    node.leaf = plan.leaves;
    node.use = next.use;
    if (next.define == 0 && next.alternative == nullptr) use.root = row;
    if (is_group) {
      node.kind = NodeKind::Group;
      node.children = define.children.size;
      for (u32 i = define.children.size; i-- > 0;) {
        const u32 child = define.children[i];
        const bool trigger = tables.connector_type(use.connector).define[child].trigger;
        node.has_trigger |= trigger;
        plan.rigid &= !trigger;
        todo.push_back({next.use, child, row, trigger, nullptr});
      }
      tables.plan_nodes.push_back(node);
      continue;
    }
    if (next.alternative == nullptr) tables.plan_params[use.first_param + define.param] = row;
    const PortRef& ref = next.alternative != nullptr ? *next.alternative : tables.port_ref(use.connector, define.param);
    BIP_ASSERT(next.alternative == nullptr || ref.choice == kNone, "a merged port among the ports of a merged port");
    if (ref.choice != kNone) {
      const Span<PortRef>& ports = tables.image->choices[ref.choice].ports;
      node.kind = NodeKind::Choice;
      node.maximal_only = true;
      node.children = ports.size;
      node.ref = ref.choice;
      use.has_choice = plan.has_choice = true;
      plan.rigid = false;
      for (u32 i = ports.size; i-- > 0;) todo.push_back({next.use, next.define, row, false, &ports[i]});
      tables.plan_nodes.push_back(node);
    } else if (ref.atom != kNone) {
      node.kind = NodeKind::Leaf;
      node.ref = tables.instance(ref.atom, ref.port);
      ++plan.leaves;
      tables.plan_nodes.push_back(node);
    } else {
      node.kind = NodeKind::Link;
      node.maximal_only = ref.maximal_only;
      node.children = 1;
      node.ref = ref.connector;
      node.use = static_cast<u32>(tables.plan_uses.size()) - plan.first_use;
      tables.plan_nodes.push_back(node);
      add_use(ref.connector, row);
    }
  }
  plan.node_count = static_cast<u32>(tables.plan_nodes.size()) - plan.first_node;
  plan.use_count = static_cast<u32>(tables.plan_uses.size()) - plan.first_use;
  plan.words = (plan.leaves + 63) / 64;
  PlanNode* nodes = tables.plan_nodes.data() + plan.first_node;
  for (u32 i = plan.node_count; i-- > 0;) {
    nodes[i].end = std::max(nodes[i].end, i + 1);
    if (nodes[i].parent != kNone) nodes[nodes[i].parent].end = std::max(nodes[nodes[i].parent].end, nodes[i].end);
    BIP_ASSERT(nodes[i].parent == kNone || nodes[i].parent < i, "node {} comes before its parent", i);
  }
  std::vector<u32> connectors;
  for (u32 i = 0; i < plan.use_count; ++i) {
    PlanUse& use = tables.plan_uses[plan.first_use + i];
    connectors.push_back(use.connector);
    const u32 end = nodes[use.root].end;
    use.first_leaf = nodes[use.root].leaf;
    use.end_leaf = end == plan.node_count ? plan.leaves : nodes[end].leaf;
    BIP_ASSERT(use.first_leaf <= use.end_leaf && use.end_leaf <= plan.leaves, "leaves {} to {} of {}", use.first_leaf,
               use.end_leaf, plan.leaves);
  }
  // Trees of witnesses come behind the connector's own.
  BIP_ASSERT(
      plan.use_count != 0 && nodes[0].end == (plan.witnesses.empty() ? plan.node_count : plan.witnesses.front().root),
      "a plan of {} nodes, its root ends at {}", plan.node_count, nodes[0].end);
  std::sort(connectors.begin(), connectors.end());
  plan.is_tree = std::adjacent_find(connectors.begin(), connectors.end()) == connectors.end();
  std::size_t links = 0, maximal = 0;
  for (u32 i = 0; i < plan.node_count; ++i) {
    links += nodes[i].kind == NodeKind::Link ? 1 : 0;
    maximal += nodes[i].maximal_only ? 1 : 0;
  }
  plan.is_listed_at_once = plan.rigid && plan.is_tree && plan.witnesses.empty() && (maximal == 0 || maximal == links);
  plan.has_ranges = plan.guarded && !plan.rigid && !plan.has_choice && plan.is_tree;
  for (u32 i = 0; i < plan.use_count && plan.has_ranges; ++i) {
    for (const Clause& clause : tables.connector_type(tables.plan_uses[plan.first_use + i].connector).clauses)
      plan.has_ranges &= clause.has_ranges;
  }
  plan.needs_ups = !plan.witnesses.empty();
  for (u32 i = 0; i < plan.use_count && !plan.needs_ups; ++i) {
    for (const Clause& clause : tables.connector_type(tables.plan_uses[plan.first_use + i].connector).clauses) {
      const bool is_seen = tables.image->ffi != nullptr || plan.has_choice;
      plan.needs_ups |= clause.down != kNone || (is_seen && clause.up != kNone);
    }
  }
  // Alternatives of one parameter are several candidates: they are listed.
  info.searched |= plan.guarded || plan.has_choice || !plan.witnesses.empty();
  info.ref = static_cast<u32>(tables.plans.size());
  tables.plans.push_back(plan);
}

}  // namespace

void link_interactions(Tables& tables, MaximalProgress progress) {
  const Image& image = *tables.image;
  const std::vector<bool> named = named_by_priorities(image);
  tables.clause_order.resize(image.connector_types.size);
  for (u32 i = 0; i < image.connector_types.size; ++i) {
    const ConnectorType& type = image.connector_types[i];
    for (u32 row = 0; row < type.clauses.size; ++row) tables.clause_order[i].push_back(row);
    std::stable_sort(tables.clause_order[i].begin(), tables.clause_order[i].end(), [&](u32 a, u32 b) {
      const Span<u32>&x = type.clauses[a].params, &y = type.clauses[b].params;
      return std::lexicographical_compare(x.begin(), x.end(), y.begin(), y.end());
    });
  }

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
  for (u32 connector = 0; connector < image.connectors.size; ++connector) {
    const ConnectorType& type = tables.connector_type(connector);
    if (type.exports) continue;
    if (!tables.interaction_of_connector.empty())
      tables.interaction_of_connector[connector] = InteractionId(tables.interactions.size());
    const Shape shape = shape_of(tables, connector);
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
      add_plan(tables, interaction);
    }
    if (interaction.kind != InteractionKind::Planned) {
      // Parameter order, for it is the order of firing.
      interaction.count = type.params.size & InteractionInfo::kMostPorts;
      std::vector<u32> params;
      for (u32 param = 0; param < type.params.size; ++param) {
        const PortRef& ref = tables.port_ref(connector, param);
        tables.flat_ports.push_back(tables.instance(ref.atom, ref.port));
        params.push_back(param);
      }
      if (interaction.kind == InteractionKind::Flat) {
        interaction.ref = tables.clause_of(image.connectors[connector].type, {params.data(), interaction.count});
      }
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
    const ConnectorType& type = tables.connector_type(connector);
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
      const PortRef& ref = tables.port_ref(connector, param);
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
    const Connector& row = image.connectors[connector];
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
  InteractionsBy::sort_unique(ports);
  InteractionsBy::sort_unique(atoms);
  Csr::sort_unique(atom_rules);
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
