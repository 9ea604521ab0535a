// See diagram.hpp. A state is a list of numbers, by atom its place and its data. The cost is that of the ways through the diagram.
#include "tests/verify/diagram.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>

namespace bip::verify::test {

namespace {

using Numbers = std::vector<std::int64_t>;
using Open = std::vector<std::optional<std::int64_t>>;
struct Condition {
  std::size_t at = 0;
  std::int64_t value = 0;
  bool is_place = false;
};
struct Case {
  std::vector<Condition> conditions;
  std::vector<std::size_t> next;
};

bool read_number(const std::string& word, std::int64_t& number) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc{} && end == word.data() + word.size() && std::to_string(number) == word;
}

class Diagram {
 public:
  Diagram(const System& system, const rt::Image& image, const rt::State& first) : system_(system), image_(image) {
    for (std::size_t atom = 0; atom < system_.atoms.size(); ++atom) {
      first_.push_back(open_.size());
      open_.emplace_back();
      const std::vector<Slot>& slots = type_of(atom).slots;
      const Numbers numbers = numbers_of(first, atom);
      for (std::size_t k = 0; k < slots.size(); ++k) open_.push_back(slots[k].is_param ? std::optional(numbers[1 + k]) : std::nullopt);
    }
  }

  bool read(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream in(line);
      std::vector<std::string> words;
      for (std::string word; in >> word;) words.push_back(word);
      if (words.empty() || !read_row(words)) return false;
    }
    return reached_.has_value();
  }

  // False: a way leaves an int open. Stops beyond `limit`.
  bool list(std::size_t limit) { return list({*reached_}, open_, limit); }
  [[nodiscard]] const std::set<Numbers>& states() const { return states_; }

  [[nodiscard]] Numbers numbers_of(const rt::State& state) const {
    Numbers all;
    for (std::size_t atom = 0; atom < system_.atoms.size(); ++atom) {
      const Numbers part = numbers_of(state, atom);
      all.insert(all.end(), part.begin(), part.end());
    }
    return all;
  }
  void write(const Numbers& numbers, rt::State& state) const {
    for (std::size_t atom = 0; atom < system_.atoms.size(); ++atom) {
      state.places[atom] = static_cast<u32>(numbers[first_[atom]]);
      const std::size_t base = image_.atoms[static_cast<u32>(atom)].slot_base;
      for (std::size_t k = 0; k < type_of(atom).slots.size(); ++k) {
        if (!type_of(atom).slots[k].is_param) state.data[base + k] = static_cast<std::uint32_t>(numbers[first_[atom] + 1 + k]);
      }
    }
  }

 private:
  [[nodiscard]] const AtomType& type_of(std::size_t atom) const { return system_.atom_types[system_.atoms[AtomId(atom)].type]; }
  [[nodiscard]] Numbers numbers_of(const rt::State& state, std::size_t atom) const {
    Numbers numbers{static_cast<std::int64_t>(state.places[atom])};
    const std::size_t base = image_.atoms[static_cast<u32>(atom)].slot_base;
    for (std::size_t k = 0; k < type_of(atom).slots.size(); ++k) numbers.push_back(static_cast<std::int32_t>(static_cast<std::uint32_t>(state.data[base + k])));
    return numbers;
  }

  bool read_row(const std::vector<std::string>& words) {
    if (words[0] == "node") {
      if (words.size() < 2 || words[1] != std::to_string(nodes_.size())) return false;
      std::vector<Case> cases(words.size() - 2);
      for (std::size_t k = 2; k < words.size(); ++k) {
        if (!read_case(words[k], cases[k - 2])) return false;
      }
      nodes_.push_back(std::move(cases));
      return true;
    }
    if (words[0] == "lemma") return !reached_ && words.size() == 2 && words[1][0] == '#' && read_node(words[1].substr(1), nodes_.size(), reached_.emplace());
    return words[0] == "root" || words[0] == "claim" || words[0] == "method" || words[0] == "end" || words[0] == "bipc-certificate";
  }
  bool read_case(const std::string& word, Case& one) const {
    std::istringstream parts(word);
    for (std::string part; std::getline(parts, part, '&');) {
      if (part[0] != '#') {
        if (!read_condition(part, one.conditions.emplace_back())) return false;
      } else if (!read_node(part.substr(1), nodes_.size(), one.next.emplace_back())) {
        return false;
      }
    }
    return true;
  }
  static bool read_node(const std::string& word, std::size_t count, std::size_t& node) {
    std::int64_t number = 0;
    if (!read_number(word, number) || number < 0 || static_cast<std::size_t>(number) >= count) return false;
    node = static_cast<std::size_t>(number);
    return true;
  }
  bool read_condition(const std::string& word, Condition& condition) const {
    const std::size_t at = word.find('@'), equals = word.find('=');
    condition.is_place = at != std::string::npos;
    if (!condition.is_place && equals == std::string::npos) return false;
    std::string path = word.substr(0, condition.is_place ? at : equals);
    const std::size_t dot = path.rfind('.');
    const std::string name = condition.is_place ? word.substr(at + 1) : path.substr(dot + 1);
    if (!condition.is_place) path = path.substr(0, dot);
    for (std::size_t atom = 0; atom < system_.atoms.size(); ++atom) {
      if (system_.atoms[AtomId(atom)].path != path) continue;
      const AtomType& type = type_of(atom);
      condition.at = first_[atom];
      if (condition.is_place) {
        const auto place = std::find(type.places.begin(), type.places.end(), name);
        condition.value = place - type.places.begin();
        return place != type.places.end();
      }
      const auto slot = std::find_if(type.slots.begin(), type.slots.end(), [&](const Slot& one) { return one.name == name; });
      condition.at += 1 + static_cast<std::size_t>(slot - type.slots.begin());
      return slot != type.slots.end() && read_number(word.substr(equals + 1), condition.value) && (slot->type != Type::Bool || condition.value == 0 || condition.value == 1);
    }
    return false;
  }

  // All states with what is known and of which these nodes hold.
  bool list(std::vector<std::size_t> nodes, const Open& before, std::size_t limit) {
    if (nodes.empty()) return finish(before, limit);
    const std::size_t node = nodes.back();
    nodes.pop_back();
    for (const Case& one : nodes_[node]) {
      Open known = before;
      bool is_way = states_.size() <= limit;
      for (const Condition& condition : one.conditions) {
        is_way = is_way && known[condition.at].value_or(condition.value) == condition.value;
        known[condition.at] = condition.value;
      }
      std::vector<std::size_t> left = nodes;
      left.insert(left.end(), one.next.begin(), one.next.end());
      if (is_way && !list(std::move(left), known, limit)) return false;
    }
    return true;
  }
  // What is still open is any place, true or false; an int has too many values.
  bool finish(const Open& known, std::size_t limit) {
    const auto open = std::find(known.begin(), known.end(), std::nullopt);
    if (open == known.end()) {
      Numbers numbers;
      for (const auto& number : known) numbers.push_back(*number);
      states_.insert(std::move(numbers));
      return true;
    }
    const auto at = static_cast<std::size_t>(open - known.begin());
    const auto atom = static_cast<std::size_t>(std::upper_bound(first_.begin(), first_.end(), at) - first_.begin()) - 1;
    const AtomType& type = type_of(atom);
    if (at != first_[atom] && type.slots[at - first_[atom] - 1].type != Type::Bool) return false;
    const auto count = static_cast<std::int64_t>(at == first_[atom] ? type.places.size() : 2);
    for (std::int64_t value = 0; value < count && states_.size() <= limit; ++value) {
      Open with = known;
      with[at] = value;
      if (!finish(with, limit)) return false;
    }
    return true;
  }

  const System& system_;
  const rt::Image& image_;
  std::vector<std::size_t> first_;
  Open open_;
  std::vector<std::vector<Case>> nodes_;
  std::optional<std::size_t> reached_;
  std::set<Numbers> states_;
};

}  // namespace

Worth diagram_worth(const std::string& text, const System& system, const rt::Image& image, const SearchGoal& goal, std::size_t limit) {
  rt::Core core(image);
  if (!core.initialize()) return Worth::TooLarge;
  rt::State state = core.snapshot();
  if (!state.marks.empty() || !state.time.empty()) return Worth::TooLarge;
  for (const AtomType& type : system.atom_types) {
    const auto is_told = [](const Slot& slot) { return slot.is_param || slot.type == Type::Int || slot.type == Type::Bool; };
    if (!std::all_of(type.slots.begin(), type.slots.end(), is_told)) return Worth::TooLarge;
  }
  Diagram diagram(system, image, state);
  if (!diagram.read(text)) return Worth::Malformed;
  if (!diagram.list(limit) || diagram.states().size() > limit) return Worth::TooLarge;
  if (!diagram.states().contains(diagram.numbers_of(state))) return Worth::Insufficient;
  for (const auto& numbers : diagram.states()) {
    diagram.write(numbers, state);
    if (breaks(core, state, goal, [&](const rt::State& next) { return diagram.states().contains(diagram.numbers_of(next)); })) return Worth::Insufficient;
  }
  return Worth::Suffices;
}

}  // namespace bip::verify::test
