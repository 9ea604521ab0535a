// See state_machine_components.hpp. Two variables per node: a choice below it puts one token more into the set than it
// takes (plus), or takes one more (minus). A step does neither. Where the choices below a node differ in their effect
// the set is refused: stronger than the definition, but linear.
//
// Steps. 1 to 3 are the definition of a state-machine component (M. Hack 1972; J. Desel, J. Esparza 1995, chapter 5,
// where it is an S-component), as clauses; 4 to 6 are the search.
//   1. Choose a set of modes, with two witnesses.
//   2. The set holds one token in the initial marking.
//   3. Each transition that touches the set takes one token out of it and puts one into it. Transitions are the
//      interactions, which the connectors' trees stand for.
//   4. Demand that the candidate marks both witnesses.
//   5. Solve; the solver's model is a set.
//   6. Check the set again, and use its modes as witnesses no more.
// Departures: the set need not be strongly connected, so it may be the union of a component and of sets without tokens,
// which is as sound. Only modes that are reachable by structure count.
#include "compiler/verify/invariants/state_machine_components.hpp"

#include <algorithm>

#include "compiler/base/log.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

// Step 3, a port: for every possible move alike, plus = to and not from, minus = from and not to.
StateMachineComponentFinder::Effect StateMachineComponentFinder::encode_port(u32 port) {
  Solver& s = *solver_;
  const u32 base = net_.mode_base[net_.graph.atom_of_port[port]];
  Effect effect{0, 0, true};
  for (const Move& move : net_.moves(port)) {
    if (!reachable_.is_on(base + move.from) || !reachable_.in_context(port)) continue;
    if (effect.is_dead) {
      effect.plus = s.new_variable();
      effect.minus = s.new_variable();
      effect.is_dead = false;
    }
    const Lit from = in_set_[base + move.from], to = in_set_[base + move.to];
    BIP_ASSERT(from != 0 && to != 0, "a possible move of port {} ends at an unreachable mode", port);
    s.add({-effect.plus, to});
    s.add({-effect.plus, -from});
    s.add({-to, from, effect.plus});
    s.add({-effect.minus, from});
    s.add({-effect.minus, -to});
    s.add({-from, to, effect.minus});
  }
  return effect;
}

// Step 3, a rendezvous: at most one child puts, at most one takes; both together cancel out.
StateMachineComponentFinder::Effect StateMachineComponentFinder::encode_rendezvous(
    const std::vector<Effect>& children) {
  Solver& s = *solver_;
  const Lit plus_variable = s.new_variable(), minus_variable = s.new_variable();
  const Effect effect{plus_variable, minus_variable, false};
  std::vector<Lit> plus, minus;
  for (const Effect& child : children) {
    plus.push_back(child.plus);
    minus.push_back(child.minus);
  }
  add_at_most_one(s, plus);
  add_at_most_one(s, minus);
  const Lit any_plus = s.new_variable(), any_minus = s.new_variable();
  for (const auto& [any, parts] : {std::pair(any_plus, &plus), std::pair(any_minus, &minus)}) {
    std::vector<Lit> some{-any};
    for (Lit part : *parts) {
      s.add({-part, any});
      some.push_back(part);
    }
    s.add(some);
  }
  s.add({-effect.plus, any_plus});
  s.add({-effect.plus, -any_minus});
  s.add({-any_plus, any_minus, effect.plus});
  s.add({-effect.minus, any_minus});
  s.add({-effect.minus, -any_plus});
  s.add({-any_minus, any_plus, effect.minus});
  return effect;
}

// Step 3, all kinds of nodes, by the effects of the children.
StateMachineComponentFinder::Effect StateMachineComponentFinder::encode_node(u32 row) {
  Solver& s = *solver_;
  const Node& node = net_.graph.nodes[row];
  if (node.kind == ConnectorNodeKind::Port) return encode_port(row);
  std::vector<Effect> live;
  for (const Edge& child : net_.graph.children(row)) {
    BIP_ASSERT(child.node < row, "node {} stands before its child {}", row, child.node);
    const Effect& below = effects_[child.node];
    if (below.is_dead && node.kind == ConnectorNodeKind::All) return {0, 0, true};
    if (!below.is_dead) live.push_back(below);
  }
  if (live.empty()) return {0, 0, true};
  if (live.size() == 1) return live[0];
  if (node.kind == ConnectorNodeKind::All) return encode_rendezvous(live);
  const Lit plus = s.new_variable(), minus = s.new_variable();
  const Effect effect{plus, minus, false};
  for (const Effect& child : live) {
    // Any subset of a trigger group may take part: only no effect at all is the same for all subsets.
    if (node.kind == ConnectorNodeKind::Trigger) {
      s.add({-child.plus});
      s.add({-child.minus});
    } else {
      s.add({-child.plus, effect.plus});
      s.add({child.plus, -effect.plus});
      s.add({-child.minus, effect.minus});
      s.add({child.minus, -effect.minus});
    }
  }
  if (node.kind == ConnectorNodeKind::Trigger) {
    s.add({-effect.plus});
    s.add({-effect.minus});
  }
  return effect;
}

// Step 1: the set contains two different witnesses; a search assumes that these are marked in its candidate.
void StateMachineComponentFinder::encode_two_witnesses() {
  Solver& s = *solver_;
  const u32 count = net_.mode_count();
  in_set_.assign(count, 0);
  first_witness_.assign(count, 0);
  second_witness_.assign(count, 0);
  std::vector<Lit> some_first, some_second;
  for (u32 mode = 0; mode < count; ++mode) {
    if (!reachable_.is_on(mode)) continue;
    in_set_[mode] = s.new_variable();
    first_witness_[mode] = s.new_variable();
    second_witness_[mode] = s.new_variable();
    // Small sets first.
    s.prefer(-in_set_[mode]);
    s.add({-first_witness_[mode], in_set_[mode]});
    s.add({-second_witness_[mode], in_set_[mode]});
    s.add({-first_witness_[mode], -second_witness_[mode]});
    some_first.push_back(first_witness_[mode]);
    some_second.push_back(second_witness_[mode]);
  }
  s.add(some_first);
  s.add(some_second);
}

// Step 2: exactly one atom begins in the set, and does so whichever of its initial modes it begins in.
void StateMachineComponentFinder::encode_one_initial_token() {
  Solver& s = *solver_;
  std::vector<Lit> initial;
  for (u32 atom = 0; atom + 1 < net_.mode_base.size(); ++atom) {
    const std::vector<u32>& modes = net_.class_at(atom).initial;
    for (std::size_t k = 0; k < modes.size(); ++k) {
      const Lit mode = in_set_[net_.mode_base[atom] + modes[k]];
      const Lit first = in_set_[net_.mode_base[atom] + modes[0]];
      if (k == 0) {
        initial.push_back(mode);
        continue;
      }
      s.add({-mode, first});
      s.add({mode, -first});
    }
  }
  s.add(initial);
  add_at_most_one(s, initial);
}

void StateMachineComponentFinder::encode() {
  solver_ = std::make_unique<Solver>();
  encode_two_witnesses();
  encode_one_initial_token();
  // Step 3. Children stand before parents; a step, the choice at a root, has no effect.
  effects_.resize(net_.graph.nodes.size());
  for (u32 row = 0; row < net_.graph.nodes.size(); ++row) {
    effects_[row] = encode_node(row);
    if (!net_.graph.nodes[row].is_root || effects_[row].is_dead) continue;
    solver_->add({-effects_[row].plus});
    solver_->add({-effects_[row].minus});
  }
}

std::vector<TokenInvariant> StateMachineComponentFinder::find(const std::vector<std::uint8_t>& marked,
                                                              std::size_t count,
                                                              const CancellationToken& cancellation) {
  BIP_ASSERT(marked.size() == net_.mode_count(), "{} marks of {} modes", marked.size(), net_.mode_count());
  std::vector<TokenInvariant> found;
  // The solver reads the clock between decisions. With so many assumptions, made one by one, that may take minutes.
  if (net_.mode_count() > kMostModes) return found;
  if (!solver_) encode();
  // Step 4. Witnesses are marked modes that no component of this call contains.
  std::vector<std::uint8_t> is_used(net_.mode_count(), 0);
  while (found.size() < count) {
    for (u32 mode = 0; mode < net_.mode_count(); ++mode) {
      if (in_set_[mode] == 0 || (marked[mode] != 0 && is_used[mode] == 0)) continue;
      solver_->assume(-first_witness_[mode]);
      solver_->assume(-second_witness_[mode]);
    }
    // Step 5: no model means that no further component excludes the candidate.
    if (solver_->solve(cancellation) != Answer::Satisfiable) break;
    TokenInvariant invariant{InvariantKind::OneToken, {}};
    for (u32 mode = 0; mode < net_.mode_count(); ++mode) {
      if (in_set_[mode] == 0 || !solver_->is_true(in_set_[mode])) continue;
      invariant.modes.push_back(mode);
      is_used[mode] = 1;
    }
    // Step 6: nothing rests on the encoding.
    if (!checker_.is_state_machine_component(invariant.modes)) break;
    BIP_ASSERT(!is_satisfied(invariant, marked), "a component of {} modes holds in the candidate",
               invariant.modes.size());
    BIP_LOG(Components, 2, "state-machine component of {} modes", invariant.modes.size());
    found.push_back(std::move(invariant));
  }
  BIP_LOG(Components, 1, "{} state-machine components exclude the candidate", found.size());
  return found;
}

}  // namespace bip::verify
