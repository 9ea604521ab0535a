// Reads a certificate line by line (compiler/docs/certificate.md), strictly: every word counts.
#include "tools/certcheck/certificate.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

namespace certcheck {

namespace {

using Text = std::string_view;
constexpr long kMostWeight = 0x40000000L;

class Reader {
 public:
  explicit Reader(const Model& model) : m_(model) {
    for (std::size_t k = 0; k < m_.atoms.size(); ++k) atoms_.emplace(m_.atoms[k].path, k);
    c_.class_of.assign(m_.atoms.size(), kNone);
    c_.reachable.resize(m_.atoms.size());
  }

  Certificate run(Text text) {
    bool has_end = false;
    for (std::size_t at = 0, end = 0; at < text.size(); at = end + 1) {
      ++line_;
      if (has_end) fail("something follows the end");
      end = std::min(text.find('\n', at), text.size());
      const Text line = text.substr(at, end - at);
      words_.clear();
      for (std::size_t from = 0; (from = line.find_first_not_of(' ', from)) != Text::npos;) {
        const std::size_t to = std::min(line.find(' ', from), line.size());
        words_.push_back(line.substr(from, to - from));
        from = to;
      }
      has_end = line == "end";
      if (!has_end) row(line);
    }
    if (!has_end) throw Rejected("the certificate has no end");
    if (c_.claim.empty() || method_.empty()) throw Rejected("the certificate does not say what it proves and how");
    c_.is_induction = method_ == "induction";
    if (!c_.is_induction && c_.claim != "deadlock-free") throw Rejected("invariants alone prove no such claim");
    if (!c_.is_induction && !c_.facts.empty()) throw Rejected("invariants are of modes");
    const bool has_modes = !c_.is_induction || !c_.classes.empty() || !c_.sets.empty();
    if (has_modes && std::count(c_.class_of.begin(), c_.class_of.end(), kNone) != 0) throw Rejected("a component has no row");
    return std::move(c_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const { throw Rejected("line " + std::to_string(line_) + ": " + why); }
  Text word(std::size_t k) const {
    if (k >= words_.size()) fail("a word is missing");
    return words_[k];
  }

  void row(Text line) {
    const Text head = words_.empty() ? Text() : words_[0];
    if (line_ == 1 && line != "bipc-certificate 1") fail("not a certificate of version 1");
    if (line_ == 1 || head == "root") return;
    if (head == "claim") {
      if (!c_.claim.empty() || line.size() < 7) fail("one claim is expected");
      c_.claim = line.substr(6);
    } else if (head == "method") {
      if (!method_.empty() || words_.size() != 2) fail("one method is expected");
      method_ = word(1);
      if (method_ == "exhaustive") throw NotCheckable("the evidence is a search of all states");
      if (method_ != "invariants" && method_ != "induction") fail("an unknown method");
    } else if (head == "class") {
      class_row();
    } else if (head == "mode") {
      mode_row();
    } else if (head == "component") {
      component_row();
    } else if (head == "trap" || head == "one-token" || head == "sum") {
      set_row(head);
    } else if (head == "node") {
      if (words_.size() != 2 || word(1) != std::to_string(c_.nodes.size())) fail("not the number of the next node");
      c_.nodes.emplace_back();
    } else if (head == "case") {
      if (c_.nodes.empty()) fail("a case without node");
      Case one{literals(2), word(1) == "-" ? kNone : number(word(1))};
      if (one.next != kNone && one.next + 1 >= c_.nodes.size()) fail("no node before this one has that number");
      c_.nodes.back().push_back(std::move(one));
    } else if (head == "reached") {
      if (c_.reached != kNone || words_.size() != 2) fail("one node is expected");
      c_.reached = number(word(1));
      if (c_.reached >= c_.nodes.size()) fail("no such node");
    } else if (head == "lemma") {
      c_.facts.push_back({literals(1), "line " + std::to_string(line_)});
    } else if (head == "range") {
      if (words_.size() != 4) fail("a range is of one slot, with two ends");
      c_.facts.push_back({{about_slot(word(1), Literal::Range, word(2), word(3))}, "line " + std::to_string(line_)});
    } else {
      fail("an unknown row");
    }
  }

  void class_row() {
    if (word(1) != std::to_string(c_.classes.size())) fail("not the number of the next class");
    Class row;
    while (row.type < m_.atom_types.size() && m_.atom_types[row.type].name != word(2)) ++row.type;
    if (row.type == m_.atom_types.size()) fail("no atom type `" + std::string(word(2)) + "`");
    row.followed.assign(m_.atom_types[row.type].slots.size(), false);
    for (std::size_t k = 3; k < words_.size(); ++k) row.followed[slot(m_.atom_types[row.type], words_[k])] = true;
    c_.classes.push_back(std::move(row));
  }

  void mode_row() {
    if (c_.classes.empty()) fail("a mode without class");
    Class& row = c_.classes.back();
    const AtomType& type = m_.atom_types[row.type];
    if (word(1) != std::to_string(row.modes.size()) || word(2) != "at") fail("not the next mode");
    Mode mode;
    mode.values.resize(type.slots.size());
    for (std::size_t k = 3; k < words_.size(); ++k) {
      if (words_[k].find('=') == Text::npos) {
        mode.places.insert(find(type.places, words_[k]));
        continue;
      }
      const auto [name, value] = split(words_[k], words_[k].find('='));
      const std::size_t at = slot(type, name);
      if (!row.followed[at]) fail("a value that is not followed");
      if (value != "?") mode.values[at] = value_of(type.types[at], value);
    }
    if (!row.numbers.emplace(mode, row.modes.size()).second) fail("a mode twice");
    row.modes.push_back(std::move(mode));
  }

  void component_row() {
    const std::size_t atom = atom_of(word(1)), row = number(word(3));
    if (word(2) != "class" || word(4) != "reachable") fail("not `component PATH class N reachable …`");
    if (c_.class_of[atom] != kNone) fail("a component twice");
    if (row >= c_.classes.size() || c_.classes[row].type != m_.atoms[atom].type) fail("the class does not fit");
    c_.class_of[atom] = row;
    for (std::size_t k = 5; k < words_.size(); ++k) {
      if (number(words_[k]) >= c_.classes[row].modes.size()) fail("no such mode");
      c_.reachable[atom].insert(number(words_[k]));
    }
  }

  void set_row(Text head) {
    Set set;
    set.is_trap = head == "trap";
    set.text = "line " + std::to_string(line_);
    const bool is_sum = head == "sum";
    if (is_sum) set.total = static_cast<int>(number(word(1), 0, kMostWeight));
    for (std::size_t k = is_sum ? 2 : 1; k < words_.size(); ++k) {
      const auto [member, weight] = is_sum ? split(words_[k], words_[k].rfind('*')) : std::pair<Text, Text>(words_[k], "1");
      const auto [path, mode] = split(member, member.rfind(':'));
      const bool is_new = set.weights.emplace(std::pair(atom_of(path), number(mode)), number(weight, 1, kMostWeight)).second;
      if (!is_new && is_sum) fail("a mode twice");
    }
    c_.sets.push_back(std::move(set));
  }

  // "!ROOT.a@PLACE", "ROOT.a.n:3", "ROOT.a.n=-5"
  [[nodiscard]] std::vector<Literal> literals(std::size_t first) const {
    std::vector<Literal> result;
    for (std::size_t k = first; k < words_.size(); ++k) {
      const bool is_negated = words_[k][0] == '!';
      const Text name = words_[k].substr(is_negated ? 1 : 0);
      const bool is_place = name.find('@') != Text::npos;
      const auto [owner, what] = split(name, is_place ? name.find('@') : name.find_last_of(":="));
      if (is_place) {
        const std::size_t atom = atom_of(owner);
        result.push_back({Literal::Place, is_negated, atom, find(m_.type_of(atom).places, what)});
      } else {
        result.push_back(about_slot(owner, name[owner.size()] == ':' ? Literal::Bit : Literal::Value, what, what));
        result.back().is_negated = is_negated;
      }
    }
    return result;
  }
  [[nodiscard]] Literal about_slot(Text name, decltype(Literal::about) about, Text low, Text high) const {
    const auto [path, data] = split(name, name.rfind('.'));
    const std::size_t atom = atom_of(path), row = slot(m_.type_of(atom), data);
    const Text type = m_.type_of(atom).types[row];
    if (about == Literal::Value) return {about, false, atom, row, value_of(type, low), value_of(type, high)};
    const long least = about == Literal::Bit ? 0 : std::numeric_limits<int>::min();
    const long most = about != Literal::Bit ? std::numeric_limits<int>::max() : type == "bool" ? 0 : 31;
    return {about, false, atom, row, number(low, least, most), number(high, least, most)};
  }

  [[nodiscard]] std::pair<Text, Text> split(Text text, std::size_t at) const {
    if (at == Text::npos) fail("`" + std::string(text) + "` is no name with what is said of it");
    return {text.substr(0, at), text.substr(at + 1)};
  }
  [[nodiscard]] std::size_t atom_of(Text path) const {
    const auto found = atoms_.find(path);
    if (found == atoms_.end()) fail("no component `" + std::string(path) + "`");
    return found->second;
  }
  [[nodiscard]] std::size_t find(const std::vector<Text>& names, Text name) const {
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end()) fail("no `" + std::string(name) + "` here");
    return static_cast<std::size_t>(at - names.begin());
  }
  [[nodiscard]] std::size_t slot(const AtomType& type, Text name) const {
    const std::size_t row = find(type.slots, name);
    if (!is_exact(type.types[row])) fail("`" + std::string(name) + "` cannot be followed");
    return row;
  }
  // Between two ends, written in the one way.
  [[nodiscard]] int number(Text text, long least, long most) const {
    long value = 0;
    (void)std::from_chars(text.data(), text.data() + text.size(), value);
    if (std::to_string(value) != text || value < least || value > most) fail("`" + std::string(text) + "` is no number here");
    return static_cast<int>(value);
  }
  [[nodiscard]] std::size_t number(Text text) const { return static_cast<std::size_t>(number(text, 0, std::numeric_limits<int>::max())); }
  // false and true as 0 and 1; strings as rows, -1 for "" where no row has it.
  [[nodiscard]] int value_of(Text type, Text text) const {
    const bool is_bool = type == "bool";
    const int value = number(text, is_bool ? 0 : std::numeric_limits<int>::min(), is_bool ? 1 : std::numeric_limits<int>::max());
    return type == "string" ? std::max(value, 0) : value;
  }

  const Model& m_;
  Certificate c_;
  std::map<Text, std::size_t> atoms_;
  std::vector<Text> words_;
  Text method_;
  std::size_t line_ = 0;
};

}  // namespace

Certificate read_certificate(const Model& model, const std::string& text) { return Reader(model).run(text); }

}  // namespace certcheck
