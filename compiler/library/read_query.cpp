// See read_query.hpp.
#include "compiler/library/read_query.hpp"

#include <charconv>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "compiler/base/ascii.hpp"
#include "compiler/library/read_observer.hpp"
#include "compiler/system/uses_time.hpp"
#include "runtime/engine/event_file.hpp"

namespace bip::library {
namespace {

constexpr std::string_view kQueryForms =
    "a query is `P=? [ PATH ]`, `P>=0.9 [ PATH ]`, `P<=0.1 [ PATH ]` or `E=? [ OBSERVER ]`";
constexpr std::string_view kPathForms = "a path is `F EXPR`, `G EXPR` or `EXPR U EXPR`, with a bound as `F<=100 EXPR`";

bool is_word_char(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' || c == '@';
}

// If the text begins with it, removes it and what is blank around it.
bool accept(std::string_view& text, std::string_view start) {
  std::string_view rest = trimmed(text);
  if (!rest.starts_with(start)) return false;
  rest.remove_prefix(start.size());
  if (is_word_char(start.back()) && !rest.empty() && is_word_char(rest.front())) return false;
  text = trimmed(rest);
  return true;
}

// The text before `end`, which goes with it.
std::optional<std::string_view> up_to(std::string_view& text, char end) {
  const std::size_t at = text.find(end);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view before = trimmed(text.substr(0, at));
  text = trimmed(text.substr(at + 1));
  return before;
}

std::optional<double> number_in(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Where the operator `U` stands: a word of its own outside of parentheses and strings.
std::size_t find_until(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '"') in_string = !in_string;
    if (in_string) continue;
    if (c == '(') ++depth;
    if (c == ')') --depth;
    const bool is_alone =
        (at == 0 || !is_word_char(text[at - 1])) && (at + 1 == text.size() || !is_word_char(text[at + 1]));
    if (c == 'U' && depth == 0 && is_alone) return at;
  }
  return std::string_view::npos;
}

// A bound, if one is written. Empty: it is sound.
std::string read_bound(std::string_view& text, const System& system, rt::PathQuery& query) {
  std::string_view limit;
  if (accept(text, "<=")) {
    std::size_t end = 0;
    while (end < text.size() && is_word_char(text[end])) ++end;
    limit = text.substr(0, end);
    text = trimmed(text.substr(end));
  } else if (accept(text, "{")) {
    const std::optional<std::string_view> inside = up_to(text, '}');
    if (!inside) return "the `}` of a bound is missing";
    limit = *inside;
  } else if (accept(text, "[")) {
    const std::optional<std::string_view> first = up_to(text, ','), last = first ? up_to(text, ']') : std::nullopt;
    if (!last) return "the bound is not of the form `[0, LIMIT]`";
    if (*first != "0") return fmt::format("a bound begins at 0, not at `{}`", *first);
    limit = *last;
  } else {
    return {};
  }
  std::uint64_t steps = 0;
  const auto [end, error] = std::from_chars(limit.data(), limit.data() + limit.size(), steps);
  if (error == std::errc() && end == limit.data() + limit.size()) {
    query.most_steps = steps;
    return {};
  }
  const rt::i64 time = rt::parse_time(limit);
  if (time < 0) return fmt::format("the bound `{}` is neither a number of steps nor a time such as 500ms", limit);
  if (!system::is_timed(system)) return fmt::format("the bound `{}` is a time, and the model has no clocks", limit);
  query.until = time;
  return {};
}

Result<rt::PathQuery> read_path(std::string_view text, const System& system) {
  rt::PathQuery query;
  const std::size_t until = find_until(text);
  if (accept(text, "G")) query.is_negated = true;
  else if (!accept(text, "F")) {
    if (until == std::string_view::npos) return Failure{std::string(kPathForms)};
    auto stays = read_condition(std::string(trimmed(text.substr(0, until))), system);
    if (!stays) return Failure{stays.error()};
    query.stays = std::move(*stays);
    text = trimmed(text.substr(until + 1));
  }
  if (std::string wrong = read_bound(text, system, query); !wrong.empty()) return Failure{std::move(wrong)};
  auto goal = read_condition(std::string(text), system);
  if (!goal) return Failure{goal.error()};
  query.goal = std::move(*goal);
  if (query.is_negated) query.goal = [holds = std::move(query.goal)](const rt::Core& core) { return !holds(core); };
  return query;
}

}  // namespace

Result<Query> read_query(const std::string& text, const System& system) {
  Query query;
  query.text = std::string(trimmed(text));
  std::string_view rest = query.text;
  if (rest.empty() || rest.back() != ']') return Failure{std::string(kQueryForms)};
  rest.remove_suffix(1);
  const bool is_expectation = rest.starts_with('E');
  if (!is_expectation && !rest.starts_with('P')) return Failure{std::string(kQueryForms)};
  rest = trimmed(rest.substr(1));
  if (accept(rest, "=?") || (is_expectation && rest.starts_with('['))) {
    query.kind = is_expectation ? QueryKind::Expectation : QueryKind::Probability;
  } else if (!is_expectation && (rest.starts_with(">=") || rest.starts_with("<="))) {
    query.kind = rest.front() == '>' ? QueryKind::AtLeast : QueryKind::AtMost;
    rest.remove_prefix(2);
    const std::string_view share = trimmed(rest.substr(0, rest.find('[')));
    const std::optional<double> value = number_in(share);
    if (!value || *value <= 0 || *value >= 1)
      return Failure{fmt::format("`{}` is no probability between 0 and 1", share)};
    query.share = *value;
    rest = trimmed(rest.substr(std::min(rest.find('['), rest.size())));
  } else {
    return Failure{std::string(kQueryForms)};
  }
  if (!rest.starts_with('[')) return Failure{std::string(kQueryForms)};
  rest = trimmed(rest.substr(1));
  if (is_expectation) {
    Result<rt::Observer> observer = read_observer(std::string(rest), system);
    if (!observer) return Failure{observer.error()};
    query.observer = std::move(*observer);
    return query;
  }
  Result<rt::PathQuery> path = read_path(rest, system);
  if (!path) return Failure{path.error()};
  query.path = std::move(*path);
  return query;
}

}  // namespace bip::library
