// See property_rows.hpp.
#include "compiler/verify/property/property_rows.hpp"

#include "compiler/model/fold.hpp"
#include "compiler/model/operators.hpp"
#include "compiler/verify/property/property_words.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// A chain `a || b || c …` is a tree half as deep as it has nodes; the checker of certificates reads 10,000 levels.
constexpr std::size_t kMaxPropertyNodes = 16'000;
// With what quantifiers write out, which makes the tree wider, not deeper.
constexpr std::size_t kMaxExpandedNodes = 1'000'000;

}  // namespace

std::uint32_t PropertyRows::make_condition(Op op, std::uint32_t a, std::uint32_t b) {
  return add({.kind = PropertyKind::Operator, .op = op, .a = a, .b = b});
}

// Disjunction of two rows, of which either may be missing: false.
std::uint32_t PropertyRows::make_either(std::uint32_t a, std::uint32_t b) {
  if (a == Property::kNoRow || b == Property::kNoRow) return a == Property::kNoRow ? b : a;
  return make_condition(Op::Or, a, b);
}

std::optional<std::int32_t> PropertyRows::constant_of(std::uint32_t row) const {
  const PropertyNode& node = property_.nodes[row];
  if (node.type != Type::Int) return std::nullopt;
  if (node.kind == PropertyKind::Constant) return node.int_value;
  if (node.kind != PropertyKind::Operator || node.op != Op::Neg) return std::nullopt;
  const std::optional<std::int32_t> operand = constant_of(node.a);
  return operand ? std::optional(fold_int(Op::Neg, *operand)) : std::nullopt;
}

// When does this division itself fault? A row, or kNoRow: never.
std::uint32_t PropertyRows::fault_of_division(std::uint32_t a, std::uint32_t b) {
  const std::optional<std::int32_t> divisor = constant_of(b), divided = constant_of(a);
  std::uint32_t fault = Property::kNoRow;
  if (!divisor || *divisor == 0) fault = make_condition(Op::Eq, b, constant(Type::Int, 0));
  const bool may_overflow = (!divisor || *divisor == -1) && (!divided || *divided == INT32_MIN);
  if (!may_overflow) return fault;
  const std::uint32_t is_least = make_condition(Op::Eq, a, constant(Type::Int, INT32_MIN));
  const std::uint32_t is_minus_one = make_condition(Op::Eq, b, constant(Type::Int, -1));
  return make_either(fault, make_condition(Op::And, is_least, is_minus_one));
}

std::uint32_t PropertyRows::fault_of(std::uint32_t row) {
  if (!problem_.empty()) return Property::kNoRow;
  const PropertyNode node = property_.nodes[row];
  if (node.kind != PropertyKind::Operator) return Property::kNoRow;
  const std::uint32_t a = fault_of(node.a);
  if (operand_count(node.op) == 1) return a;
  std::uint32_t b = fault_of(node.b);
  if (b != Property::kNoRow && node.op == Op::And) b = make_condition(Op::And, node.a, b);
  if (b != Property::kNoRow && node.op == Op::Or) {
    const std::uint32_t goes_on = make_not(node.a);
    b = make_condition(Op::And, goes_on, b);
  }
  const std::uint32_t own =
      is_division(node.op) && node.type == Type::Int ? fault_of_division(node.a, node.b) : Property::kNoRow;
  return make_either(make_either(a, b), own);
}

void PropertyRows::guard_divisions() {
  if (!problem_.empty()) return;
  const std::uint32_t whole = property_.root;
  const std::uint32_t fault = fault_of(whole);
  if (fault == Property::kNoRow) return;
  property_.fault = fault;
  if (property_.is_never) {
    property_.root = make_condition(Op::Or, fault, whole);
    return;
  }
  const std::uint32_t is_sound = make_not(fault);
  property_.root = make_condition(Op::And, is_sound, whole);
}

Type PropertyRows::type(std::uint32_t row) const {
  return row < property_.nodes.size() ? property_.nodes[row].type : Type::Bool;
}

std::uint32_t PropertyRows::add(PropertyNode node) {
  BIP_ASSERT(!problem_.empty() || node.kind != PropertyKind::Operator ||
                 (node.a < property_.nodes.size() && node.b < property_.nodes.size()),
             "an operator before its operands");
  if (quantifiers_ == 0 && ++written_ > kMaxPropertyNodes)
    set_problem("the property has more than " + std::to_string(kMaxPropertyNodes) + " values and operators");
  if (property_.nodes.size() >= kMaxExpandedNodes)
    set_problem("written out, the property has more than " + std::to_string(kMaxExpandedNodes) +
                " values and operators");
  const bool joins = node.kind == PropertyKind::Operator && problem_.empty();
  is_temporal_.push_back(node.kind == PropertyKind::HappensConnector || node.kind == PropertyKind::HappensPort ||
                                 node.kind == PropertyKind::Temporal ||
                                 (joins && (is_temporal(node.a) || is_temporal(node.b)))
                             ? 1
                             : 0);
  const bool has_operands = problem_.empty() && (joins || node.kind == PropertyKind::Temporal);
  const bool is_word = node.kind == PropertyKind::Temporal;
  const auto any = [&](const std::vector<std::uint8_t>& of) { return has_operands && (of[node.a] | of[node.b]) != 0; };
  is_of_past_.push_back((is_word && is_of_past(node.temporal)) || any(is_of_past_) ? 1 : 0);
  looks_ahead_.push_back((is_word && !is_of_past(node.temporal)) || any(looks_ahead_) ? 1 : 0);
  extents_.emplace_back();
  property_.nodes.push_back(node);
  return static_cast<std::uint32_t>(property_.nodes.size() - 1);
}

bool PropertyRows::is_folded(std::uint32_t row) const {
  const PropertyNode* const node = !bound_.is_empty() && row < property_.nodes.size() ? &property_.nodes[row] : nullptr;
  return node != nullptr && node->kind == PropertyKind::Constant &&
         (node->type == Type::Int || node->type == Type::Bool);
}

std::uint32_t PropertyRows::constant(Type of_type, std::int32_t value) {
  return add({.type = of_type, .int_value = value});
}

void PropertyRows::forget_from(std::size_t row) {
  BIP_ASSERT(row <= property_.nodes.size() && is_temporal_.size() == property_.nodes.size() &&
                 extents_.size() == property_.nodes.size(),
             "the rows from {} of {} on are forgotten", row, property_.nodes.size());
  property_.nodes.resize(row);
  is_temporal_.resize(row);
  is_of_past_.resize(row);
  looks_ahead_.resize(row);
  extents_.resize(row);
}

std::uint32_t PropertyRows::join(Op op, std::uint32_t a, std::uint32_t b, std::size_t mark) {
  if (!problem_.empty() || !is_folded(a)) return make_condition(op, a, b);
  const bool value = property_.nodes[a].int_value != 0;
  if (value == (op == Op::And)) return b;
  forget_from(mark);
  return constant(Type::Bool, value ? 1 : 0);
}

std::uint32_t PropertyRows::make_not(std::uint32_t a) {
  return add({.kind = PropertyKind::Operator, .op = Op::Not, .a = a, .b = a});
}

std::uint32_t PropertyRows::join_all(IndexQuantifier quantifier, const std::vector<std::uint32_t>& rows,
                                     std::optional<std::int64_t> limit, std::size_t known, bool is_decided,
                                     std::size_t mark) {
  const auto both = [this](std::uint32_t a, std::uint32_t b) { return make_condition(Op::And, a, b); };
  const auto either = [this](std::uint32_t a, std::uint32_t b) { return make_condition(Op::Or, a, b); };
  const auto whole = [&](bool value) {
    forget_from(mark);
    return constant(Type::Bool, value ? 1 : 0);
  };
  // At least so many of the rows, or false, or true.
  const auto least = [&](std::int64_t count) {
    const std::int64_t needed = count - static_cast<std::int64_t>(known);
    if (needed <= 0) return constant(Type::Bool, 1);
    if (needed > static_cast<std::int64_t>(rows.size())) return constant(Type::Bool, 0);
    return at_least(static_cast<std::size_t>(needed), rows.data(), rows.data() + rows.size(), both, either,
                    [this] { return !problem_.empty(); });
  };
  const auto note = [&](std::uint32_t made, std::int64_t count, bool is_negated) {
    const std::int64_t needed = count - static_cast<std::int64_t>(known);
    if (needed > 0 && needed <= static_cast<std::int64_t>(rows.size()))
      last_counted_ = {made, is_negated, {rows, static_cast<std::uint32_t>(needed)}};
    return made;
  };
  switch (quantifier) {
    case IndexQuantifier::ForAll:
    case IndexQuantifier::Exists: {
      const bool is_forall = quantifier == IndexQuantifier::ForAll;
      if (is_decided || rows.empty()) return whole(is_decided != is_forall);
      const std::uint32_t* const end = rows.data() + rows.size();
      return is_forall ? join_rows(rows.data(), end, both) : note(join_rows(rows.data(), end, either), 1, false);
    }
    case IndexQuantifier::AtLeast: return note(least(*limit), *limit, false);
    case IndexQuantifier::AtMost: return note(make_not(least(*limit + 1)), *limit + 1, true);
    case IndexQuantifier::Exactly: {
      const std::uint32_t enough = least(*limit);
      return both(enough, make_not(least(*limit + 1)));
    }
  }
  BIP_UNREACHABLE("a quantifier of no kind");
}

bool PropertyRows::is_temporal(std::uint32_t row) const { return row < is_temporal_.size() && is_temporal_[row] != 0; }

}  // namespace bip::verify
