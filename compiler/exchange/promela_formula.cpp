// See promela_formula.hpp. Linear in the formula; shared parts are written again.
#include "compiler/exchange/promela_formula.hpp"

#include <vector>

#include <fmt/format.h>

#include "compiler/model/operators.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::exchange {

namespace {

using verify::FormulaKind;
using verify::FormulaNode;
using verify::Property;
using verify::PropertyKind;
using verify::PropertyNode;

// A condition on a state. `wrong`: what Promela lacks.
std::string condition_text(const Property& condition, const ConditionNames& names, std::string& wrong) {
  std::vector<std::string> texts;
  for (const PropertyNode& node : condition.nodes) {
    if (node.type == Type::Float || is_ffi(node.type)) wrong = "the property reads a float or a C++ object";
    std::string text;
    switch (node.kind) {
      case PropertyKind::Constant:
        text = node.type == Type::Bool ? node.int_value != 0 ? "true" : "false" : fmt::format("({})", node.int_value);
        break;
      case PropertyKind::At: text = names.marked(AtomId(node.owner), node.row); break;
      case PropertyKind::Data: text = names.variable(AtomId(node.owner), node.row); break;
      case PropertyKind::CanPort: text = names.can_port(AtomId(node.owner), node.row); break;
      case PropertyKind::CanConnector: text = names.can_connector(ConnectorId(node.owner)); break;
      case PropertyKind::Operator:
        text = family_of(node.op) == OpFamily::Sign
                   ? fmt::format("({}{})", symbol_of(node.op), texts[node.a])
                   : fmt::format("({} {} {})", texts[node.a], symbol_of(node.op), texts[node.b]);
        break;
      case PropertyKind::HappensConnector:
      case PropertyKind::HappensPort:
      case PropertyKind::Temporal: BIP_UNREACHABLE("a condition on a state");
    }
    texts.push_back(std::move(text));
  }
  return texts[condition.root];
}

// Is a condition or `next` reached by operators of a point alone?
bool speaks_of_first_point(const verify::Formula& formula, std::uint32_t row) {
  const FormulaNode& node = formula.nodes[row];
  switch (node.kind) {
    case FormulaKind::State:
    case FormulaKind::Step:
    case FormulaKind::Next: return true;
    case FormulaKind::Not: return speaks_of_first_point(formula, node.a);
    case FormulaKind::And:
    case FormulaKind::Or: return speaks_of_first_point(formula, node.a) || speaks_of_first_point(formula, node.b);
    case FormulaKind::Constant:
    case FormulaKind::Until:
    case FormulaKind::Release:
    case FormulaKind::Previously:
    case FormulaKind::Since: break;
  }
  return false;
}

}  // namespace

Result<std::string> ltl_text(const verify::Formula& formula, const ConditionNames& names, const PromelaRuns& runs,
                             std::string& macros) {
  std::string wrong;
  for (std::size_t k = 0; k < formula.states.size(); ++k)
    macros += fmt::format("#define c{} ({})\n", k, condition_text(formula.states[k], names, wrong));
  std::vector<std::string> texts;
  constexpr std::size_t kLongest = 1 << 16;
  for (const FormulaNode& node : formula.nodes) {
    const auto left = [&] { return texts[node.a]; };
    const auto right = [&] { return texts[node.b]; };
    std::string text;
    switch (node.kind) {
      case FormulaKind::Constant: text = node.value ? "true" : "false"; break;
      case FormulaKind::State: text = fmt::format("c{}", node.row); break;
      case FormulaKind::Step: text = runs.happens(formula.steps[node.row]); break;
      case FormulaKind::Not: text = fmt::format("(! {})", left()); break;
      case FormulaKind::And: text = fmt::format("({} && {})", left(), right()); break;
      case FormulaKind::Or: text = fmt::format("({} || {})", left(), right()); break;
      case FormulaKind::Previously:
      case FormulaKind::Since:
        wrong = "`previously`, `once`, `historically` and `since`: its formulas look ahead";
        break;
      case FormulaKind::Next: text = runs.next(left()); break;
      case FormulaKind::Until:
        text = left() == "true" ? fmt::format("(<> (at && {}))", right())
                                : fmt::format("(((! at) || {}) U (at && {}))", left(), right());
        break;
      case FormulaKind::Release:
        text = left() == "false" ? fmt::format("([] ((! at) || {}))", right())
                                 : fmt::format("((at && {}) V ((! at) || {}))", left(), right());
        break;
    }
    if (text.size() > kLongest) return Failure{"a property of this size"};
    texts.push_back(std::move(text));
  }
  if (!wrong.empty()) return Failure{wrong};
  // `[]`, `<>`, `U` and `V` find the first point by themselves.
  if (!speaks_of_first_point(formula, formula.root)) return texts[formula.root];
  return fmt::format("((! at) U (at && {}))", texts[formula.root]);
}

}  // namespace bip::exchange
