// What is read. First .bsys text as nested lists, with a stack of its own, so that depth costs heap; nothing of the
// compiler is used here, on purpose. Of a system: types of atoms, and all connectors as one graph over atoms' ports. Of
// a certificate: its rows, with names turned into numbers.
#pragma once
#include <algorithm>
#include <array>
#include <charconv>
#include <istream>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <z3++.h>

namespace certcheck {

/// The certificate or the system is not what it should be.
struct Rejected : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// It may be sound, but this program cannot tell.
struct NotCheckable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline constexpr std::size_t kNone = ~std::size_t{0};
using Rows = std::vector<std::size_t>;
using Text = std::string_view;

[[nodiscard]] inline std::string quoted(Text text) { return '`' + std::string(text) + '`'; }
template <class Range, class Value>
[[nodiscard]] bool contains(const Range& range, const Value& value) {
  return std::find(range.begin(), range.end(), value) != range.end();
}
/// The row that is called so.
template <class Range, class Member>
[[nodiscard]] std::size_t row_of(const Range& rows, Text name, Member member) {
  const auto found = std::ranges::find(rows, name, member);
  return found != rows.end() ? static_cast<std::size_t>(found - rows.begin())
                             : throw Rejected(quoted(name) + " is not there");
}

struct Tree {
  bool is_list = false, is_string = false;
  Text text;  // of a word or string, in the text that was read; escapes stay: strings are only compared with each other
  std::vector<Tree> items;  // of a list

  friend bool operator==(const Tree&, const Tree&) = default;
  [[nodiscard]] Text head() const { return items.empty() ? Text() : items[0].text; }
  [[nodiscard]] const Tree& at(std::size_t k) const { return items.at(k); }
  [[nodiscard]] std::vector<const Tree*> all(Text name) const {
    std::vector<const Tree*> found;
    for (const Tree& item : items)
      if (item.head() == name) found.push_back(&item);
    return found;
  }
  /// The first list within this one with that head, or an empty one.
  [[nodiscard]] const Tree& operator[](Text name) const {
    static const Tree kEmpty{true, false, {}, {}};
    const auto found = std::find_if(items.begin(), items.end(), [&](const Tree& item) { return item.head() == name; });
    return found == items.end() ? kEmpty : *found;
  }
  /// The lists with one of these heads, at any depth.
  [[nodiscard]] std::vector<const Tree*> find(const std::vector<Text>& heads) const {
    std::vector<const Tree*> found;
    for (const Tree& item : items) {
      if (contains(heads, item.head())) found.push_back(&item);
      const std::vector<const Tree*> inner = item.find(heads);
      found.insert(found.end(), inner.begin(), inner.end());
    }
    return found;
  }
  /// Is that a word from item `first` on?
  [[nodiscard]] bool has_word(Text word, std::size_t first) const {
    for (std::size_t k = first; k < items.size(); ++k)
      if (!items[k].is_list && !items[k].is_string && items[k].text == word) return true;
    return false;
  }
  /// A word "-7" or "7".
  [[nodiscard]] int number(int most = 10000) const {
    int value = 0;
    const char* const end = text.data() + text.size();
    const auto [last, error] = std::from_chars(text.data(), end, value);
    const bool is_small = !is_list && error == std::errc() && last == end && value > -most && value < most;
    return is_small ? value : throw Rejected("a small number was expected, not " + quoted(text));
  }
  /// A word "7:name" or "7" as 7.
  [[nodiscard]] std::size_t row() const {
    std::uint32_t value = 0;
    const bool is_row = !is_list && std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc();
    return is_row ? value : throw Rejected("a row number was expected, not " + quoted(text));
  }
  /// "5000000ns"
  [[nodiscard]] std::int64_t ticks() const {
    std::int64_t value = 0;
    const char* const end = text.data() + text.size();
    const auto [last, error] = std::from_chars(text.data(), end, value);
    const bool is_time = !is_list && error == std::errc() && std::string_view(last, end) == "ns";
    return is_time ? value : throw Rejected("a time was expected, not " + quoted(text));
  }
  /// The rows after a list's head.
  [[nodiscard]] Rows rows() const {
    Rows rows;
    for (std::size_t k = 1; k < items.size(); ++k) rows.push_back(items[k].row());
    return rows;
  }
};

/// A list of all that the text has; the text must stay.
[[nodiscard]] inline Tree read_trees(Text text) {
  // Code is followed by functions that call themselves.
  constexpr std::size_t kMaxDepth = 10000;
  std::vector<Tree> open(1, Tree{true, false, {}, {}});
  for (std::size_t at = 0, end = 0; at < text.size(); at = end) {
    const char c = text[at];
    end = at + 1;
    if (c == ';') {
      end = std::min(text.find('\n', at), text.size());
    } else if (c == '(') {
      open.push_back(Tree{true, false, {}, {}});
      if (open.size() > kMaxDepth) throw NotCheckable("lists are nested too deeply");
    } else if (c == ')') {
      if (open.size() < 2) throw Rejected("one `)` too many");
      Tree done = std::move(open.back());
      open.pop_back();
      open.back().items.push_back(std::move(done));
    } else if (c == '"') {
      while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
      if (end >= text.size()) throw Rejected("a string does not end");
      open.back().items.push_back({false, true, text.substr(at + 1, end - at - 1), {}});
      ++end;
    } else if (!contains(Text(" \n\t\r"), c)) {
      end = std::min(text.find_first_of(" \n\t\r()\";", at), text.size());
      // Places in the source are of no interest here.
      if (c != '@') open.back().items.push_back({false, false, text.substr(at, end - at), {}});
    }
  }
  return open.size() == 1 ? std::move(open[0]) : throw Rejected("a `)` is missing");
}

/// A place (a bool: is it marked?), data, a clock, or what `resume` says of the atom.
struct Variable {
  Text name, type;
  bool is_param = false;
};
struct Port {
  Text name;
  bool is_exported = false;
  Rows variables;
  std::set<std::size_t> written;  // those that a `down` may change
};
struct Transition {
  std::size_t port = kNone;  // kNone: internal
  Rows from, to;
  const Tree *guard = nullptr, *action = nullptr;  // (guard …) and (do …), perhaps empty
  const Tree *row = nullptr, *resume = nullptr;    // the bounds are in `row`; resume: perhaps empty
  bool is_eager = false, is_delayable = false;
};
/// Its value is a variable; what code sets it to are three others, of which `first_slot` is the first.
struct Clock {
  Text name;
  std::int64_t unit = 1;  // in ticks
  std::size_t first_slot = 0;
};
struct AtomType {
  Text name;
  std::size_t places = 0;  // so many of the variables are places; data follows
  std::vector<Variable> variables;
  std::vector<Port> ports;
  Transition initial;  // from nowhere
  std::vector<Transition> transitions;
  std::vector<const Tree*> priorities, invariants;
  Rows finals;                // places where a run may end
  std::string unfollowed;     // why its atoms cannot be checked
  bool is_automaton = false;  // always exactly one place is marked
  // With time come, as last variables, the clocks; 0 or for which transition's `resume` the atom waits (number + 1, the
  // initial one is the last); and, if it does, the number of the atom with which it goes on.
  bool is_timed = false;
  std::vector<Clock> clocks;
  std::size_t first_clock = 0, waits = 0;

  /// The place or data of that name.
  [[nodiscard]] std::size_t find(Text variable, bool is_place) const {
    const std::span all(variables);
    return is_place ? row_of(all.first(places), variable, &Variable::name)
                    : places + row_of(all.subspan(places), variable, &Variable::name);
  }
};
struct Atom {
  Text path;
  std::size_t type = 0;
  const Tree* args = nullptr;
};

struct Clause {
  Rows params;
  const Tree *guard = nullptr, *up = nullptr, *down = nullptr;
};
/// All: a rendezvous. Trigger: a group with triggers. Any: exactly one of them (merged ports), each of which is a
/// rendezvous of one.
enum class Kind { Port, All, Trigger, Any };
struct Edge {
  std::size_t node = 0;
  bool is_trigger = false;
  bool is_maximal = false;  // only the largest interactions of the connector there
};
struct Node {
  Kind kind = Kind::Port;
  std::vector<Edge> children;
  Rows parents;
  bool is_step = false;
  std::size_t connector = kNone;  // whose root group it is
};
/// A variable of a port that a connector binds: of which parameter, which one, its type.
using BoundVariable = std::tuple<std::size_t, std::size_t, Text>;
struct Connector {
  Text path;
  std::size_t root = 0, compound = 0;
  std::vector<Edge> params;
  std::vector<BoundVariable> bound;
  const Tree* data = nullptr;
  std::vector<Text> variables;  // their types
  Rows exported;                // variables of the port that it exports
  std::vector<Clause> clauses;
  bool is_sync = false;  // its ports resume together
  bool is_cut = false;   // more take part than the model has: it is not known whether they can
};

struct Model {
  bool is_timed = false;
  std::string text;
  Tree tree;
  std::map<Text, int> strings;
  std::vector<AtomType> atom_types;
  std::vector<const Tree*> functions, priorities;
  std::vector<Atom> atoms;
  Rows first_port;  // by atom, and the total: node of its port 0
  Rows atom_of_port;
  std::vector<Connector> connectors;
  std::vector<Node> nodes;  // children before parents; ports first

  [[nodiscard]] const AtomType& type_of(std::size_t atom) const { return atom_types[atoms[atom].type]; }
  [[nodiscard]] const Port& port(std::size_t node) const {
    return type_of(atom_of_port.at(node)).ports[node - first_port[atom_of_port[node]]];
  }
};

/// The model keeps the text, and points into it.
void read_model(std::string text, Model& model);

/// Nothing happens in it.
[[nodiscard]] AtomType empty_type(Text name);
/// The model with one more atom, `observer`: a bool `waits` and a clock `since`, which no step touches. Points into the
/// model.
[[nodiscard]] Model with_observer(const Model& model);

/// Types whose values are followed; of float and FFI data nothing is known.
[[nodiscard]] inline bool is_exact(Text type) { return type == "int" || type == "bool" || type == "string"; }

inline constexpr int kMostWeight = 0x40000000;
/// By variable of an atom: its value, or nothing where it may be any.
using Values = std::vector<std::optional<int>>;
using Modes = std::set<std::size_t>;
struct Class {
  std::size_t type = 0;
  std::vector<bool> followed;  // by variable: places are
  std::vector<Values> modes;
  std::map<Values, std::size_t> numbers;
};
/// A variable is between two values, or one of its bits is set: or not. Of a set: the atom is in a mode.
struct Literal {
  std::size_t atom = 0, variable = 0;
  int low = 1, high = 1;
  std::optional<unsigned> bit = {};
  bool is_negated = false;

  friend auto operator<=>(const Literal&, const Literal&) = default;
};
/// All literals hold; or, in a sum, a variable's value. Times its weight.
struct Case {
  std::vector<Literal> literals;
  bool is_value = false;
  int weight = 1;
};
/// The bits beside the states in a proof about runs (rounds.hpp), variables of one more atom than there are: what the
/// tester of the claim knows; is the demand met in this round; are more rounds over; have rounds begun; is the turn
/// guessed to be impossible from there on.
struct Monitor {
  enum Kind : std::size_t { Bit, Seen, Over, Started, Never, kKinds };
  static constexpr std::size_t row(std::size_t kind, std::size_t number) { return number * kKinds + kind; }
};
/// A word of the row `fairness`: of each interaction, of each atom, or of one connector, port (its node) or atom.
struct Fair {
  enum What : std::size_t { Interactions, Atoms, Connector, Port, Atom, kKinds } what = Interactions;
  bool is_strong = false;
  std::size_t row = kNone;
};
/// What a word of fairness demands: a step of the atom, or of the connector or port; or the interaction of the
/// connector (kNone: a port alone) with these ports.
struct Turn {
  std::size_t fair = 0;  // row of Certificate::fair
  std::size_t row = kNone;
  Rows ports;
};
/// One of the cases holds; or what they are, times their weights, adds up to the total, modulo 2^32. A bound: to the
/// total at most; its weights are not below 0, all of them add up to less than kMostWeight, and at most one case of a
/// component holds.
struct Fact {
  std::string line;
  std::vector<Case> cases;
  std::optional<int> total;
  bool is_bound = false;
  std::size_t step = kNone;  // of a bound that holds where no interaction of this node is possible: weights of any sign
};
/// A clock (of an atom, by variable) less another one is at most the limit; kNone: 0.
struct Bound {
  std::size_t atom = kNone, clock = 0, other_atom = kNone, other_clock = 0;
  std::int64_t limit = 0;
};
struct Zone {
  std::vector<Bound> bounds;
  std::size_t rank = 0;  // of claims that something comes
};
/// With time: states say nothing of components that are like these two, any two of which they speak of (pairs.cpp).
struct Pair {
  std::size_t first = kNone, second = kNone;
  std::set<std::pair<std::size_t, std::size_t>> holders;  // atom, variable: may hold the number of such a component
};
/// A row of an automaton that reads sets of modes, by atom: first those outside of the arrays, then position by
/// position.
struct SetRow {
  std::string line;
  Text promise;  // trap, at-most, at-least: of the first; of others none
  std::size_t from = kNone, position = 0, to = 0;
  std::map<std::size_t, Modes> modes;
};
struct Certificate {
  std::string claim, fairness;                 // the latter of claims about runs; empty: none
  std::vector<Fair> fair;                      // what it says, word by word; none: nothing
  std::optional<std::size_t> rounds;           // of claims about runs without states: no run has more
  std::optional<std::int64_t> later;           // of claims that something comes: ticks
  std::map<std::size_t, std::size_t> returns;  // the same: of ranks, an atom
  std::vector<Turn> turns;                     // that each round has
  std::vector<Fact> facts, sets;               // sets: of modes; without total: traps
  std::vector<Fact> unless;                    // bounds of states without steps
  std::map<Values, char32_t> row_of_local;     // parameters as 0
  std::vector<Values> locals;
  std::set<std::u32string> states;                    // all that a search has reached: by atom a row of locals
  std::map<std::u32string, std::vector<Zone>> zones;  // with time: of each state, one of these holds
  std::vector<std::vector<bool>> is_told;             // with time, by atom and variable: states say it; else: any value
  std::optional<Pair> pair;
  std::vector<SetRow> set_rows;  // of a proof for all sizes
  std::vector<Class> classes;    // none: the certificate says nothing of modes
  Rows class_of;                 // by atom
  std::vector<Modes> reachable;
};

/// Is nothing expected after it?
enum class Last { Yes, No };
[[nodiscard]] Certificate read_certificate(const Model& model, std::istream& text, Last last = Last::Yes);
/// Is it a proof? Says how much was checked; throws Rejected or NotCheckable (states.cpp). Z3 is slow to give up what
/// it holds.
[[nodiscard]] std::string check(const Model& model, const Certificate& certificate, z3::context& z);
[[nodiscard]] std::string check(const Model& model, std::istream& certificate, z3::context& z);
/// The same of a text with several systems, for all sizes of one (sizes.cpp), or with one.
[[nodiscard]] std::string check_all(const std::string& systems, std::istream& certificates, z3::context& z);
/// The two of the certificate and a third one; without the other ones that are like them, but for what all do together.
struct PairModel {
  Model model;
  std::array<std::size_t, 3> members{};
  // What tells those apart that are alike, if anything does: of these three, then of the others; where it is an
  // argument.
  std::vector<int> numbers;
  std::array<std::vector<const Tree*>, 3> args;
};
/// Any three are to the rest as these three are, but for their numbers; throws Rejected or NotCheckable (pairs.cpp).
[[nodiscard]] PairModel model_of_pair(const Model& model, const Certificate& certificate);
/// The same for a model with time (zones.cpp): listed are states of all components with zones, or those of a pair.
void check_zones(const Model& model, const Certificate& certificate, z3::context& z, const PairModel* pair = nullptr);
/// Modes of the first of these sizes, with rows that say how it grows, exclude a deadlock from it on (words.cpp). The
/// others are compared with what the rows say.
void check_words(const std::vector<const Model*>& models, const Certificate& certificate, z3::context& z);
/// From which mode to which.
using Moves = std::vector<std::pair<std::size_t, std::size_t>>;
/// What an atom begins in, and the moves of its ports from modes that it can be in: to those, or to none (kNone).
struct AtomMoves {
  std::vector<Moves> by_port;
  Modes first;
};
/// Do two cases, all of whose literals are about one component, exclude each other?
[[nodiscard]] bool are_exclusive(const Model& model, const std::vector<Literal>& a, const std::vector<Literal>& b);
/// By atom, whatever its connectors do.
[[nodiscard]] std::vector<AtomMoves> moves_of(const Model& model, const Certificate& certificate, z3::context& z);
/// Modes are closed, reachable ones and sets are kept by every step (structure.cpp).
void check_structure(const Model& model, const Certificate& certificate, z3::context& z);

}  // namespace certcheck
