// See automaton.hpp.
#include "compiler/verify/liveness/automaton.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "compiler/analysis/graph_algorithms.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::size_t kMaxMarks = 32;
constexpr std::size_t kMaxStates = 4096;
// Of the tableau, all states together: about a second.
constexpr std::size_t kMaxBranches = 200'000, kMaxComparisons = 50'000'000;

using FormulaRow = std::uint32_t;
using ConditionMask = std::uint64_t;

enum class NormalKind : std::uint8_t { False, True, Literal, And, Or, Next, Until, Release };
// A formula in negation normal form; equal ones share a row. True and False have the rows 1 and 0.
struct NormalNode {
  NormalKind kind = NormalKind::False;
  FormulaRow a = 0, b = 0;
  FormulaRow bit = 0;  // Literal
  bool is_negated = false;
  friend auto operator<=>(const NormalNode&, const NormalNode&) = default;
};

// Of a position the automaton reads conditions on its state, on its step, and then the values of the operators that
// look back: bits in this order. By node of the formula; others have none.
std::vector<FormulaRow> bits_of_past(const Formula& formula) {
  std::vector<FormulaRow> bits(formula.nodes.size(), kNoSuccessor);
  auto next = static_cast<FormulaRow>(formula.states.size() + formula.steps.size());
  for (std::size_t row = 0; row < formula.nodes.size(); ++row) {
    if (looks_back(formula.nodes[row].kind)) bits[row] = next++;
  }
  BIP_ASSERT(next <= 64, "{} conditions and operators of the past", next);
  return bits;
}

class NormalForms {
 public:
  NormalForms() {
    (void)add({.kind = NormalKind::False});
    (void)add({.kind = NormalKind::True});
  }
  static constexpr FormulaRow kFalseRow = 0, kTrueRow = 1;
  [[nodiscard]] const NormalNode& operator[](FormulaRow row) const { return nodes_[row]; }
  [[nodiscard]] std::size_t size() const { return nodes_.size(); }

  FormulaRow of(const Formula& formula, bool is_negated) {
    BIP_ASSERT(formula.root < formula.nodes.size(), "node {} of {} is the root", formula.root, formula.nodes.size());
    made_.assign(2 * formula.nodes.size(), kNone);
    bit_of_past_ = bits_of_past(formula);
    return make(formula, formula.root, is_negated);
  }

 private:
  static constexpr FormulaRow kNone = 0xffffffffu;

  FormulaRow add(NormalNode node) {
    const auto [at, is_new] = rows_.try_emplace(node, static_cast<FormulaRow>(nodes_.size()));
    if (is_new) nodes_.push_back(node);
    return at->second;
  }
  [[nodiscard]] bool is_literal_and_negation(FormulaRow a, FormulaRow b) const {
    const NormalNode &x = nodes_[a], &y = nodes_[b];
    return x.kind == NormalKind::Literal && y.kind == NormalKind::Literal && x.bit == y.bit &&
           x.is_negated != y.is_negated;
  }
  // `true U a`, `false R a`.
  [[nodiscard]] bool is_eventually(FormulaRow row) const {
    return nodes_[row].kind == NormalKind::Until && nodes_[row].a == kTrueRow;
  }
  [[nodiscard]] bool is_always(FormulaRow row) const {
    return nodes_[row].kind == NormalKind::Release && nodes_[row].a == kFalseRow;
  }
  FormulaRow make_and(FormulaRow a, FormulaRow b) {
    if (a == b || b == kTrueRow) return a;
    if (a == kTrueRow) return b;
    if (a == kFalseRow || b == kFalseRow || is_literal_and_negation(a, b)) return kFalseRow;
    return add({.kind = NormalKind::And, .a = std::min(a, b), .b = std::max(a, b)});
  }
  FormulaRow make_or(FormulaRow a, FormulaRow b) {
    if (a == b || b == kFalseRow) return a;
    if (a == kFalseRow) return b;
    if (a == kTrueRow || b == kTrueRow || is_literal_and_negation(a, b)) return kTrueRow;
    // Fa || Fb is F(a || b).
    if (is_eventually(a) && is_eventually(b)) return make_until(kTrueRow, make_or(nodes_[a].b, nodes_[b].b));
    return add({.kind = NormalKind::Or, .a = std::min(a, b), .b = std::max(a, b)});
  }
  FormulaRow make_next(FormulaRow a) {
    if (a == kFalseRow || a == kTrueRow) return a;
    return add({.kind = NormalKind::Next, .a = a, .b = a});
  }
  FormulaRow make_until(FormulaRow a, FormulaRow b) {
    if (b == kFalseRow || b == kTrueRow || a == kFalseRow || a == b) return b;
    // a U (a U b), F(a U b), FFb, FGFb.
    const NormalNode right = nodes_[b];
    if (right.kind == NormalKind::Until && right.a == a) return b;
    if (a == kTrueRow && right.kind == NormalKind::Until) return make_until(kTrueRow, right.b);
    if (a == kTrueRow && is_always(b) && is_eventually(right.b)) return b;
    return add({.kind = NormalKind::Until, .a = a, .b = b});
  }
  FormulaRow make_release(FormulaRow a, FormulaRow b) {
    if (b == kFalseRow || b == kTrueRow || a == kTrueRow || a == b) return b;
    const NormalNode right = nodes_[b];
    if (right.kind == NormalKind::Release && right.a == a) return b;
    if (a == kFalseRow && right.kind == NormalKind::Release) return make_release(kFalseRow, right.b);
    if (a == kFalseRow && is_eventually(b) && is_always(right.b)) return b;
    return add({.kind = NormalKind::Release, .a = a, .b = b});
  }
  // The depth of formulas is limited by the parser.
  FormulaRow make(const Formula& formula, FormulaRow row, bool is_negated) {
    FormulaRow& known = made_[2 * row + (is_negated ? 1 : 0)];
    if (known != kNone) return known;
    const FormulaRow made = make_anew(formula, row, is_negated);
    made_[2 * row + (is_negated ? 1 : 0)] = made;
    return made;
  }
  FormulaRow make_anew(const Formula& formula, FormulaRow row, bool is_negated) {
    const FormulaNode& node = formula.nodes[row];
    const auto part = [&](FormulaRow of) { return make(formula, of, is_negated); };
    const FormulaRow steps = static_cast<FormulaRow>(formula.states.size());
    switch (node.kind) {
      case FormulaKind::Constant: return node.value != is_negated ? kTrueRow : kFalseRow;
      case FormulaKind::State: return add({.kind = NormalKind::Literal, .bit = node.row, .is_negated = is_negated});
      case FormulaKind::Step:
        return add({.kind = NormalKind::Literal, .bit = steps + node.row, .is_negated = is_negated});
      case FormulaKind::Not: return make(formula, node.a, !is_negated);
      case FormulaKind::And:
      case FormulaKind::Or: {
        const FormulaRow a = part(node.a), b = part(node.b);
        return (node.kind == FormulaKind::And) != is_negated ? make_and(a, b) : make_or(a, b);
      }
      case FormulaKind::Next: return make_next(part(node.a));
      case FormulaKind::Previously:
      case FormulaKind::Since:
        return add({.kind = NormalKind::Literal, .bit = bit_of_past_[row], .is_negated = is_negated});
      case FormulaKind::Until:
      case FormulaKind::Release: {
        const FormulaRow a = part(node.a), b = part(node.b);
        return (node.kind == FormulaKind::Until) != is_negated ? make_until(a, b) : make_release(a, b);
      }
    }
    BIP_UNREACHABLE("a formula of no kind");
  }

  std::vector<NormalNode> nodes_;
  std::map<NormalNode, FormulaRow> rows_;
  std::vector<FormulaRow> made_;  // by node of the formula, twice: as it is, negated
  std::vector<FormulaRow> bit_of_past_;
};

// A set of formulas, sorted.
using FormulaRows = std::vector<FormulaRow>;
void insert_sorted(FormulaRows& rows, FormulaRow row) {
  const auto at = std::lower_bound(rows.begin(), rows.end(), row);
  if (at == rows.end() || *at != row) rows.insert(at, row);
}

class Tableau {
 public:
  Result<Automaton> run(const Formula& formula, bool is_negated) {
    const FormulaRow root = forms_.of(formula, is_negated);
    for (FormulaRow row = 0; row < forms_.size(); ++row) {
      if (forms_[row].kind == NormalKind::Until)
        mark_of_until_.emplace(row, static_cast<FormulaRow>(mark_of_until_.size()));
    }
    // FormulaRows that simplification left behind count, too; a formula near the limit is no usual one.
    if (mark_of_until_.size() > kMaxMarks)
      return Failure{"the property has more than " + std::to_string(kMaxMarks) + " promises (`eventually`, `until`)"};
    made_.marks = static_cast<std::uint32_t>((ConditionMask{1} << mark_of_until_.size()) - 1);
    FormulaRows first;
    add_conjuncts(first, root);
    (void)state_of(first);
    for (FormulaRow state = 0; state < states_.size(); ++state) {
      const FormulaRows formulas = states_[state];
      expand(formulas);
      if (states_.size() > kMaxStates)
        return Failure{"the property needs an automaton with more than " + std::to_string(kMaxStates) + " states"};
      if (is_too_large()) return Failure{"the property has too many alternatives"};
    }
    return std::move(made_);
  }

 private:
  // A part of a state's tableau: what is still to be taken apart, and what was found.
  struct Branch {
    FormulaRows todo, taken, next;
    ConditionMask required = 0, forbidden = 0;
    std::uint32_t postponed = 0;  // untils whose right side does not come now
  };

  [[nodiscard]] bool is_too_large() const { return branches_ > kMaxBranches || comparisons_ > kMaxComparisons; }

  FormulaRow state_of(const FormulaRows& formulas) {
    const auto [at, is_new] = row_of_state_.try_emplace(formulas, static_cast<FormulaRow>(states_.size()));
    if (is_new) {
      states_.push_back(formulas);
      made_.edges.emplace_back();
    }
    return at->second;
  }
  // `a && b` in a set is a and b.
  void add_conjuncts(FormulaRows& rows, FormulaRow row) const {
    FormulaRows todo{row};
    while (!todo.empty()) {
      const FormulaRow at = todo.back();
      todo.pop_back();
      if (forms_[at].kind == NormalKind::And) {
        todo.push_back(forms_[at].a);
        todo.push_back(forms_[at].b);
      } else if (at != NormalForms::kTrueRow) {
        insert_sorted(rows, at);
      }
    }
  }

  void expand(const FormulaRows& formulas) {
    std::vector<Branch> open(1), found;
    open[0].todo = formulas;
    while (!open.empty() && !is_too_large()) {
      Branch branch = std::move(open.back());
      open.pop_back();
      if (!take_apart(branch, open)) continue;
      add_uncovered(found, branch);
    }
    const FormulaRow from = row_of_state_.at(formulas);
    std::vector<AutomatonEdge> edges;
    for (const Branch& branch : found)
      edges.push_back({branch.required, branch.forbidden, state_of(branch.next), made_.marks & ~branch.postponed});
    std::sort(edges.begin(), edges.end());
    BIP_ASSERT(
        std::all_of(edges.begin(), edges.end(),
                    [&](const AutomatonEdge& e) { return (e.required & e.forbidden) == 0 && e.to < states_.size(); }),
        "an edge of state {} requires what it forbids", from);
    made_.edges[from] = std::move(edges);
  }
  // Takes formulas apart until none is left; alternatives go to `open`. False: a contradiction.
  bool take_apart(Branch& branch, std::vector<Branch>& open) {
    ++branches_;
    while (!branch.todo.empty()) {
      const FormulaRow row = branch.todo.back();
      branch.todo.pop_back();
      if (std::binary_search(branch.taken.begin(), branch.taken.end(), row)) continue;
      insert_sorted(branch.taken, row);
      const NormalNode node = forms_[row];
      switch (node.kind) {
        case NormalKind::False: return false;
        case NormalKind::True: break;
        case NormalKind::Literal:
          (node.is_negated ? branch.forbidden : branch.required) |= ConditionMask{1} << node.bit;
          if ((branch.required & branch.forbidden) != 0) return false;
          break;
        case NormalKind::And:
          branch.todo.push_back(node.a);
          branch.todo.push_back(node.b);
          break;
        case NormalKind::Or:
          open.push_back(branch);
          open.back().todo.push_back(node.b);
          branch.todo.push_back(node.a);
          break;
        case NormalKind::Next: add_conjuncts(branch.next, node.a); break;
        case NormalKind::Until:
          // Now its right side, or its left side and itself later.
          open.push_back(branch);
          open.back().todo.push_back(node.a);
          add_conjuncts(open.back().next, row);
          open.back().postponed |= std::uint32_t{1} << mark_of_until_.at(row);
          branch.todo.push_back(node.b);
          break;
        case NormalKind::Release:
          open.push_back(branch);
          open.back().todo.push_back(node.b);
          add_conjuncts(open.back().next, row);
          branch.todo.push_back(node.a);
          branch.todo.push_back(node.b);
          break;
      }
    }
    return std::find(branch.next.begin(), branch.next.end(), NormalForms::kFalseRow) == branch.next.end();
  }
  // Does `a` allow all that `b` allows, and promise no more?
  static bool covers(const Branch& a, const Branch& b) {
    return (a.required & ~b.required) == 0 && (a.forbidden & ~b.forbidden) == 0 && (a.postponed & ~b.postponed) == 0 &&
           std::includes(b.next.begin(), b.next.end(), a.next.begin(), a.next.end());
  }
  void add_uncovered(std::vector<Branch>& found, const Branch& branch) {
    comparisons_ += 2 * found.size();
    if (std::any_of(found.begin(), found.end(), [&](const Branch& other) { return covers(other, branch); })) return;
    std::erase_if(found, [&](const Branch& other) { return covers(branch, other); });
    found.push_back(branch);
  }

  NormalForms forms_;
  std::map<FormulaRow, FormulaRow> mark_of_until_;
  std::map<FormulaRows, FormulaRow> row_of_state_;
  std::vector<FormulaRows> states_;
  Automaton made_;
  std::size_t branches_ = 0, comparisons_ = 0;
};

// Strong components of the automaton, in reverse topological order.
class AutomatonComponents {
 public:
  explicit AutomatonComponents(const Automaton& automaton)
      : automaton_(automaton), component_(automaton.edges.size(), kNoSuccessor) {
    StrongComponents<std::size_t> search;
    search.begin(automaton.edges.size());
    for (FormulaRow state = 0; state < automaton.edges.size(); ++state) search.visit(state, *this);
    BIP_ASSERT(std::find(component_.begin(), component_.end(), kNoSuccessor) == component_.end(),
               "a state of {} is in none of {} components", component_.size(), may_accept_.size());
  }
  [[nodiscard]] FormulaRow of(FormulaRow state) const { return component_[state]; }
  /// Does a cycle of the component have all marks?
  [[nodiscard]] bool may_accept(FormulaRow component) const { return may_accept_[component] != 0; }
  /// Does it, or one that it reaches?
  [[nodiscard]] bool is_useful(FormulaRow component) const { return is_useful_[component] != 0; }

  // The visitor.
  static std::size_t enter(FormulaRow) { return 0; }
  [[nodiscard]] FormulaRow next(FormulaRow state, std::size_t& edge) const {
    return edge == automaton_.edges[state].size() ? kNoSuccessor : automaton_.edges[state][edge++].to;
  }
  static void reach(FormulaRow, FormulaRow) {}
  void close(const FormulaRow* states, std::size_t count) {
    const FormulaRow row = static_cast<FormulaRow>(may_accept_.size());
    BIP_ASSERT(std::all_of(states, states + count, [&](FormulaRow s) { return component_[s] == kNoSuccessor; }),
               "a state of component {} is in one that was complete", row);
    for (std::size_t k = 0; k < count; ++k) component_[states[k]] = row;
    std::uint32_t marks = 0;
    bool has_cycle = false, reaches_useful = false;
    for (std::size_t k = 0; k < count; ++k) {
      for (const AutomatonEdge& edge : automaton_.edges[states[k]]) {
        if (component_[edge.to] == row) {
          has_cycle = true;
          marks |= edge.marks;
        } else {
          reaches_useful = reaches_useful || is_useful_[component_[edge.to]] != 0;
        }
      }
    }
    const bool accepts = has_cycle && marks == automaton_.marks;
    may_accept_.push_back(accepts ? 1 : 0);
    is_useful_.push_back(accepts || reaches_useful ? 1 : 0);
  }

 private:
  const Automaton& automaton_;
  std::vector<FormulaRow> component_;
  std::vector<std::uint8_t> may_accept_, is_useful_;
};

// Removes states from which nothing accepts, and marks where they do not count. Keeps the order of states.
void prune(Automaton& automaton) {
  const AutomatonComponents components(automaton);
  std::vector<FormulaRow> row(automaton.edges.size(), kNoSuccessor);
  FormulaRow count = 0;
  for (FormulaRow state = 0; state < row.size(); ++state) {
    if (components.is_useful(components.of(state))) row[state] = count++;
  }
  if (row[0] == kNoSuccessor) {
    automaton = {};
    return;
  }
  Automaton made;
  made.marks = automaton.marks;
  for (FormulaRow state = 0; state < row.size(); ++state) {
    if (row[state] == kNoSuccessor) continue;
    const FormulaRow own = components.of(state);
    std::vector<AutomatonEdge> edges;
    for (AutomatonEdge edge : automaton.edges[state]) {
      if (row[edge.to] == kNoSuccessor) continue;
      if (components.of(edge.to) != own || !components.may_accept(own)) edge.marks = 0;
      edge.to = row[edge.to];
      edges.push_back(edge);
    }
    made.edges.push_back(std::move(edges));
    made.may_accept.push_back(components.may_accept(own) ? 1 : 0);
  }
  automaton = std::move(made);
}

// Joins bisimilar states: a partition refined until the edges of the states of a class agree. Drops what is not
// reached.
void join_equal_states(Automaton& automaton) {
  const std::size_t states = automaton.edges.size();
  std::vector<FormulaRow> class_of(states, 0);
  std::size_t classes = 1;
  for (;;) {
    std::map<std::pair<FormulaRow, std::vector<AutomatonEdge>>, FormulaRow> rows;
    std::vector<FormulaRow> refined(states);
    for (FormulaRow state = 0; state < states; ++state) {
      std::vector<AutomatonEdge> edges = automaton.edges[state];
      for (AutomatonEdge& edge : edges) edge.to = class_of[edge.to];
      std::sort(edges.begin(), edges.end());
      edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
      refined[state] =
          rows.try_emplace({class_of[state], std::move(edges)}, static_cast<FormulaRow>(rows.size())).first->second;
    }
    BIP_ASSERT(rows.size() >= classes, "{} classes of states became {}", classes, rows.size());
    class_of = std::move(refined);
    if (rows.size() == classes) break;
    classes = rows.size();
  }
  // Classes are numbered by their first state, so the initial one stays 0.
  Automaton made;
  made.marks = automaton.marks;
  std::vector<FormulaRow> row_of_class(classes, kNoSuccessor), todo;
  std::vector<FormulaRow> state_of_class(classes, kNoSuccessor);
  for (FormulaRow state = 0; state < states; ++state) {
    if (state_of_class[class_of[state]] == kNoSuccessor) state_of_class[class_of[state]] = state;
  }
  const auto row_of = [&](FormulaRow of_class) {
    if (row_of_class[of_class] == kNoSuccessor) {
      row_of_class[of_class] = static_cast<FormulaRow>(todo.size());
      todo.push_back(of_class);
    }
    return row_of_class[of_class];
  };
  (void)row_of(class_of[0]);
  for (std::size_t at = 0; at < todo.size(); ++at) {
    const FormulaRow state = state_of_class[todo[at]];
    std::vector<AutomatonEdge> edges = automaton.edges[state];
    for (AutomatonEdge& edge : edges) edge.to = row_of(class_of[edge.to]);
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    made.edges.push_back(std::move(edges));
    made.may_accept.push_back(automaton.may_accept[state]);
  }
  automaton = std::move(made);
}

// Removes each mark that is on every edge which has some other mark: then it comes as often as that.
void drop_implied_marks(Automaton& automaton) {
  std::uint32_t kept = automaton.marks;
  for (std::uint32_t k = 0; k < kMaxMarks; ++k) {
    const std::uint32_t mark = std::uint32_t{1} << k;
    if ((kept & mark) == 0) continue;
    std::uint32_t without = 0;  // marks that are on some edge without it
    for (const std::vector<AutomatonEdge>& edges : automaton.edges) {
      for (const AutomatonEdge& edge : edges) {
        if ((edge.marks & mark) == 0) without |= edge.marks;
      }
    }
    if ((kept & ~mark & ~without) != 0) kept &= ~mark;
  }
  automaton.marks = kept;
  for (auto& edges : automaton.edges) {
    for (AutomatonEdge& edge : edges) edge.marks &= kept;
  }
}

// A deterministic monitor of the operators that look back: one bit for each, which the next position reads (Havelund,
// Rosu 2002). It runs beside the automaton, whose edges require values of these operators; what is left requires
// conditions alone. A position is followed by cases: conditions are decided one by one until all values are known that
// the edge and the next bits need.
class PastMonitor {
 public:
  PastMonitor(const Formula& formula, const Automaton& automaton)
      : formula_(formula), automaton_(automaton), bit_of_past_(bits_of_past(formula)) {
    const std::size_t conditions = formula.states.size() + formula.steps.size();
    of_conditions_ = first_conditions(conditions);
    for (FormulaRow row = 0; row < formula.nodes.size(); ++row) {
      if (looks_back(formula.nodes[row].kind)) past_.push_back(row);
    }
  }

  Result<Automaton> run() {
    made_.marks = automaton_.marks;
    (void)state_of({0, 0});
    for (FormulaRow at = 0; at < states_.size(); ++at) {
      const State from = states_[at];
      BIP_ASSERT(from.automaton < automaton_.edges.size() && made_.edges.size() == states_.size(),
                 "state {} of the automaton, {} of {} states have edges", from.automaton, made_.edges.size(),
                 states_.size());
      std::vector<AutomatonEdge> edges;
      for (const AutomatonEdge& edge : automaton_.edges[from.automaton]) follow(from, edge, edges);
      std::sort(edges.begin(), edges.end());
      edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
      edges_ += edges.size();
      made_.edges[at] = std::move(edges);
      if (states_.size() > kMaxStates)
        return Failure{"the property needs an automaton with more than " + std::to_string(kMaxStates) + " states"};
      if (edges_ > kMaxBranches || cases_ > kMaxBranches) return Failure{"the property has too many alternatives"};
    }
    return std::move(made_);
  }

 private:
  // `past`: by bit, as the position before left it.
  struct State {
    FormulaRow automaton = 0;
    ConditionMask past = 0;
    friend auto operator<=>(const State&, const State&) = default;
  };
  enum class Truth : std::uint8_t { False, True, Open };

  FormulaRow state_of(const State& state) {
    const auto [at, is_new] = row_of_state_.try_emplace(state, static_cast<FormulaRow>(states_.size()));
    if (is_new) {
      states_.push_back(state);
      made_.edges.emplace_back();
    }
    return at->second;
  }
  static Truth negated_truth(Truth a) {
    return a == Truth::Open ? Truth::Open : a == Truth::True ? Truth::False : Truth::True;
  }
  static Truth both(Truth a, Truth b) {
    if (a == Truth::False || b == Truth::False) return Truth::False;
    return a == Truth::True && b == Truth::True ? Truth::True : Truth::Open;
  }
  static Truth either(Truth a, Truth b) { return negated_truth(both(negated_truth(a), negated_truth(b))); }
  [[nodiscard]] Truth known(ConditionMask required, ConditionMask forbidden, FormulaRow bit) const {
    const ConditionMask mask = ConditionMask{1} << bit;
    return (required & mask) != 0 ? Truth::True : (forbidden & mask) != 0 ? Truth::False : Truth::Open;
  }

  // Of the nodes that look back or stand below one that does. Nodes that look ahead stand above them only.
  void evaluate(ConditionMask past, ConditionMask required, ConditionMask forbidden) {
    const auto steps = static_cast<FormulaRow>(formula_.states.size());
    truth_.assign(formula_.nodes.size(), Truth::Open);
    for (FormulaRow row = 0; row < formula_.nodes.size(); ++row) {
      const FormulaNode& node = formula_.nodes[row];
      const Truth a = truth_[node.a], b = truth_[node.b];
      Truth& value = truth_[row];
      switch (node.kind) {
        case FormulaKind::Constant: value = node.value ? Truth::True : Truth::False; break;
        case FormulaKind::State: value = known(required, forbidden, node.row); break;
        case FormulaKind::Step: value = known(required, forbidden, steps + node.row); break;
        case FormulaKind::Not: value = negated_truth(a); break;
        case FormulaKind::And: value = both(a, b); break;
        case FormulaKind::Or: value = either(a, b); break;
        case FormulaKind::Previously: value = carried(past, row); break;
        case FormulaKind::Since: value = either(b, both(a, carried(past, row))); break;
        case FormulaKind::Next:
        case FormulaKind::Until:
        case FormulaKind::Release: break;
      }
    }
  }
  [[nodiscard]] Truth carried(ConditionMask past, FormulaRow row) const {
    return (past >> bit_of_past_[row] & 1) != 0 ? Truth::True : Truth::False;
  }
  // What the next position reads of the operator.
  [[nodiscard]] Truth left_by(FormulaRow row) const {
    return truth_[formula_.nodes[row].kind == FormulaKind::Previously ? formula_.nodes[row].a : row];
  }
  // A condition on which the node's value still depends.
  [[nodiscard]] FormulaRow open_condition(FormulaRow row) const {
    const auto steps = static_cast<FormulaRow>(formula_.states.size());
    for (;;) {
      const FormulaNode& node = formula_.nodes[row];
      BIP_ASSERT(truth_[row] == Truth::Open && !looks_ahead(node.kind), "node {} depends on no condition", row);
      if (node.kind == FormulaKind::State) return node.row;
      if (node.kind == FormulaKind::Step) return steps + node.row;
      // Of `since` the right side first: where nothing is carried the left one does not matter.
      const bool is_right =
          truth_[node.a] != Truth::Open || (node.kind == FormulaKind::Since && truth_[node.b] == Truth::Open);
      row = is_right ? node.b : node.a;
    }
  }

  void follow(const State& from, const AutomatonEdge& edge, std::vector<AutomatonEdge>& edges) {
    const bool ends_here = automaton_.accepts_whatever_follows(edge.to);
    struct Case {
      ConditionMask required, forbidden;
    };
    std::vector<Case> open{{edge.required & of_conditions_, edge.forbidden & of_conditions_}};
    while (!open.empty() && cases_ <= kMaxBranches) {
      const Case at = open.back();
      open.pop_back();
      ++cases_;
      evaluate(from.past, at.required, at.forbidden);
      bool is_possible = true;
      FormulaRow undecided = kNoSuccessor;
      ConditionMask next = 0;
      for (const FormulaRow row : past_) {
        const ConditionMask bit = ConditionMask{1} << bit_of_past_[row];
        if (((edge.required | edge.forbidden) & bit) != 0) {
          const Truth wanted = (edge.required & bit) != 0 ? Truth::True : Truth::False;
          if (truth_[row] == Truth::Open) undecided = row;
          else is_possible = is_possible && truth_[row] == wanted;
        }
        // What follows such an edge does not matter.
        if (ends_here) continue;
        const Truth left = left_by(row);
        if (left == Truth::True) next |= bit;
        if (left == Truth::Open)
          undecided = formula_.nodes[row].kind == FormulaKind::Previously ? formula_.nodes[row].a : row;
      }
      if (!is_possible) continue;
      if (undecided == kNoSuccessor) {
        edges.push_back({at.required, at.forbidden, state_of({edge.to, next}), edge.marks});
        continue;
      }
      const ConditionMask condition = ConditionMask{1} << open_condition(undecided);
      open.push_back({at.required | condition, at.forbidden});
      open.push_back({at.required, at.forbidden | condition});
    }
  }

  const Formula& formula_;
  const Automaton& automaton_;
  const std::vector<FormulaRow> bit_of_past_;
  std::vector<FormulaRow> past_;  // nodes
  ConditionMask of_conditions_ = 0;
  std::map<State, FormulaRow> row_of_state_;
  std::vector<State> states_;
  Automaton made_;
  std::size_t edges_ = 0, cases_ = 0;
  std::vector<Truth> truth_;  // by node
};

}  // namespace

bool Automaton::accepts_whatever_follows(std::uint32_t state) const {
  return std::any_of(edges[state].begin(), edges[state].end(), [&](const AutomatonEdge& edge) {
    return edge.required == 0 && edge.forbidden == 0 && edge.to == state && edge.marks == marks;
  });
}

Result<Automaton> make_automaton(const Formula& formula, RunsOf runs) {
  Result<Automaton> made = Tableau().run(formula, runs == RunsOf::Negation);
  if (!made) return made;
  prune(*made);
  if (made->is_empty()) return made;
  join_equal_states(*made);
  const bool has_past = std::any_of(formula.nodes.begin(), formula.nodes.end(),
                                    [](const FormulaNode& node) { return looks_back(node.kind); });
  if (has_past) {
    const Automaton ahead = std::move(*made);
    made = PastMonitor(formula, ahead).run();
    if (!made) return made;
    prune(*made);
    if (made->is_empty()) return made;
    join_equal_states(*made);
  }
  drop_implied_marks(*made);
  join_equal_states(*made);
  // Joined states have other components.
  prune(*made);
  return made;
}

}  // namespace bip::verify
