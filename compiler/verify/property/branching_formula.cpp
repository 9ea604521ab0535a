// Formulas of branching time from parsed properties (branching_formula.hpp).
#include "compiler/verify/property/branching_formula.hpp"

#include <map>
#include <optional>
#include <string_view>
#include <tuple>

#include "compiler/model/operators.hpp"
#include "compiler/verify/property/condition_table.hpp"
#include "compiler/verify/property/make_formula.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

Quantifier dual(Quantifier q) { return q == Quantifier::All ? Quantifier::Some : Quantifier::All; }

class BranchingMaker {
 public:
  BranchingMaker(const Property& parsed, const std::vector<std::uint8_t>& is_temporal,
                 const std::vector<TextExtent>& extents)
      : parsed_(parsed), is_temporal_(is_temporal), extents_(extents), conditions_(parsed) {
    BIP_ASSERT(is_temporal.size() == parsed.nodes.size() && extents.size() == parsed.nodes.size(), "{} of {} nodes",
               is_temporal.size(), parsed.nodes.size());
    made_.text = parsed.text;
  }

  Result<BranchingFormula> run() {
    made_.root = make(parsed_.root, Sign::Plain);
    made_.negation = negation();
    made_.states = conditions_.take();
    if (problem_.empty() && made_.states.size() > kMaxConditions)
      problem_ = "the property has more than " + std::to_string(kMaxConditions) + " conditions";
    if (!problem_.empty()) return Failure{problem_};
    return std::move(made_);
  }

 private:
  enum class Sign : std::uint8_t { Plain, Negated };
  static Sign opposite(Sign sign) { return sign == Sign::Plain ? Sign::Negated : Sign::Plain; }

  // Equal nodes share a row, and the text of the first one.
  std::uint32_t add(BranchingNode node) {
    const auto key = std::make_tuple(node.kind, node.quantifier, node.value, node.a, node.b, node.row);
    const auto [at, is_new] = rows_.try_emplace(key, static_cast<std::uint32_t>(made_.nodes.size()));
    if (is_new) made_.nodes.push_back(std::move(node));
    return at->second;
  }
  std::uint32_t constant(bool value) { return add({.kind = BranchingKind::Constant, .value = value}); }
  void set_problem(std::uint32_t row, const std::string& why) {
    if (problem_.empty()) problem_ = "column " + std::to_string(extents_[row].begin + 1) + ": " + why;
  }
  [[nodiscard]] std::string text_of(std::uint32_t row) const {
    return parsed_.text.substr(extents_[row].begin, extents_[row].end - extents_[row].begin);
  }
  // The text behind a word that stands in front, without parentheses around all of it.
  [[nodiscard]] std::string operand_of(std::uint32_t row, std::string_view word = "possibly") const {
    constexpr std::string_view kBlanks = " \t\n";
    std::string text = text_of(row).substr(word.size());
    for (;;) {
      text = text.substr(text.find_first_not_of(kBlanks));
      text = text.substr(0, text.find_last_not_of(kBlanks) + 1);
      if (text.front() != '(' || closing(text) + 1 != text.size()) return text;
      text = text.substr(1, text.size() - 2);
    }
  }
  // Where the parenthesis that begins the text is closed.
  [[nodiscard]] static std::size_t closing(const std::string& text) {
    int open = 0;
    bool is_in_string = false;
    for (std::size_t at = 0; at < text.size(); ++at) {
      if (text[at] == '"') is_in_string = !is_in_string;
      if (is_in_string) continue;
      if (text[at] == '(') ++open;
      if (text[at] == ')' && --open == 0) return at;
    }
    return text.size();
  }
  // Has the formula a word that no `possibly` before it makes one of some run?
  [[nodiscard]] bool has_bare_word(std::uint32_t row) const {
    if (is_temporal_[row] == 0) return false;
    BIP_ASSERT(row < parsed_.nodes.size(), "node {} of {}", row, parsed_.nodes.size());
    const PropertyNode& node = parsed_.nodes[row];
    if (node.kind != PropertyKind::Operator) return node.temporal != TemporalOperator::Possibly;
    return has_bare_word(node.a) || (node.b != node.a && has_bare_word(node.b));
  }

  // Of `possibly` before one word at most, whose operands are conditions on states.
  [[nodiscard]] std::string negation() const {
    const PropertyNode& root = parsed_.nodes[parsed_.root];
    if (root.kind != PropertyKind::Temporal || root.temporal != TemporalOperator::Possibly) return {};
    const auto before = [](const char* words, const std::string& operand) { return words + ('(' + operand + ')'); };
    if (is_temporal_[root.a] == 0) return before("never ", operand_of(parsed_.root));
    const PropertyNode& path = parsed_.nodes[root.a];
    if (path.kind != PropertyKind::Temporal || is_temporal_[path.a] != 0 || is_temporal_[path.b] != 0) return {};
    switch (path.temporal) {
      case TemporalOperator::Eventually: return before("never ", operand_of(root.a, "eventually"));
      case TemporalOperator::Always: return before("eventually !", operand_of(root.a, "always"));
      case TemporalOperator::Never: return before("eventually ", operand_of(root.a, "never"));
      case TemporalOperator::Next:
      case TemporalOperator::Until:
      case TemporalOperator::Unless: return before("!", operand_of(parsed_.root));
      case TemporalOperator::LeadsTo:
      case TemporalOperator::Previously:
      case TemporalOperator::Once:
      case TemporalOperator::Historically:
      case TemporalOperator::Since:
      case TemporalOperator::Possibly: return {};
    }
    BIP_UNREACHABLE("a word of no kind");
  }

  // The parser has limited the depth.
  std::uint32_t make(std::uint32_t row, Sign sign) {
    const PropertyNode& node = parsed_.nodes[row];
    if (is_temporal_[row] == 0) {
      if (node.kind == PropertyKind::Constant) return constant((node.int_value != 0) == (sign == Sign::Plain));
      return add({.kind = sign == Sign::Plain ? BranchingKind::State : BranchingKind::NotState,
                  .row = conditions_.row_of(row)});
    }
    if (node.kind == PropertyKind::Operator) {
      if (node.op == Op::Not) return make(node.a, opposite(sign));
      BIP_ASSERT(node.op == Op::And || node.op == Op::Or, "operator {} of formulas", node.op);
      const bool is_and = (node.op == Op::And) == (sign == Sign::Plain);
      const std::uint32_t a = make(node.a, sign);
      return add({.kind = is_and ? BranchingKind::And : BranchingKind::Or, .a = a, .b = make(node.b, sign)});
    }
    BIP_ASSERT(node.kind == PropertyKind::Temporal, "what happens has no form in branching time");
    if (node.temporal != TemporalOperator::Possibly)
      return make_path(Quantifier::All, row, sign, "has `" + text_of(row) + '`');
    const PropertyNode& operand = parsed_.nodes[node.a];
    if (!has_bare_word(node.a))
      return until(Quantifier::Some, constant_of(true, sign), make(node.a, sign), sign,
                   "reaches `" + operand_of(row) + '`');
    if (operand.kind == PropertyKind::Temporal)
      return make_path(Quantifier::Some, node.a, sign, "has `" + operand_of(row) + '`');
    const std::string symbol(symbol_of(operand.op));
    const std::string inside = operand.op == Op::Not ? "!…" : "… " + symbol + " …";
    set_problem(row, "`possibly` cannot ask for one run by several words of it: write `possibly eventually (" + inside +
                         ")`, where each of them asks for all runs, or `possibly` before each word");
    return constant(false);
  }
  // The constant as an operand that was negated with its operator.
  std::uint32_t constant_of(bool value, Sign sign) { return constant(value == (sign == Sign::Plain)); }

  // Operands are negated already; so is the operator, by its dual.
  std::uint32_t quantified(BranchingKind kind, Quantifier q, std::uint32_t a, std::uint32_t b, Sign sign,
                           const std::string& of_run) {
    if (sign == Sign::Negated) {
      q = dual(q);
      if (kind != BranchingKind::Next)
        kind = kind == BranchingKind::Until ? BranchingKind::Release : BranchingKind::Until;
    }
    return add({.kind = kind, .quantifier = q, .is_negation = sign == Sign::Negated, .a = a, .b = b, .of_run = of_run});
  }
  std::uint32_t until(Quantifier q, std::uint32_t a, std::uint32_t b, Sign sign, const std::string& of_run) {
    return quantified(BranchingKind::Until, q, a, b, sign, of_run);
  }
  std::uint32_t release(Quantifier q, std::uint32_t a, std::uint32_t b, Sign sign, const std::string& of_run) {
    return quantified(BranchingKind::Release, q, a, b, sign, of_run);
  }
  std::uint32_t disjunction(std::uint32_t a, std::uint32_t b, Sign sign) {
    return add({.kind = sign == Sign::Plain ? BranchingKind::Or : BranchingKind::And, .a = a, .b = b});
  }
  std::uint32_t make_path(Quantifier q, std::uint32_t row, Sign sign, const std::string& of_run) {
    const PropertyNode& node = parsed_.nodes[row];
    switch (node.temporal) {
      case TemporalOperator::Always: return release(q, constant_of(false, sign), make(node.a, sign), sign, of_run);
      case TemporalOperator::Never:
        return release(q, constant_of(false, sign), make(node.a, opposite(sign)), sign, of_run);
      case TemporalOperator::Eventually: return until(q, constant_of(true, sign), make(node.a, sign), sign, of_run);
      case TemporalOperator::Next: {
        const std::uint32_t a = make(node.a, sign);
        return quantified(BranchingKind::Next, q, a, a, sign, of_run);
      }
      case TemporalOperator::Until: {
        const std::uint32_t a = make(node.a, sign);
        return until(q, a, make(node.b, sign), sign, of_run);
      }
      // a W b is b R (a || b).
      case TemporalOperator::Unless: {
        const std::uint32_t a = make(node.a, sign), b = make(node.b, sign);
        return release(q, b, disjunction(a, b, sign), sign, of_run);
      }
      case TemporalOperator::LeadsTo: {
        if (q == Quantifier::Some) {
          set_problem(row,
                      "`possibly (… leads to …)` asks for one run by two words of it: write `possibly always (… "
                      "implies possibly …)` or `possibly always (… implies eventually …)`");
          return constant(false);
        }
        const std::uint32_t answer = until(q, constant_of(true, sign), make(node.b, sign), sign, {});
        return release(q, constant_of(false, sign), disjunction(make(node.a, opposite(sign)), answer, sign), sign,
                       of_run);
      }
      case TemporalOperator::Previously:
      case TemporalOperator::Once:
      case TemporalOperator::Historically:
      case TemporalOperator::Since:
      case TemporalOperator::Possibly: break;
    }
    BIP_UNREACHABLE("a word of one path");
  }

  const Property& parsed_;
  const std::vector<std::uint8_t>& is_temporal_;  // by node
  const std::vector<TextExtent>& extents_;        // by node
  ConditionTable conditions_;
  BranchingFormula made_;
  std::string problem_;
  std::map<std::tuple<BranchingKind, Quantifier, bool, std::uint32_t, std::uint32_t, std::uint32_t>, std::uint32_t>
      rows_;
};

}  // namespace

Result<BranchingFormula> make_branching(const Property& parsed, const std::vector<std::uint8_t>& is_temporal,
                                        const std::vector<TextExtent>& extents) {
  return BranchingMaker(parsed, is_temporal, extents).run();
}

std::optional<std::string> certificate_text(const BranchingFormula& formula, const System& system) {
  constexpr std::size_t kMostBytes = 1'000'000;
  BIP_ASSERT(formula.root < formula.nodes.size(), "node {} of {} is the root", formula.root, formula.nodes.size());
  std::vector<std::string> texts;  // by node
  for (const BranchingNode& node : formula.nodes) {
    const auto condition = [&] {
      Property made = formula.states[node.row];
      made.is_never = true;
      return certificate_text(made, system);
    };
    const auto binary = [&](const std::string& name) {
      return '(' + name + ' ' + texts[node.a] + ' ' + texts[node.b] + ')';
    };
    const std::string quantifier = node.quantifier == Quantifier::All ? "all-" : "some-";
    const auto text = [&]() -> std::string {
      switch (node.kind) {
        case BranchingKind::Constant: return node.value ? "true" : "false";
        case BranchingKind::State: return condition();
        case BranchingKind::NotState: return "(not " + condition() + ')';
        case BranchingKind::And: return binary("and");
        case BranchingKind::Or: return binary("or");
        case BranchingKind::Next: return '(' + quantifier + "next " + texts[node.a] + ')';
        case BranchingKind::Until: return binary(quantifier + "until");
        case BranchingKind::Release: return binary(quantifier + "release");
      }
      BIP_UNREACHABLE("a formula of no kind");
    };
    texts.push_back(text());
    if (texts.back().size() > kMostBytes) return std::nullopt;
  }
  return texts[formula.root];
}

}  // namespace bip::verify
