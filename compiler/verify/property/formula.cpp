// Formulas from parsed properties, and their meaning on a run that ends in a cycle (formula.hpp).
#include "compiler/verify/property/formula.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "compiler/system/system.hpp"
#include "compiler/verify/property/condition_table.hpp"
#include "compiler/verify/property/make_formula.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class FormulaMaker {
 public:
  FormulaMaker(const Property& parsed, const std::vector<std::uint8_t>& is_temporal)
      : parsed_(parsed), is_temporal_(is_temporal), conditions_(parsed) {
    BIP_ASSERT(is_temporal.size() == parsed.nodes.size(), "{} of {} nodes", is_temporal.size(), parsed.nodes.size());
    made_.text = parsed.text;
  }

  Result<Formula> run(std::optional<std::int64_t> within) {
    made_.root = make(parsed_.root);
    made_.response = response_of(parsed_.root);
    made_.states = conditions_.take();
    BIP_ASSERT(!within || made_.response, "a limit of time of no response");
    if (within) made_.response->within = within;
    const auto past = std::count_if(made_.nodes.begin(), made_.nodes.end(),
                                    [](const FormulaNode& node) { return looks_back(node.kind); });
    if (made_.states.size() + made_.steps.size() + static_cast<std::size_t>(past) > kMaxConditions)
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
  std::uint32_t once(std::uint32_t a) { return add({.kind = FormulaKind::Since, .a = constant(true), .b = a}); }

  std::uint32_t make_condition(std::uint32_t row) {
    const PropertyNode& node = parsed_.nodes[row];
    if (node.kind == PropertyKind::Constant) return constant(node.int_value != 0);
    const std::uint32_t at = conditions_.row_of(row);
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
  // Without words of time, which speak of other points.
  [[nodiscard]] bool is_of_one_point(std::uint32_t row) const {
    const PropertyNode& node = parsed_.nodes[row];
    if (is_temporal_[row] == 0) return true;
    if (node.kind != PropertyKind::Operator) return node.kind != PropertyKind::Temporal;
    return is_of_one_point(node.a) && (node.b == node.a || is_of_one_point(node.b));
  }
  // Its nodes are those that the formula has already.
  std::optional<Formula::Response> response_of(std::uint32_t row) {
    const PropertyNode& node = parsed_.nodes[row];
    if (node.kind != PropertyKind::Temporal) return std::nullopt;
    if (node.temporal == TemporalOperator::Always) {
      const std::optional<Formula::Response> inner = response_of(node.a);
      if (!inner || !inner->asks_once) return inner;
      return Formula::Response{false, constant(true), inner->response, {}};
    }
    const bool asks_once = node.temporal == TemporalOperator::Eventually;
    if ((!asks_once && node.temporal != TemporalOperator::LeadsTo) || !is_of_one_point(node.a) ||
        !is_of_one_point(node.b))
      return std::nullopt;
    return Formula::Response{asks_once, make(node.a), make(node.b), {}};
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
      case TemporalOperator::Previously: return add({.kind = FormulaKind::Previously, .a = a, .b = a});
      case TemporalOperator::Once: return once(a);
      case TemporalOperator::Historically: return negate(once(negate(a)));
      case TemporalOperator::Since: return add({.kind = FormulaKind::Since, .a = a, .b = b});
      // a W b is b R (a || b).
      case TemporalOperator::Unless:
        return add({.kind = FormulaKind::Release, .a = b, .b = add({.kind = FormulaKind::Or, .a = a, .b = b})});
      case TemporalOperator::Possibly: break;
    }
    BIP_UNREACHABLE("a temporal operator");
  }

  const Property& parsed_;
  const std::vector<std::uint8_t>& is_temporal_;  // by node
  ConditionTable conditions_;
  Formula made_;
  std::map<std::tuple<FormulaKind, bool, std::uint32_t, std::uint32_t, std::uint32_t>, std::uint32_t> rows_;
};

}  // namespace

Result<Formula> make_formula(const Property& parsed, const std::vector<std::uint8_t>& is_temporal,
                             std::optional<std::int64_t> within) {
  return FormulaMaker(parsed, is_temporal).run(within);
}

bool is_invariant_of_past(const Formula& formula) {
  BIP_ASSERT(formula.root < formula.nodes.size(), "node {} of {} is the root", formula.root, formula.nodes.size());
  const FormulaNode& root = formula.nodes[formula.root];
  if (root.kind != FormulaKind::Release) return false;
  const FormulaNode& left = formula.nodes[root.a];
  if (left.kind != FormulaKind::Constant || left.value) return false;
  std::vector<std::uint8_t> is_reached(formula.nodes.size(), 0);
  is_reached[root.b] = 1;
  bool has_past = false;
  for (std::size_t row = formula.nodes.size(); row-- > 0;) {
    if (is_reached[row] == 0) continue;
    const FormulaNode& node = formula.nodes[row];
    if (looks_ahead(node.kind)) return false;
    has_past = has_past || looks_back(node.kind);
    const bool is_leaf =
        node.kind == FormulaKind::Constant || node.kind == FormulaKind::State || node.kind == FormulaKind::Step;
    if (!is_leaf) is_reached[node.a] = is_reached[node.b] = 1;
  }
  return has_past;
}

namespace {

// How many operators that look back lie within each other.
std::size_t depth_of_past(const Formula& formula) {
  std::vector<std::size_t> depth(formula.nodes.size(), 0);
  std::size_t most = 0;
  for (std::size_t row = 0; row < formula.nodes.size(); ++row) {
    const FormulaNode& node = formula.nodes[row];
    const bool is_leaf =
        node.kind == FormulaKind::Constant || node.kind == FormulaKind::State || node.kind == FormulaKind::Step;
    if (is_leaf) continue;
    depth[row] = std::max(depth[node.a], depth[node.b]) + (looks_back(node.kind) ? 1 : 0);
    most = std::max(most, depth[row]);
  }
  return most;
}

}  // namespace

std::optional<std::string> certificate_text(const Formula& formula, const System& system) {
  constexpr std::size_t kMostBytes = 1'000'000;
  std::vector<std::string> texts;  // by node
  for (const FormulaNode& node : formula.nodes) {
    const auto unary = [&](const char* name) { return '(' + std::string(name) + ' ' + texts[node.a] + ')'; };
    const auto binary = [&](const char* name) {
      return '(' + std::string(name) + ' ' + texts[node.a] + ' ' + texts[node.b] + ')';
    };
    const auto text = [&]() -> std::string {
      switch (node.kind) {
        case FormulaKind::Constant: return node.value ? "true" : "false";
        case FormulaKind::State: {
          Property condition = formula.states[node.row];
          condition.is_never = true;
          return certificate_text(condition, system);
        }
        case FormulaKind::Step: {
          const StepCondition& step = formula.steps[node.row];
          if (!step.is_port) return "(happens " + system.connectors[ConnectorId(std::size_t{step.owner})].path + ')';
          const Atom& atom = system.atoms[AtomId(std::size_t{step.owner})];
          return "(happens-port " + atom.path + ' ' + system.atom_types[atom.type].ports[step.port].name + ')';
        }
        case FormulaKind::Not: return unary("not");
        case FormulaKind::And: return binary("and");
        case FormulaKind::Or: return binary("or");
        case FormulaKind::Next: return unary("next");
        case FormulaKind::Until: return binary("until");
        case FormulaKind::Release: return binary("release");
        case FormulaKind::Previously: return unary("previously");
        case FormulaKind::Since: return binary("since");
      }
      BIP_UNREACHABLE("a formula of no kind");
    };
    texts.push_back(text());
    if (texts.back().size() > kMostBytes) return std::nullopt;
  }
  return texts[formula.root];
}

bool holds_at_last(const Formula& formula, std::uint32_t row, const std::vector<std::uint64_t>& states,
                   const std::vector<std::uint64_t>& steps) {
  BIP_ASSERT(states.size() == steps.size() && !states.empty(), "{} states, {} steps", states.size(), steps.size());
  BIP_ASSERT(row < formula.nodes.size(), "node {} of {}", row, formula.nodes.size());
  std::vector<std::uint8_t> before(row + 1, 0), value(row + 1, 0);
  for (std::size_t at = 0; at < states.size(); ++at) {
    before.swap(value);
    for (std::uint32_t k = 0; k <= row; ++k) {
      const FormulaNode& node = formula.nodes[k];
      const auto holds = [&] {
        switch (node.kind) {
          case FormulaKind::Constant: return node.value;
          case FormulaKind::State: return (states[at] >> node.row & 1) != 0;
          case FormulaKind::Step: return (steps[at] >> node.row & 1) != 0;
          case FormulaKind::Not: return value[node.a] == 0;
          case FormulaKind::And: return value[node.a] != 0 && value[node.b] != 0;
          case FormulaKind::Or: return value[node.a] != 0 || value[node.b] != 0;
          case FormulaKind::Previously: return at != 0 && before[node.a] != 0;
          case FormulaKind::Since: return value[node.b] != 0 || (at != 0 && value[node.a] != 0 && before[k] != 0);
          // Not below a node that looks back only.
          case FormulaKind::Next:
          case FormulaKind::Until:
          case FormulaKind::Release: return false;
        }
        BIP_UNREACHABLE("a formula of no kind");
      };
      value[k] = holds() ? 1 : 0;
    }
  }
  return value[row] != 0;
}

bool holds_on_lasso(const Formula& formula, const std::vector<std::uint64_t>& states,
                    const std::vector<std::uint64_t>& steps, std::size_t cycle) {
  BIP_ASSERT(states.size() == steps.size() && cycle < states.size(), "a cycle from {} of {} positions", cycle,
             states.size());
  // What looks back may differ from round to round, but each operator settles within one more round: over a round
  // `since` is a monotone function of one bit, and twice such a function is once. So the rounds before go to the stem.
  const std::size_t length = states.size() - cycle;
  const std::size_t size = states.size() + depth_of_past(formula) * length, last_round = size - length;
  const auto position = [&](std::size_t at) { return at < states.size() ? at : cycle + (at - cycle) % length; };
  const auto after = [&](std::size_t at) { return at + 1 < size ? at + 1 : last_round; };
  std::vector<std::vector<std::uint8_t>> holds(formula.nodes.size(), std::vector<std::uint8_t>(size, 0));
  for (std::size_t row = 0; row < formula.nodes.size(); ++row) {
    const FormulaNode& node = formula.nodes[row];
    std::vector<std::uint8_t>& value = holds[row];
    const std::vector<std::uint8_t>&a = holds[node.a], &b = holds[node.b];
    BIP_ASSERT(node.a <= row && node.b <= row, "node {} stands before its operands {} and {}", row, node.a, node.b);
    if (looks_back(node.kind)) {
      for (std::size_t at = 0; at < size; ++at) {
        const bool is_since = b[at] != 0 || (a[at] != 0 && at != 0 && value[at - 1] != 0);
        value[at] = (node.kind == FormulaKind::Since ? is_since : at != 0 && a[at - 1] != 0) ? 1 : 0;
      }
      continue;
    }
    // Fixpoints: least for Until, greatest for Release. A second round carries values once around the cycle.
    if (node.kind == FormulaKind::Release) std::fill(value.begin(), value.end(), std::uint8_t{1});
    for (int round = 0; round < 2; ++round) {
      for (std::size_t at = size; at-- > 0;) {
        bool is = false;
        switch (node.kind) {
          case FormulaKind::Constant: is = node.value; break;
          case FormulaKind::State: is = (states[position(at)] >> node.row & 1) != 0; break;
          case FormulaKind::Step: is = (steps[position(at)] >> node.row & 1) != 0; break;
          case FormulaKind::Not: is = a[at] == 0; break;
          case FormulaKind::And: is = a[at] != 0 && b[at] != 0; break;
          case FormulaKind::Or: is = a[at] != 0 || b[at] != 0; break;
          case FormulaKind::Next: is = a[after(at)] != 0; break;
          case FormulaKind::Until: is = b[at] != 0 || (a[at] != 0 && value[after(at)] != 0); break;
          case FormulaKind::Release: is = b[at] != 0 && (a[at] != 0 || value[after(at)] != 0); break;
          case FormulaKind::Previously:
          case FormulaKind::Since: BIP_UNREACHABLE("an operator of the past");
        }
        value[at] = is ? 1 : 0;
      }
    }
  }
  return holds[formula.root][0] != 0;
}

}  // namespace bip::verify
