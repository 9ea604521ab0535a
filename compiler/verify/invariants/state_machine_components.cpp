// For each node two variables: a choice below puts one token more than it takes (plus), or takes one more (minus);
// steps must do neither. Choices that may differ in what they do are not allowed at all.
#include "compiler/verify/invariants/state_machine_components.hpp"

#include <algorithm>

namespace bip::verify {

StateMachineComponentFinder::Effect StateMachineComponentFinder::effect_of(u32 row) {
  Solver& s = *solver_;
  const Node& node = net_.nodes[row];
  Effect effect;
  if (node.kind == NodeKind::Port) {
    const u32 base = net_.mode_base[net_.atom_of_port[row]];
    effect.is_dead = true;
    for (const Move& move : net_.moves(row)) {
      if (!reachable_.is_on(base + move.from) || !reachable_.in_context(row)) continue;
      if (effect.is_dead) effect = {s.new_variable(), s.new_variable(), false};
      const Lit from = in_set_[base + move.from], to = in_set_[base + move.to];
      // plus = to and not from, minus = from and not to, for every move alike.
      s.add({-effect.plus, to});
      s.add({-effect.plus, -from});
      s.add({-to, from, effect.plus});
      s.add({-effect.minus, from});
      s.add({-effect.minus, -to});
      s.add({-from, to, effect.minus});
    }
    return effect;
  }
  std::vector<Effect> live;
  for (const Edge& child : net_.children(row)) {
    const Effect& below = effects_[child.node];
    if (below.is_dead && node.kind == NodeKind::All) return {0, 0, true};
    if (!below.is_dead) live.push_back(below);
  }
  if (live.empty()) return {0, 0, true};
  if (live.size() == 1) return live[0];
  effect = {s.new_variable(), s.new_variable(), false};
  if (node.kind == NodeKind::All) {
    std::vector<Lit> plus, minus;
    for (const Effect& e : live) {
      plus.push_back(e.plus);
      minus.push_back(e.minus);
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
  for (const Effect& e : live) {
    if (node.kind == NodeKind::Trigger) {
      s.add({-e.plus});
      s.add({-e.minus});
    } else {
      s.add({-e.plus, effect.plus});
      s.add({e.plus, -effect.plus});
      s.add({-e.minus, effect.minus});
      s.add({e.minus, -effect.minus});
    }
  }
  if (node.kind == NodeKind::Trigger) {
    s.add({-effect.plus});
    s.add({-effect.minus});
  }
  return effect;
}

void StateMachineComponentFinder::build() {
  solver_ = std::make_unique<Solver>();
  Solver& s = *solver_;
  const u32 count = net_.mode_count();
  in_set_.assign(count, 0);
  first_.assign(count, 0);
  second_.assign(count, 0);
  std::vector<Lit> some_first, some_second, initial;
  for (u32 mode = 0; mode < count; ++mode) {
    if (!reachable_.is_on(mode)) continue;
    in_set_[mode] = s.new_variable();
    first_[mode] = s.new_variable();
    second_[mode] = s.new_variable();
    s.prefer(-in_set_[mode]);
    s.add({-first_[mode], in_set_[mode]});
    s.add({-second_[mode], in_set_[mode]});
    s.add({-first_[mode], -second_[mode]});
    some_first.push_back(first_[mode]);
    some_second.push_back(second_[mode]);
  }
  s.add(some_first);
  s.add(some_second);
  for (u32 atom = 0; atom + 1 < net_.mode_base.size(); ++atom) {
    const std::vector<u32>& modes = net_.class_at(atom).initial;
    for (std::size_t k = 0; k < modes.size(); ++k) {
      const Lit here = in_set_[net_.mode_base[atom] + modes[k]];
      const Lit head = in_set_[net_.mode_base[atom] + modes[0]];
      if (k == 0) {
        initial.push_back(here);
        continue;
      }
      s.add({-here, head});
      s.add({here, -head});
    }
  }
  s.add(initial);
  add_at_most_one(s, initial);
  effects_.resize(net_.nodes.size());
  for (u32 row = 0; row < net_.nodes.size(); ++row) {
    effects_[row] = effect_of(row);
    if (!net_.nodes[row].is_root || effects_[row].is_dead) continue;
    s.add({-effects_[row].plus});
    s.add({-effects_[row].minus});
  }
}

std::vector<TokenInvariant> StateMachineComponentFinder::find(TrapFinder& checker,
                                                              const std::vector<std::uint8_t>& marked,
                                                              std::size_t count,
                                                              const CancellationToken& cancellation) {
  std::vector<TokenInvariant> found;
  // The solver looks at the clock between decisions. With so many assumed one by one it may not come to that for
  // minutes.
  if (net_.mode_count() > kMostModes) return found;
  if (!solver_) build();
  std::vector<std::uint8_t> is_used(net_.mode_count(), 0);
  while (found.size() < count) {
    for (u32 mode = 0; mode < net_.mode_count(); ++mode) {
      if (in_set_[mode] == 0 || (marked[mode] != 0 && is_used[mode] == 0)) continue;
      solver_->assume(-first_[mode]);
      solver_->assume(-second_[mode]);
    }
    if (solver_->solve(cancellation) != Answer::Satisfiable) break;
    TokenInvariant invariant{InvariantKind::OneToken, {}};
    for (u32 mode = 0; mode < net_.mode_count(); ++mode) {
      if (in_set_[mode] == 0 || !solver_->is_true(in_set_[mode])) continue;
      invariant.modes.push_back(mode);
      is_used[mode] = 1;
    }
    if (!checker.is_state_machine_component(invariant.modes)) break;
    found.push_back(std::move(invariant));
  }
  return found;
}

}  // namespace bip::verify
