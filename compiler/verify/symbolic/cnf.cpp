// See cnf.hpp.
#include "compiler/verify/symbolic/cnf.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

Cnf::Cnf(const Aig& aig, Solver& solver) : aig_(aig), solver_(solver), literals_(aig.size(), 0) {
  literals_[0] = solver_.new_variable();
  solver_.add({-literals_[0]});
}

Lit Cnf::literal(Signal signal) {
  BIP_ASSERT(node_of(signal) < aig_.size(), "node {} of {}", node_of(signal), aig_.size());
  if (literals_.size() < aig_.size()) literals_.resize(aig_.size(), 0);
  std::vector<u32> todo{node_of(signal)};
  while (!todo.empty()) {
    const u32 node = todo.back();
    if (literals_[node] != 0) {
      todo.pop_back();
      continue;
    }
    if (aig_.is_input(node)) {
      literals_[node] = solver_.new_variable();
      continue;
    }
    const auto [a, b] = aig_.node(node);
    const Lit a_literal = encoded(a), b_literal = encoded(b);
    // Of a node that one operand decides the other one is not encoded, so the operands come one after the other.
    if (is_false(a_literal) || is_false(b_literal)) {
      literals_[node] = literals_[0];
      continue;
    }
    if (a_literal == 0 || b_literal == 0) {
      todo.push_back(node_of(b_literal == 0 ? b : a));
      continue;
    }
    if (is_true(a_literal) || is_true(b_literal)) {
      literals_[node] = is_true(a_literal) ? b_literal : a_literal;
      continue;
    }
    // out <-> a and b.
    const Lit out = solver_.new_variable();
    literals_[node] = out;
    solver_.add({-out, a_literal});
    solver_.add({-out, b_literal});
    solver_.add({out, -a_literal, -b_literal});
  }
  return encoded(signal);
}

namespace {

/// Depth-first search over the nodes below signals; visits each input once over all calls.
class InputVisitor {
 public:
  explicit InputVisitor(const Aig& aig) : aig_(aig), is_visited_(aig.size(), 0) {}
  template <class Visit>
  void visit_inputs(Signal signal, const Visit& visit) {
    std::vector<u32> todo{node_of(signal)};
    while (!todo.empty()) {
      const u32 node = todo.back();
      todo.pop_back();
      if (node == 0 || is_visited_[node] != 0) continue;
      is_visited_[node] = 1;
      if (aig_.is_input(node)) {
        visit(node);
        continue;
      }
      todo.push_back(node_of(aig_.node(node).a));
      todo.push_back(node_of(aig_.node(node).b));
    }
  }

 private:
  const Aig& aig_;
  std::vector<std::uint8_t> is_visited_;
};

}  // namespace

ConeOfInfluence cone_of_influence(const TransitionSystem& system, const std::vector<Signal>& signals,
                                  const std::vector<std::uint8_t>& followed) {
  ConeOfInfluence cone;
  cone.bits.assign(system.bits.size(), 0);
  cone.steps.assign(system.steps.size(), 0);
  std::vector<u32> bit_of(system.aig.size(), kNoRow), step_of(system.aig.size(), kNoRow);
  for (u32 bit = 0; bit < system.bits.size(); ++bit) bit_of[node_of(system.bits[bit].now)] = bit;
  for (u32 step = 0; step < system.steps.size(); ++step) step_of[node_of(system.steps[step].chosen)] = step;
  // Places of one automaton come together: "exactly one" ties them.
  std::vector<u32> group_of(system.bits.size(), kNoRow);
  for (u32 g = 0; g < system.exactly_one.size(); ++g) {
    for (u32 bit : system.exactly_one[g]) group_of[bit] = g;
  }
  InputVisitor visitor(system.aig);
  std::vector<Signal> todo = signals;
  while (!todo.empty()) {
    const Signal signal = todo.back();
    todo.pop_back();
    const auto add_bit = [&](u32 bit) {
      if (cone.bits[bit] != 0 || (!followed.empty() && followed[bit] == 0)) return;
      cone.bits[bit] = 1;
      todo.push_back(system.bits[bit].next);
    };
    visitor.visit_inputs(signal, [&](u32 node) {
      if (const u32 bit = bit_of[node]; bit != kNoRow) {
        if (group_of[bit] == kNoRow) add_bit(bit);
        else
          for (u32 other : system.exactly_one[group_of[bit]]) add_bit(other);
      } else if (const u32 step = step_of[node]; step != kNoRow && cone.steps[step] == 0) {
        cone.steps[step] = 1;
        todo.push_back(system.steps[step].fine);
      }
    });
  }
  return cone;
}

std::vector<u32> atoms_below(const TransitionSystem& system, Signal signal) {
  std::vector<u32> atom_of(system.aig.size(), kNoRow);
  for (const StateBit& bit : system.bits) atom_of[node_of(bit.now)] = bit.atom;
  std::vector<u32> atoms;
  InputVisitor(system.aig).visit_inputs(signal, [&](u32 node) {
    if (atom_of[node] != kNoRow) atoms.push_back(atom_of[node]);
  });
  std::sort(atoms.begin(), atoms.end());
  atoms.erase(std::unique(atoms.begin(), atoms.end()), atoms.end());
  return atoms;
}

std::vector<std::uint8_t> nodes_in_cone(const TransitionSystem& system, const ConeOfInfluence& cone) {
  const Aig& aig = system.aig;
  std::vector<std::uint8_t> covered(aig.size(), 0), is_bit(aig.size(), 0);
  covered[0] = 1;
  for (std::size_t k = 0; k < system.bits.size(); ++k) {
    is_bit[node_of(system.bits[k].now)] = 1;
    if (cone.bits[k] != 0) covered[node_of(system.bits[k].now)] = 1;
  }
  // One pass suffices: operands stand before the nodes that use them.
  for (u32 node = 1; node < aig.size(); ++node) {
    if (aig.is_input(node)) {
      if (is_bit[node] == 0) covered[node] = 1;
      continue;
    }
    const auto [a, b] = aig.node(node);
    BIP_ASSERT(node_of(a) < node && node_of(b) < node, "node {} has operands {} and {}", node, node_of(a), node_of(b));
    covered[node] = covered[node_of(a)] & covered[node_of(b)];
  }
  return covered;
}

void Cnf::add(const std::vector<Signal>& clause) {
  std::vector<Lit> literals;
  for (Signal s : clause) literals.push_back(literal(s));
  solver_.add(literals);
}

void Cnf::fix_false(Signal input) {
  BIP_ASSERT(aig_.is_input(node_of(input)) && encoded(input) == 0, "node {} is no input, or encoded", node_of(input));
  literals_[node_of(input)] = (input & 1) != 0 ? -literals_[0] : literals_[0];
}

Lit Cnf::add_step(const TransitionSystem& system, const std::vector<std::vector<Signal>>& invariants) {
  return add_step(system, invariants, 0, system.steps.size());
}

Lit Cnf::add_step(const TransitionSystem& system, const std::vector<std::vector<Signal>>& invariants, std::size_t begin,
                  std::size_t end) {
  BIP_ASSERT(begin <= end && end <= system.steps.size(), "steps {} to {} of {}", begin, end, system.steps.size());
  for (std::size_t row = 0; row < system.steps.size(); ++row) {
    if (row < begin || row >= end) fix_false(system.steps[row].chosen);
  }
  const Lit activation = solver_.new_variable();
  std::vector<Lit> chosen;
  for (std::size_t row = begin; row < end; ++row) {
    const SystemStep& step = system.steps[row];
    chosen.push_back(literal(step.chosen));
    solver_.add({-activation, -chosen.back(), literal(step.fine)});
  }
  add_at_most_one(solver_, chosen);
  chosen.push_back(-activation);
  solver_.add(chosen);
  add_state(system);
  for (const std::vector<Signal>& clause : invariants) add(clause);
  return activation;
}

void Cnf::add_state(const TransitionSystem& system) {
  for (Signal inside : system.in_range) add({inside});
  for (const std::vector<u32>& group : system.exactly_one) {
    std::vector<Lit> places;
    for (u32 bit : group) places.push_back(literal(system.bits[bit].now));
    solver_.add(places);
    add_at_most_one(solver_, places);
  }
}

}  // namespace bip::verify
