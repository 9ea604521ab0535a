// Parses the words of properties of runs and of branching time, before and between expressions.
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/property/property_parser.hpp"
#include "compiler/verify/property/property_words.hpp"
#include "runtime/engine/event_file.hpp"

namespace bip::verify {

bool PropertyParser::is_misplaced() {
  const std::size_t start = at_;
  for (const OtherSign& other : kOtherPrefixes) {
    if (begins_name(other.sign.back()) ? !take_words(other.sign) : !take_sign(other.sign)) continue;
    at_ = start;
    set_problem("`" + std::string(other.sign) + "` is written `" + std::string(other.word) + "`");
    return true;
  }
  at_ = start;
  for (const TemporalWord& prefix : kPrefixes) {
    if (!take_words(prefix.word)) continue;
    at_ = start;
    set_problem("`" + std::string(prefix.word) + "` inside of an expression needs parentheses: `(" +
                std::string(prefix.word) + " …)`");
    return true;
  }
  return false;
}

std::uint32_t PropertyParser::add_temporal(TemporalOperator op, std::uint32_t a, std::uint32_t b, std::size_t start,
                                           std::size_t word) {
  if (op == TemporalOperator::Possibly && !possibly_at_) possibly_at_ = word;
  if (is_of_past(op) && !past_at_) past_at_ = word;
  const std::uint32_t row = add({.kind = PropertyKind::Temporal, .temporal = op, .a = a, .b = b});
  extents_[row] = {start, text_.find_last_not_of(" \t\n", at_ - 1) + 1};
  return row;
}

void PropertyParser::take_within(std::uint32_t a, std::uint32_t b) {
  skip_blanks();
  const std::size_t start = at_;
  if (!problem_.empty() || !take_words("within")) return;
  skip_blanks();
  const std::size_t number = at_;
  std::string time;
  while (at_ < text_.size() && is_digit(text_[at_])) {
    while (at_ < text_.size() && is_digit(text_[at_])) time += text_[at_++];
    skip_blanks();
    while (at_ < text_.size() && is_letter(text_[at_])) time += text_[at_++];
    // `1 s 500 ms`
    const std::size_t behind = at_;
    skip_blanks();
    if (at_ >= text_.size() || !is_digit(text_[at_])) at_ = behind;
  }
  const std::int64_t ticks = rt::parse_time(time);
  const bool is_second = within_.has_value();
  if (ticks < 0) {
    at_ = number;
    set_problem("a time was expected, such as `50 ms`; its units are s, ms, us and ns");
  } else if (is_second || !system::is_timed(system_) || looks_ahead_[a] != 0 || looks_ahead_[b] != 0 ||
             is_of_past_[a] != 0 || is_of_past_[b] != 0) {
    at_ = start;
    set_problem(is_second                    ? kWithinAlone
                : !system::is_timed(system_) ? "`within` bounds a time, and the model has no clocks"
                                             : "`within` is about conditions and `happens`, not about what else "
                                               "comes or has been");
  }
  within_ = ticks;
  within_at_ = start;
  within_row_ = static_cast<std::uint32_t>(property_.nodes.size());
}

bool PropertyParser::check_operand(std::string_view word, TemporalOperator op, std::uint32_t row, std::size_t start) {
  if (!check_condition(row, start)) return false;
  if (!is_of_past(op) || looks_ahead_[row] == 0) return true;
  at_ = start;
  set_problem("`" + std::string(word) + "` looks back, and this looks ahead");
  return false;
}

bool PropertyParser::check_condition(std::uint32_t row, std::size_t start) {
  if (problem_.empty() && type(row) != Type::Bool) {
    skip_blanks();
    const bool goes_on = at_ < text_.size() && !begins_name(text_[at_]) && text_[at_] != ')';
    if (goes_on) {
      set_problem("this does not belong to the property");
      return false;
    }
    at_ = start;
    set_problem("a condition was expected, this is " + std::string(name_of(type(row))));
  }
  return problem_.empty();
}

std::uint32_t PropertyParser::parse_prefixed(int depth, bool& has_prefix) {
  if (depth > kMaxPropertyDepth) {
    set_problem("nested too deeply");
    return 0;
  }
  skip_blanks();
  const std::size_t start = at_;
  for (const TemporalWord& prefix : kPrefixes) {
    if (!take_words(prefix.word)) continue;
    has_prefix = true;
    skip_blanks();
    const std::size_t operand = at_;
    const bool has_parentheses = is_next('(');
    bool is_prefixed = false;
    const std::uint32_t a = parse_prefixed(depth + 1, is_prefixed);
    if (!check_operand(prefix.word, prefix.meaning, a, operand)) return 0;
    // `eventually (always a) && b`: of the whole, or of the first part? A pair of parentheses around the whole leaves
    // an operator whose row is older than the closing sign.
    const PropertyNode& node = property_.nodes[a];
    if (has_parentheses && !is_prefixed && node.kind == PropertyKind::Operator && node.op != Op::Not &&
        is_temporal(a) && !closes_at_end(operand)) {
      at_ = start;
      set_problem("does `" + std::string(prefix.word) + "` reach to the end? Write `" + std::string(prefix.word) +
                  " (… " + std::string(symbol_of(node.op)) + " …)` or `(" + std::string(prefix.word) + " …) " +
                  std::string(symbol_of(node.op)) + " …`");
      return 0;
    }
    if (prefix.meaning == TemporalOperator::Eventually) take_within(a, a);
    return add_temporal(prefix.meaning, a, a, start, start);
  }
  return parse_expression(1, depth);
}

bool PropertyParser::closes_at_end(std::size_t start) const {
  int open = 0;
  for (std::size_t at = start; at < at_; ++at) {
    if (text_[at] == '(') ++open;
    if (text_[at] == ')' && --open == 0) return text_.find_first_not_of(" \t\n", at + 1) >= at_;
  }
  return false;
}

std::string PropertyParser::both_readings(std::size_t prefix, std::string_view connective) const {
  const std::string first = word_at(prefix), then(connective);
  return "`" + first + " (… " + then + " …)` or `(" + first + " …) " + then + " …`";
}

std::uint32_t PropertyParser::parse_formula(int depth) {
  skip_blanks();
  const std::size_t start = at_, mark = property_.nodes.size();
  if (const std::optional<IndexQuantifier> quantifier = take_quantifier())
    return parse_quantified(*quantifier, depth + 1, !counts(*quantifier));
  bool has_prefix = false;
  const std::uint32_t left = parse_prefixed(depth, has_prefix);
  if (!problem_.empty()) return 0;
  skip_blanks();
  const std::size_t middle = at_;
  for (const OtherSign& other : kOtherConnectives) {
    if (begins_name(other.sign.front()) ? !take_words(other.sign) : !take_sign(other.sign)) continue;
    at_ = middle;
    set_problem("`" + std::string(other.sign) + "` is written `" + std::string(other.word) + "`" +
                (has_prefix ? ": " + both_readings(start, other.word) : std::string()));
    return 0;
  }
  const TemporalWord* found = nullptr;
  for (const TemporalWord& word : kConnectives) {
    if (found == nullptr && take_words(word.word)) found = &word;
  }
  const bool is_implication = found == nullptr && take_words("implies");
  if (found == nullptr && !is_implication) return left;
  const std::string word(is_implication ? "implies" : found->word);
  if (has_prefix) {
    at_ = middle;
    set_problem("does `" + word_at(start) + "` reach over `" + word + "`? Write " + both_readings(start, word));
    return 0;
  }
  skip_blanks();
  const std::size_t behind = at_;
  bool is_prefixed = false;
  const std::uint32_t right = parse_prefixed(depth + 1, is_prefixed);
  const TemporalOperator meaning = found == nullptr ? TemporalOperator::Always : found->meaning;
  if (!check_operand(word, meaning, left, start) || !check_operand(word, meaning, right, behind)) return 0;
  if (meaning == TemporalOperator::LeadsTo) take_within(left, right);
  skip_blanks();
  const std::size_t end = at_;
  for (const std::string_view next : {"leads to", "until", "unless", "since", "implies"}) {
    if (!take_words(next)) continue;
    at_ = end;
    set_problem("`" + word + "` and `" + std::string(next) + "` need parentheses: which comes first?");
    return 0;
  }
  if (!is_implication) return add_temporal(found->meaning, left, right, start, middle);
  if (is_folded(left)) {
    if (property_.nodes[left].int_value != 0) return right;
    forget_from(mark);
    return constant(Type::Bool, 1);
  }
  const std::uint32_t negated = make_not(left);
  return add({.kind = PropertyKind::Operator, .op = Op::Or, .a = negated, .b = right});
}

}  // namespace bip::verify
