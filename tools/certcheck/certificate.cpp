// Reads a certificate line by line (compiler/docs/certificate.md); `moves` of the classes stay empty.
#include "tools/certcheck/certificate.hpp"

#include <algorithm>
#include <sstream>
#include <utility>

namespace certcheck {

namespace {

class Reader {
 public:
  explicit Reader(const Model& model) : m_(model) {}
  Certificate run(const std::string& text) {
    read(text);
    return std::move(c_);
  }

 private:
  void read(const std::string& text) {
    std::istringstream in(text);
    std::string line;
    std::size_t number = 0;
    bool has_end = false, has_method = false;
    std::map<std::string, std::size_t> atom_rows;
    for (std::size_t k = 0; k < m_.atoms.size(); ++k) atom_rows.emplace(m_.atoms[k].path, k);
    c_.class_of.assign(m_.atoms.size(), kNone);
    c_.reachable.resize(m_.atoms.size());
    while (std::getline(in, line)) {
      std::istringstream words(line);
      std::string head, word;
      words >> head;
      ++number;
      const auto fail = [&](const std::string& why) { throw Rejected("line " + std::to_string(number) + ": " + why); };
      if (number == 1 && line != "bipc-certificate 1") fail("not a certificate of version 1");
      if (has_end) fail("something follows the end");
      if (line == "method exhaustive") throw NotCheckable("the evidence is a search of all states");
      if (head == "method" && line != "method invariants" && line != "method induction") fail("an unknown method");
      if (head == "method" && std::exchange(has_method, true)) fail("one method is expected");
      if (head == "method") c_.is_induction = line == "method induction";
      if (head == "method" && !c_.is_induction && c_.claim != "deadlock-free") fail("invariants alone prove no such claim");
      if (head == "claim") {
        if (!c_.claim.empty() || line.size() < 7) fail("one claim is expected");
        c_.claim = line.substr(6);
      }
      if (head == "class") {
        words >> word;
        if (word != std::to_string(c_.classes.size())) fail("not the number of the next class");
        words >> word;
        Class row;
        while (row.type < m_.atom_types.size() && m_.atom_types[row.type].name != word) ++row.type;
        if (row.type == m_.atom_types.size()) fail("no atom type `" + word + "`");
        const AtomType& type = m_.atom_types[row.type];
        row.followed.assign(type.slots.size(), false);
        while (words >> word) {
          const auto slot = std::find(type.slots.begin(), type.slots.end(), word);
          if (slot == type.slots.end()) fail("no slot `" + word + "`");
          const std::size_t k = static_cast<std::size_t>(slot - type.slots.begin());
          if (type.types[k] != "int" && type.types[k] != "bool" && type.types[k] != "string") fail("`" + word + "` cannot be followed");
          row.followed[k] = true;
        }
        c_.classes.push_back(std::move(row));
      } else if (head == "mode") {
        if (c_.classes.empty()) fail("a mode without class");
        mode(words, c_.classes.back(), fail);
      } else if (head == "component") {
        words >> word;
        const auto atom = atom_rows.find(word);
        if (atom == atom_rows.end()) fail("no component `" + word + "`");
        words >> word >> word;
        const std::size_t row = number_of(word, fail);
        words >> word;
        if (c_.class_of[atom->second] != kNone) fail("a component twice");
        if (row >= c_.classes.size() || c_.classes[row].type != m_.atoms[atom->second].type) fail("the class does not fit");
        c_.class_of[atom->second] = row;
        while (words >> word) c_.reachable[atom->second].insert(number_of(word, fail));
        if (!c_.reachable[atom->second].empty() && *c_.reachable[atom->second].rbegin() >= c_.classes[row].states.size()) fail("no such mode");
      } else if (head == "trap" || head == "one-token" || head == "sum") {
        Set set;
        set.is_trap = head == "trap";
        set.text = "line " + std::to_string(number);
        if (head == "sum") {
          if (!(words >> word)) fail("a sum without total");
          set.total = word == "0" ? 0 : weight_of(word, fail);
        }
        std::map<std::pair<std::size_t, std::size_t>, int> members;
        while (words >> word) {
          int weight = 1;
          if (const std::size_t star = word.rfind('*'); head == "sum" && star != std::string::npos) {
            weight = weight_of(word.substr(star + 1), fail);
            word.resize(star);
          }
          const std::size_t colon = word.rfind(':');
          const auto atom = atom_rows.find(word.substr(0, colon));
          if (colon == std::string::npos || atom == atom_rows.end()) fail("no component in `" + word + "`");
          const bool is_new = members.emplace(std::pair(atom->second, number_of(word.substr(colon + 1), fail)), weight).second;
          if (!is_new && head == "sum") fail("a mode twice");
        }
        for (const auto& [member, weight] : members) {
          set.members.push_back(member);
          set.weights.push_back(weight);
        }
        c_.sets.push_back(std::move(set));
      } else if (head == "range" || head == "lemma") {
        c_.facts.push_back(fact(words, head == "range", atom_rows, fail));
        c_.facts.back().text = "line " + std::to_string(number);
      } else if (head == "node") {
        words >> word;
        if (word != std::to_string(c_.nodes.size())) fail("not the number of the next node");
        c_.nodes.emplace_back();
      } else if (head == "case") {
        if (c_.nodes.empty()) fail("a case without node");
        Case one;
        words >> word;
        one.is_end = word == "-";
        if (!one.is_end) one.next = number_of(word, fail);
        if (!one.is_end && one.next + 1 >= c_.nodes.size()) fail("no node before this one has that number");
        one.parts = fact(words, false, atom_rows, fail).parts;
        c_.nodes.back().push_back(std::move(one));
      } else if (head == "reached") {
        Fact fact;
        words >> word;
        fact.node = number_of(word, fail);
        fact.is_reached = true;
        fact.text = "line " + std::to_string(number);
        if (fact.node >= c_.nodes.size()) fail("no such node");
        c_.facts.push_back(std::move(fact));
      } else if (head == "end") {
        has_end = true;
      } else if (number != 1 && head != "root" && head != "claim" && head != "method") {
        fail("an unknown row");
      }
    }
    if (!has_end) throw Rejected("the certificate has no end");
    if (c_.claim.empty() || !has_method) throw Rejected("the certificate does not say what it proves and how");
    if (c_.is_induction && c_.classes.empty() && c_.sets.empty()) return;
    if (std::find(c_.class_of.begin(), c_.class_of.end(), kNone) != c_.class_of.end()) throw Rejected("a component has no row");
  }

  template <class Fail>
  static int weight_of(const std::string& word, const Fail& fail) {
    const std::size_t weight = number_of(word, fail);
    if (weight == 0 || weight > 0x40000000UL) fail("`" + word + "` is no weight");
    return static_cast<int>(weight);
  }

  // Of at most 32 bits, written in the one way.
  template <class Fail>
  static std::size_t number_of(const std::string& word, const Fail& fail) {
    const bool is_one = !word.empty() && word.size() <= 10 && word.find_first_not_of("0123456789") == std::string::npos;
    if (!is_one || std::to_string(std::stoul(word)) != word || std::stoul(word) > 0x80000000UL) fail("`" + word + "` is no number here");
    return std::stoul(word);
  }

  template <class Fail>
  static std::int32_t value_of(const std::string& word, const Fail& fail) {
    const bool is_negative = !word.empty() && word[0] == '-';
    const auto size = static_cast<std::int64_t>(number_of(word.substr(is_negative ? 1 : 0), fail));
    return static_cast<std::int32_t>(is_negative ? -size : size);
  }

  // "ROOT.a.n 0 7", or literals "!ROOT.a@PLACE", "ROOT.a.n:3"
  template <class Fail>
  Fact fact(std::istringstream& words, bool is_range, const std::map<std::string, std::size_t>& atom_rows, const Fail& fail) {
    Fact result;
    result.is_range = is_range;
    std::string word;
    while (words >> word) {
      Fact::Part part;
      part.is_negated = !is_range && word[0] == '!';
      const std::string name = word.substr(part.is_negated ? 1 : 0);
      const std::size_t at = name.find('@'), colon = name.find_last_of(":=");
      part.is_place = !is_range && at != std::string::npos;
      part.is_value = !is_range && !part.is_place && colon != std::string::npos && name[colon] == '=';
      const std::size_t dot = name.rfind('.', colon);
      if (!is_range && !part.is_place && colon == std::string::npos) fail("`" + word + "` is no literal");
      const auto atom = atom_rows.find(name.substr(0, part.is_place ? at : dot));
      if (atom == atom_rows.end()) fail("no component in `" + word + "`");
      part.atom = atom->second;
      const AtomType& type = m_.atom_types[m_.atoms[part.atom].type];
      const std::string own = part.is_place ? name.substr(at + 1) : is_range ? name.substr(dot + 1) : name.substr(dot + 1, colon - dot - 1);
      const std::vector<std::string>& names = part.is_place ? type.places : type.slots;
      part.row = static_cast<std::size_t>(std::find(names.begin(), names.end(), own) - names.begin());
      if (part.row == names.size()) fail("no `" + own + "` in `" + word + "`");
      if (!part.is_place && type.types[part.row] != "int" && type.types[part.row] != "bool" && type.types[part.row] != "string") fail("`" + own + "` cannot be followed");
      if (part.is_value) part.value = value_of(name.substr(colon + 1), fail);
      else if (!is_range && !part.is_place) part.bit = static_cast<unsigned>(number_of(name.substr(colon + 1), fail));
      if (part.bit > 31) fail("an int has 32 bits");
      result.parts.push_back(part);
      if (is_range && !(words >> result.low >> result.high)) fail("a range has two ends");
    }
    if (is_range && result.parts.size() != 1) fail("a range is of one slot");
    return result;
  }

  template <class Fail>
  void mode(std::istringstream& words, Class& row, const Fail& fail) {
    const AtomType& type = m_.atom_types[row.type];
    LocalState state;
    state.values.resize(type.slots.size());
    std::string word;
    words >> word;
    if (word != std::to_string(row.states.size())) fail("not the number of the next mode");
    words >> word;
    if (word != "at") fail("a mode without `at`");
    while (words >> word) {
      const std::size_t equals = word.find('=');
      const auto row_of = [&](const std::vector<std::string>& names, const std::string& name) {
        const auto at = std::find(names.begin(), names.end(), name);
        if (at == names.end()) fail("no `" + name + "` here");
        return static_cast<std::size_t>(at - names.begin());
      };
      if (equals == std::string::npos) {
        state.places.insert(row_of(type.places, word));
        continue;
      }
      const std::size_t slot = row_of(type.slots, word.substr(0, equals));
      if (!row.followed[slot]) fail("a value that is not followed");
      const std::string value = word.substr(equals + 1);
      if (value == "?") continue;
      state.values[slot] = {true, value_of(value, fail)};
    }
    if (!row.numbers.emplace(state, row.states.size()).second) fail("a mode twice");
    row.states.push_back(std::move(state));
  }

  static constexpr std::size_t kNone = ~std::size_t{0};
  const Model& m_;
  Certificate c_;
};

}  // namespace

Certificate read_certificate(const Model& model, const std::string& text) { return Reader(model).run(text); }

}  // namespace certcheck
