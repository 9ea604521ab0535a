// A connector with the connectors that it binds in place of the parameters that name them, and its interactions one
// after the other: the lists that other tools' formats and the circuit of a transition system need, and that the System
// never makes.
//
// The tree is linear in the occurrences of connectors below it (a connector that two others bind occurs twice), the
// number of interactions exponential in the synchrons beside triggers. So both have limits, and interactions are
// enumerated lazily: memory and time of one interaction are linear in the tree.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/system/system_ids.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::analysis {

using u32 = std::uint32_t;
inline constexpr u32 kNoRow = 0xffffffffu;

struct InteractionTree {
  /// Group: of a `define`. Leaf: a port of an atom. Link: a bound connector. Choice: one port of several (merged
  /// ports).
  enum class Kind : std::uint8_t { Group, Leaf, Link, Choice };
  struct Node {
    Kind kind = Kind::Group;
    bool is_trigger = false;
    bool has_trigger = false;   // Group: one of its children is a trigger
    bool maximal_only = false;  // Link: shows only its maximal interactions
    u32 use = 0;                // the use that it belongs to; Link: the one that it leads to
    u32 end = 0;                // rows [its own, end) are the node and all below it
    AtomId atom{};              // Leaf
    u32 port = 0;               // Leaf: of the atom's type
    std::vector<u32> children;
  };
  /// An occurrence of a connector in the tree. Row 0 is the connector that the tree is made of.
  struct Use {
    ConnectorId connector;
    u32 root = 0;                  // its outermost group
    std::vector<u32> param_nodes;  // by parameter of the connector's type; kNoRow: `define` does not name it
  };
  std::vector<Node> nodes;  // in preorder: parents before their children
  std::vector<Use> uses;    // users before those that they bind

  /// Returns whether `node` is `root` or below it. O(1).
  [[nodiscard]] bool is_below(u32 root, u32 node) const {
    BIP_ASSERT(root < nodes.size() && node < nodes.size(), "nodes {} and {} of {}", root, node, nodes.size());
    return root <= node && node < nodes[root].end;
  }
};

struct InteractionTreeLimits {
  std::size_t nodes = 20000;
  u32 depth = 200;  // bound connectors and merged ports on the way from the root to a leaf
};

/// Builds the tree of a connector of a valid System. Failure: deeper or larger than the limits.
[[nodiscard]] Result<InteractionTree> build_interaction_tree(const System& system, ConnectorId connector,
                                                             const InteractionTreeLimits& limits = {});

/// An interaction: rows of leaves, ascending.
using Leaves = std::vector<u32>;

/// Enumerates the interactions of a node lazily, in a fixed order: of a rendezvous the last child changes first; a
/// group with triggers counts like a binary number whose lowest digit is the first child. Guards are not looked at. The
/// tree must outlive the object. Recursion follows the tree, whose depth is limited.
class InteractionEnumerator {
 public:
  InteractionEnumerator(const InteractionTree& tree, u32 node);
  /// Replaces `leaves` by the next interaction; false: there is none left.
  [[nodiscard]] bool next(Leaves& leaves);
  /// Returns whether the enumeration was given up: more than a million combinations in a row without a trigger, which
  /// takes triggers that are bound to nothing.
  [[nodiscard]] bool is_given_up() const { return rejected_ > kMaxRejected; }

 private:
  static constexpr std::size_t kMaxRejected = 1u << 20;
  [[nodiscard]] bool first(u32 row);
  [[nodiscard]] bool advance(u32 row);
  [[nodiscard]] bool first_of_group(u32 row);
  [[nodiscard]] bool advance_group(u32 row);
  [[nodiscard]] bool step_group(const InteractionTree::Node& group);
  [[nodiscard]] bool has_active_trigger(const InteractionTree::Node& group) const;

  const InteractionTree& tree_;
  u32 root_;
  bool has_begun_ = false;
  std::size_t rejected_ = 0;             // combinations without a trigger since the last interaction
  std::vector<std::uint8_t> is_active_;  // by node: takes part in its group; set only below a group with triggers
  std::vector<u32> alternative_;         // by node, Link and Choice: the child at hand
};

/// Returns all interactions of the node in the enumerator's order. Failure: there are more than `limit`.
[[nodiscard]] Result<std::vector<Leaves>> list_interactions(const InteractionTree& tree, u32 node, std::size_t limit);

/// Returns by node whether it is a leaf of the interaction or above one.
[[nodiscard]] std::vector<std::uint8_t> chosen_nodes(const InteractionTree& tree, const Leaves& leaves);
/// Returns the chosen alternative of a merged port, any other node itself; kNoRow for kNoRow and if none is chosen.
[[nodiscard]] u32 chosen_alternative(const InteractionTree& tree, u32 node, const std::vector<std::uint8_t>& chosen);
/// Returns the clause for the parameters of the use that are chosen, or null.
[[nodiscard]] const Clause* chosen_clause(const System& system, const InteractionTree::Use& use,
                                          const std::vector<std::uint8_t>& chosen);

}  // namespace bip::analysis
