// See aiger.hpp.
#include "compiler/verify/symbolic/aiger.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class AigerWriter {
 public:
  AigerWriter(TransitionSystem& transition_system, const System& system)
      : transition_system_(transition_system), aig_(transition_system.aig), system_(system) {}

  std::string write(Signal bad) {
    // The transition relation as functions: a step is taken if it is the only chosen one and is fine, else all bits
    // stay.
    Signal some = kFalse, several = kFalse, fine = kFalse;
    for (const SystemStep& step : transition_system_.steps) {
      several = aig_.make_or(several, aig_.make_and(some, step.chosen));
      some = aig_.make_or(some, step.chosen);
      fine = aig_.make_or(fine, aig_.make_and(step.chosen, step.fine));
    }
    const Signal is_taken = aig_.make_and(negated(several), fine);
    std::vector<Signal> next;
    for (const StateBit& bit : transition_system_.bits) next.push_back(aig_.make_ite(is_taken, bit.next, bit.now));
    const Signal output = aig_.make_and(bad, negated(several));

    number_nodes(next, output);
    std::string text = fmt::format("aag {} {} {} 1 {}\n", inputs_.size() + next.size() + gates_.size(), inputs_.size(),
                                   next.size(), gates_.size());
    for (std::size_t k = 0; k < inputs_.size(); ++k) text += fmt::format("{}\n", 2 * (k + 1));
    for (std::size_t k = 0; k < next.size(); ++k) {
      const StateBit& bit = transition_system_.bits[k];
      const std::uint32_t latch = literal_of(bit.now) & ~1u;
      const std::uint32_t next_value = literal_of(next[k]) ^ (bit.initial == 1 ? 1u : 0u);
      text += bit.initial < 0 ? fmt::format("{} {} {}\n", latch, next_value, latch)
                              : fmt::format("{} {}\n", latch, next_value);
    }
    text += fmt::format("{}\n", literal_of(output));
    for (const std::uint32_t node : gates_) {
      const Aig::Node operands = aig_.node(node);
      const std::uint32_t left = literal_of(operands.a), right = literal_of(operands.b), gate = variable_[node] * 2;
      BIP_ASSERT(left < gate && right < gate, "gate {} has operands {} and {}", gate, left, right);
      text += fmt::format("{} {} {}\n", gate, std::max(left, right), std::min(left, right));
    }
    return text + symbols();
  }

 private:
  // Inputs that something depends on, then latches, then gates in topological order, which is that of the nodes.
  void number_nodes(const std::vector<Signal>& next, Signal output) {
    std::vector<std::uint8_t> is_used(aig_.size(), 0), is_bit(aig_.size(), 0);
    for (const StateBit& bit : transition_system_.bits) is_bit[node_of(bit.now)] = 1;
    for (Signal s : next) is_used[node_of(s)] = 1;
    is_used[node_of(output)] = 1;
    for (std::uint32_t node = static_cast<std::uint32_t>(aig_.size()); node-- > 1;) {
      if (is_used[node] == 0 || aig_.is_input(node)) continue;
      is_used[node_of(aig_.node(node).a)] = 1;
      is_used[node_of(aig_.node(node).b)] = 1;
    }
    variable_.assign(aig_.size(), 0);
    is_negated_.assign(aig_.size(), 0);
    std::uint32_t variable = 0;
    for (std::uint32_t node = 1; node < aig_.size(); ++node) {
      if (is_used[node] == 0 || !aig_.is_input(node) || is_bit[node] != 0) continue;
      inputs_.push_back(node);
      variable_[node] = ++variable;
    }
    for (const StateBit& bit : transition_system_.bits) {
      variable_[node_of(bit.now)] = ++variable;
      is_negated_[node_of(bit.now)] = bit.initial == 1 ? 1 : 0;
    }
    for (std::uint32_t node = 1; node < aig_.size(); ++node) {
      if (is_used[node] == 0 || aig_.is_input(node)) continue;
      gates_.push_back(node);
      variable_[node] = ++variable;
    }
  }
  // Node 0 is the constant false in both forms.
  [[nodiscard]] std::uint32_t literal_of(Signal signal) const {
    const std::uint32_t node = node_of(signal);
    BIP_ASSERT(node == 0 || variable_[node] != 0, "node {} has no number", node);
    return 2 * variable_[node] + ((signal & 1u) ^ is_negated_[node]);
  }

  [[nodiscard]] std::string symbols() const {
    std::string text;
    std::vector<std::uint32_t> step_of(aig_.size(), 0);
    for (std::uint32_t k = 0; k < transition_system_.steps.size(); ++k)
      step_of[node_of(transition_system_.steps[k].chosen)] = k + 1;
    for (std::size_t k = 0; k < inputs_.size(); ++k) {
      const std::uint32_t step = step_of[inputs_[k]];
      text += step == 0 ? fmt::format("i{} any {}\n", k, inputs_[k]) : fmt::format("i{} step {}\n", k, step - 1);
    }
    for (std::size_t k = 0; k < transition_system_.bits.size(); ++k) {
      const StateBit& bit = transition_system_.bits[k];
      const Atom& atom = system_.atoms[AtomId(std::size_t{bit.atom})];
      const AtomType& type = system_.atom_types[atom.type];
      text += fmt::format("l{} {}{}", k, bit.initial == 1 ? "not " : "", atom.path);
      text += bit.is_place ? fmt::format("@{}\n", type.places[bit.row])
                           : fmt::format(".{}[{}]\n", type.variables[bit.row].name, bit.position);
    }
    return text + "o0 bad\n";
  }

  TransitionSystem& transition_system_;
  Aig& aig_;
  const System& system_;
  std::vector<std::uint32_t> inputs_, gates_;  // nodes, in the order of their numbers
  std::vector<std::uint32_t> variable_;        // by node; 0: not written
  std::vector<std::uint8_t> is_negated_;       // by node: the latch holds the negated bit
};

}  // namespace

std::string aiger_text(TransitionSystem& transition_system, Signal bad, const System& system) {
  return AigerWriter(transition_system, system).write(bad);
}

}  // namespace bip::verify
