// See shapes.hpp. Interactions are in the candidate order of semantics.md: connectors that export no port, then
// internal ports.
#include "runtime/explore/shapes.hpp"

#include <algorithm>

#include "bip/assert.hpp"

namespace bip::rt {

namespace {

// An automaton whose ports each label one transition without guard and action, and nothing else that could be looked
// at.
bool only_moves(const AtomType& type) {
  if (type.priorities.size != 0 || type.invariants.size != 0 || type.initial.size != 1) return false;
  std::vector<bool> seen(type.ports.size, false);
  for (const Transition& t : type.transitions) {
    if (t.from.size != 1 || t.to.size != 1 || t.guard != kNone || t.action != kNone || t.port == kNone || seen[t.port])
      return false;
    seen[t.port] = true;
  }
  return std::all_of(type.variables.begin(), type.variables.end(), [](const Var& var) { return var.is_param; });
}

// A connector's tree, what it binds included.
struct Tree {
  std::vector<InteractionLeaf> leaves;
  std::vector<u32> reads;  // atoms whose data it names
  bool has_trigger = false, has_choice = false, has_code = false, has_fault = false;
};

class ShapeBuilder {
 public:
  ShapeBuilder(const Core& core, MaximalProgress progress) : core_(core), image_(core.image()), progress_(progress) {
    for (const AtomType& type : image_.atom_types) only_moves_.push_back(only_moves(type));
    owner_.assign(image_.cell_count, kNone);
    for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
      const Atom& row = image_.atoms[atom];
      for (u32 variable = 0; variable < image_.atom_types[row.type].variables.size; ++variable) {
        const VariableId id = row.variable(variable);
        BIP_ASSERT(owner_[id] == kNone, "variable {} belongs to two atoms", id);
        owner_[id] = atom;
      }
    }
  }

  Shapes build() {
    for (u32 connector = 0; connector < image_.connectors.size; ++connector) {
      if (image_.connector_types[image_.connectors[connector].type].exports) continue;
      add_connector(connector);
    }
    for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
      const AtomType& type = image_.atom_types[image_.atoms[atom].type];
      for (u32 port = 0; port < type.ports.size; ++port) {
        if (type.ports[port].exported) continue;
        Tree tree;
        tree.leaves.push_back(leaf(atom, port));
        add(tree, kNone);
      }
    }
    std::vector<InteractionsBy::Pair> pairs;
    for (const InteractionId interaction : shapes_.interactions.ids()) {
      for (const u32 atom : shapes_.atoms_of(interaction)) pairs.push_back({atom, interaction});
    }
    BIP_ASSERT(shapes_.interactions.size() == core_.tables().interactions.size() &&
                   has_fault_.size() == shapes_.interactions.size(),
               "{} shapes of {} interactions", shapes_.interactions.size(), core_.tables().interactions.size());
    shapes_.interactions_of_atom = InteractionsBy::build(image_.atoms.size, pairs);
    shapes_.calls_cpp = image_.ffi != nullptr;
    shapes_.needs_core = shapes_.calls_cpp || !core_.tables().inner_rules.groups.empty();
    if (image_.priorities.size != 0 && !shapes_.needs_core && !add_rules()) shapes_.needs_core = true;
    add_watched();
    return std::move(shapes_);
  }

 private:
  InteractionLeaf leaf(u32 atom, u32 port) const {
    for (const Transition& t : image_.atom_types[image_.atoms[atom].type].transitions) {
      if (t.port == port) return {atom, port, t.from[0], t.to[0]};
    }
    return {atom, port, kNone, kNone};
  }

  void add_connector(u32 top) {
    Tree tree;
    std::vector<u32> todo{top};
    std::vector<PortRef> refs;
    while (!todo.empty()) {
      const u32 connector = todo.back();
      todo.pop_back();
      const Connector& row = image_.connectors[connector];
      const ConnectorType& type = image_.connector_types[row.type];
      for (const DefineNode& node : type.define) tree.has_trigger |= node.trigger;
      for (const Clause& clause : type.clauses) {
        tree.has_code |= clause.guard != kNone || clause.up != kNone || clause.down != kNone;
        tree.has_fault |= clause.guard != kNone || clause.may_fault;
      }
      for (u32 k = 0; k < row.bind_count; ++k) {
        BIP_ASSERT(row.binds + k < image_.binds.size, "bound variable {} of {}", row.binds + k, image_.binds.size);
        const u32 atom = owner_[image_.binds[row.binds + k].variable()];
        if (atom != kNone) tree.reads.push_back(atom);
      }
      refs.clear();
      for (u32 param = 0; param < type.params.size; ++param) refs.push_back(image_.port_refs[row.ports + param]);
      for (std::size_t k = 0; k < refs.size(); ++k) {
        const PortRef ref = refs[k];
        if (ref.choice != kNone) {
          tree.has_choice = true;
          for (const PortRef& port : image_.choices[ref.choice].ports) refs.push_back(port);
        } else if (ref.atom != kNone) {
          tree.leaves.push_back(leaf(ref.atom, ref.port));
        } else {
          todo.push_back(ref.connector);
        }
      }
    }
    add_witnesses(top, tree);
    add(tree, top);
  }

  // What decides about connectors that export a port: the atoms below the members of their groups, and those that the
  // rules read.
  void add_witnesses(u32 top, Tree& tree) const {
    const Tables& tables = core_.tables();
    const u32 plan_row = tables.interactions[tables.interaction_of(top)].plan();
    if (tables.inner_rules.groups.empty() || plan_row == kNone) return;
    const Plan& plan = tables.plans[plan_row];
    const PlanNode* nodes = tables.plan_nodes.data() + plan.first_node;
    for (const PlanWitness& witness : plan.witnesses) {
      for (u32 i = witness.root; i < nodes[witness.root].end; ++i) {
        if (nodes[i].kind == NodeKind::Leaf) tree.reads.push_back(tables.port_atom[nodes[i].ref]);
      }
      for (const u32 rule : tables.inner_rules.groups[witness.group].rules) {
        const Priority& row = image_.priorities[rule];
        for (u32 k = 0; k < row.bind_count; ++k) tree.reads.push_back(owner_[image_.binds[row.binds + k].variable()]);
      }
    }
  }

  void add(const Tree& tree, u32 connector) {
    InteractionShape shape;
    shape.is_rendezvous = !tree.has_trigger && !tree.has_choice;
    shape.leaves = {static_cast<u32>(shapes_.leaves.size()), static_cast<u32>(tree.leaves.size())};
    shapes_.leaves.insert(shapes_.leaves.end(), tree.leaves.begin(), tree.leaves.end());
    std::vector<u32> atoms = tree.reads;
    for (const InteractionLeaf& at : tree.leaves) atoms.push_back(at.atom);
    std::sort(atoms.begin(), atoms.end());
    atoms.erase(std::unique(atoms.begin(), atoms.end()), atoms.end());
    shape.atoms = {static_cast<u32>(shapes_.atoms.size()), static_cast<u32>(atoms.size())};
    shapes_.atoms.insert(shapes_.atoms.end(), atoms.begin(), atoms.end());
    bool moves = shape.is_rendezvous && !tree.has_code && !tree.has_fault && atoms.size() == tree.leaves.size();
    for (const InteractionLeaf& at : tree.leaves)
      moves = moves && only_moves_[image_.atoms[at.atom].type] && at.from != kNone;
    shape.form = moves ? InteractionForm::Moves : InteractionForm::Table;
    (void)shapes_.interactions.push(shape);
    (void)has_fault_.push(connector != kNone && ((tree.has_fault && image_.sites.size != 0) || tree.has_choice ||
                                                 (tree.has_trigger && progress_ == MaximalProgress::Off)));
  }

  // Rules as sets of dominators. False: they are not that simple.
  bool add_rules() {
    const PriorityTables rules = link_priorities(core_.tables());
    for (const Priority& rule : image_.priorities) {
      if (rule.guard != kNone) return false;
    }
    for (const InteractionId interaction : shapes_.interactions.ids()) {
      if (rules.is_involved[interaction] != 0 && !shapes_.interactions[interaction].is_rendezvous) return false;
    }
    const auto connector_of = [&](InteractionId interaction) { return core_.tables().interactions[interaction].row; };
    const auto params_of = [&](InteractionId interaction) {
      std::vector<u32> params(core_.tables().connector_type(connector_of(interaction)).params.size);
      for (u32 k = 0; k < params.size(); ++k) params[k] = k;
      return params;
    };
    std::vector<std::vector<InteractionId>> highs(rules.count);
    for (const HighEdge& edge : rules.high_edges) {
      if (matches_high(core_.tables(), image_.priorities[edge.rule], connector_of(edge.interaction),
                       params_of(edge.interaction)))
        highs[edge.rule].push_back(edge.interaction);
    }
    std::vector<CsrOf<InteractionId, InteractionId>::Pair> pairs;
    for (const InteractionId interaction : shapes_.interactions.ids()) {
      std::vector<bool> seen(rules.count, false);
      IndexVector<InteractionId, bool> is_high(shapes_.interactions.size(), false);
      std::vector<u32> todo;
      for (const u32 rule : rules.low_of_interaction[interaction]) {
        if (matches_low(core_.tables(), image_.priorities[rule], connector_of(interaction), params_of(interaction)))
          todo.push_back(rule);
      }
      while (!todo.empty()) {
        const u32 rule = todo.back();
        todo.pop_back();
        if (seen[rule]) continue;
        seen[rule] = true;
        for (const InteractionId high : highs[rule]) {
          if (!is_high[high]) pairs.push_back({interaction, high});
          is_high[high] = true;
        }
        for (const u32 next : rules.next[rule]) todo.push_back(next);
      }
    }
    shapes_.dominators = CsrOf<InteractionId, InteractionId>::build(shapes_.interactions.size(), pairs);
    return true;
  }

  void add_watched() {
    if (std::find(has_fault_.begin(), has_fault_.end(), true) == has_fault_.end()) return;
    std::vector<CsrOf<InteractionId, InteractionId>::Pair> pairs;
    for (const InteractionId interaction : shapes_.interactions.ids()) {
      std::vector<InteractionId> near;
      for (const u32 atom : shapes_.atoms_of(interaction)) {
        for (const InteractionId other : shapes_.interactions_of_atom[atom]) {
          if (has_fault_[other]) near.push_back(other);
        }
      }
      std::sort(near.begin(), near.end());
      near.erase(std::unique(near.begin(), near.end()), near.end());
      for (const InteractionId other : near) pairs.push_back({interaction, other});
    }
    shapes_.watched = CsrOf<InteractionId, InteractionId>::build(shapes_.interactions.size(), pairs);
  }

  const Core& core_;
  const Image& image_;
  MaximalProgress progress_;
  std::vector<bool> only_moves_;
  IndexVector<VariableId, u32> owner_;
  IndexVector<InteractionId, bool> has_fault_;
  Shapes shapes_;
};

}  // namespace

Shapes shapes_of(const Core& core, MaximalProgress progress) { return ShapeBuilder(core, progress).build(); }

}  // namespace bip::rt
