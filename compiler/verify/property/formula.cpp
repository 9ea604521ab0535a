// Formulas from parsed properties, and their meaning on a run that ends in a cycle (formula.hpp).
#include "compiler/verify/property/formula.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "compiler/verify/property/make_formula.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// A valuation is one word.
constexpr std::size_t kMaxConditions = 64;

class FormulaMaker {
 public:
  FormulaMaker(const Property& parsed, const std::vector<std::uint8_t>& is_temporal)
      : parsed_(parsed), is_temporal_(is_temporal) {
    BIP_ASSERT(is_temporal.size() == parsed.nodes.size(), "{} of {} nodes", is_temporal.size(), parsed.nodes.size());
    made_.text = parsed.text;
  }

  Result<Formula> run() {
    made_.root = make(parsed_.root);
    if (made_.states.size() + made_.steps.size() > kMaxConditions)
      return Failure{"the property has more than " + std::to_string(kMaxConditions) + " conditions"};
    return std::move(made_);
  }

 private:
  // Equal nodes share a row.
  std::uint32_t add(FormulaNode node) {
    const auto key = std::make_tuple(node.kind, node.value, node.a, node.b, node.row);
    const auto [at, is_new] = rows_.try_emplace(key, static_cast<std::uint32_t>(made_.nodes.size()));
    if (is_new) made_.nodes.push_back(node);
    return at->second;
  }
  std::uint32_t constant(bool value) { return add({.kind = FormulaKind::Constant, .value = value}); }
  std::uint32_t negate(std::uint32_t a) { return add({.kind = FormulaKind::Not, .a = a, .b = a}); }
  std::uint32_t always(std::uint32_t a) { return add({.kind = FormulaKind::Release, .a = constant(false), .b = a}); }
  std::uint32_t eventually(std::uint32_t a) { return add({.kind = FormulaKind::Until, .a = constant(true), .b = a}); }

  // A copy of the part of the tree, its operands first.
  std::uint32_t copy(std::uint32_t row, Property& to) {
    PropertyNode node = parsed_.nodes[row];
    if (node.kind == PropertyKind::Operator) {
      const bool is_unary = node.a == node.b;
      node.a = copy(node.a, to);
      node.b = is_unary ? node.a : copy(node.b, to);
    }
    to.nodes.push_back(node);
    return static_cast<std::uint32_t>(to.nodes.size() - 1);
  }
  std::uint32_t make_condition(std::uint32_t row) {
    const PropertyNode& node = parsed_.nodes[row];
    if (node.kind == PropertyKind::Constant) return constant(node.int_value != 0);
    Property condition;
    condition.root = copy(row, condition);
    const auto key_of = [](const Property& p) {
      std::vector<std::tuple<PropertyKind, Type, Op, std::uint32_t, std::uint32_t, std::int32_t, double, std::uint32_t,
                             std::uint32_t>>
          key;
      for (const PropertyNode& n : p.nodes)
        key.emplace_back(n.kind, n.type, n.op, n.a, n.b, n.int_value, n.float_value, n.owner, n.row);
      return key;
    };
    const auto same = std::find_if(made_.states.begin(), made_.states.end(),
                                   [&](const Property& other) { return key_of(other) == key_of(condition); });
    const auto at = static_cast<std::uint32_t>(same - made_.states.begin());
    if (same == made_.states.end()) made_.states.push_back(std::move(condition));
    return add({.kind = FormulaKind::State, .row = at});
  }
  std::uint32_t make_step(const PropertyNode& node) {
    const StepCondition wanted{node.kind == PropertyKind::HappensPort, node.owner,
                               node.kind == PropertyKind::HappensPort ? node.row : 0};
    const auto same = std::find_if(made_.steps.begin(), made_.steps.end(), [&](const StepCondition& other) {
      return other.is_port == wanted.is_port && other.owner == wanted.owner && other.port == wanted.port;
    });
    const auto at = static_cast<std::uint32_t>(same - made_.steps.begin());
    if (same == made_.steps.end()) made_.steps.push_back(wanted);
    return add({.kind = FormulaKind::Step, .row = at});
  }
  // The parser has limited the depth.
  std::uint32_t make(std::uint32_t row) {
    if (is_temporal_[row] == 0) return make_condition(row);
    const PropertyNode& node = parsed_.nodes[row];
    if (node.kind == PropertyKind::HappensConnector || node.kind == PropertyKind::HappensPort) return make_step(node);
    const std::uint32_t a = make(node.a);
    if (node.kind == PropertyKind::Operator) {
      if (node.op == Op::Not) return negate(a);
      BIP_ASSERT(node.op == Op::And || node.op == Op::Or, "operator {} of formulas", node.op);
      const std::uint32_t b = make(node.b);
      return add({.kind = node.op == Op::And ? FormulaKind::And : FormulaKind::Or, .a = a, .b = b});
    }
    const std::uint32_t b = node.b == node.a ? a : make(node.b);
    switch (node.temporal) {
      case TemporalOperator::Always: return always(a);
      case TemporalOperator::Never: return always(negate(a));
      case TemporalOperator::Eventually: return eventually(a);
      case TemporalOperator::Next: return add({.kind = FormulaKind::Next, .a = a, .b = a});
      case TemporalOperator::LeadsTo: return always(add({.kind = FormulaKind::Or, .a = negate(a), .b = eventually(b)}));
      case TemporalOperator::Until: return add({.kind = FormulaKind::Until, .a = a, .b = b});
      // a W b is b R (a || b).
      case TemporalOperator::Unless:
        return add({.kind = FormulaKind::Release, .a = b, .b = add({.kind = FormulaKind::Or, .a = a, .b = b})});
    }
    BIP_UNREACHABLE("a temporal operator");
  }

  const Property& parsed_;
  const std::vector<std::uint8_t>& is_temporal_;  // by node
  Formula made_;
  std::map<std::tuple<FormulaKind, bool, std::uint32_t, std::uint32_t, std::uint32_t>, std::uint32_t> rows_;
};

}  // namespace

Result<Formula> make_formula(const Property& parsed, const std::vector<std::uint8_t>& is_temporal) {
  return FormulaMaker(parsed, is_temporal).run();
}

bool holds_on_lasso(const Formula& formula, const std::vector<std::uint64_t>& states,
                    const std::vector<std::uint64_t>& steps, std::size_t cycle) {
  const std::size_t size = states.size();
  BIP_ASSERT(size == steps.size() && cycle < size, "a cycle from {} of {} positions", cycle, size);
  const auto after = [&](std::size_t at) { return at + 1 < size ? at + 1 : cycle; };
  std::vector<std::vector<std::uint8_t>> holds(formula.nodes.size(), std::vector<std::uint8_t>(size, 0));
  for (std::size_t row = 0; row < formula.nodes.size(); ++row) {
    const FormulaNode& node = formula.nodes[row];
    std::vector<std::uint8_t>& value = holds[row];
    const std::vector<std::uint8_t>&a = holds[node.a], &b = holds[node.b];
    // Fixpoints: least for Until, greatest for Release. A second round carries values once around the cycle.
    if (node.kind == FormulaKind::Release) std::fill(value.begin(), value.end(), std::uint8_t{1});
    for (int round = 0; round < 2; ++round) {
      for (std::size_t at = size; at-- > 0;) {
        bool is = false;
        switch (node.kind) {
          case FormulaKind::Constant: is = node.value; break;
          case FormulaKind::State: is = (states[at] >> node.row & 1) != 0; break;
          case FormulaKind::Step: is = (steps[at] >> node.row & 1) != 0; break;
          case FormulaKind::Not: is = a[at] == 0; break;
          case FormulaKind::And: is = a[at] != 0 && b[at] != 0; break;
          case FormulaKind::Or: is = a[at] != 0 || b[at] != 0; break;
          case FormulaKind::Next: is = a[after(at)] != 0; break;
          case FormulaKind::Until: is = b[at] != 0 || (a[at] != 0 && value[after(at)] != 0); break;
          case FormulaKind::Release: is = b[at] != 0 && (a[at] != 0 || value[after(at)] != 0); break;
        }
        value[at] = is ? 1 : 0;
      }
    }
  }
  return holds[formula.root][0] != 0;
}

}  // namespace bip::verify
