// See point_of_run.hpp.
#include "compiler/library/point_of_run.hpp"

#include <algorithm>

#include "compiler/verify/property/expression.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::library {

using verify::FormulaKind;

namespace {

constexpr std::uint64_t kViolated = std::uint64_t{1} << 63u;

bool is_taken(const verify::StepCondition& step, rt::Core& core, const rt::Candidate* candidate) {
  if (candidate == nullptr) return false;
  if (!step.is_port) return candidate->connector == step.owner;
  std::vector<rt::Participant> participants;
  core.participants(*candidate, participants);
  return std::any_of(participants.begin(), participants.end(), [&](const rt::Participant& participant) {
    return participant.atom == step.owner && participant.port == step.port;
  });
}

std::uint64_t next_bits(const verify::Formula& formula, rt::Core& core, const rt::Candidate* candidate,
                        std::uint64_t before) {
  // By node; operands come before operators.
  std::vector<bool> holds(formula.nodes.size());
  std::uint64_t bits = before & kViolated;
  std::uint64_t bit = 1;
  for (std::size_t row = 0; row < formula.nodes.size(); ++row) {
    const verify::FormulaNode& node = formula.nodes[row];
    switch (node.kind) {
      case FormulaKind::Constant: holds[row] = node.value; break;
      case FormulaKind::State: holds[row] = verify::is_true(formula.states[node.row], core); break;
      case FormulaKind::Step: holds[row] = is_taken(formula.steps[node.row], core, candidate); break;
      case FormulaKind::Not: holds[row] = !holds[node.a]; break;
      case FormulaKind::And: holds[row] = holds[node.a] && holds[node.b]; break;
      case FormulaKind::Or: holds[row] = holds[node.a] || holds[node.b]; break;
      case FormulaKind::Since:
        holds[row] = holds[node.b] || (holds[node.a] && (before & bit) != 0);
        if (holds[row]) bits |= bit;
        bit <<= 1u;
        break;
      case FormulaKind::Release:
        BIP_ASSERT(row == formula.root, "`always` within an invariant");
        if (!holds[node.b]) bits |= kViolated;
        break;
      case FormulaKind::Previously:
      case FormulaKind::Next:
      case FormulaKind::Until: BIP_UNREACHABLE("no monitor of the past has this word");
    }
  }
  return bits;
}

}  // namespace

bool is_true_at(const verify::Formula& formula, std::uint32_t row, rt::Core& core, const rt::Candidate* candidate) {
  const verify::FormulaNode& node = formula.nodes[row];
  switch (node.kind) {
    case FormulaKind::Constant: return node.value;
    case FormulaKind::State: return verify::is_true(formula.states[node.row], core);
    case FormulaKind::Step: return is_taken(formula.steps[node.row], core, candidate);
    case FormulaKind::Not: return !is_true_at(formula, node.a, core, candidate);
    case FormulaKind::And:
      return is_true_at(formula, node.a, core, candidate) && is_true_at(formula, node.b, core, candidate);
    case FormulaKind::Or:
      return is_true_at(formula, node.a, core, candidate) || is_true_at(formula, node.b, core, candidate);
    case FormulaKind::Next:
    case FormulaKind::Until:
    case FormulaKind::Release:
    case FormulaKind::Previously:
    case FormulaKind::Since: break;
  }
  BIP_UNREACHABLE("a word of time within a response");
}

bool can_monitor(const verify::Formula& formula) {
  const auto is = [&](FormulaKind kind) {
    return std::count_if(formula.nodes.begin(), formula.nodes.end(),
                         [&](const verify::FormulaNode& node) { return node.kind == kind; });
  };
  return is(FormulaKind::Previously) == 0 && is(FormulaKind::Since) < 64 && verify::is_invariant_of_past(formula);
}

rt::TimedMonitor monitor_of(const verify::Formula& formula) {
  BIP_ASSERT(can_monitor(formula), "no monitor of `{}`", formula.text);
  return {[&formula](rt::Core& core, const rt::Candidate* candidate, std::uint64_t before) {
            return next_bits(formula, core, candidate, before);
          },
          [](std::uint64_t bits) { return (bits & kViolated) != 0; }};
}

}  // namespace bip::library
