// See clauses.hpp. The cost is the number of states that satisfy the rows times what is enabled in each.
#include "tests/verify/clauses.hpp"

#include <algorithm>
#include <sstream>

#include "compiler/system/system.hpp"

namespace bip::verify::test {

namespace {

constexpr std::size_t kNone = ~std::size_t{0};

bool read_row_number(const std::string& word, std::size_t count, std::uint32_t& row) {
  std::int64_t number = 0;
  if (!read_number(word, number) || number < 0 || static_cast<std::size_t>(number) >= count) return false;
  row = static_cast<std::uint32_t>(number);
  return true;
}
template <class Names, class NameOf>
bool find_name(const Names& names, const std::string& name, std::uint32_t& row, NameOf name_of) {
  for (std::size_t k = 0; k < names.size(); ++k) {
    row = static_cast<std::uint32_t>(k);
    if (name_of(names[k]) == name) return true;
  }
  return false;
}
const std::string& variable_name(const DataVariable& variable) { return variable.name; }
const std::string& own_name(const std::string& name) { return name; }

}  // namespace

std::size_t Clauses::atom_of(const std::string& path) const {
  for (std::size_t atom = 0; atom < system_.atoms.size(); ++atom) {
    if (system_.atoms[AtomId(atom)].path == path) return atom;
  }
  return kNone;
}

bool Clauses::split_data(const std::string& path, std::size_t& atom, std::uint32_t& variable) const {
  const std::size_t dot = path.rfind('.');
  if (dot == std::string::npos) return false;
  atom = atom_of(path.substr(0, dot));
  return atom != kNone && find_name(system_.atom_types[system_.atoms[AtomId(atom)].type].variables,
                                    path.substr(dot + 1), variable, variable_name);
}

bool Clauses::read_literal(std::string word, Literal& literal) const {
  literal.is_negated = word[0] == '!';
  if (literal.is_negated) word.erase(0, 1);
  const std::size_t at = word.find('@'), sign = word.find_last_of(":=");
  literal.is_place = at != std::string::npos;
  if (literal.is_place) {
    literal.atom = atom_of(word.substr(0, at));
    return literal.atom != kNone && find_name(system_.atom_types[system_.atoms[AtomId(literal.atom)].type].places,
                                              word.substr(at + 1), literal.row, own_name);
  }
  if (sign == std::string::npos || !split_data(word.substr(0, sign), literal.atom, literal.row)) return false;
  const Type type = system_.atom_types[system_.atoms[AtomId(literal.atom)].type].variables[literal.row].type;
  const std::string what = word.substr(sign + 1);
  literal.is_bit = word[sign] == ':';
  if (literal.is_bit) return read_row_number(what, type == Type::Bool ? 1 : 32, literal.bit);
  const std::size_t dots = what.find("..");
  if (!read_number(what.substr(0, dots), literal.low) ||
      !read_number(dots == std::string::npos ? what : what.substr(dots + 2), literal.high))
    return false;
  return type != Type::Bool || (literal.low >= 0 && literal.low <= 1 && literal.high >= 0 && literal.high <= 1);
}

bool Clauses::read_case(const std::string& word, Case& one) const {
  std::istringstream parts(word);
  for (std::string part; std::getline(parts, part, '&');) {
    if (!read_literal(part, one.emplace_back())) return false;
  }
  return true;
}

bool Clauses::read_mode(const std::vector<std::string>& words, Rows& rows) const {
  if (rows.classes.empty()) return false;
  Class& row = rows.classes.back();
  const AtomType& type = system_.atom_types[row.type];
  if (words.size() < 3 || words[1] != std::to_string(row.modes.size())) return false;
  Mode mode;
  std::size_t places = 0;
  for (std::size_t k = 2; k < words.size(); ++k) {
    const std::string& word = words[k];
    const std::size_t equals = std::min(word.find('='), word.size());
    std::uint32_t found = 0;
    if (word[0] == '@') {
      if (!find_name(type.places, word.substr(1), mode.place, own_name)) return false;
      ++places;
      continue;
    }
    if (word[0] != '.' || !find_name(type.variables, word.substr(1, equals - 1), found, variable_name)) return false;
    std::int64_t number = 0;
    if (equals == word.size() || !read_number(word.substr(equals + 1), number)) return false;
    if (type.variables[found].type == Type::String) rows.is_listable = false;
    mode.values[found] = static_cast<std::int32_t>(number);
  }
  // Data that the modes don't know can be anything.
  const bool knows_all = std::all_of(type.variables.begin(), type.variables.end(), [&](const DataVariable& variable) {
    return variable.is_param || mode.values.contains(static_cast<std::uint32_t>(&variable - type.variables.data()));
  });
  rows.is_listable = rows.is_listable && places == 1 && knows_all;
  if (std::find(row.modes.begin(), row.modes.end(), mode) != row.modes.end()) return false;
  row.modes.push_back(mode);
  return true;
}

bool Clauses::read_row(const std::vector<std::string>& words, Rows& rows) const {
  const std::string& head = words[0];
  if (head == "class") {
    Class row;
    std::uint32_t type = 0;
    std::vector<std::string> names;
    for (const AtomType& one : system_.atom_types) names.push_back(one.name);
    if (words.size() != 3 || words[1] != std::to_string(rows.classes.size()) ||
        !find_name(names, words[2], type, own_name))
      return false;
    row.type = AtomTypeId(std::size_t{type});
    rows.classes.push_back(std::move(row));
    return true;
  }
  if (head == "mode") return read_mode(words, rows);
  if (head == "component") {
    const std::size_t atom = words.size() < 5 ? kNone : atom_of(words[1]);
    std::uint32_t row = 0;
    if (atom == kNone || rows.class_of[atom] != kNone || !read_row_number(words[3], rows.classes.size(), row))
      return false;
    rows.class_of[atom] = row;
    if (rows.classes[row].type != system_.atoms[AtomId(atom)].type) return false;
    for (std::size_t k = 5; k < words.size(); ++k) {
      std::uint32_t mode = 0;
      if (!read_row_number(words[k], rows.classes[row].modes.size(), mode)) return false;
      rows.reachable[atom].insert(mode);
    }
    return true;
  }
  if (head == "trap" || head == "one-token") {
    std::set<Member> members;
    for (std::size_t k = 1; k < words.size(); ++k) {
      const std::size_t colon = words[k].rfind(':');
      if (colon == std::string::npos) return false;
      Member member{atom_of(words[k].substr(0, colon)), 0};
      // A mode that the class lacks is none that holds.
      if (member.atom == kNone || !read_row_number(words[k].substr(colon + 1), 0x7fffffff, member.mode)) return false;
      members.insert(member);
    }
    (head == "trap" ? rows.traps : rows.one_tokens).push_back(std::move(members));
    return true;
  }
  if (head == "sum") {
    Sum sum;
    if (words.size() < 2 || !read_number(words[1], sum.total)) return false;
    for (std::size_t k = 2; k < words.size(); ++k) {
      const std::size_t colon = words[k].rfind(':'), star = words[k].rfind('*');
      if (colon == std::string::npos || star == std::string::npos || star < colon) return false;
      Member member{atom_of(words[k].substr(0, colon)), 0};
      std::int64_t weight = 0;
      if (member.atom == kNone ||
          !read_row_number(words[k].substr(colon + 1, star - colon - 1), 0x7fffffff, member.mode))
        return false;
      if (!read_number(words[k].substr(star + 1), weight)) return false;
      sum.weights[member] += weight;
    }
    rows.sums.push_back(std::move(sum));
    return true;
  }
  if (head == "equation") {
    Equation equation;
    std::int64_t total = 0;
    if (words.size() < 3 || !read_number(words[1], total)) return false;
    equation.total = static_cast<std::uint32_t>(total);
    for (std::size_t k = 2; k < words.size(); ++k) {
      const std::size_t star = words[k].rfind('*');
      auto& [term, weight] = equation.terms.emplace_back();
      if (star == std::string::npos || !read_number(words[k].substr(star + 1), weight)) return false;
      const std::string name = words[k].substr(0, star);
      const bool is_value = name.find_first_of("@=:") == std::string::npos;
      if (is_value) term.emplace_back().is_value = true;
      if (is_value ? !split_data(name, term[0].atom, term[0].row) : !read_case(name, term)) return false;
    }
    rows.equations.push_back(std::move(equation));
    return true;
  }
  if (head == "lemma") {
    std::vector<Case> lemma(words.size() - 1);
    for (std::size_t k = 1; k < words.size(); ++k) {
      if (!read_case(words[k], lemma[k - 1])) return false;
    }
    rows.lemmas.push_back(std::move(lemma));
    return true;
  }
  return head == "root" || head == "claim" || head == "method" || head == "end" || head == "bipc-certificate";
}

bool Clauses::read(const std::string& text, Rows& rows) const {
  rows.class_of.assign(system_.atoms.size(), kNone);
  rows.reachable.resize(system_.atoms.size());
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream in(line);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    if (words.empty() || !read_row(words, rows)) return false;
  }
  return std::find(rows.class_of.begin(), rows.class_of.end(), kNone) == rows.class_of.end();
}

std::int32_t Clauses::value(const rt::State& state, std::size_t atom, std::uint32_t variable) const {
  return static_cast<std::int32_t>(
      static_cast<std::uint32_t>(state.data[image_.atoms[static_cast<u32>(atom)].variable(variable)]));
}

bool Clauses::is_in(const rt::State& state, std::size_t atom, const Mode& mode) const {
  return state.places[atom] == mode.place &&
         std::all_of(mode.values.begin(), mode.values.end(),
                     [&](const auto& known) { return value(state, atom, known.first) == known.second; });
}

bool Clauses::hold(const Rows& rows, const rt::State& state) const {
  const auto in_mode = [&](std::size_t atom, std::uint32_t mode) {
    const std::vector<Mode>& modes = rows.classes[rows.class_of[atom]].modes;
    return mode < modes.size() && rows.reachable[atom].contains(mode) && is_in(state, atom, modes[mode]);
  };
  for (std::size_t atom = 0; atom < rows.reachable.size(); ++atom) {
    if (std::none_of(rows.reachable[atom].begin(), rows.reachable[atom].end(),
                     [&](std::uint32_t mode) { return in_mode(atom, mode); }))
      return false;
  }
  const auto tokens = [&](const std::set<Member>& members) {
    return std::count_if(members.begin(), members.end(),
                         [&](const Member& member) { return in_mode(member.atom, member.mode); });
  };
  for (const std::set<Member>& trap : rows.traps) {
    if (tokens(trap) == 0) return false;
  }
  for (const std::set<Member>& set : rows.one_tokens) {
    if (tokens(set) != 1) return false;
  }
  for (const Sum& sum : rows.sums) {
    std::int64_t total = 0;
    for (const auto& [member, weight] : sum.weights) total += in_mode(member.atom, member.mode) ? weight : 0;
    if (total != sum.total) return false;
  }
  for (const Equation& equation : rows.equations) {
    std::uint32_t total = 0;
    for (const auto& [term, weight] : equation.terms) {
      const bool is_value = term[0].is_value;
      const std::uint32_t one = is_value ? static_cast<std::uint32_t>(value(state, term[0].atom, term[0].row))
                                : holds(term, state) ? 1
                                                     : 0;
      total += static_cast<std::uint32_t>(weight) * one;
    }
    if (total != equation.total) return false;
  }
  return std::all_of(rows.lemmas.begin(), rows.lemmas.end(), [&](const std::vector<Case>& lemma) {
    return std::any_of(lemma.begin(), lemma.end(), [&](const Case& one) { return holds(one, state); });
  });
}

bool Clauses::holds(const Case& one, const rt::State& state) const {
  return std::all_of(one.begin(), one.end(), [&](const Literal& l) {
    if (l.is_place) return (state.places[l.atom] == l.row) != l.is_negated;
    const std::int32_t v = value(state, l.atom, l.row);
    const bool is_so = l.is_bit ? ((static_cast<std::uint32_t>(v) >> l.bit) & 1) != 0 : l.low <= v && v <= l.high;
    return is_so != l.is_negated;
  });
}

Worth Clauses::worth(const std::string& text, const SearchGoal& goal, std::size_t limit) {
  Rows rows;
  const bool is_sound = read(text, rows);
  if (!rows.is_listable || rows.classes.empty()) return Worth::TooLarge;
  if (!is_sound) return Worth::Malformed;
  std::size_t count = 1;
  for (const std::set<std::uint32_t>& modes : rows.reachable) {
    count *= modes.size();
    if (count > limit) return Worth::TooLarge;
  }
  rt::Core core(image_);
  if (!core.initialize()) return Worth::TooLarge;
  rt::State state = core.snapshot();
  if (!state.marks.empty() || !state.time.empty()) return Worth::TooLarge;
  const rt::State first = state;
  if (!hold(rows, first)) return Worth::Insufficient;
  for (std::size_t number = 0; number < count; ++number) {
    std::size_t rest = number;
    bool exists = true;
    for (std::size_t atom = 0; atom < rows.reachable.size(); ++atom) {
      auto chosen = rows.reachable[atom].begin();
      std::advance(chosen, static_cast<long>(rest % rows.reachable[atom].size()));
      rest /= rows.reachable[atom].size();
      const Mode& mode = rows.classes[rows.class_of[atom]].modes[*chosen];
      const std::vector<DataVariable>& variables = system_.atom_types[system_.atoms[AtomId(atom)].type].variables;
      state.places[atom] = mode.place;
      for (const auto& [variable, v] : mode.values) {
        if (variables[variable].is_param && value(first, atom, variable) != v) exists = false;
        if (!variables[variable].is_param)
          state.data[image_.atoms[static_cast<u32>(atom)].variable(variable)] = static_cast<std::uint32_t>(v);
      }
    }
    if (!exists || !hold(rows, state)) continue;
    if (breaks(core, state, goal, [&](const rt::State& next) { return hold(rows, next); })) return Worth::Insufficient;
  }
  return Worth::Suffices;
}

}  // namespace bip::verify::test
