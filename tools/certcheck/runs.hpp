// Properties of runs: linear temporal logic (Pnueli 1977) about conditions on states and about steps. A run satisfies
// `(runs F)` if F is true at its first point, and `(points F)`, of what looks back, if F is true at each of its points.
//
// Runs that violate a formula are those of a tester (Kesten, Pnueli, Raviv 1998): it has a bit for each operator that
// speaks of other points. One that looks ahead: what was promised about this point, any value, and a step is possible
// only if the promise is kept. One that looks back: what the point before has left. A promise that some point is to
// come must not be postponed for ever: each pending one is over infinitely often.
#pragma once
#include <unordered_map>

#include "tools/certcheck/successors.hpp"

namespace certcheck {

class Formula {
 public:
  /// Of a claim.
  explicit Formula(const Tree& claim);

  /// Conditions on states, and what happens.
  [[nodiscard]] const std::vector<Tree>& leaves() const { return leaves_; }
  [[nodiscard]] static bool is_about_step(const Tree& leaf) {
    return leaf.head() == "happens" || leaf.head() == "happens-port";
  }
  [[nodiscard]] std::size_t bits() const { return bits_.size(); }
  /// Of those, how many may be pending.
  [[nodiscard]] std::size_t promises() const;
  /// True of the bit at first, as the run is to violate the claim; nothing: any value.
  [[nodiscard]] std::optional<bool> first(std::size_t bit) const;

  struct Point {
    expr possible, violated;  // keeps its promises; of (points …): is F false?
    Local next, pending;      // by bit: what looks back leaves; what is promised and has not come
  };
  /// With the truth of the leaves, the bits, and those of the next point, of which only those matter that look ahead.
  [[nodiscard]] Point point(const Terms& terms, const Local& leaves, const Local& now, const Local& later) const;
  [[nodiscard]] bool looks_ahead(std::size_t bit) const;

 private:
  void add(const Tree& e, std::size_t depth);
  [[nodiscard]] expr value(const Tree& e, const Local& leaves, const Local& now, const Local& later) const;

  Tree root_;
  bool is_of_points_ = false;
  std::vector<Tree> leaves_, bits_;
  std::size_t root_bit_ = kNone;
};

/// The steps of listed states, and whether a fair run through them violates the claim.
class Runs {
 public:
  Runs(const Certificate& certificate, const Tree& claim, const Terms& terms);

  /// The state whose steps follow; the system looks at it.
  void enter(const std::u32string& state, System& system);
  /// `parts`: is the node a port that takes part? For sure: the step is possible whatever is not followed.
  void add(const Model& model, const Step& step, const std::map<std::size_t, expr>& parts, const std::u32string& to);
  /// No step is left. The last state of a run repeats.
  void leave(const expr& has_step);
  /// With the state where runs begin.
  void check(const std::u32string& first);

 private:
  using Node = std::uint64_t;  // a listed state and bits of the formula
  using Nodes = std::vector<Node>;
  struct Mark {
    std::size_t region = 0, number = 0, low = 0;
  };
  static constexpr Node kNowhere = ~Node{0};
  using Units = std::set<std::pair<std::size_t, std::size_t>>;  // word of fairness; label, atom, or the one thing
  struct Change {
    Node to = 0;
    std::uint64_t pending = 0;
    bool is_violated = false;
  };
  using Changes = std::vector<std::vector<Change>>;  // by bits
  struct Edge {
    Node to = 0;
    std::size_t label = kNone;  // kNone: the end
    const Changes* changes = nullptr;
    bool is_sure = false;
  };
  struct Move {
    Node to = 0;
    const Edge* edge = nullptr;
    std::uint64_t pending = 0;
  };

  [[nodiscard]] Node row_of_state(const std::u32string& state) const;
  void add_edge(Node to, std::size_t label, bool is_sure);
  const Changes& changes_of(const std::vector<bool>& truth);
  [[nodiscard]] std::vector<Move> moves(Node node) const;
  [[nodiscard]] Nodes reach_all(Node first);
  void each_component(const Nodes& nodes, const std::function<void(const Nodes&)>& visit);
  [[nodiscard]] Nodes fair_part(const Nodes& component) const;

  const Certificate& proof_;
  const Terms& terms_;
  const Formula formula_;
  const bool is_of_points_;
  const std::vector<std::u32string> states_ = std::vector(proof_.states.begin(), proof_.states.end());
  Node now_ = 0;
  std::vector<bool> truth_;  // of the leaves, in the state
  std::vector<std::vector<Edge>> edges_ = std::vector<std::vector<Edge>>(states_.size());
  std::map<std::pair<std::size_t, Rows>, std::size_t> labels_;  // by connector and ports
  std::vector<Units> units_;                                    // by label
  std::map<std::vector<bool>, Changes> changes_;
  std::unordered_map<Node, Mark> marks_;  // of those that are reached
  std::size_t regions_ = 0;
};

}  // namespace certcheck
