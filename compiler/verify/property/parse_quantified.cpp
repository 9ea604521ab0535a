// Parses a quantifier with its range, and what it reaches over once for each value of its variable.
#include "compiler/verify/property/property_parser.hpp"
#include "runtime/core/text.hpp"

namespace bip::verify {

namespace {

// Of variables of quantifiers.
constexpr std::size_t kMaxRounds = 4'000'000;

}  // namespace

std::optional<IndexQuantifier> PropertyParser::take_quantifier() {
  const std::size_t start = at_;
  for (const QuantifierWord& quantifier : kQuantifiers) {
    if (!take_words(quantifier.word)) continue;
    const char next = is_next('(') ? '(' : at_ < text_.size() ? text_[at_] : '\0';
    if (begins_name(next) || is_digit(next) || next == '(') return quantifier.meaning;
    at_ = start;
  }
  return std::nullopt;
}

std::optional<std::int64_t> PropertyParser::parse_index(const char* what) {
  skip_blanks();
  const std::size_t start = at_;
  const std::optional<std::int64_t> value = evaluate(at_);
  if (value) return value;
  at_ = start;
  set_problem(what);
  return std::nullopt;
}

PropertyParser::Positions PropertyParser::parse_range() {
  skip_blanks();
  const std::size_t start = at_;
  if (begins_name(at_ < text_.size() ? text_[at_] : '\0')) {
    const std::string path = parse_path();
    if (!bound_.value_of(path)) {
      if (const std::uint32_t size = rows_.size_of_array(rt::whole_path(path)); size != 0) return {0, size};
      at_ = start;
      set_problem("there is no array of components `" + path + "`");
      return {};
    }
    at_ = start;
  }
  const std::optional<std::int64_t> low = parse_index("a range was expected: `0..3`, or an array of components");
  if (low && !take_sign("..")) set_problem("a range has two bounds: `0..3`");
  const std::optional<std::int64_t> high = low ? parse_index("the upper bound of a range was expected") : low;
  return low && high ? Positions{*low, *high} : Positions{};
}

std::uint32_t PropertyParser::parse_quantified(IndexQuantifier quantifier, int depth, bool is_formula) {
  const std::size_t start = at_;
  const auto wrong = [&](std::size_t at, const std::string& why) {
    at_ = at;
    set_problem(why);
    return 0u;
  };
  const std::string forms = "quantifiers are written " + std::string(kQuantifierForms);
  const std::optional<std::int64_t> limit = counts(quantifier) ? parse_index("a number was expected") : std::nullopt;
  if (!problem_.empty()) return 0;
  skip_blanks();
  const std::size_t name_at = at_;
  const std::string name = parse_path();
  if (name.empty() || name.find_first_of(".[") != std::string::npos || !take_words("in")) return wrong(start, forms);
  const Positions range = parse_range();
  if (!problem_.empty()) return 0;
  if (!take_sign(":")) return wrong(at_, "a `:` was expected; " + forms);
  const std::size_t body = at_, mark = property_.nodes.size();
  std::vector<std::uint32_t> rows;
  std::size_t known = 0;  // of counted ones: true whatever the state
  ++quantifiers_;
  bool is_decided = false;
  for (std::int64_t value = range.low; value < range.high && !is_decided && problem_.empty(); ++value) {
    at_ = body;
    if (++rounds_ > kMaxRounds) return wrong(name_at, "there are too many values of variables");
    bound_.bind(name, value);
    const std::size_t before = property_.nodes.size();
    const std::uint32_t row = is_formula ? parse_formula(depth + 1) : parse_expression(1, depth + 1);
    const bool is_constant = is_folded(row) && type(row) == Type::Bool;
    bound_.release();
    if (problem_.empty() && (type(row) != Type::Bool || (counts(quantifier) && is_temporal(row))))
      return wrong(body, counts(quantifier) ? "conditions on one state are counted"
                                            : "a condition was expected, this is " + std::string(name_of(type(row))));
    if (!is_constant || !problem_.empty()) {
      rows.push_back(row);
      continue;
    }
    const bool is_true = property_.nodes[row].int_value != 0;
    forget_from(before);
    if (counts(quantifier)) known += is_true ? 1 : 0;
    else is_decided = is_true == (quantifier == IndexQuantifier::Exists);
  }
  if (range.low >= range.high) at_ = end_of_body(text_, body, is_formula ? Reach::Formula : Reach::Expression);
  const std::uint32_t made = problem_.empty() ? join_all(quantifier, rows, limit, known, is_decided, mark) : 0;
  --quantifiers_;
  return made;
}

}  // namespace bip::verify
