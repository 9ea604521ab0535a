// See published_events.hpp.
#include "compiler/driver/published_events.hpp"

#include <algorithm>
#include <charconv>
#include <string>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "compiler/base/ascii.hpp"

namespace bip::driver {
namespace {

using rt::CellType;

EventValue default_value(CellType type) {
  switch (type) {
    case CellType::Int: return std::int32_t{0};
    case CellType::Bool: return false;
    case CellType::Float: return 0.0;
    case CellType::String: return std::string();
  }
  BIP_UNREACHABLE("an event with a C++ object");
}

template <class Number>
std::optional<EventValue> number_of(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<EventValue> value_of(CellType type, std::string_view text) {
  switch (type) {
    case CellType::Int: return number_of<std::int32_t>(text);
    case CellType::Float: return number_of<double>(text);
    case CellType::Bool:
      if (text == "true" || text == "1") return true;
      if (text == "false" || text == "0") return false;
      return std::nullopt;
    case CellType::String:
      if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
      return std::string(text);
  }
  return std::nullopt;
}

// `level=3`, `text="a; b"`: taken off the front of what stands between parentheses, with its `;`.
std::string_view take_assignment(std::string_view& text) {
  std::size_t end = 0;
  for (bool in_string = false; end < text.size() && (in_string || text[end] != ';'); ++end) {
    if (text[end] == '"' && (end == 0 || text[end - 1] != '\\')) in_string = !in_string;
  }
  const std::string_view assignment = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return trimmed(assignment);
}

}  // namespace

rt::u32 PublishedEvents::find(std::string_view candidate) const {
  const std::size_t end = candidate.find_first_of(" :(");
  const std::string_view head = candidate.substr(0, end);
  if (const rt::u32 row = ports_.find(head); row != rt::kNone) return row;
  if (end == std::string_view::npos || candidate[end] != ':') return rt::kNone;
  const std::string_view port = trimmed(candidate.substr(end + 1));
  return ports_.find(fmt::format("{}.{}", head, port.substr(0, port.find_first_of(" ("))));
}

rt::u32 PublishedEvents::find_word(std::string_view text) const {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of(" :!(`'"), text.size());
    if (const rt::u32 row = ports_.find(text.substr(0, end)); row != rt::kNone) return row;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return rt::kNone;
}

Result<PublishedEvent> PublishedEvents::read(std::string_view chosen) const {
  PublishedEvent event;
  event.row = find(chosen);
  BIP_ASSERT(event.row != rt::kNone, "`{}` is no event", std::string(chosen));
  const rt::Span<rt::Var>& vars = ports_.vars(event.row);
  for (const rt::Var& var : vars) event.values.push_back(default_value(var.type));
  const std::size_t open = chosen.find('('), close = chosen.rfind(')');
  std::string_view shown;
  if (open != std::string_view::npos && close != std::string_view::npos && open < close)
    shown = chosen.substr(open + 1, close - open - 1);
  std::vector<bool> is_shown(vars.size);
  for (std::size_t k = 0; !trimmed(shown).empty(); ++k) {
    const std::string_view assignment = take_assignment(shown);
    const std::size_t equals = assignment.find('=');
    const std::string_view name =
        equals == std::string_view::npos ? std::string_view() : trimmed(assignment.substr(0, equals));
    std::size_t row = k;
    if (!name.empty())
      for (row = 0; row < vars.size && name != vars[static_cast<rt::u32>(row)].name;) ++row;
    if (row >= vars.size)
      return Failure{fmt::format("`{}` is no variable of port `{}`", assignment, ports_.path(event.row))};
    const std::string_view text = name.empty() ? assignment : trimmed(assignment.substr(equals + 1));
    const std::optional<EventValue> value = value_of(vars[static_cast<rt::u32>(row)].type, text);
    if (!value) return Failure{fmt::format("`{}` is no value of its type", assignment)};
    event.values[row] = *value;
    is_shown[row] = true;
  }
  for (const bool is : is_shown) event.shows_values = event.shows_values && is;
  return event;
}

}  // namespace bip::driver
