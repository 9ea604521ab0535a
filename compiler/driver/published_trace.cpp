// See published_trace.hpp. Reads one line at a time.
#include "compiler/driver/published_trace.hpp"

#include <fmt/format.h>

#include <cctype>
#include <charconv>

namespace bip::driver {
namespace {

constexpr std::string_view kPrefix = "[BIP ENGINE]:";
constexpr std::string_view kAtTime = " at global time ";

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())) != 0) text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.remove_suffix(1);
  return text;
}

// The number at the front, taken off. False if there is none.
bool take_number(std::string_view& text, std::uint64_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{}) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

bool take(std::string_view& text, std::string_view word) {
  if (!text.starts_with(word)) return false;
  text.remove_prefix(word.size());
  return true;
}

// "[3] ROOT.k: p.put(v=1;)" without its number.
bool take_candidate(std::string_view text, std::string& candidate) {
  std::uint64_t ignored = 0;
  if (!take(text, "[") || !take_number(text, ignored) || !take(text, "]")) return false;
  candidate = trimmed(text);
  return !candidate.empty();
}

// "2 interactions and 1 internal port:" -> 3
std::uint64_t announced(std::string_view text) {
  std::uint64_t sum = 0;
  while (!text.empty()) {
    std::uint64_t count = 0;
    if (std::isdigit(static_cast<unsigned char>(text.front())) != 0 && take_number(text, count)) {
      sum += count;
    } else {
      text.remove_prefix(1);
    }
  }
  return sum;
}

std::string normal_value(std::string_view value) {
  if (value == "true") return "1";
  if (value == "false") return "0";
  if (value.size() >= 2 && value.front() == '"' && value.back() == '"')
    return std::string(value.substr(1, value.size() - 2));
  if (value.find_first_of(".eE") == std::string_view::npos) return std::string(value);
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  // The published engine writes six digits.
  return error == std::errc{} && end == value.data() + value.size() ? fmt::format("{:.6g}", number)
                                                                    : std::string(value);
}

}  // namespace

std::string normal_candidate(std::string_view candidate) {
  std::string out;
  bool in_string = false;
  for (std::size_t i = 0; i < candidate.size(); ++i) {
    const char c = candidate[i];
    if (c == '"' && (i == 0 || candidate[i - 1] != '\\')) in_string = !in_string;
    if (c == '=' && !in_string) {
      // A value goes up to its `;`, which a string may hold too.
      std::size_t end = i + 1;
      const bool quoted = end < candidate.size() && candidate[end] == '"';
      if (quoted) {
        for (++end; end < candidate.size() && (candidate[end] != '"' || candidate[end - 1] == '\\');) ++end;
      }
      while (end < candidate.size() && candidate[end] != ';') ++end;
      out += '=' + normal_value(trimmed(candidate.substr(i + 1, end - i - 1)));
      i = end - 1;
    } else if (in_string || std::isspace(static_cast<unsigned char>(c)) == 0) {
      out += c;
    } else if (!out.empty() && out.back() != ' ') {
      out += ' ';
    }
  }
  return std::string(trimmed(out));
}

Result<std::vector<TraceState>> read_published_trace(std::string_view text) {
  std::vector<TraceState> states;
  std::uint64_t expected = 0;
  std::size_t number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (!take(line, kPrefix)) continue;
    line = trimmed(line);
    std::string candidate;
    if (take(line, "state #")) {
      TraceState& state = states.emplace_back();
      state.line = number;
      if (!take_number(line, state.number)) return Failure{fmt::format("line {} has no state number", number)};
      // Timed systems: "state #3 and global time 6s: …".
      const std::size_t colon = line.find(':');
      const std::string_view rest =
          colon == std::string_view::npos ? std::string_view() : trimmed(line.substr(colon + 1));
      state.is_deadlock = rest.starts_with("deadlock");
      // "limit reached", "error": nothing to compare there.
      const bool is_list =
          rest.find("interaction") != std::string_view::npos || rest.find("internal port") != std::string_view::npos;
      if (!state.is_deadlock && !is_list) states.pop_back();
      expected = is_list ? announced(rest) : 0;
      if (!states.empty()) states.back().is_complete = expected == 0;
    } else if (take(line, "-> choose")) {
      if (states.empty() || !take_candidate(trimmed(line), states.back().chosen))
        return Failure{fmt::format("line {} chooses nothing that can be read", number)};
      TraceState& state = states.back();
      if (const std::size_t at = state.chosen.rfind(kAtTime);
          at != std::string::npos && state.chosen.find('"', at) == std::string::npos) {
        state.instant = trimmed(std::string_view(state.chosen).substr(at + kAtTime.size()));
        state.chosen.resize(at);
      }
    } else if (line.starts_with('[')) {
      if (states.empty() || !take_candidate(line, candidate))
        return Failure{fmt::format("line {} is no interaction of a state", number)};
      states.back().candidates.push_back(std::move(candidate));
      states.back().is_complete = states.back().candidates.size() >= expected;
    }
  }
  if (states.empty()) return Failure{"no line `[BIP ENGINE]: state #…` in it"};
  return states;
}

}  // namespace bip::driver
