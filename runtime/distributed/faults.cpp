// See faults.hpp.
#include "runtime/distributed/faults.hpp"

#include <algorithm>
#include <cctype>

namespace bip::rt {

namespace {

constexpr i64 kMostTime = i64{1000} * 86400 * 1000000000;  // a thousand days
constexpr u32 kMostSlowness = 1000;

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  for (std::size_t end; (end = text.find(at)) != std::string_view::npos; text.remove_prefix(end + 1))
    parts.push_back(text.substr(0, end));
  parts.push_back(text);
  return parts;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (const std::string_view word : split(text, ' ')) {
    if (!word.empty()) words.push_back(word);
  }
  return words;
}

// Takes digits from the front. False: there are none, or too many.
bool take_number(std::string_view& text, i64 most, i64& value) {
  const std::size_t before = text.size();
  value = 0;
  while (!text.empty() && std::isdigit(static_cast<unsigned char>(text.front())) != 0) {
    value = value * 10 + (text.front() - '0');
    if (value > most) return false;
    text.remove_prefix(1);
  }
  return text.size() != before;
}

// "1s500ms".
bool read_time(std::string_view text, i64& time) {
  struct Unit {
    std::string_view name;
    i64 ns;
  };
  constexpr Unit kUnits[] = {{"ns", 1},         {"us", 1000},        {"ms", 1000000}, {"min", 60000000000},
                             {"s", 1000000000}, {"h", 3600000000000}};
  time = 0;
  do {
    i64 number = 0;
    if (!take_number(text, kMostTime, number)) return false;
    const auto* unit = std::find_if(std::begin(kUnits), std::end(kUnits),
                                    [&](const Unit& known) { return text.starts_with(known.name); });
    if (unit == std::end(kUnits) || number > (kMostTime - time) / unit->ns) return false;
    time += number * unit->ns;
    text.remove_prefix(unit->name.size());
  } while (!text.empty());
  return true;
}

class FaultReader {
 public:
  explicit FaultReader(const std::vector<std::string>& nodes) : nodes_(nodes) {}

  Result<NetworkFaults> read(std::string_view text) {
    for (const std::string_view part : split(text, ',')) {
      words_ = words_of(part);
      if (words_.empty()) {
        problem_ = "a fault is missing before or after a comma";
      } else if (words_[0] == "cut") {
        cut();
      } else if (words_[0] == "crash") {
        crash();
      } else if (words_[0] == "slow") {
        slow();
      } else if (words_[0] == "lose") {
        percent(faults_.lost_percent, 50);
      } else if (words_[0] == "double") {
        percent(faults_.doubled_percent, 100);
      } else {
        problem_ = quoted(words_[0]) + " is no fault: there are cut, crash, slow, lose and double";
      }
      if (!problem_.empty()) return Failure{problem_};
    }
    return std::move(faults_);
  }

 private:
  static std::string quoted(std::string_view text) { return '`' + std::string(text) + '`'; }

  bool has_words(std::size_t count, const char* example) {
    if (words_.size() != count)
      problem_ = "expected " + quoted(example) + ", found " +
                 quoted(std::string_view(words_.front().data(),
                                         static_cast<std::size_t>(words_.back().end() - words_.front().begin())));
    return problem_.empty();
  }
  bool node(std::string_view name, u32& node) {
    const auto found = std::find(nodes_.begin(), nodes_.end(), name);
    node = static_cast<u32>(found - nodes_.begin());
    if (found != nodes_.end()) return true;
    problem_ = quoted(name) + " is none of the nodes";
    for (std::size_t i = 0; i < nodes_.size(); ++i) problem_ += (i == 0 ? " " : ", ") + nodes_[i];
    return false;
  }
  bool time(std::string_view text, i64& time) {
    if (!read_time(text, time)) problem_ = quoted(text) + " is no time such as `3s` or `1s500ms`";
    return problem_.empty();
  }

  void cut() {
    NetworkFaults::Cut cut;
    if (!has_words(3, "cut 1-2 3s..5s")) return;
    const std::size_t dash = words_[1].find('-'), dots = words_[2].find("..");
    if (dash == std::string_view::npos || dots == std::string_view::npos) {
      problem_ = "expected `cut 1-2 3s..5s`: two nodes, and when the cut begins and ends";
    } else if (node(words_[1].substr(0, dash), cut.a) && node(words_[1].substr(dash + 1), cut.b) &&
               time(words_[2].substr(0, dots), cut.from) && time(words_[2].substr(dots + 2), cut.until)) {
      if (cut.a == cut.b) problem_ = "a cut is between two nodes, not at " + quoted(nodes_[cut.a]) + " alone";
      else if (cut.until <= cut.from) problem_ = "the cut " + quoted(words_[2]) + " ends before it begins";
      else faults_.cuts.push_back(cut);
    }
  }
  void crash() {
    NetworkFaults::Crash crash;
    if (!has_words(3, "crash 3 5s") || !node(words_[1], crash.node) || !time(words_[2], crash.at)) return;
    faults_.crashes.push_back(crash);
  }
  void slow() {
    u32 which = 0;
    i64 factor = 0;
    if (!has_words(3, "slow 2 x10") || !node(words_[1], which)) return;
    std::string_view text = words_[2];
    const bool has_sign = text.starts_with('x');
    if (has_sign) text.remove_prefix(1);
    if (!has_sign || !take_number(text, kMostSlowness, factor) || factor == 0 || !text.empty()) {
      problem_ = quoted(words_[2]) + " is no factor from `x1` to `x1000`";
      return;
    }
    faults_.slowness.resize(nodes_.size(), 1);
    faults_.slowness[which] = static_cast<u32>(factor);
  }
  void percent(u32& value, i64 most) {
    i64 number = 0;
    if (!has_words(2, words_[0] == "lose" ? "lose 5%" : "double 5%")) return;
    std::string_view text = words_[1];
    if (take_number(text, most, number) && text == "%") value = static_cast<u32>(number);
    else problem_ = quoted(words_[1]) + " is no share from `0%` to `" + std::to_string(most) + "%`";
  }

  const std::vector<std::string>& nodes_;
  NetworkFaults faults_;
  std::vector<std::string_view> words_;
  std::string problem_;
};

}  // namespace

Result<NetworkFaults> read_faults(std::string_view text, const std::vector<std::string>& nodes) {
  return text.empty() ? NetworkFaults{} : FaultReader(nodes).read(text);
}

}  // namespace bip::rt
