// Reads a certificate line by line (compiler/docs/certificate.md), strictly: every word counts.
#include "tools/certcheck/checked_model.hpp"

#include <limits>
#include <ranges>

namespace certcheck {
namespace {

class CertificateReader {
 public:
  explicit CertificateReader(const Model& model) : model_(model) {
    for (std::size_t k = 0; k < model_.atoms.size(); ++k) atoms_.emplace(model_.atoms[k].path, k);
    for (std::size_t k = 0; k < model_.atoms.size(); ++k) {
      state_.emplace_back();
      for (const Variable& variable : model_.type_of(k).variables)
        state_[k].push_back(variable.is_param ? std::optional(0) : std::nullopt);
      proof_.is_told.emplace_back(state_[k].size(), false);
    }
    proof_.class_of.assign(model_.atoms.size(), kNone);
    proof_.reachable.resize(model_.atoms.size());
  }

  Certificate run(std::istream& text, Last last) {
    std::string line;
    while (std::getline(text, line) && line != "end") {
      ++line_;
      words_.clear();
      for (const auto word : std::views::split(Text(line), ' '))
        if (!word.empty()) words_.emplace_back(word.begin(), word.end());
      try {
        if (line_ != 1) row(line);
        else need(line == "bipc-certificate 1", "not a certificate of version 1");
      } catch (const Rejected& e) {
        throw Rejected(place() + ": " + e.what());
      }
    }
    if (line != "end" || text.eof() || (last == Last::Yes && text.get() != EOF))
      throw Rejected("its last row is not `end`");
    if (proof_.claim.empty()) throw Rejected("the certificate does not say what it proves");
    if (!proof_.classes.empty() && contains(proof_.class_of, kNone)) throw Rejected("a component has no row");
    if (!proof_.unless.empty() && proof_.claim != "deadlock-free")
      throw Rejected("rows of states without steps, of another claim than that there are none");
    if (!proof_.states.empty() &&
        !(proof_.classes.empty() && proof_.facts.empty() && proof_.sets.empty() && proof_.unless.empty()))
      throw Rejected("more is said than which states there are");
    if (model_.is_timed && (proof_.states.empty() || proof_.zones.size() != proof_.states.size()))
      throw Rejected("the model has time, so states with zones are expected");
    return std::move(proof_);
  }

 private:
  void row(Text line) {
    // Each with the least number of its words.
    static const std::map<Text, std::pair<std::size_t, void (CertificateReader::*)()>> kForms{
        {"class", {3, &CertificateReader::class_row}},         {"mode", {3, &CertificateReader::mode_row}},
        {"component", {5, &CertificateReader::component_row}}, {"trap", {1, &CertificateReader::fact_row}},
        {"one-token", {1, &CertificateReader::fact_row}},      {"sum", {2, &CertificateReader::fact_row}},
        {"lemma", {1, &CertificateReader::fact_row}},          {"equation", {2, &CertificateReader::fact_row}},
        {"state", {1, &CertificateReader::state_row}},         {"pair", {3, &CertificateReader::pair_row}},
        {"zone", {1, &CertificateReader::zone_row}},           {"fairness", {2, &CertificateReader::fairness_row}},
        {"rounds", {2, &CertificateReader::rounds_row}},       {"turn", {2, &CertificateReader::turn_row}},
        {"begin", {3, &CertificateReader::set_row}},           {"next", {4, &CertificateReader::set_row}},
        {"bound", {2, &CertificateReader::fact_row}},          {"later", {2, &CertificateReader::later_row}},
        {"returns", {3, &CertificateReader::returns_row}},     {"unless", {3, &CertificateReader::fact_row}}};
    const Text head = words_.empty() ? Text() : words_[0];
    if (line == "method exhaustive") throw NotCheckable("the evidence is a search of all states");
    if (head == "root" || head == "method") return;
    if (head == "claim") {
      need(proof_.claim.empty() && line.size() > 6, "one claim is expected");
      proof_.claim = line.substr(6);
      return;
    }
    const auto form = kForms.find(head);
    need(form != kForms.end(), "an unknown row");
    need(words_.size() >= form->second.first, "a word is missing");
    (this->*form->second.second)();
  }

  void fairness_row() {
    need(proof_.fairness.empty(), "fairness twice");
    for (std::size_t k = 1; k < words_.size(); ++k) proof_.fairness += (k == 1 ? "" : " ") + std::string(words_[k]);
    if (proof_.fairness == "none") return;
    for (std::size_t k = 1; k < words_.size(); ++k) proof_.fair.push_back(fair(words_[k]));
  }
  // "weak", "strong:atoms", "weak:connector:PATH", "weak:port:PATH.PORT", "strong:atom:PATH"
  [[nodiscard]] Fair fair(Text word) const {
    static const std::vector<Text> kWhats{"", ":atoms", ":connector:", ":port:", ":atom:"};
    Fair fair;
    fair.is_strong = word.starts_with("strong");
    const Text rest = word.substr(std::min<std::size_t>(fair.is_strong ? 6 : 4, word.size()));
    const std::size_t end = std::min(rest.find(':', 1), rest.size() - 1) + 1;
    const auto what = std::ranges::find(kWhats, rest.substr(0, end));
    fair.what = static_cast<Fair::What>(what - kWhats.begin());
    need((fair.is_strong || word.starts_with("weak")) && what != kWhats.end() &&
             (fair.what < Fair::Connector) == (end == rest.size()),
         "is no fairness", word);
    const Text name = rest.substr(end);
    if (fair.what == Fair::Connector) fair.row = row_of(model_.connectors, name, &Connector::path);
    if (fair.what == Fair::Atom) fair.row = atom_of(name);
    if (fair.what == Fair::Port) fair.row = port_of(name);
    return fair;
  }
  // "PATH.PORT"
  [[nodiscard]] std::size_t port_of(Text name) const {
    const auto [path, port] = split(name, name.rfind('.'));
    const std::size_t atom = atom_of(path);
    return model_.first_port[atom] + row_of(model_.type_of(atom).ports, port, &Port::name);
  }
  void rounds_row() {
    need(words_.size() == 2 && !proof_.rounds, "not the number of rounds");
    proof_.rounds = static_cast<std::size_t>(number(words_[1], 0, kMostBits));
  }
  // "later 5ns"
  void later_row() {
    const Text ticks = words_[1].substr(0, words_[1].size() - std::min<std::size_t>(words_[1].size(), 2));
    need(words_.size() == 2 && words_[1].ends_with("ns") && !proof_.later, "no duration");
    proof_.later = ticks_of(ticks);
    need(*proof_.later > 0, "no duration");
  }
  // "returns 3 ROOT.a"
  void returns_row() {
    const std::size_t rank = static_cast<std::size_t>(number(words_[1], 0)), atom = atom_of(words_[2]);
    need(words_.size() == 3 && model_.type_of(atom).is_timed, "no component with time");
    need(proof_.returns.emplace(rank, atom).second, "a rank twice");
  }
  // "begin trap 0 ROOT.a:1", "next 0 2 1 ROOT.b[2]:0 ROOT.c[2]:3"
  void set_row() {
    static const std::vector<Text> kPromises{"trap", "at-most", "at-least"};
    const bool is_first = words_[0] == "begin";
    SetRow& row = proof_.set_rows.emplace_back();
    row.line = place();
    need(!is_first || contains(kPromises, words_[1]), "no promise");
    const auto count = [&](std::size_t k) { return static_cast<std::size_t>(number(words_[k], 0)); };
    if (is_first) row.promise = *std::ranges::find(kPromises, words_[1]);
    else row.from = count(1), row.position = count(2);
    row.to = count(is_first ? 2 : 3);
    for (std::size_t k = is_first ? 3 : 4; k < words_.size(); ++k) {
      const auto [path, number] = split(words_[k], words_[k].rfind(':'));
      row.modes[atom_of(path)].insert(mode(atom_of(path), number));
    }
  }
  // A word of fairness with a name; an atom; or a connector, if it is none of a port alone, and ports.
  void turn_row() {
    Turn& turn = proof_.turns.emplace_back();
    need(!proof_.fair.empty(), "without fairness no turn is expected");
    const bool is_named = words_.size() == 2 && words_[1].find(':') != Text::npos;
    const bool is_atom = words_.size() == 2 && atoms_.contains(words_[1]);
    const Fair wanted = is_named ? fair(words_[1]) : Fair{is_atom ? Fair::Atoms : Fair::Interactions};
    const auto said = std::ranges::find_if(proof_.fair, [&](const Fair& one) {
      return one.what == wanted.what && one.row == wanted.row && (!is_named || one.is_strong == wanted.is_strong);
    });
    need(said != proof_.fair.end(), "a turn of another kind of fairness");
    turn.fair = static_cast<std::size_t>(said - proof_.fair.begin());
    turn.row = is_atom ? atoms_.at(words_[1]) : wanted.row;
    if (is_named || is_atom) return;
    const auto connector = std::ranges::find(model_.connectors, words_[1], &Connector::path);
    if (connector != model_.connectors.end())
      turn.row = static_cast<std::size_t>(connector - model_.connectors.begin());
    for (std::size_t k = turn.row == kNone ? 1 : 2; k < words_.size(); ++k) turn.ports.push_back(port_of(words_[k]));
  }
  void class_row() {
    need(words_.size() == 3 && words_[1] == std::to_string(proof_.classes.size()),
         "not the number of the next class, and its type");
    Class& row = proof_.classes.emplace_back();
    row.type = row_of(model_.atom_types, words_[2], &AtomType::name);
    row.followed.assign(model_.atom_types[row.type].variables.size(), false);
  }

  void mode_row() {
    need(!proof_.classes.empty() && words_[1] == std::to_string(proof_.classes.back().modes.size()),
         "not the next mode");
    Class& row = proof_.classes.back();
    const AtomType& type = model_.atom_types[row.type];
    Values mode(type.variables.size());
    std::fill_n(mode.begin(), type.places, 0);
    for (std::size_t k = 2; k < words_.size(); ++k) tell(type, said(type, words_[k]), mode, words_[k]);
    for (std::size_t k = 0; k < mode.size(); ++k) row.followed[k] = row.followed[k] || mode[k];
    need(row.numbers.emplace(mode, row.modes.size()).second, "a mode twice");
    row.modes.push_back(std::move(mode));
  }

  void component_row() {
    const std::size_t atom = atom_of(words_[1]), row = static_cast<std::size_t>(number(words_[3], 0));
    need(words_[2] == "class" && words_[4] == "reachable", "not `component PATH class N reachable …`");
    need(proof_.class_of[atom] == kNone, "a component twice");
    need(row < proof_.classes.size() && proof_.classes[row].type == model_.atoms[atom].type, "the class does not fit");
    proof_.class_of[atom] = row;
    for (std::size_t k = 5; k < words_.size(); ++k) proof_.reachable[atom].insert(mode(atom, words_[k]));
  }

  // Cases, of sums with their weights: "ROOT.a:2" of sets, of others literals joined by `&`.
  void fact_row() {
    const Text head = words_[0];
    const bool is_unless = head == "unless", is_bound = is_unless || head == "bound", is_equation = head == "equation",
               is_sum = head == "sum" || is_equation || is_bound, is_set = !is_equation && !is_bound && head != "lemma";
    Fact& fact = (is_set      ? proof_.sets
                  : is_unless ? proof_.unless
                              : proof_.facts)
                     .emplace_back(Fact{place(), {}, {}, is_bound});
    std::int64_t most = 0;
    if (is_unless) fact.step = step_of(words_[1]), fact.total = 0;
    else if (is_sum) fact.total = number(words_[1]);
    else if (head == "one-token") fact.total = 1;
    for (std::size_t k = is_sum ? 2 : 1; k < words_.size(); ++k) {
      Case& row = fact.cases.emplace_back();
      const auto [text, weight] =
          is_sum ? split(words_[k], words_[k].rfind('*')) : std::pair<Text, Text>(words_[k], "1");
      row.weight = number(weight, -kMostWeight, kMostWeight);
      most += std::abs(std::int64_t{row.weight});
      need(!is_bound || ((is_unless || row.weight >= 0) && most < kMostWeight), "weights of a bound are not small",
           words_[k]);
      row.is_value = is_equation && text.find_first_of("@=:&!") == Text::npos;
      if (is_set) {
        const auto [path, number] = split(text, text.rfind(':'));
        row.literals.push_back({atom_of(path), mode(atom_of(path), number)});
        continue;
      }
      for (const auto part : std::views::split(text, '&'))
        row.literals.push_back(literal(Text(part.begin(), part.end()), row.is_value));
    }
    if (is_bound) check_bound(fact);
  }
  // Each case is about one component, and at most one case about a component holds.
  void check_bound(const Fact& fact) const {
    std::map<std::size_t, std::vector<const Case*>> cases_of;
    for (const Case& row : fact.cases) {
      for (const Literal& l : row.literals) need(l.atom == row.literals[0].atom, "a case is about two components");
      for (const Case* other : cases_of[row.literals[0].atom])
        need(are_exclusive(model_, row.literals, other->literals),
             "two cases about a component do not exclude each other");
      cases_of[row.literals[0].atom].push_back(&row);
    }
  }
  // The node of a connector that is none of another one, or of a port alone.
  [[nodiscard]] std::size_t step_of(Text name) {
    if (steps_.empty()) {
      for (const Connector& c : model_.connectors) steps_.emplace(c.path, c.root);
    }
    const auto connector = steps_.find(name);
    if (connector == steps_.end()) {
      const auto [path, port] = split(name, name.rfind('.'));
      need(atoms_.contains(path), "is neither a connector nor a port", name);
      const std::size_t atom = atom_of(path);
      return own_step(model_.first_port[atom] + row_of(model_.type_of(atom).ports, port, &Port::name), name);
    }
    return own_step(connector->second, name);
  }
  [[nodiscard]] std::size_t own_step(std::size_t node, Text name) const {
    need(model_.nodes[node].is_step, "is no step of its own", name);
    return node;
  }

  // One value; of an automaton, all of its places.
  void tell(const AtomType& type, const Literal& l, Values& values, Text word) const {
    const bool is_place = l.variable < type.places;
    need(!l.bit && l.low == l.high && (is_place || !l.is_negated), "does not tell a value", word);
    if (is_place && type.is_automaton) std::fill_n(values.begin(), type.places, 0);
    values[l.variable] = l.is_negated ? 0 : l.low;
  }
  // The state of the row before but for what this one says.
  void state_row() {
    for (std::size_t k = 1; k < words_.size(); ++k) {
      const Literal l = literal(words_[k], false);
      const AtomType& type = model_.type_of(l.atom);
      need(!type.variables[l.variable].is_param, "is a parameter", words_[k]);
      // With time, data of which the first state says nothing may have any value, always.
      need(!model_.is_timed || proof_.states.empty() || proof_.is_told[l.atom][l.variable], "is not told of all states",
           words_[k]);
      tell(type, l, state_[l.atom], words_[k]);
    }
    if (model_.is_timed && proof_.states.empty()) tell_first();
    need(std::none_of(state_.begin(), state_.end(), [](const Values& local) { return contains(local, std::nullopt); }),
         "the state is not told in full");
    std::u32string rows;
    for (const Values& local : state_) {
      const auto [at, is_new] = proof_.row_of_local.try_emplace(local, static_cast<char32_t>(proof_.locals.size()));
      if (is_new) proof_.locals.push_back(local);
      rows += at->second;
    }
    now_ = rows;
    proof_.states.insert(std::move(rows));
  }
  // Beside a pair there are components of which nothing is said.
  void tell_first() {
    for (std::size_t a = 0; a < state_.size(); ++a) {
      for (std::size_t k = 0; k < state_[a].size(); ++k)
        proof_.is_told[a][k] = state_[a][k].has_value() && !model_.type_of(a).variables[k].is_param;
      const bool is_silent = proof_.pair && !contains(proof_.is_told[a], true);
      for (std::size_t k = 0; k < state_[a].size(); ++k)
        if (!state_[a][k] && (is_silent || (k >= model_.type_of(a).places && k < model_.type_of(a).waits)))
          state_[a][k] = 0;
    }
  }
  // "pair ROOT.a[0] ROOT.a[1] ROOT.b.n": the two, and data that may hold numbers
  void pair_row() {
    need(model_.is_timed && proof_.states.empty() && !proof_.pair, "no states of a pair follow");
    proof_.pair = Pair{atom_of(words_[1]), atom_of(words_[2]), {}};
    for (std::size_t k = 3; k < words_.size(); ++k) {
      const Literal l = literal(words_[k], true);
      need(!l.is_negated, "is no variable", words_[k]);
      proof_.pair->holders.emplace(l.atom, l.variable);
    }
  }
  // "ROOT.a.x<=7", "ROOT.a.x-ROOT.b.y<=3", "ROOT.a.x>=2": of the state above; first "rank=3"
  void zone_row() {
    need(model_.is_timed && !now_.empty(), "no state has this zone");
    Zone& zone = proof_.zones[now_].emplace_back();
    const bool has_rank = words_.size() > 1 && words_[1].starts_with("rank=");
    if (has_rank) zone.rank = static_cast<std::size_t>(number(words_[1].substr(5), 0));
    for (std::size_t k = has_rank ? 2 : 1; k < words_.size(); ++k) {
      const auto [names, limit] = split(words_[k], words_[k].find('='));
      const bool is_least = names.ends_with('>'), is_most = names.ends_with('<');
      need(is_least || is_most, "is no bound", words_[k]);
      const Text clocks = names.substr(0, names.size() - 1);
      const std::size_t minus = clocks.find('-');
      Bound& bound = zone.bounds.emplace_back();
      std::tie(bound.atom, bound.clock) = clock(clocks.substr(0, minus));
      if (minus != Text::npos) std::tie(bound.other_atom, bound.other_clock) = clock(clocks.substr(minus + 1));
      bound.limit = ticks_of(limit);
      if (!is_least) continue;
      std::swap(bound.atom, bound.other_atom);
      std::swap(bound.clock, bound.other_clock);
      bound.limit = -bound.limit;
    }
  }
  // Its atom, and which variable it is.
  [[nodiscard]] std::pair<std::size_t, std::size_t> clock(Text name) const {
    const std::size_t dot = std::min(name.rfind('.'), name.size());
    const std::size_t atom = atom_of(name.substr(0, dot));
    need(dot != name.size(), "is no clock", name);
    const AtomType& type = model_.type_of(atom);
    return {atom, type.first_clock + row_of(type.clocks, name.substr(dot + 1), &Clock::name)};
  }
  // PATH and what is said of the atom; or "!" and that
  [[nodiscard]] Literal literal(Text name, bool is_value) const {
    const bool is_negated = name.starts_with('!');
    if (is_negated) name.remove_prefix(1);
    if (name.starts_with('%')) {
      Literal literal{model_.atoms.size(), monitor_row(name.substr(1))};
      literal.is_negated = is_negated;
      return literal;
    }
    const std::size_t at = std::min(name.substr(0, name.find_first_of("=:")).find_last_of(".@"), name.size());
    const std::size_t atom = atom_of(name.substr(0, at));
    Literal literal = said(model_.type_of(atom), name.substr(at), is_value);
    literal.atom = atom;
    literal.is_negated = is_negated;
    return literal;
  }
  // "bit3": of the monitor
  [[nodiscard]] std::size_t monitor_row(Text name) const {
    need(proof_.rounds.has_value(), "has no monitor");
    static const std::vector<Text> kKinds{"bit", "seen", "over", "started", "never"};
    const std::size_t digit = std::min(name.find_first_of("0123456789"), name.size());
    return Monitor::row(row_of(kKinds, name.substr(0, digit), std::identity()),
                        static_cast<std::size_t>(number(name.substr(digit), 0, kMostBits)));
  }
  // "@PLACE", ".n=-5", ".n=1..4", ".n:3"; a variable's value is ".n"
  [[nodiscard]] Literal said(const AtomType& type, Text what, bool is_value = false) const {
    const std::size_t mark = std::min(what.find_first_of("=:"), what.size());
    const bool is_place = what.starts_with('@');
    need((is_place || what.starts_with('.')) && (mark == what.size()) == (is_place || is_value), "says nothing", what);
    Literal literal;
    literal.variable = type.find(what.substr(1, mark - 1), is_place);
    const Variable& variable = type.variables[literal.variable];
    need(is_value ? variable.type == "int" : is_exact(variable.type), "cannot be followed", what);
    if (mark == what.size()) return literal;
    const Text told = what.substr(mark + 1);
    const std::size_t dots = told.find("..");
    if (what[mark] == ':') literal.bit = static_cast<unsigned>(number(told, 0, variable.type == "bool" ? 0 : 31));
    else literal.low = value(variable, told.substr(0, dots));
    literal.high = dots == Text::npos ? literal.low : value(variable, told.substr(dots + 2));
    return literal;
  }

  [[nodiscard]] std::string place() const { return "line " + std::to_string(line_); }
  void need(bool is_so, Text why, Text what = {}) const {
    if (!is_so) throw Rejected((what.empty() ? "" : quoted(what) + ' ') + std::string(why));
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
  // Of those that the atom's class has.
  [[nodiscard]] std::size_t mode(std::size_t atom, Text text) const {
    const std::size_t row = proof_.class_of[atom], mode = static_cast<std::size_t>(number(text, 0));
    need(row < proof_.classes.size() && mode < proof_.classes[row].modes.size(), "is no mode here", text);
    return mode;
  }
  // Between two ends, written in the one way.
  [[nodiscard]] int number(Text text, int least = std::numeric_limits<int>::min(),
                           int most = std::numeric_limits<int>::max()) const {
    int value = 0;
    (void)std::from_chars(text.data(), text.data() + text.size(), value);
    need(std::to_string(value) == text && value >= least && value <= most, "is no number here", text);
    return value;
  }
  [[nodiscard]] std::int64_t ticks_of(Text text) const {
    std::int64_t value = 0;
    (void)std::from_chars(text.data(), text.data() + text.size(), value);
    need(std::to_string(value) == text && std::abs(value) < kMostTicks, "is no number here", text);
    return value;
  }
  // false and true as 0 and 1; strings as rows, -1 for "" where no row has it.
  [[nodiscard]] int value(const Variable& variable, Text text) const {
    if (variable.type == "string") return std::max(number(text), 0);
    return variable.type == "bool" ? number(text, 0, 1) : number(text);
  }

  static constexpr int kMostBits = 10000;
  static constexpr std::int64_t kMostTicks = std::int64_t{1} << 62;

  const Model& model_;
  Certificate proof_;
  std::u32string now_;  // the state of the last row
  std::map<Text, std::size_t> atoms_, steps_;
  std::vector<Values> state_;  // of the row before
  std::vector<Text> words_;
  std::size_t line_ = 0;
};

// Do the two literals never hold together?
bool is_exclusive(const AtomType& type, const Literal& a, const Literal& b) {
  if (a.bit || b.bit || (a.is_negated && b.is_negated)) return false;
  const bool are_places = a.variable < type.places && b.variable < type.places && type.is_automaton;
  if (a.variable != b.variable) return are_places && !a.is_negated && !b.is_negated;
  if (a.is_negated) return a.low <= b.low && b.high <= a.high;
  if (b.is_negated) return b.low <= a.low && a.high <= b.high;
  return a.high < b.low || b.high < a.low;
}

}  // namespace

bool are_exclusive(const Model& model, const std::vector<Literal>& a, const std::vector<Literal>& b) {
  return std::ranges::any_of(a, [&](const Literal& one) {
    return std::ranges::any_of(b,
                               [&](const Literal& other) { return is_exclusive(model.type_of(one.atom), one, other); });
  });
}

Certificate read_certificate(const Model& model, std::istream& text, Last last) {
  return CertificateReader(model).run(text, last);
}

}  // namespace certcheck
