// See published_trace.hpp. Reads one line at a time.
#include "compiler/driver/published_trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>

#include "compiler/base/ascii.hpp"
#include "runtime/engine/event_file.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {
namespace {

constexpr std::string_view kPrefix = "[BIP ENGINE]:";
constexpr std::string_view kAtTime = " at global time ";

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
bool take_candidate(std::string_view text, std::uint64_t& number, std::string& candidate) {
  if (!take(text, "[") || !take_number(text, number) || !take(text, "]")) return false;
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

std::string without_intervals(std::string_view candidate) {
  // No interval has a `)`; an internal port has none either, and no blank.
  const std::size_t close = candidate.rfind(')');
  const std::size_t at = candidate.find_first_of("[]", close == std::string_view::npos ? 0 : close);
  if (at == 0 || at == std::string_view::npos || candidate[at - 1] != ' ') return std::string(candidate);
  return std::string(trimmed(candidate.substr(0, at)));
}

namespace {

// What the words of an error are about; None: they are none of an error.
TraceEnd end_of(std::string_view text) {
  struct Row {
    std::string_view words;
    TraceEnd end;
  };
  static constexpr Row kRows[] = {{"time-lock", TraceEnd::TimeLock},
                                  {"time lock", TraceEnd::TimeLock},
                                  {"non deterministic", TraceEnd::TwoTransitions},
                                  {"1-safe", TraceEnd::NotOneSafe},
                                  {"cycle in priorities", TraceEnd::PriorityCycle},
                                  {"invariant", TraceEnd::Invariant},
                                  {"unexpected event", TraceEnd::Event},
                                  {"timing violation", TraceEnd::Late},
                                  {"ERROR", TraceEnd::Error}};
  for (const Row& row : kRows) {
    if (text.find(row.words) != std::string_view::npos) return row.end;
  }
  return TraceEnd::None;
}

// The word behind `words`, without the mark at its end; empty: there is none.
std::string_view word_after(std::string_view text, std::string_view words) {
  const std::size_t at = text.find(words);
  if (at == std::string_view::npos) return {};
  text.remove_prefix(at + words.size());
  text = text.substr(0, text.find(' '));
  return text.ends_with('!') ? text.substr(0, text.size() - 1) : text;
}

class PublishedTraceReader {
 public:
  explicit PublishedTraceReader(std::string_view text) : text_(text) {}

  Result<PublishedTrace> read() {
    while (!text_.empty() && failure_.empty()) {
      ++number_;
      const std::size_t end = text_.find('\n');
      std::string_view line = text_.substr(0, end);
      text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
      is_cut_ = end == std::string_view::npos;
      if (take(line, kPrefix)) read_line(trimmed(line));
      // The text was cut off in this line.
      if (!failure_.empty() && is_cut_ && !trace_.states.empty()) failure_.clear();
    }
    if (!failure_.empty()) return Failure{failure_};
    if (trace_.states.empty() && trace_.end == TraceEnd::None) return Failure{"no line `[BIP ENGINE]: state #…` in it"};
    return std::move(trace_);
  }

 private:
  void read_line(std::string_view line) {
    if (take(line, "state #")) return read_state(line);
    if (take(line, "-> choose")) return read_choice(trimmed(line));
    if (line.starts_with('[')) return read_candidate(line);
    note_end(line);
  }

  void note_end(std::string_view line) {
    const TraceEnd end = end_of(line);
    if (end == TraceEnd::None || trace_.end != TraceEnd::None) return;
    trace_.end = end;
    trace_.end_line = number_;
    // Without its newline it is whole if it has the mark that ends all of them.
    const bool is_whole = !is_cut_ || line.ends_with('!');
    if (line.starts_with("ERROR") && !is_whole) trace_.end = TraceEnd::CutError;
    if (take(line, "ERROR:")) line = trimmed(line);
    trace_.end_text = line;
    if (is_whole) note_names(line);
  }

  // What the end is about: "the invariant i of component ROOT.a has been violated!", "invariant ROOT.a.i violated!",
  // "Petri net not 1-safe in ROOT.a!", "time-lock at 5s!".
  void note_names(std::string_view line) {
    BIP_ASSERT(trace_.end != TraceEnd::None, "names without an end in line {}", number_);
    if (trace_.end == TraceEnd::TimeLock) trace_.end_lock = word_after(line, " at ");
    if (trace_.end == TraceEnd::TwoTransitions || trace_.end == TraceEnd::NotOneSafe)
      trace_.end_component = word_after(line, " in ");
    if (trace_.end != TraceEnd::Invariant) return;
    std::string_view invariant = word_after(line, "invariant "), component = word_after(line, " of component ");
    if (invariant == "has" || invariant == "violated") return;
    if (const std::size_t dot = invariant.rfind('.'); dot != std::string_view::npos && component.empty()) {
      component = invariant.substr(0, dot);
      invariant.remove_prefix(dot + 1);
    }
    trace_.end_invariant = invariant;
    trace_.end_component = component;
  }

  void read_state(std::string_view line) {
    TraceState state;
    state.line = number_;
    if (!take_number(line, state.number)) return fail("line {} has no state number");
    // With time: "state #3 and global time 6s: …".
    const std::size_t colon = line.find(':');
    std::string_view head = line.substr(0, colon);
    if (take(head, " and global time ")) state.entered = trimmed(head);
    const std::string_view rest =
        colon == std::string_view::npos ? std::string_view() : trimmed(line.substr(colon + 1));
    state.is_deadlock = rest.starts_with("deadlock");
    if (!state.entered.empty() && rt::parse_time(state.entered) < 0) return fail("line {} has no instant");
    const auto has = [&](std::string_view words) { return rest.find(words) != std::string_view::npos; };
    const bool is_list = has("interaction") || has("internal port") || has("external port");
    // "limit reached", "error": nothing to compare there.
    if (!is_cut_) trace_.ends_behind_choice = false;
    if (!state.is_deadlock && !is_list) {
      trace_.end_instant = state.entered;
      return note_end(rest);
    }
    expected_ = is_list ? announced(rest) : 0;
    state.is_complete = expected_ == 0;
    if (state.is_deadlock && trace_.end == TraceEnd::None) {
      trace_.end = TraceEnd::Deadlock;
      trace_.end_line = number_;
    }
    if (!is_last_complete()) return fail("line {} follows a state that lists fewer interactions than it announces");
    if (!trace_.states.empty() && state.number != trace_.states.back().number + 1)
      return fail("line {} has a number that does not follow that of the state before");
    trace_.states.push_back(std::move(state));
  }

  [[nodiscard]] bool is_last_complete() const { return trace_.states.empty() || trace_.states.back().is_complete; }

  void read_choice(std::string_view line) {
    std::string chosen;
    std::uint64_t number = 0;
    if (trace_.states.empty() || !take_candidate(line, number, chosen))
      return fail("line {} chooses nothing that can be read");
    if (!is_last_complete()) return fail("line {} follows a state that lists fewer interactions than it announces");
    trace_.ends_behind_choice = true;
    TraceState& state = trace_.states.back();
    if (const std::size_t at = chosen.rfind(kAtTime);
        at != std::string::npos && chosen.find('"', at) == std::string::npos) {
      state.instant = trimmed(std::string_view(chosen).substr(at + kAtTime.size()));
      chosen.resize(at);
      // Cut off perhaps: `1s` of `1s400ms`.
      if (is_cut_) return state.instant.clear();
      if (rt::parse_time(state.instant) < 0) return fail("line {} chooses at no instant");
    }
    state.chosen = without_intervals(chosen);
    state.chosen_rank = rank_of(state, number);
    // A choice that was cut off says too little to be followed.
    if (text_.empty() && is_cut_off(state)) state.chosen.clear();
  }

  // Alternatives of a merged port have one text.
  static std::size_t rank_of(const TraceState& state, std::uint64_t number) {
    const std::string wanted = normal_candidate(state.chosen);
    std::size_t rank = 0;
    for (std::size_t k = 0; k < std::min<std::size_t>(number, state.candidates.size()); ++k)
      rank += normal_candidate(without_intervals(state.candidates[k])) == wanted ? 1 : 0;
    return rank;
  }

  static bool is_cut_off(const TraceState& state) {
    for (const std::string& candidate : state.candidates) {
      if (normal_candidate(without_intervals(candidate)) == normal_candidate(state.chosen)) return false;
    }
    return true;
  }

  void read_candidate(std::string_view line) {
    std::string candidate;
    std::uint64_t ignored = 0;
    if (trace_.states.empty() || !take_candidate(line, ignored, candidate))
      return fail("line {} is no interaction of a state");
    TraceState& state = trace_.states.back();
    if (state.is_complete) return fail("line {} is one interaction more than its state announces");
    // Cut off perhaps: it says too little to be compared.
    if (is_cut_) return;
    // `now` is the state's instant.
    const std::string name = without_intervals(candidate);
    std::string intervals = candidate.substr(name.size());
    for (std::size_t at = intervals.find("now"); at != std::string::npos && !state.entered.empty();
         at = intervals.find("now"))
      intervals.replace(at, 3, state.entered);
    for (std::size_t at = intervals.find("+INFTY ]"); at != std::string::npos; at = intervals.find("+INFTY ]"))
      intervals[at + 7] = '[';
    state.candidates.push_back(name + intervals);
    state.is_complete = state.candidates.size() >= expected_;
  }

  void fail(fmt::format_string<std::size_t&> what) { failure_ = fmt::format(what, number_); }

  std::string_view text_;
  std::size_t number_ = 0;  // of the line at hand
  std::uint64_t expected_ = 0;
  bool is_cut_ = false;  // the line at hand is the last one, without its end
  PublishedTrace trace_;
  std::string failure_;
};

}  // namespace

Result<PublishedTrace> read_published_trace(std::string_view text) { return PublishedTraceReader(text).read(); }

}  // namespace bip::driver
