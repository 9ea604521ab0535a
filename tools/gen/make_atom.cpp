// Random atom types: state machines, or two of them in one Petri net (1-safe by construction: every transition takes
// and puts one token in each group that it touches). A port's transitions leave different markings or have opposite
// guards, so that the run-time error "two enabled transitions of one port" does not end most runs at once.
#include "tools/gen/make.hpp"

namespace bip::gen {
namespace {

class AtomMaker {
 public:
  AtomMaker(Prng& random, const Style& style, const std::vector<PortType>& types, const std::string& name)
      : random_(random), style_(style), types_(types), code_(random, style) {
    atom_.name = name;
  }

  AtomType make() {
    make_data();
    make_ports();
    make_places();
    for (const Port& port : atom_.ports) make_transitions(port);
    if (!style_.regular && random_.percent(25)) make_internal();
    if (style_.atom_rules) make_rules();
    if (style_.invariants && random_.percent(60)) make_invariant();
    if (random_.percent(60)) atom_.initial_action = code_.body(known(), random_.between(1, 3), 1);
    choose_notation();
    return atom_;
  }

 private:
  std::string fresh(const char* prefix) {
    static const std::vector<std::string> words = {"clock",    "unit",     "second",   "lazy",  "resume",
                                                   "remember", "behavior", "contains", "async", "day"};
    if (style_.odd_names && next_word_ < words.size() && random_.percent(30)) return words[next_word_++];
    return prefix + std::to_string(next_++);
  }
  std::vector<Known> known() const {
    std::vector<Known> result;
    for (const Var& var : atom_.params) result.push_back({"", var.name, var.type, false});
    for (const Var& var : atom_.data) result.push_back({"", var.name, var.type, true});
    return result;
  }
  std::string data_of(Ty type) {
    Var var;
    var.name = fresh("x");
    var.type = type;
    var.exported = random_.percent(style_.ruled ? 60 : 25);
    // Objects begin as C++ makes them.
    const bool is_object = type == Ty::Pair || type == Ty::Wide;
    if (!is_object && random_.percent(40))
      var.init = random_.percent(30) ? code_.expression(type, {}, 1) : code_.literal(type);
    atom_.data.push_back(var);
    return var.name;
  }
  void make_data() {
    for (int n = random_.percent(50) ? random_.between(1, 2) : 0; n > 0; --n) {
      Var var;
      var.name = fresh("n");
      var.type = code_.native_type();
      atom_.params.push_back(var);
    }
    for (int n = random_.between(1, 3); n > 0; --n) data_of(code_.type());
  }
  void make_ports() {
    for (int n = random_.between(1, 4); n > 0; --n) {
      const PortType& type = random_.pick(types_);
      Port port;
      port.name = fresh("p");
      port.type = type.name;
      port.exported = atom_.ports.empty() || !random_.percent(10);
      port.vars = shown(type);
      if (style_.merged && port.exported && random_.percent(40)) {
        port.merged = fresh("m");
        Port other = port;
        other.name = fresh("p");
        other.vars = shown(type);
        atom_.ports.push_back(port);
        port = other;
      }
      atom_.ports.push_back(port);
    }
  }
  /// Data for a port's variables, new ones if there are none of the type.
  std::vector<std::string> shown(const PortType& type) {
    std::vector<std::string> vars;
    std::set<std::string> used;
    for (const Var& var : type.vars) {
      std::vector<std::string> fitting;
      for (const Var& d : atom_.data) {
        if (d.type == var.type && !used.contains(d.name)) fitting.push_back(d.name);
      }
      vars.push_back(fitting.empty() ? data_of(var.type) : random_.pick(fitting));
      used.insert(vars.back());
    }
    return vars;
  }
  /// Rules that go up in rank, so that no cycle can close; one with `*` stands alone.
  void make_rules() {
    std::vector<std::string> ranked;
    for (const Port& port : atom_.ports) ranked.push_back(port.name);
    if (ranked.size() < 2) return;
    random_.shuffle(ranked);
    bool star = random_.percent(20);
    for (int k = 0, n = star ? 1 : random_.between(1, 3); k < n; ++k) {
      std::size_t low = random_.below(ranked.size() - 1), high = low + 1 + random_.below(ranked.size() - low - 1);
      AtomRule rule{"r" + std::to_string(k), ranked[low], ranked[high], {}};
      if (star) (random_.percent(50) ? rule.low : rule.high) = "*";
      if (random_.percent(50)) rule.guard = code_.guard(known());
      atom_.rules.push_back(rule);
    }
  }
  void make_invariant() {
    static const std::vector<std::string> scopes = {"", "at", "from"};
    Invariant invariant;
    invariant.name = "i0";
    invariant.scope = random_.pick(scopes);
    if (!invariant.scope.empty()) invariant.places.push_back(random_.pick(first_));
    if (invariant.scope == "at" && !second_.empty()) invariant.places.push_back(random_.pick(second_));
    invariant.condition = code_.guard(known());
    // Violated at once in too many models otherwise.
    if (random_.percent(60)) {
      Expr other = unary("!", invariant.condition, Ty::Bool);
      invariant.condition = binary("||", invariant.condition, std::move(other), Ty::Bool);
    }
    atom_.invariants.push_back(std::move(invariant));
  }
  void make_places() {
    int n = random_.between(1, 4);
    for (int k = 0; k < n; ++k) first_.push_back("S" + std::to_string(k));
    if (!style_.regular && random_.percent(15)) {
      for (int k = 0, m = random_.between(2, 3); k < m; ++k) second_.push_back("U" + std::to_string(k));
    }
    atom_.places = first_;
    atom_.places.insert(atom_.places.end(), second_.begin(), second_.end());
    atom_.initial.push_back(random_.pick(first_));
    if (!second_.empty()) atom_.initial.push_back(random_.pick(second_));
  }
  /// Places that a port's transitions leave: distinct choices over the same groups exclude each other.
  std::vector<std::vector<std::string>> sources() {
    std::vector<std::vector<std::string>> result;
    int groups = second_.empty() ? 0 : random_.between(0, 2);
    if (groups == 0 || groups == 2) {
      for (const std::string& s : first_) {
        if (groups == 0) result.push_back({s});
        for (const std::string& u : second_) {
          if (groups == 2) result.push_back({s, u});
        }
      }
    } else {
      for (const std::string& u : second_) result.push_back({u});
    }
    random_.shuffle(result);
    return result;
  }
  std::vector<std::string> targets(const std::vector<std::string>& from) {
    std::vector<std::string> result;
    for (const std::string& place : from) result.push_back(random_.pick(place[0] == 'S' ? first_ : second_));
    return result;
  }
  void make_transitions(const Port& port) {
    auto from = sources();
    std::size_t count = style_.lively && random_.percent(80) ? from.size() : 1 + random_.below(from.size());
    if (style_.regular) count = 1;
    for (std::size_t k = 0; k < count; ++k) {
      Transition t;
      t.port = port.name;
      t.from = from[k];
      t.to = targets(t.from);
      if (!style_.regular && random_.percent(style_.lively ? 15 : 35)) t.guard = code_.guard(known());
      if (random_.percent(65)) t.action = code_.body(known(), random_.between(1, 2), 1);
      atom_.transitions.push_back(t);
      if (t.guard && random_.percent(40)) add_opposite(t);
    }
  }
  void add_opposite(Transition t) {
    t.guard = unary("!", std::move(*t.guard), Ty::Bool);
    t.to = targets(t.from);
    t.action = code_.body(known(), random_.between(1, 2), 1);
    atom_.transitions.push_back(std::move(t));
  }
  /// Internal transitions lead to later places only, or count to seven: both end.
  void make_internal() {
    for (std::size_t k = 0; k < first_.size(); ++k) {
      if (!random_.percent(35)) continue;
      Transition t;
      t.from = {first_[k]};
      if (k + 1 < first_.size()) {
        t.to = {first_[k + 1 + random_.below(first_.size() - k - 1)]};
        if (random_.percent(70)) t.guard = code_.guard(known());
        if (random_.percent(60)) t.action = code_.body(known(), 1, 1);
        atom_.transitions.push_back(t);
        if (t.guard && random_.percent(30)) add_opposite_internal(t, k);
        continue;
      }
      std::string counter = data_of(Ty::Int);
      Expr name;
      name.kind = ExprKind::Name;
      name.name = counter;
      t.to = t.from;
      t.guard = binary("<", binary("&", name, int_literal(7), Ty::Int), int_literal(random_.between(1, 7)), Ty::Bool);
      Stmt stmt;
      stmt.name = counter;
      stmt.value = binary("+", name, int_literal(1), Ty::Int);
      t.action.push_back(stmt);
      atom_.transitions.push_back(t);
    }
  }
  void add_opposite_internal(Transition t, std::size_t k) {
    t.guard = unary("!", std::move(*t.guard), Ty::Bool);
    t.to = {first_[k + 1 + random_.below(first_.size() - k - 1)]};
    atom_.transitions.push_back(std::move(t));
  }
  void choose_notation() {
    bool fits = style_.paper && atom_.params.empty() && second_.empty() && !style_.odd_names;
    fits = fits && atom_.rules.empty() && atom_.invariants.empty();
    for (const Var& var : atom_.data) fits = fits && !var.exported;
    for (const Port& port : atom_.ports) fits = fits && port.exported && port.merged.empty();
    for (const Transition& t : atom_.transitions) fits = fits && !t.port.empty();
    atom_.paper = fits;
  }

  Prng& random_;
  const Style& style_;
  const std::vector<PortType>& types_;
  CodeMaker code_;
  AtomType atom_;
  std::vector<std::string> first_, second_;
  int next_ = 0;
  std::size_t next_word_ = 0;
};

}  // namespace

AtomType make_atom(Prng& random, const Style& style, const std::vector<PortType>& types, const std::string& name) {
  return AtomMaker(random, style, types, name).make();
}

}  // namespace bip::gen
