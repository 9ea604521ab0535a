// See operators.hpp.
#include "compiler/genom/operators.hpp"

#include <algorithm>
#include <iterator>

namespace bip::genom {
namespace {

constexpr BinaryOperator kOperators[] = {
    {"||", Precedence::LogicalOr},  {"&&", Precedence::LogicalAnd}, {"|", Precedence::Or},
    {"^", Precedence::Xor},         {"&", Precedence::And},         {"==", Precedence::Equality},
    {"!=", Precedence::Equality},   {"<", Precedence::Comparison},  {">", Precedence::Comparison},
    {"<=", Precedence::Comparison}, {">=", Precedence::Comparison}, {"<<", Precedence::Shift},
    {">>", Precedence::Shift},      {"+", Precedence::Sum},         {"-", Precedence::Sum},
    {"*", Precedence::Product},     {"/", Precedence::Product},     {"%", Precedence::Product}};

}  // namespace

BinaryOperator binary_operator_at(const Token& first, const Token& second) {
  if (first.kind != TokenKind::Sign) return {};
  std::string_view text = first.text;
  const bool is_angle = text == "<" || text == ">";
  if (is_angle && second.is(text) && second.range.begin == first.range.end) text = text == "<" ? "<<" : ">>";
  const auto found = std::find_if(std::begin(kOperators), std::end(kOperators),
                                  [text](const BinaryOperator& op) { return op.text == text; });
  return found == std::end(kOperators) ? BinaryOperator{} : *found;
}

}  // namespace bip::genom
