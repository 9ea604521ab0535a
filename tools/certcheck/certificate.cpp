// Reads a certificate line by line (compiler/docs/certificate.md), strictly: every word counts.
#include "tools/certcheck/certificate.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

namespace certcheck {

namespace {

using Limits = std::numeric_limits<int>;
constexpr int kMostWeight = 0x40000000;

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
      need(!has_end, "something follows the end");
      end = std::min(text.find('\n', at), text.size());
      const Text line = text.substr(at, end - at);
      words_.clear();
      for (std::size_t from = 0, to = 0; (from = line.find_first_not_of(' ', from)) != Text::npos; from = to) {
        to = std::min(line.find(' ', from), line.size());
        words_.push_back(line.substr(from, to - from));
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
  [[nodiscard]] std::string place() const { return "line " + std::to_string(line_); }
  void need(bool is_so, Text why, Text what = {}) const {
    if (!is_so) throw Rejected(place() + ": " + (what.empty() ? "" : '`' + std::string(what) + "` ") + std::string(why));
  }
  [[nodiscard]] Text word(std::size_t k) const {
    need(k < words_.size(), "a word is missing");
    return words_[k];
  }

  void row(Text line) {
    const Text head = words_.empty() ? Text() : words_[0];
    need(line_ != 1 || line == "bipc-certificate 1", "not a certificate of version 1");
    if (line_ == 1 || head == "root") return;
    if (head == "claim") {
      need(c_.claim.empty() && line.size() > 6, "one claim is expected");
      c_.claim = line.substr(6);
    } else if (head == "method") {
      need(method_.empty() && words_.size() == 2, "one method is expected");
      method_ = word(1);
      if (method_ == "exhaustive") throw NotCheckable("the evidence is a search of all states");
      need(method_ == "invariants" || method_ == "induction", "an unknown method");
    } else if (head == "class") {
      class_row();
    } else if (head == "mode") {
      mode_row();
    } else if (head == "component") {
      component_row();
    } else if (head == "trap" || head == "one-token" || head == "sum") {
      set_row(head);
    } else if (head == "node") {
      need(words_.size() == 2 && word(1) == std::to_string(c_.nodes.size()), "not the number of the next node");
      c_.nodes.emplace_back();
    } else if (head == "case") {
      need(!c_.nodes.empty(), "a case without node");
      const std::size_t next = word(1) == "-" ? kNone : number(word(1));
      need(next == kNone || next + 1 < c_.nodes.size(), "no node before this one has that number");
      c_.nodes.back().push_back({literals(2), next});
    } else if (head == "reached") {
      need(c_.reached == kNone && words_.size() == 2, "one node is expected");
      c_.reached = number(word(1));
      need(c_.reached < c_.nodes.size(), "no such node");
    } else if (head == "lemma") {
      c_.facts.push_back({literals(1), place()});
    } else if (head == "range") {
      need(words_.size() == 4, "a range is of one slot, with two ends");
      Literal one = about(word(1));
      one.low = number(word(2), Limits::min(), Limits::max());
      one.high = number(word(3), Limits::min(), Limits::max());
      c_.facts.push_back({{one}, place()});
    } else {
      need(false, "an unknown row");
    }
  }

  void class_row() {
    need(word(1) == std::to_string(c_.classes.size()), "not the number of the next class");
    Class row;
    while (row.type < m_.atom_types.size() && m_.atom_types[row.type].name != word(2)) ++row.type;
    need(row.type < m_.atom_types.size(), "no such atom type");
    const AtomType& type = m_.atom_types[row.type];
    row.followed.assign(type.variables.size(), false);
    std::fill_n(row.followed.begin(), type.places, true);
    for (std::size_t k = 3; k < words_.size(); ++k) row.followed[variable(type, words_[k], false)] = true;
    c_.classes.push_back(std::move(row));
  }

  void mode_row() {
    need(!c_.classes.empty(), "a mode without class");
    Class& row = c_.classes.back();
    const AtomType& type = m_.atom_types[row.type];
    need(word(1) == std::to_string(row.modes.size()) && word(2) == "at", "not the next mode");
    Values mode(type.variables.size());
    std::fill_n(mode.begin(), type.places, 0);
    for (std::size_t k = 3; k < words_.size(); ++k) {
      const std::size_t equals = words_[k].find('=');
      const std::size_t at = variable(type, words_[k].substr(0, equals), equals == Text::npos);
      need(row.followed[at], "a value that is not followed");
      if (equals == Text::npos) mode[at] = 1;
      else if (words_[k].substr(equals + 1) != "?") mode[at] = value_of(type.variables[at], words_[k].substr(equals + 1));
    }
    need(row.numbers.emplace(mode, row.modes.size()).second, "a mode twice");
    row.modes.push_back(std::move(mode));
  }

  void component_row() {
    const std::size_t atom = atom_of(word(1)), row = number(word(3));
    need(word(2) == "class" && word(4) == "reachable", "not `component PATH class N reachable …`");
    need(c_.class_of[atom] == kNone, "a component twice");
    need(row < c_.classes.size() && c_.classes[row].type == m_.atoms[atom].type, "the class does not fit");
    c_.class_of[atom] = row;
    for (std::size_t k = 5; k < words_.size(); ++k) {
      need(number(words_[k]) < c_.classes[row].modes.size(), "no such mode");
      c_.reachable[atom].insert(number(words_[k]));
    }
  }

  void set_row(Text head) {
    const bool is_sum = head == "sum";
    Set set{head == "trap", {}, is_sum ? number(word(1), 0, kMostWeight) : 1, place()};
    for (std::size_t k = is_sum ? 2 : 1; k < words_.size(); ++k) {
      const auto [member, weight] = is_sum ? split(words_[k], words_[k].rfind('*')) : std::pair<Text, Text>(words_[k], "1");
      const auto [path, mode] = split(member, member.rfind(':'));
      const bool is_new = set.weights.emplace(std::pair(atom_of(path), number(mode)), number(weight, 1, kMostWeight)).second;
      need(is_new || !is_sum, "a mode twice");
    }
    c_.sets.push_back(std::move(set));
  }

  // "!ROOT.a@PLACE", "ROOT.a.n:3", "ROOT.a.n=-5"
  [[nodiscard]] std::vector<Literal> literals(std::size_t first) const {
    std::vector<Literal> result;
    for (std::size_t k = first; k < words_.size(); ++k) {
      const bool is_negated = words_[k][0] == '!';
      const Text name = words_[k].substr(is_negated ? 1 : 0);
      const std::size_t at = name.find('@');
      const auto [owner, what] = split(name, at != Text::npos ? at : name.find_last_of(":="));
      Literal one = at != Text::npos ? about(name) : about(owner);
      const Variable& variable = m_.type_of(one.atom).variables[one.variable];
      if (at == Text::npos && name[owner.size()] == '=') one.low = one.high = value_of(variable, what);
      else if (at == Text::npos) one.bit = number(what, 0, variable.type == "bool" ? 0 : 31);
      one.is_negated = is_negated;
      result.push_back(one);
    }
    return result;
  }
  // PATH@PLACE or PATH.SLOT
  [[nodiscard]] Literal about(Text name) const {
    const bool is_place = name.find('@') != Text::npos;
    const auto [path, what] = split(name, is_place ? name.find('@') : name.rfind('.'));
    const std::size_t atom = atom_of(path);
    return {atom, variable(m_.type_of(atom), what, is_place), 1, 1, {}, false};
  }

  [[nodiscard]] std::pair<Text, Text> split(Text text, std::size_t at) const {
    need(at != Text::npos, "is no name with what is said of it", text);
    return {text.substr(0, at), text.substr(at + 1)};
  }
  [[nodiscard]] std::size_t atom_of(Text path) const {
    const auto found = atoms_.find(path);
    need(found != atoms_.end(), "is no component", path);
    return found->second;
  }
  [[nodiscard]] std::size_t variable(const AtomType& type, Text name, bool is_place) const {
    const std::size_t row = find_variable(type, name, is_place);
    need(row != kNone, is_place ? "is no place here" : "is no data here", name);
    need(is_exact(type.variables[row].type), "cannot be followed", name);
    return row;
  }
  // Between two ends, written in the one way.
  [[nodiscard]] int number(Text text, int least, int most) const {
    int value = 0;
    (void)std::from_chars(text.data(), text.data() + text.size(), value);
    need(std::to_string(value) == text && value >= least && value <= most, "is no number here", text);
    return value;
  }
  [[nodiscard]] std::size_t number(Text text) const { return static_cast<std::size_t>(number(text, 0, Limits::max())); }
  // false and true as 0 and 1; strings as rows, -1 for "" where no row has it.
  [[nodiscard]] int value_of(const Variable& variable, Text text) const {
    const bool is_bool = variable.type == "bool";
    const int value = number(text, is_bool ? 0 : Limits::min(), is_bool ? 1 : Limits::max());
    return variable.type == "string" ? std::max(value, 0) : value;
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
