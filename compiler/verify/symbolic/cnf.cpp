// See cnf.hpp.
#include "compiler/verify/symbolic/cnf.hpp"

namespace bip::verify {

Cnf::Cnf(const Aig& circuit, Solver& solver) : circuit_(circuit), solver_(solver), literals_(circuit.size(), 0) {
  literals_[0] = solver_.new_variable();
  solver_.add({-literals_[0]});
}

Lit Cnf::literal(Signal signal) {
  if (literals_.size() < circuit_.size()) literals_.resize(circuit_.size(), 0);
  std::vector<u32> todo{node_of(signal)};
  while (!todo.empty()) {
    const u32 row = todo.back();
    if (literals_[row] != 0) {
      todo.pop_back();
      continue;
    }
    if (circuit_.is_input(row)) {
      literals_[row] = solver_.new_variable();
      continue;
    }
    const auto [a, b] = circuit_.node(row);
    const Lit x = literals_[node_of(a)], y = literals_[node_of(b)];
    if (x == 0 || y == 0) {
      if (x == 0) todo.push_back(node_of(a));
      if (y == 0) todo.push_back(node_of(b));
      continue;
    }
    const Lit la = (a & 1) != 0 ? -x : x, lb = (b & 1) != 0 ? -y : y;
    const Lit here = solver_.new_variable();
    literals_[row] = here;
    solver_.add({-here, la});
    solver_.add({-here, lb});
    solver_.add({here, -la, -lb});
  }
  return known(signal);
}

namespace {

// Nodes below, each once over all calls.
class Below {
 public:
  explicit Below(const Aig& circuit) : circuit_(circuit), seen_(circuit.size(), 0) {}
  template <class See>
  void look(Signal signal, const See& see) {
    std::vector<u32> todo{node_of(signal)};
    while (!todo.empty()) {
      const u32 row = todo.back();
      todo.pop_back();
      if (row == 0 || seen_[row] != 0) continue;
      seen_[row] = 1;
      if (circuit_.is_input(row)) {
        see(row);
        continue;
      }
      todo.push_back(node_of(circuit_.node(row).a));
      todo.push_back(node_of(circuit_.node(row).b));
    }
  }

 private:
  const Aig& circuit_;
  std::vector<std::uint8_t> seen_;
};

}  // namespace

ConeOfInfluence cone_of_influence(const TransitionSystem& machine, const std::vector<Signal>& signals) {
  ConeOfInfluence relevant;
  relevant.bits.assign(machine.bits.size(), 0);
  relevant.steps.assign(machine.steps.size(), 0);
  std::vector<u32> bit_of(machine.circuit.size(), kNoRow), step_of(machine.circuit.size(), kNoRow);
  for (u32 row = 0; row < machine.bits.size(); ++row) bit_of[node_of(machine.bits[row].now)] = row;
  for (u32 row = 0; row < machine.steps.size(); ++row) step_of[node_of(machine.steps[row].chosen)] = row;
  // Places of one automaton come together: "exactly one" ties them.
  std::vector<u32> group_of(machine.bits.size(), kNoRow);
  for (u32 g = 0; g < machine.exactly_one.size(); ++g) {
    for (u32 row : machine.exactly_one[g]) group_of[row] = g;
  }
  Below below(machine.circuit);
  std::vector<Signal> todo = signals;
  while (!todo.empty()) {
    const Signal signal = todo.back();
    todo.pop_back();
    const auto add_bit = [&](u32 row) {
      if (relevant.bits[row] != 0) return;
      relevant.bits[row] = 1;
      todo.push_back(machine.bits[row].next);
    };
    below.look(signal, [&](u32 node) {
      if (const u32 row = bit_of[node]; row != kNoRow) {
        if (group_of[row] == kNoRow) add_bit(row);
        else
          for (u32 other : machine.exactly_one[group_of[row]]) add_bit(other);
      } else if (const u32 step = step_of[node]; step != kNoRow && relevant.steps[step] == 0) {
        relevant.steps[step] = 1;
        todo.push_back(machine.steps[step].fine);
      }
    });
  }
  return relevant;
}

std::vector<std::uint8_t> nodes_in_cone(const TransitionSystem& machine, const ConeOfInfluence& relevant) {
  const Aig& circuit = machine.circuit;
  std::vector<std::uint8_t> covered(circuit.size(), 0);
  covered[0] = 1;
  for (std::size_t k = 0; k < machine.bits.size(); ++k) {
    if (relevant.bits[k] != 0) covered[node_of(machine.bits[k].now)] = 1;
  }
  // Nodes come after those below them.
  std::vector<std::uint8_t> is_bit(circuit.size(), 0);
  for (const StateBit& bit : machine.bits) is_bit[node_of(bit.now)] = 1;
  for (u32 row = 1; row < circuit.size(); ++row) {
    if (circuit.is_input(row)) {
      if (is_bit[row] == 0) covered[row] = 1;
      continue;
    }
    covered[row] = covered[node_of(circuit.node(row).a)] & covered[node_of(circuit.node(row).b)];
  }
  return covered;
}

void Cnf::add(const std::vector<Signal>& clause) {
  std::vector<Lit> literals;
  for (Signal s : clause) literals.push_back(literal(s));
  solver_.add(literals);
}

void Cnf::add_state(const TransitionSystem& machine) {
  for (Signal inside : machine.in_range) add({inside});
  for (const std::vector<u32>& group : machine.exactly_one) {
    std::vector<Lit> places;
    for (u32 row : group) places.push_back(literal(machine.bits[row].now));
    solver_.add(places);
    add_at_most_one(solver_, places);
  }
}

}  // namespace bip::verify
