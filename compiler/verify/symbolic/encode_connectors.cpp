// Connectors of the transition system: which interactions are candidates, and what firing one does: `up`s bottom up,
// `down`s top down, ports in parameter order.
#include <algorithm>

#include "compiler/system/system.hpp"
#include "compiler/verify/net/abstract_code.hpp"
#include "compiler/verify/symbolic/transition_system_builder.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

TransitionSystemBuilder::Local& TransitionSystemBuilder::local_in(Store& store, u32 atom) {
  return store.atoms.try_emplace(atom, now_[atom]).first->second;
}

// Neither guards nor merged ports with values. The values of a merged port are those of the alternative taken: where
// code may see them, interactions one by one say which it is.
bool TransitionSystemBuilder::is_plain(const Tree& tree) const {
  for (const Use& use : tree.uses) {
    const ConnectorType& type = system_.connector_types[system_.connectors[use.connector].type];
    const rt::ConnectorType& linked = image_.connector_types[image_.connectors[use.connector.value].type];
    bool has_code = false;
    for (std::size_t k = 0; k < type.clauses.size(); ++k) {
      const Clause& clause = type.clauses[k];
      if (linked.clauses[k].may_fault || !is_always_true(system_.code, clause.guard)) return false;
      has_code = has_code || clause.guard.is_valid() || clause.up.is_valid() || clause.down.is_valid();
    }
    for (std::size_t p = 0; p < type.params.size(); ++p) {
      const u32 node = use.param_nodes[p];
      const bool has_values = !system_.port_types[type.params[p].type].variables.empty();
      if (node != kNoRow && tree.nodes[node].kind == Kind::Choice && has_values && has_code) return false;
    }
  }
  return true;
}

// Can any choice of alternatives be taken together, and is none of them a part of another one? So if no port has two
// leaves, and two leaves of one atom are alternatives to each other.
bool TransitionSystemBuilder::has_free_choices(const Tree& tree) const {
  std::vector<u32> parent(tree.nodes.size(), kNoRow);
  std::map<u32, Leaves> of_atom;
  for (u32 row = 0; row < tree.nodes.size(); ++row) {
    for (u32 child : tree.nodes[row].children) parent[child] = row;
    if (tree.nodes[row].kind == Kind::Leaf) of_atom[tree.nodes[row].atom.value].push_back(row);
  }
  const auto meet = [&](u32 a, u32 b) {
    std::vector<u32> above;
    for (; a != kNoRow; a = parent[a]) above.push_back(a);
    while (std::find(above.begin(), above.end(), b) == above.end()) b = parent[b];
    return b;
  };
  for (const auto& [atom, leaves] : of_atom) {
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      for (std::size_t j = i + 1; j < leaves.size(); ++j) {
        if (tree.nodes[leaves[i]].port == tree.nodes[leaves[j]].port) return false;
        if (tree.nodes[meet(leaves[i], leaves[j])].kind != Kind::Choice) return false;
      }
    }
  }
  return true;
}

// By node: is it chosen?
std::vector<Signal> TransitionSystemBuilder::fixed_choice(const Tree& tree, const Leaves& leaves) const {
  std::vector<Signal> chosen;
  for (const std::uint8_t is : analysis::chosen_nodes(tree, leaves)) chosen.push_back(is != 0 ? kTrue : kFalse);
  return chosen;
}

// Of the rows, one that is available, if `when`: an input a row but the last says whether it is this one.
void TransitionSystemBuilder::choose_one(const std::vector<u32>& rows, const std::vector<Signal>& available,
                                         Signal when, std::vector<Signal>& chosen) {
  std::vector<Signal> later(rows.size() + 1, kFalse);
  for (std::size_t k = rows.size(); k-- > 0;) later[k] = aig_.make_or(later[k + 1], available[rows[k]]);
  Signal rest = when;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Signal wanted = later[k + 1] == kFalse ? kTrue : aig_.make_or(aig_.make_input(), negated(later[k + 1]));
    chosen[rows[k]] = aig_.make_and(aig_.make_and(rest, available[rows[k]]), wanted);
    rest = aig_.make_and(rest, negated(chosen[rows[k]]));
  }
}

// All ports that are available, from the root down; of alternatives, any one that is.
std::vector<Signal> TransitionSystemBuilder::largest_choice(const Tree& tree) {
  const std::size_t count = tree.nodes.size();
  std::vector<Signal> available(count, kFalse), chosen(count, kFalse);
  std::vector<u32> order{tree.uses[0].root};
  for (std::size_t head = 0; head < order.size(); ++head) {
    for (u32 child : tree.nodes[order[head]].children) order.push_back(child);
  }
  for (std::size_t k = order.size(); k-- > 0;) {
    const Node& node = tree.nodes[order[k]];
    Signal& node_is_on = available[order[k]];
    if (node.kind == Kind::Leaf) {
      node_is_on = transition_system_.port_is_on[port_of(node)];
      continue;
    }
    const bool needs_one = node.has_trigger || node.kind == Kind::Choice;
    node_is_on = needs_one ? kFalse : kTrue;
    for (u32 child : node.children) {
      if (node.kind == Kind::Choice) node_is_on = aig_.make_or(node_is_on, available[child]);
      else if (!node.has_trigger) node_is_on = aig_.make_and(node_is_on, available[child]);
      else if (tree.nodes[child].is_trigger) node_is_on = aig_.make_or(node_is_on, available[child]);
    }
  }
  chosen[order[0]] = available[order[0]];
  for (u32 row : order) {
    if (tree.nodes[row].kind == Kind::Choice) {
      choose_one(tree.nodes[row].children, available, chosen[row], chosen);
      continue;
    }
    for (u32 child : tree.nodes[row].children) {
      chosen[child] = tree.nodes[row].has_trigger ? aig_.make_and(chosen[row], available[child]) : chosen[row];
    }
  }
  return chosen;
}

// A connector's own data and what it is bound to. Of a merged port, the alternative that is chosen.
Variables TransitionSystemBuilder::variables_of(const Tree& tree, const Use& use, const std::vector<Signal>& chosen,
                                                Store& store) {
  const u32 base = image_.connectors[use.connector.value].first_cell;
  const ConnectorType& type = system_.connector_types[system_.connectors[use.connector].type];
  // By Bind variable the row among all variables; kNoRow: nothing is chosen there.
  auto rows = std::make_shared<std::vector<u32>>();
  for (std::size_t p = 0; p < type.params.size(); ++p) {
    const std::size_t variables = system_.port_types[type.params[p].type].variables.size();
    u32 node = use.param_nodes[p];
    if (node != kNoRow && tree.nodes[node].kind == Kind::Choice) {
      u32 alternative = kNoRow;
      for (u32 child : tree.nodes[node].children) {
        if (chosen[child] == kTrue) alternative = child;
      }
      node = alternative;
    }
    for (std::size_t v = 0; v < variables; ++v) {
      if (node == kNoRow) {
        rows->push_back(kNoRow);
      } else if (tree.nodes[node].kind == Kind::Leaf) {
        const u32 atom = tree.nodes[node].atom.value;
        rows->push_back(image_.atoms[atom].first_cell + type_of(atom).ports[tree.nodes[node].port].variables[v]);
      } else {
        const ConnectorId below = tree.uses[tree.nodes[node].use].connector;
        const ConnectorType& below_type = system_.connector_types[system_.connectors[below].type];
        rows->push_back(image_.connectors[below.value].first_cell + below_type.export_variables[v]);
      }
    }
  }
  for (const DataRef& ref : system_.connectors[use.connector].data) {
    rows->push_back(image_.atoms[ref.atom.value].first_cell + ref.variable);
  }
  Variables v;
  v.self = [&store, base](u32 k) { return store.frames[base + k]; };
  v.set_self = [&store, base](u32 k, Word w) { store.frames[base + k] = std::move(w); };
  v.bind = [this, &store, rows](u32 k) {
    const u32 row = (*rows)[k];
    BIP_ASSERT(row == kNoRow || row < image_.cell_count, "bound variable {} is in cell {}", k, row);
    if (row == kNoRow) return Word{};
    if (row >= atom_of_cell_.size()) return store.frames[row];
    const u32 atom = atom_of_cell_[row];
    const u32 variable = row - image_.atoms[atom].first_cell;
    const auto found = store.atoms.find(atom);
    return found == store.atoms.end() ? now_[atom].variables[variable] : found->second.variables[variable];
  };
  v.set_bind = [this, &store, rows](u32 k, Word w) {
    const u32 row = (*rows)[k];
    if (row == kNoRow) return;
    if (row >= atom_of_cell_.size()) {
      store.frames[row] = std::move(w);
      return;
    }
    const u32 atom = atom_of_cell_[row];
    local_in(store, atom).variables[row - image_.atoms[atom].first_cell] = std::move(w);
  };
  return v;
}

// By clause: is it the one for what is chosen?
std::vector<Signal> TransitionSystemBuilder::clause_choice(const Tree& tree, const Use& use,
                                                           const std::vector<Signal>& chosen) {
  const ConnectorType& type = system_.connector_types[system_.connectors[use.connector].type];
  std::vector<Signal> result;
  for (const Clause& clause : type.clauses) {
    Signal is_chosen = chosen[use.root];
    for (u32 p = 0; p < type.params.size(); ++p) {
      const bool wanted = std::binary_search(clause.params.begin(), clause.params.end(), p);
      const Signal is = use.param_nodes[p] == kNoRow ? kFalse : chosen[use.param_nodes[p]];
      is_chosen = aig_.make_and(is_chosen, wanted ? is : negated(is));
    }
    result.push_back(is_chosen);
  }
  (void)tree;
  return result;
}

// Ports, guards bottom up with their `up`s, and that what shows only its maximal interactions shows one.
// Participants::Given: the choice is `leaves`; else `chosen` is a function of the state. Leaves the connectors' own
// data in the store.
Signal TransitionSystemBuilder::is_enabled(const Tree& tree, u32 root, const Leaves& leaves, Participants participants,
                                           const std::vector<Signal>& chosen, Store& store) {
  Signal result = chosen[root];
  Signal there = kTrue;
  if (participants == Participants::Given) {
    for (u32 leaf : leaves) there = aig_.make_and(there, transition_system_.port_is_on[port_of(tree.nodes[leaf])]);
    result = there;
  }
  if (result == kFalse) return kFalse;
  for (std::size_t u = tree.uses.size(); u-- > 0;) {
    const Use& use = tree.uses[u];
    if (chosen[use.root] == kFalse || !tree.is_below(root, use.root)) continue;
    const ConnectorType& type = system_.connector_types[system_.connectors[use.connector].type];
    for (std::size_t k = 0; k < type.variables.size(); ++k) {
      const Type variable = type.variables[k].type;
      store.frames[image_.connectors[use.connector.value].first_cell + static_cast<u32>(k)] =
          variable == Type::Int || variable == Type::Bool || variable == Type::String ? word_of(0) : Word{};
    }
    const Variables variables = variables_of(tree, use, chosen, store);
    const std::vector<Signal> clauses = clause_choice(tree, use, chosen);
    for (std::size_t k = 0; k < clauses.size(); ++k) {
      if (clauses[k] == kFalse) continue;
      Signal fault = kFalse;
      Signal holds = code_.test(type.clauses[k].guard, variables, clauses[k], fault);
      code_.execute(type.clauses[k].up, variables, clauses[k], fault);
      if (fault != kFalse) {
        // Whether the engine looks at this interaction depends on others: it may be a fault, or nothing.
        code_.note(type.clauses[k].loc, "a fault in a connector's guard or `up`");
        guard_fault_ = aig_.make_or(guard_fault_, aig_.make_and(there, fault));
        holds = aig_.make_ite(fault, aig_.make_input(), holds);
      }
      result = aig_.make_and(result, aig_.make_or(negated(clauses[k]), holds));
    }
  }
  if (participants != Participants::Given) return result;
  for (u32 row = 0; row < tree.nodes.size(); ++row) {
    if (tree.nodes[row].kind != Kind::Link || !tree.nodes[row].maximal_only || chosen[row] == kFalse || row == root ||
        !tree.is_below(root, row))
      continue;
    const u32 below = tree.nodes[row].children[0];
    Result<std::vector<Leaves>> all = analysis::list_interactions(tree, below, most_interactions());
    Leaves own;
    for (u32 leaf : leaves) {
      if (tree.is_below(below, leaf)) own.push_back(leaf);
    }
    for (std::size_t k = 0; all && k < all->size(); ++k) {
      const Leaves& larger = (*all)[k];
      if (larger.size() <= own.size() || !std::includes(larger.begin(), larger.end(), own.begin(), own.end())) continue;
      Store other;
      result = aig_.make_and(
          result, negated(is_enabled(tree, below, larger, Participants::Given, fixed_choice(tree, larger), other)));
    }
  }
  return result;
}

void TransitionSystemBuilder::record(Signal when, u32 port, const Local& before, const Post& post) {
  const u32 atom = tables_.port_atom[port];
  if (before.variables == now_[atom].variables) fired_plainly_[port] = aig_.make_or(fired_plainly_[port], when);
  else moves_[atom].push_back({when, post.local});
}

// `down`, then the ports in parameter order, depth first.
void TransitionSystemBuilder::fire_use(const Tree& tree, u32 row, const std::vector<Signal>& chosen, Store& store,
                                       const std::vector<std::vector<Signal>>& clauses, SystemStep& step, Signal& fault,
                                       Signal& lost) {
  const Use& use = tree.uses[row];
  const ConnectorType& type = system_.connector_types[system_.connectors[use.connector].type];
  BIP_ASSERT(clauses.size() == tree.uses.size() && clauses[row].size() == type.clauses.size(), "{} clauses of use {}",
             clauses[row].size(), row);
  for (std::size_t k = 0; k < type.clauses.size(); ++k) {
    code_.execute(type.clauses[k].down, variables_of(tree, use, chosen, store), clauses[row][k], fault);
  }
  // Of a merged port each alternative, where it is the one.
  std::vector<u32> parts;
  for (u32 node : use.param_nodes) {
    if (node == kNoRow) continue;
    if (tree.nodes[node].kind == Kind::Choice)
      parts.insert(parts.end(), tree.nodes[node].children.begin(), tree.nodes[node].children.end());
    else parts.push_back(node);
  }
  for (u32 node : parts) {
    if (chosen[node] == kFalse) continue;
    if (tree.nodes[node].kind == Kind::Link) {
      fire_use(tree, tree.nodes[node].use, chosen, store, clauses, step, fault, lost);
    } else if (tree.nodes[node].kind == Kind::Leaf) {
      const u32 port = port_of(tree.nodes[node]);
      Local& local = local_in(store, tables_.port_atom[port]);
      const bool is_plain = local.variables == now_[tables_.port_atom[port]].variables;
      if (is_plain && !posts_[port]) posts_[port] = fire(port, local);
      const Post post = is_plain ? *posts_[port] : fire(port, local);
      fault = aig_.make_or(fault, aig_.make_and(chosen[node], post.fault));
      lost = aig_.make_or(lost, aig_.make_and(chosen[node], post.lost));
      step.parts.emplace_back(port, chosen[node]);
      record(aig_.make_and(step.chosen, chosen[node]), port, local, post);
      merge(chosen[node], post.local, local);
    }
  }
}

void TransitionSystemBuilder::add_step(rt::InteractionId interaction, const Tree& tree,
                                       const std::vector<Signal>& chosen, Store store, Signal candidate) {
  SystemStep step{.interaction = interaction, .chosen = aig_.make_input(), .possible = candidate, .parts = {}};
  std::vector<std::vector<Signal>> clauses;
  for (const Use& use : tree.uses) clauses.push_back(clause_choice(tree, use, chosen));
  Signal fault = kFalse, lost = kFalse;
  fire_use(tree, 0, chosen, store, clauses, step, fault, lost);
  std::vector<Signal> params;
  for (u32 node : tree.uses[0].param_nodes) params.push_back(node == kNoRow ? kFalse : chosen[node]);
  params_.push_back(std::move(params));
  BIP_ASSERT(params_.size() == transition_system_.steps.size() + 1 && step_fault_.size() == step_lost_.size(),
             "{} rows of {} steps", params_.size(), transition_system_.steps.size() + 1);
  step_fault_.push_back(fault);
  step_lost_.push_back(lost);
  transition_system_.steps.push_back(std::move(step));
}

void TransitionSystemBuilder::add_connector(rt::InteractionId interaction, u32 connector) {
  const ConnectorId id(std::size_t{connector});
  const std::string name = system_.connectors[id].path;
  Result<Tree> built = analysis::build_interaction_tree(system_, id, {.nodes = most_nodes()});
  if (!built) {
    transition_system_.unsupported =
        '`' + name + "` has more than " + std::to_string(most_nodes()) + " ports and connectors (--memory allows more)";
    return;
  }
  const Tree& tree = *built;
  if (is_plain(tree) && has_free_choices(tree)) {
    const std::vector<Signal> chosen = largest_choice(tree);
    Store store;
    const Signal candidate = is_enabled(tree, tree.uses[0].root, {}, Participants::OfState, chosen, store);
    add_step(interaction, tree, chosen, std::move(store), candidate);
    return;
  }
  Result<std::vector<Leaves>> listed = analysis::list_interactions(tree, tree.uses[0].root, most_interactions());
  if (!listed) {
    transition_system_.unsupported = '`' + name + "` has more than " + std::to_string(most_interactions()) +
                                     " interactions with guards (--memory allows more)";
    return;
  }
  const std::vector<Leaves>& all = *listed;
  std::vector<Signal> enabled;
  std::vector<Store> stores;
  for (const Leaves& leaves : all) {
    Store store;
    enabled.push_back(
        is_enabled(tree, tree.uses[0].root, leaves, Participants::Given, fixed_choice(tree, leaves), store));
    stores.push_back(std::move(store));
  }
  for (std::size_t k = 0; k < all.size(); ++k) {
    Signal candidate = enabled[k];
    for (std::size_t j = 0; j < all.size() && candidate != kFalse; ++j) {
      if (all[j].size() > all[k].size() && std::includes(all[j].begin(), all[j].end(), all[k].begin(), all[k].end())) {
        candidate = aig_.make_and(candidate, negated(enabled[j]));
      }
    }
    if (candidate != kFalse) add_step(interaction, tree, fixed_choice(tree, all[k]), stores[k], candidate);
  }
}

void TransitionSystemBuilder::add_connectors() {
  constexpr std::size_t kConnectorsBetweenLooks = 16;
  std::size_t count = 0;
  for (const rt::InteractionId interaction : tables_.interactions_of_connectors()) {
    if (!transition_system_.unsupported.empty() || aig_.is_full()) break;
    transition_system_.is_stopped = count++ % kConnectorsBetweenLooks == 0 && cancellation_.is_over();
    if (transition_system_.is_stopped) break;
    add_connector(interaction, tables_.interactions[interaction].row);
  }
}

void TransitionSystemBuilder::add_internal_ports() {
  for (const rt::InteractionId interaction : tables_.interactions_of_ports()) {
    const u32 port = tables_.interactions[interaction].row;
    if (transition_system_.port_is_on[port] == kFalse) continue;
    SystemStep step{.interaction = interaction,
                    .chosen = aig_.make_input(),
                    .possible = transition_system_.port_is_on[port],
                    .parts = {{port, kTrue}}};
    const Local& now = now_[tables_.port_atom[port]];
    if (!posts_[port]) posts_[port] = fire(port, now);
    record(step.chosen, port, now, *posts_[port]);
    params_.emplace_back();
    step_fault_.push_back(posts_[port]->fault);
    step_lost_.push_back(posts_[port]->lost);
    transition_system_.steps.push_back(std::move(step));
  }
}

}  // namespace bip::verify
