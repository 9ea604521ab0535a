// A connector with those that it binds in place of the parameters that name them, and the configurations that it has:
// the lists of interactions that other tools' formats need and that the System never makes.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/system/system.hpp"

namespace bip::exchange {

using u32 = std::uint32_t;
inline constexpr u32 kNoRow = 0xffffffffu;
inline constexpr std::size_t kMaxConfigurations = 2048;

struct ConnectorTree {
  enum class Kind : std::uint8_t { Group, Leaf, Link, Choice };
  struct Node {
    Kind kind = Kind::Group;
    bool is_trigger = false, has_trigger = false, maximal_only = false;
    u32 use = 0;    // the use it belongs to; Link: the one it leads to
    AtomId atom{};  // Leaf
    u32 port = 0;   // Leaf: of the atom's type
    std::vector<u32> children;
  };
  /// A connector as it occurs in the tree; row 0 is the one on top.
  struct Use {
    ConnectorId connector;
    u32 root = 0;
    std::vector<u32> param_nodes;
  };
  std::vector<Node> nodes;  // children after their parents
  std::vector<Use> uses;    // likewise
};
/// A name as it may stand in comments and strings of any format: letters, digits and `_.[](), -`.
[[nodiscard]] std::string plain(const std::string& name);
/// Nodes, sorted.
using Leaves = std::vector<u32>;

/// Failure: nested too deeply, or too large.
[[nodiscard]] Result<ConnectorTree> expand(const System& system, ConnectorId connector);
/// All configurations of a node, each as its leaves. Failure: more than kMaxConfigurations.
[[nodiscard]] Result<std::vector<Leaves>> configurations(const ConnectorTree& tree, u32 node);
/// By node: is it chosen, with these leaves?
[[nodiscard]] std::vector<std::uint8_t> chosen_nodes(const ConnectorTree& tree, const Leaves& leaves);
/// The alternative that is chosen of a merged port, else the node itself; kNoRow: nothing is.
[[nodiscard]] u32 chosen_alternative(const ConnectorTree& tree, u32 node, const std::vector<std::uint8_t>& chosen);
[[nodiscard]] bool is_below(const ConnectorTree& tree, u32 root, u32 node);
/// The clause for what is chosen of a use; null: there is none.
[[nodiscard]] const Clause* chosen_clause(const System& system, const ConnectorTree::Use& use,
                                          const std::vector<std::uint8_t>& chosen);

}  // namespace bip::exchange
