// Maximal interactions of a connector with guards by branch and bound, for searches whose descent
// (interaction_search.hpp) goes on for long.
//
// A set of configurations is what has been decided of a plan's optional parts: in, out, or open. Over such a set each
// connector, from the leaves up, has ranges for what its `up` computes, joined over the clauses that may be chosen, and
// a guard that no value in them makes true rules the set out (if the connector is in) or the connector (if it is open).
// What is left is tried at its largest: enabled, it stands for all below; else the next open part is in first, then
// out. So a sum that cannot reach its threshold costs one look, a sum that may not pass a small one as many as there
// are small sums.
#pragma once
#include <vector>

#include "runtime/core/link/tables.hpp"
#include "runtime/core/search/bits.hpp"
#include "runtime/core/search/ranges.hpp"

namespace bip::rt {

enum class PlanPart : std::uint8_t { In, Open, Out };

class RangeSearch {
 public:
  RangeSearch(const Tables& tables, const Plan& plan, u32 root, const Cell* all, const u32* binds);
  /// All configurations within this one.
  void start(const Bits& largest);
  /// Looks at the set; false: none of it is enabled.
  bool look();
  /// The largest configuration that was left by the last look.
  [[nodiscard]] Bits largest() const;
  /// After look: decides one more part, which is in. False: nothing is open.
  bool decide();
  /// The next set, after this one and those within it. False: there is none.
  bool next();

 private:
  [[nodiscard]] const PlanNode& node(u32 row) const { return nodes_[row]; }
  bool look_at_use(u32 use);
  bool join_clause(const Clause& clause, Range* into, bool is_first);
  void bind(const PlanUse& use, const ConnectorType& type);

  const Tables& tables_;
  const Plan& plan_;
  const PlanNode* nodes_;
  const PlanUse* uses_;
  u32 root_, end_;
  const Cell* all_;
  const u32* binds_;
  std::vector<std::uint8_t> in_largest_, is_optional_, possible_;  // by node
  std::vector<PlanPart> decided_, state_;                          // by node: alone, and with those above
  std::vector<u32> use_of_root_;                                   // by node: the use whose root it is, or kNone
  std::vector<u32> first_own_;                                     // by use: rows of own_
  std::vector<Range> own_, scratch_;
  std::vector<BoundRange> bound_;
  std::vector<std::uint8_t> may_, must_;  // by parameter of the use at hand
  std::vector<u32> path_;                 // decided nodes
  RangeMachine machine_;
};

}  // namespace bip::rt
