// Reads a certificate line by line (compiler/docs/certificate.md), strictly: every word counts.
#include "tools/certcheck/certificate.hpp"

#include <limits>

namespace certcheck {
namespace {

using Limits = std::numeric_limits<int>;

class Reader {
 public:
  explicit Reader(const Model& model) : m_(model) {
    for (std::size_t k = 0; k < m_.atoms.size(); ++k) atoms_.emplace(m_.atoms[k].path, k);
    for (std::size_t k = 0; k < m_.atoms.size(); ++k) {
      state_.emplace_back();
      for (const Variable& variable : m_.type_of(k).variables) state_[k].push_back(variable.is_param ? std::optional(0) : std::nullopt);
    }
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
      need(line_ != 1 || line == "bipc-certificate 1", "not a certificate of version 1");
      has_end = line == "end";
      if (line_ != 1 && !has_end) row(line);
    }
    if (!has_end) throw Rejected("the certificate has no end");
    if (c_.claim.empty()) throw Rejected("the certificate does not say what it proves");
    const bool has_modes = !c_.classes.empty() || !c_.sets.empty();
    if (has_modes && contains(c_.class_of, kNone)) throw Rejected("a component has no row");
    if (!c_.states.empty() && (has_modes || !c_.facts.empty())) throw Rejected("more is said than which states there are");
    return std::move(c_);
  }

 private:
  void row(Text line) {
    // Each with the least number of its words.
    static const std::map<Text, std::pair<std::size_t, void (Reader::*)()>> kForms{
        {"class", {3, &Reader::class_row}}, {"mode", {3, &Reader::mode_row}}, {"component", {5, &Reader::component_row}},
        {"trap", {1, &Reader::set_row}}, {"one-token", {1, &Reader::set_row}}, {"sum", {2, &Reader::set_row}},
        {"state", {1, &Reader::state_row}}, {"lemma", {1, &Reader::lemma_row}}, {"equation", {3, &Reader::equation_row}}};
    const Text head = words_.empty() ? Text() : words_[0];
    if (line == "method exhaustive") throw NotCheckable("the evidence is a search of all states");
    if (head == "root" || head == "method") return;
    if (head == "claim") {
      need(c_.claim.empty() && line.size() > 6, "one claim is expected");
      c_.claim = line.substr(6);
      return;
    }
    const auto form = kForms.find(head);
    need(form != kForms.end(), "an unknown row");
    need(words_.size() >= form->second.first, "a word is missing");
    (this->*form->second.second)();
  }

  void class_row() {
    need(words_[1] == std::to_string(c_.classes.size()), "not the number of the next class");
    Class& row = c_.classes.emplace_back();
    while (row.type < m_.atom_types.size() && m_.atom_types[row.type].name != words_[2]) ++row.type;
    need(row.type < m_.atom_types.size(), "is no atom type", words_[2]);
    const AtomType& type = m_.atom_types[row.type];
    row.followed.assign(type.variables.size(), false);
    std::fill_n(row.followed.begin(), type.places, true);
    for (std::size_t k = 3; k < words_.size(); ++k) row.followed[variable(type, words_[k], false)] = true;
  }

  void mode_row() {
    need(!c_.classes.empty(), "a mode without class");
    Class& row = c_.classes.back();
    const AtomType& type = m_.atom_types[row.type];
    need(words_[1] == std::to_string(row.modes.size()) && words_[2] == "at", "not the next mode");
    Values mode(type.variables.size());
    std::fill_n(mode.begin(), type.places, 0);
    for (std::size_t k = 3; k < words_.size(); ++k) {
      const std::size_t equals = words_[k].find('=');
      const std::size_t at = variable(type, words_[k].substr(0, equals), equals == Text::npos);
      need(row.followed[at], "a value that is not followed");
      if (equals == Text::npos) mode[at] = 1;
      else if (words_[k].substr(equals + 1) != "?") mode[at] = value(type.variables[at], words_[k].substr(equals + 1));
    }
    need(row.numbers.emplace(mode, row.modes.size()).second, "a mode twice");
    row.modes.push_back(std::move(mode));
  }

  void component_row() {
    const std::size_t atom = atom_of(words_[1]), row = number(words_[3]);
    need(words_[2] == "class" && words_[4] == "reachable", "not `component PATH class N reachable …`");
    need(c_.class_of[atom] == kNone, "a component twice");
    need(row < c_.classes.size() && c_.classes[row].type == m_.atoms[atom].type, "the class does not fit");
    c_.class_of[atom] = row;
    for (std::size_t k = 5; k < words_.size(); ++k) {
      need(number(words_[k]) < c_.classes[row].modes.size(), "no such mode");
      c_.reachable[atom].insert(number(words_[k]));
    }
  }

  void set_row() {
    const bool is_sum = words_[0] == "sum";
    Set& set = c_.sets.emplace_back(Set{line(), words_[0] == "trap", is_sum ? number(words_[1], 0, kMostWeight) : 1, {}});
    for (std::size_t k = is_sum ? 2 : 1; k < words_.size(); ++k) {
      const auto [member, weight] = is_sum ? split(words_[k], words_[k].rfind('*')) : std::pair<Text, Text>(words_[k], "1");
      const auto [path, mode] = split(member, member.rfind(':'));
      const bool is_new = set.weights.emplace(std::pair(atom_of(path), number(mode)), number(weight, 1, kMostWeight)).second;
      need(is_new || !is_sum, "a mode twice");
    }
  }

  // The state of the row before but for what this one says.
  void state_row() {
    for (std::size_t k = 1; k < words_.size(); ++k) {
      const Literal l = literal(words_[k]);
      const AtomType& type = m_.type_of(l.atom);
      const bool is_place = l.variable < type.places;
      need(!l.bit && l.low == l.high && (is_place || !l.is_negated) && !type.variables[l.variable].is_param, "does not tell a value", words_[k]);
      if (is_place && type.is_automaton) std::fill_n(state_[l.atom].begin(), type.places, 0);
      state_[l.atom][l.variable] = l.is_negated ? 0 : l.low;
    }
    need(std::none_of(state_.begin(), state_.end(), [](const Values& local) { return contains(local, std::nullopt); }), "the state is not told in full");
    c_.states.insert(state_);
  }
  void lemma_row() { c_.facts.push_back({line(), cases(1, false), {}}); }
  void equation_row() { c_.facts.push_back({line(), cases(2, true), number(words_[1], Limits::min(), Limits::max())}); }
  // Words from `first` on: literals joined by `&`, and their weight.
  [[nodiscard]] std::vector<Case> cases(std::size_t first, bool is_sum) const {
    std::vector<Case> result;
    for (std::size_t k = first; k < words_.size(); ++k) {
      Case& one = result.emplace_back();
      const auto [text, weight] = is_sum ? split(words_[k], words_[k].rfind('*')) : std::pair<Text, Text>(words_[k], "1");
      one.weight = number(weight, -kMostWeight, kMostWeight);
      one.is_value = is_sum && text.find_first_of("@=:&") == Text::npos;
      for (std::size_t at = 0, end = 0; at <= text.size(); at = end + 1) {
        end = std::min(text.find('&', at), text.size());
        one.literals.push_back(one.is_value ? about(text) : literal(text.substr(at, end - at)));
      }
      if (one.is_value) need(m_.type_of(one.literals[0].atom).variables[one.literals[0].variable].type == "int", "is no int", text);
    }
    return result;
  }
  // "ROOT.a@PLACE", "ROOT.a.n=-5", "ROOT.a.n=1..4", "ROOT.a.n:3"; or "!" and one of these
  [[nodiscard]] Literal literal(Text name) const {
    Literal one;
    const bool is_negated = name.starts_with('!');
    if (is_negated) name.remove_prefix(1);
    if (contains(name, '@')) {
      one = about(name);
    } else {
      const auto [owner, what] = split(name, name.find_last_of(":="));
      one = about(owner);
      const Variable& variable = m_.type_of(one.atom).variables[one.variable];
      const std::size_t dots = what.find("..");
      if (name[owner.size()] == ':') one.bit = static_cast<unsigned>(number(what, 0, variable.type == "bool" ? 0 : 31));
      else one.low = value(variable, what.substr(0, dots));
      one.high = dots == Text::npos ? one.low : value(variable, what.substr(dots + 2));
    }
    one.is_negated = is_negated;
    return one;
  }
  // PATH@PLACE or PATH.SLOT
  [[nodiscard]] Literal about(Text name) const {
    const bool is_place = contains(name, '@');
    const auto [path, what] = split(name, is_place ? name.find('@') : name.rfind('.'));
    Literal one;
    one.atom = atom_of(path);
    one.variable = variable(m_.type_of(one.atom), what, is_place);
    return one;
  }

  [[nodiscard]] std::string line() const { return "line " + std::to_string(line_); }
  void need(bool is_so, Text why, Text what = {}) const {
    if (!is_so) throw Rejected(line() + ": " + (what.empty() ? "" : quoted(what) + ' ') + std::string(why));
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
    const std::size_t row = type.find(name, is_place);
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
  [[nodiscard]] int value(const Variable& variable, Text text) const {
    const bool is_bool = variable.type == "bool";
    const int value = number(text, is_bool ? 0 : Limits::min(), is_bool ? 1 : Limits::max());
    return variable.type == "string" ? std::max(value, 0) : value;
  }

  const Model& m_;
  Certificate c_;
  std::map<Text, std::size_t> atoms_;
  std::vector<Values> state_;  // of the row before
  std::vector<Text> words_;
  std::size_t line_ = 0;
};

}  // namespace

Certificate read_certificate(const Model& model, const std::string& text) { return Reader(model).run(text); }

}  // namespace certcheck
