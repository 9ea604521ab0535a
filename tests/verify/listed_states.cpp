// See listed_states.hpp. A state is a list of numbers, by atom its place and its data.
#include "tests/verify/listed_states.hpp"

#include <algorithm>
#include <optional>
#include <sstream>

#include "compiler/system/system.hpp"

namespace bip::verify::test {

namespace {

using Numbers = std::vector<std::int64_t>;
using Open = std::vector<std::optional<std::int64_t>>;

class List {
 public:
  List(const System& system, const rt::Image& image, const rt::State& first) : system_(system), image_(image) {
    for (std::size_t atom = 0; atom < system_.atoms.size(); ++atom) {
      first_.push_back(open_.size());
      open_.emplace_back();
      const std::vector<DataVariable>& variables = type_of(atom).variables;
      const Numbers numbers = numbers_of(first, atom);
      for (std::size_t k = 0; k < variables.size(); ++k)
        open_.push_back(variables[k].is_param ? std::optional(numbers[1 + k]) : std::nullopt);
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
    return true;
  }

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
      const rt::VariableId base = image_.atoms[static_cast<u32>(atom)].variable(0);
      for (u32 k = 0; k < type_of(atom).variables.size(); ++k) {
        if (!type_of(atom).variables[k].is_param)
          state.data[base + k] = static_cast<std::uint32_t>(numbers[first_[atom] + 1 + k]);
      }
    }
  }

 private:
  [[nodiscard]] const AtomType& type_of(std::size_t atom) const {
    return system_.atom_types[system_.atoms[AtomId(atom)].type];
  }
  [[nodiscard]] Numbers numbers_of(const rt::State& state, std::size_t atom) const {
    Numbers numbers{static_cast<std::int64_t>(state.places[atom])};
    const rt::VariableId base = image_.atoms[static_cast<u32>(atom)].variable(0);
    for (u32 k = 0; k < type_of(atom).variables.size(); ++k)
      numbers.push_back(static_cast<std::int32_t>(static_cast<std::uint32_t>(state.data[base + k])));
    return numbers;
  }

  bool read_row(const std::vector<std::string>& words) {
    if (words[0] != "state")
      return words[0] == "root" || words[0] == "claim" || words[0] == "method" || words[0] == "end" ||
             words[0] == "bipc-certificate";
    for (std::size_t k = 1; k < words.size(); ++k) {
      if (!read_word(words[k])) return false;
    }
    Numbers numbers;
    for (const auto& number : open_) {
      if (!number) return false;
      numbers.push_back(*number);
    }
    states_.insert(std::move(numbers));
    return true;
  }
  bool read_word(const std::string& word) {
    const std::size_t at = word.find('@'), equals = word.find('=');
    const bool is_place = at != std::string::npos;
    if (!is_place && equals == std::string::npos) return false;
    std::string path = word.substr(0, is_place ? at : equals);
    const std::size_t dot = path.rfind('.');
    const std::string name = is_place ? word.substr(at + 1) : path.substr(dot + 1);
    if (!is_place) path = path.substr(0, dot);
    for (std::size_t atom = 0; atom < system_.atoms.size(); ++atom) {
      if (system_.atoms[AtomId(atom)].path != path) continue;
      const AtomType& type = type_of(atom);
      if (is_place) {
        const auto place = std::find(type.places.begin(), type.places.end(), name);
        open_[first_[atom]] = place - type.places.begin();
        return place != type.places.end();
      }
      const auto variable = std::find_if(type.variables.begin(), type.variables.end(),
                                         [&](const DataVariable& one) { return one.name == name; });
      std::int64_t value = 0;
      if (variable == type.variables.end() || variable->is_param || !read_number(word.substr(equals + 1), value) ||
          (variable->type == Type::Bool && value != 0 && value != 1))
        return false;
      open_[first_[atom] + 1 + static_cast<std::size_t>(variable - type.variables.begin())] = value;
      return true;
    }
    return false;
  }

  const System& system_;
  const rt::Image& image_;
  std::vector<std::size_t> first_;
  Open open_;  // of the row before; null where nothing is told yet
  std::set<Numbers> states_;
};

}  // namespace

Worth listed_worth(const std::string& text, const System& system, const rt::Image& image, const SearchGoal& goal,
                   std::size_t limit) {
  rt::Core core(image);
  if (!core.initialize()) return Worth::TooLarge;
  rt::State state = core.snapshot();
  if (!state.marks.empty() || !state.time.empty()) return Worth::TooLarge;
  for (const AtomType& type : system.atom_types) {
    const auto is_told = [](const DataVariable& variable) {
      return variable.is_param || variable.type == Type::Int || variable.type == Type::Bool;
    };
    if (!std::all_of(type.variables.begin(), type.variables.end(), is_told)) return Worth::TooLarge;
  }
  List list(system, image, state);
  if (!list.read(text)) return Worth::Malformed;
  if (list.states().empty() || list.states().size() > limit) return Worth::TooLarge;
  if (!list.states().contains(list.numbers_of(state))) return Worth::Insufficient;
  for (const auto& numbers : list.states()) {
    list.write(numbers, state);
    if (breaks(core, state, goal, [&](const rt::State& next) { return list.states().contains(list.numbers_of(next)); }))
      return Worth::Insufficient;
  }
  return Worth::Suffices;
}

}  // namespace bip::verify::test
