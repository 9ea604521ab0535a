// Reads a certificate line by line (compiler/docs/certificate.md), strictly: every word counts.
#include "tools/certcheck/certificate.hpp"

#include <algorithm>
#include <sstream>

namespace certcheck {

namespace {

class Reader {
 public:
  explicit Reader(const Model& model) : m_(model) {
    for (std::size_t k = 0; k < m_.atoms.size(); ++k) atoms_.emplace(m_.atoms[k].path, k);
    c_.class_of.assign(m_.atoms.size(), kNone);
    c_.reachable.resize(m_.atoms.size());
  }

  Certificate run(const std::string& text) {
    std::istringstream in(text);
    bool has_end = false;
    for (std::string line; std::getline(in, line);) {
      ++line_;
      if (has_end) fail("something follows the end");
      words_.clear();
      std::istringstream words(line);
      for (std::string word; words >> word;) words_.push_back(word);
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
    if (has_modes) split_classes();
    return std::move(c_);
  }

 private:
  // Modes may overlap: which one a move meets is judged for components that can be in the same ones, so each such group is a class.
  void split_classes() {
    std::map<std::pair<std::size_t, std::set<std::size_t>>, std::size_t> rows;
    const std::size_t count = c_.classes.size();
    std::vector<bool> is_taken(count, false);
    for (std::size_t atom = 0; atom < c_.class_of.size(); ++atom) {
      const std::size_t old = c_.class_of[atom];
      const auto [at, is_new] = rows.try_emplace({old, c_.reachable[atom]}, old);
      if (is_new && is_taken.at(old)) {
        at->second = c_.classes.size();
        c_.classes.push_back(Class(c_.classes[old]));
      }
      is_taken[old] = true;
      c_.class_of[atom] = at->second;
    }
  }
  [[noreturn]] void fail(const std::string& why) const { throw Rejected("line " + std::to_string(line_) + ": " + why); }
  const std::string& word(std::size_t k) const {
    if (k >= words_.size()) fail("a word is missing");
    return words_[k];
  }

  void row(const std::string& line) {
    const std::string head = words_.empty() ? "" : words_[0];
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
    } else if (head == "lemma" || head == "range") {
      Fact fact;
      if (head == "lemma") fact.literals = literals(1);
      else fact.literals.push_back(range());
      fact.text = "line " + std::to_string(line_);
      c_.facts.push_back(std::move(fact));
    } else {
      fail("an unknown row");
    }
  }

  void class_row() {
    if (word(1) != std::to_string(c_.classes.size())) fail("not the number of the next class");
    Class row;
    while (row.type < m_.atom_types.size() && m_.atom_types[row.type].name != word(2)) ++row.type;
    if (row.type == m_.atom_types.size()) fail("no atom type `" + word(2) + "`");
    const AtomType& type = m_.atom_types[row.type];
    row.followed.assign(type.slots.size(), false);
    for (std::size_t k = 3; k < words_.size(); ++k) row.followed[slot(type, words_[k])] = true;
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
      const std::size_t equals = words_[k].find('=');
      if (equals == std::string::npos) {
        mode.places.insert(find(type.places, words_[k]));
        continue;
      }
      const std::size_t at = slot(type, words_[k].substr(0, equals));
      const std::string text = words_[k].substr(equals + 1);
      if (!row.followed[at]) fail("a value that is not followed");
      if (text != "?") mode.values[at] = value_of(type.types[at], text);
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

  void set_row(const std::string& head) {
    Set set;
    set.is_trap = head == "trap";
    set.text = "line " + std::to_string(line_);
    const bool is_sum = head == "sum";
    if (is_sum) set.total = weight(word(1), 0);
    for (std::size_t k = is_sum ? 2 : 1; k < words_.size(); ++k) {
      const std::size_t star = is_sum ? words_[k].rfind('*') : std::string::npos, colon = words_[k].rfind(':', star);
      if (colon == std::string::npos) fail("no mode in `" + words_[k] + "`");
      const std::size_t mode = number(words_[k].substr(colon + 1, star == std::string::npos ? star : star - colon - 1));
      const bool is_new = set.weights.emplace(std::pair(atom_of(words_[k].substr(0, colon)), mode), star == std::string::npos ? 1 : weight(words_[k].substr(star + 1), 1)).second;
      if (!is_new && is_sum) fail("a mode twice");
    }
    c_.sets.push_back(std::move(set));
  }

  // "ROOT.a.n 0 7"
  [[nodiscard]] Literal range() const {
    if (words_.size() != 4) fail("a range is of one slot, with two ends");
    Literal literal = about_slot(word(1));
    literal.about = Literal::Range;
    literal.low = value(word(2));
    literal.high = value(word(3));
    return literal;
  }
  // "!ROOT.a@PLACE", "ROOT.a.n:3", "ROOT.a.n=-5"
  [[nodiscard]] std::vector<Literal> literals(std::size_t first) const {
    std::vector<Literal> result;
    for (std::size_t k = first; k < words_.size(); ++k) {
      const bool is_negated = words_[k][0] == '!';
      const std::string name = words_[k].substr(is_negated ? 1 : 0);
      const std::size_t at = name.find('@'), end = name.find_last_of(":=");
      Literal literal;
      if (at != std::string::npos) {
        literal.atom = atom_of(name.substr(0, at));
        literal.row = find(m_.type_of(literal.atom).places, name.substr(at + 1));
      } else {
        if (end == std::string::npos) fail("`" + words_[k] + "` is no literal");
        literal = about_slot(name.substr(0, end));
        literal.about = name[end] == ':' ? Literal::Bit : Literal::Value;
        const std::string& type = m_.type_of(literal.atom).types[literal.row];
        literal.low = literal.high = literal.about == Literal::Bit ? value(name.substr(end + 1)) : value_of(type, name.substr(end + 1));
        const int bits = type == "bool" ? 1 : 32;
        if (literal.about == Literal::Bit && (literal.low < 0 || literal.low >= bits)) fail("no such bit in `" + words_[k] + "`");
      }
      literal.is_negated = is_negated;
      result.push_back(literal);
    }
    return result;
  }
  [[nodiscard]] Literal about_slot(const std::string& path) const {
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos) fail("no slot in `" + path + "`");
    Literal literal;
    literal.atom = atom_of(path.substr(0, dot));
    literal.row = slot(m_.type_of(literal.atom), path.substr(dot + 1));
    return literal;
  }

  [[nodiscard]] std::size_t atom_of(const std::string& path) const {
    const auto found = atoms_.find(path);
    if (found == atoms_.end()) fail("no component `" + path + "`");
    return found->second;
  }
  [[nodiscard]] std::size_t find(const std::vector<std::string>& names, const std::string& name) const {
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end()) fail("no `" + name + "` here");
    return static_cast<std::size_t>(at - names.begin());
  }
  [[nodiscard]] std::size_t slot(const AtomType& type, const std::string& name) const {
    const std::size_t row = find(type.slots, name);
    if (!is_exact(type.types[row])) fail("`" + name + "` cannot be followed");
    return row;
  }
  // Of at most 32 bits, written in the one way.
  [[nodiscard]] std::size_t number(const std::string& text) const {
    const bool is_one = !text.empty() && text.size() <= 10 && text.find_first_not_of("0123456789") == std::string::npos;
    if (!is_one || std::to_string(std::stoul(text)) != text || std::stoul(text) > 0x80000000UL) fail("`" + text + "` is no number here");
    return std::stoul(text);
  }
  [[nodiscard]] int value(const std::string& text) const {
    const bool is_negative = !text.empty() && text[0] == '-';
    const auto size = static_cast<std::int64_t>(number(text.substr(is_negative ? 1 : 0)));
    if (!is_negative && size > 0x7fffffff) fail("`" + text + "` is no int");
    return static_cast<int>(is_negative ? -size : size);
  }
  // false and true as 0 and 1; strings as rows, -1 for "" where no row has it.
  [[nodiscard]] int value_of(const std::string& type, const std::string& text) const {
    if (type == "bool" && text != "0" && text != "1") fail("`" + text + "` is no bool");
    return type == "string" ? std::max(value(text), 0) : value(text);
  }
  [[nodiscard]] int weight(const std::string& text, std::size_t least) const {
    if (number(text) < least || number(text) > 0x40000000UL) fail("`" + text + "` is no weight");
    return static_cast<int>(number(text));
  }

  const Model& m_;
  Certificate c_;
  std::map<std::string, std::size_t> atoms_;
  std::vector<std::string> words_;
  std::string method_;
  std::size_t line_ = 0;
};

}  // namespace

Certificate read_certificate(const Model& model, const std::string& text) { return Reader(model).run(text); }

}  // namespace certcheck
