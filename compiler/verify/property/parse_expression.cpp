// Parses the expressions of properties by precedence climbing (Richards, Whitby-Strevens 1979).
#include "compiler/model/fold.hpp"
#include "compiler/model/operators.hpp"
#include "compiler/verify/property/binary_operators.hpp"
#include "compiler/verify/property/property_parser.hpp"

namespace bip::verify {

std::uint32_t PropertyParser::parse_operand(int depth) {
  if (depth > kMaxPropertyDepth) {
    set_problem("nested too deeply");
    return 0;
  }
  skip_blanks();
  const std::size_t start = at_;
  if (take_sign("(")) {
    const std::uint32_t inside = accepts_formulas_ ? parse_formula(depth + 1) : parse_expression(1, depth + 1);
    if (!take_sign(")")) {
      set_problem(word_at(at_) == "under" ? "`under` stands behind a whole property" : "a `)` is missing");
    }
    return inside;
  }
  if (take_sign("!")) return make_unary(Op::Not, parse_operand(depth + 1), start);
  if (take_sign("~")) return make_unary(Op::BitNot, parse_operand(depth + 1), start);
  if (take_sign("-")) return make_unary(Op::Neg, parse_operand(depth + 1), start);
  if (take_sign("\"")) return parse_string();
  if (is_at_number()) return parse_number();
  if (accepts_formulas_ && is_misplaced()) return 0;
  if (const std::optional<IndexQuantifier> quantifier = take_quantifier()) return parse_quantified(*quantifier, depth);
  if (!problem_.empty()) return 0;
  const std::string name = parse_path();
  if (!problem_.empty()) return 0;
  if (const std::optional<std::int64_t> value = bound_.value_of(name); value && !is_next('@'))
    return constant(Type::Int, static_cast<std::int32_t>(*value));
  if (name == "true" || name == "false") return add({.int_value = name == "true" ? 1 : 0});
  if (name == "can") return parse_offer(start, PropertyKind::CanConnector, PropertyKind::CanPort);
  if (accepts_formulas_ && name == "happens" && !is_next('@'))
    return parse_offer(start, PropertyKind::HappensConnector, PropertyKind::HappensPort);
  if (name.empty()) {
    set_problem(at_ == text_.size() ? "the property ends too early" : "a value was expected here");
    return 0;
  }
  return parse_reference(name, start);
}

std::uint32_t PropertyParser::make_unary(Op op, std::uint32_t a, std::size_t start) {
  const bool fits = takes(info_of(op).operands, type(a));
  if (!fits && problem_.empty()) {
    at_ = start;
    set_problem(op == Op::Not      ? "`!` needs a truth value"
                : op == Op::BitNot ? "`~` needs an int"
                                   : "`-` needs a number");
  }
  if (fits && is_folded(a)) return constant(type(a), fold_int(op, property_.nodes[a].int_value));
  return add({.kind = PropertyKind::Operator, .type = type(a), .op = op, .a = a, .b = a});
}

std::uint32_t PropertyParser::parse_expression(int level, int depth) {
  const std::size_t mark = property_.nodes.size();
  std::uint32_t left = parse_operand(depth);
  while (problem_.empty()) {
    skip_blanks();
    const std::size_t start = at_;
    // No subtraction of what is greater.
    if (accepts_formulas_ && (text_.compare(at_, 2, "->") == 0 || text_.compare(at_, 3, "-->") == 0)) return left;
    const BinaryOperator* found = nullptr;
    for (const BinaryOperator& binary : binary_operators()) {
      if (found == nullptr && text_.compare(at_, binary.sign.size(), binary.sign) == 0) found = &binary;
    }
    if (found == nullptr || found->level < level) return left;
    at_ += found->sign.size();
    const bool was_beside_text = is_beside_text_;
    is_beside_text_ = family_of(found->op) == OpFamily::Equality && type(left) == Type::String;
    const std::uint32_t right = parse_expression(found->level + 1, depth + 1);
    is_beside_text_ = was_beside_text;
    if (!problem_.empty()) return left;
    left = make_binary(*found, left, right, start, mark);
  }
  return left;
}

std::uint32_t PropertyParser::make_binary(const BinaryOperator& binary, std::uint32_t a, std::uint32_t b,
                                          std::size_t start, std::size_t mark) {
  const bool numbers = is_numeric(type(a)) && is_numeric(type(b));
  const OperandTypes operands = info_of(binary.op).operands;
  if (problem_.empty() && binary.op != Op::And && binary.op != Op::Or && (is_temporal(a) || is_temporal(b))) {
    at_ = start;
    set_problem("`" + std::string(binary.sign) + "` compares values of one state, not what happens in a run");
  }
  const bool fits = operands == OperandTypes::Native ? numbers || type(a) == type(b)
                                                     : takes(operands, type(a)) && takes(operands, type(b));
  const bool is_float = type(a) == Type::Float || type(b) == Type::Float;
  const Type result = result_of(binary.op, is_float ? Type::Float : Type::Int);
  if (!fits && problem_.empty()) {
    at_ = start;
    set_problem("`" + std::string(binary.sign) + "` does not take " + name_of(type(a)) + " and " + name_of(type(b)) +
                hint_of(binary.op, property_.nodes[a]));
  }
  if (is_division(binary.op) && result == Type::Int && problem_.empty()) {
    const std::optional<std::int32_t> divisor = constant_of(b);
    if (!divisor || *divisor == 0 || *divisor == -1) division_at_ = start;
  }
  if (binary.op == Op::And || binary.op == Op::Or) return join(binary.op, a, b, mark);
  if (problem_.empty() && is_folded(a) && is_folded(b) && type(a) == Type::Int) {
    const std::int32_t left = property_.nodes[a].int_value, right = property_.nodes[b].int_value;
    if (!is_division(binary.op) || !division_faults(left, right)) {
      forget_from(mark);
      return constant(result, fold_int(binary.op, left, right));
    }
  }
  return add({.kind = PropertyKind::Operator, .type = result, .op = binary.op, .a = a, .b = b});
}

}  // namespace bip::verify
