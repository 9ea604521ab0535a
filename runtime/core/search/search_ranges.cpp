// Maximal interactions of a connector with guards by branch and bound, for searches whose descent (search.cpp) goes on
// for long.
//
// A set of configurations is what has been decided of a plan's optional parts: in, out, or open. Over such a set each
// connector, from the leaves up, has ranges for what its `up` computes, joined over the clauses that may be chosen, and
// a guard that no value in them makes true rules the set out (if the connector is in) or the connector (if it is open).
// What is left is tried at its largest: enabled, it stands for all below; else the next open part is in first, then
// out. So a sum that cannot reach its threshold costs one look, a sum that may not pass a small one as many as there
// are small sums.
#include <algorithm>

#include "runtime/core/core.hpp"
#include "runtime/core/search/ranges.hpp"

namespace bip::rt {

namespace {

enum class Part : std::uint8_t { In, Open, Out };

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
  std::vector<Part> decided_, state_;                              // by node: alone, and with those above
  std::vector<u32> use_of_root_;                                   // by node: the use whose root it is, or kNone
  std::vector<u32> first_own_;                                     // by use: rows of own_
  std::vector<Range> own_, scratch_;
  std::vector<BoundRange> bound_;
  std::vector<std::uint8_t> may_, must_;  // by parameter of the use at hand
  std::vector<u32> path_;                 // decided nodes
  RangeMachine machine_;
};

RangeSearch::RangeSearch(const Tables& tables, const Plan& plan, u32 root, const Cell* all, const u32* binds)
    : tables_(tables),
      plan_(plan),
      nodes_(tables.plan_nodes.data() + plan.first_node),
      uses_(tables.plan_uses.data() + plan.first_use),
      root_(root),
      end_(nodes_[root].end),
      all_(all),
      binds_(binds),
      in_largest_(plan.node_count),
      is_optional_(plan.node_count),
      possible_(plan.node_count),
      decided_(plan.node_count, Part::In),
      state_(plan.node_count),
      use_of_root_(plan.node_count, kNone) {
  for (u32 i = 0; i < plan.use_count; ++i) {
    use_of_root_[uses_[i].root] = i;
    first_own_.push_back(static_cast<u32>(own_.size()));
    own_.resize(own_.size() + tables.connector_type(uses_[i].connector).variables.size);
  }
  // What shows only its maximal interactions goes as a whole.
  std::vector<std::uint8_t> is_rigid(plan.node_count);
  for (u32 i = root + 1; i < end_; ++i) {
    const PlanNode& parent = nodes_[nodes_[i].parent];
    is_rigid[i] = is_rigid[nodes_[i].parent] | (parent.kind == NodeKind::Link && parent.maximal_only ? 1 : 0);
    is_optional_[i] = parent.has_trigger && is_rigid[i] == 0 ? 1 : 0;
  }
}

void RangeSearch::start(const Bits& largest) {
  path_.clear();
  std::fill(in_largest_.begin(), in_largest_.end(), std::uint8_t{0});
  for (u32 i = end_; i-- > root_;) {
    const u32 leaf = nodes_[i].leaf;
    if (nodes_[i].kind == NodeKind::Leaf) in_largest_[i] = largest[leaf >> 6] >> (leaf & 63) & 1;
    if (in_largest_[i] != 0 && i != root_) in_largest_[nodes_[i].parent] = 1;
    decided_[i] = is_optional_[i] != 0 ? Part::Open : Part::In;
  }
}

bool RangeSearch::look() {
  for (u32 i = root_; i < end_; ++i) {
    const Part above = i == root_ ? Part::In : state_[nodes_[i].parent];
    state_[i] = in_largest_[i] == 0 ? Part::Out : std::max(above, decided_[i]);
  }
  for (u32 i = end_; i-- > root_;) {
    bool possible = state_[i] != Part::Out;
    if (possible && nodes_[i].kind != NodeKind::Leaf) {
      bool all = true, trigger = false;
      for (u32 child = i + 1; child < nodes_[i].end; child = nodes_[child].end) {
        all &= possible_[child] != 0;
        trigger |= possible_[child] != 0 && nodes_[child].trigger;
      }
      possible = nodes_[i].has_trigger ? trigger : all;
    }
    if (possible && use_of_root_[i] != kNone) possible = look_at_use(use_of_root_[i]);
    possible_[i] = possible ? 1 : 0;
    if (!possible && state_[i] == Part::In) return false;
  }
  return possible_[root_] != 0;
}

// The ranges of a connector's interactions if it takes part. False: it cannot.
bool RangeSearch::look_at_use(u32 row) {
  const PlanUse& use = uses_[row];
  const ConnectorType& type = tables_.connector_type(use.connector);
  may_.assign(type.params.size, 0);
  must_.assign(type.params.size, 0);
  for (u32 param = 0; param < type.params.size; ++param) {
    const u32 at = tables_.plan_params[use.first_param + param];
    if (at == kNone) continue;
    bool may = at == use.root || possible_[at] != 0, must = true;
    for (u32 i = at; i != use.root; i = nodes_[i].parent) {
      may &= possible_[i] != 0;
      must &= decided_[i] == Part::In;
    }
    may_[param] = may ? 1 : 0;
    must_[param] = may && must ? 1 : 0;
  }
  bind(use, type);
  Range* const own = own_.data() + first_own_[row];
  bool any = !type.is_total;
  std::fill(own, own + type.variables.size, Range{});
  for (const Clause& clause : type.clauses) {
    u32 needed = static_cast<u32>(std::count(must_.begin(), must_.end(), 1));
    bool fits = true;
    for (const u32 param : clause.params) {
      fits &= may_[param] != 0;
      needed -= must_[param];
    }
    if (fits && needed == 0) any |= join_clause(clause, own, !any);
  }
  return any;
}

// False: its guard is.
bool RangeSearch::join_clause(const Clause& clause, Range* into, bool is_first) {
  const std::size_t size = scratch_.size();
  std::fill(scratch_.begin(), scratch_.end(), Range{});
  if (machine_.value(clause.guard_ranges, scratch_.data(), bound_.data()).hi <= 0) return false;
  machine_.run(clause.up_ranges, scratch_.data(), size, bound_.data());
  for (std::size_t i = 0; i < size; ++i) {
    if (is_first) into[i] = scratch_[i];
    else into[i].join(scratch_[i]);
  }
  return true;
}

void RangeSearch::bind(const PlanUse& use, const ConnectorType& type) {
  const Connector& connector = tables_.image->connectors[use.connector];
  scratch_.resize(type.variables.size);
  bound_.resize(connector.bind_count);
  for (u32 i = 0; i < connector.bind_count; ++i) bound_[i].interaction = all_ + binds_[connector.binds + i];
  for (u32 param = 0; param < type.params.size; ++param) {
    const u32 at = tables_.plan_params[use.first_param + param];
    if (at == kNone || nodes_[at].kind != NodeKind::Link) continue;
    const u32 below = nodes_[at].use;
    const ConnectorType& from = tables_.connector_type(uses_[below].connector);
    for (u32 i = 0; i < from.export_variables.size; ++i) {
      bound_[type.params[param].first_bind + i] = {nullptr, own_[first_own_[below] + from.export_variables[i]]};
    }
  }
}

Bits RangeSearch::largest() const {
  Bits bits(plan_.words, 0);
  std::vector<std::uint8_t> chosen(plan_.node_count);
  for (u32 i = root_; i < end_; ++i) {
    chosen[i] = possible_[i] != 0 && (i == root_ || chosen[nodes_[i].parent] != 0) ? 1 : 0;
    const u32 leaf = nodes_[i].leaf;
    if (nodes_[i].kind == NodeKind::Leaf && chosen[i] != 0) bits[leaf >> 6] |= u64{1} << (leaf & 63);
  }
  return bits;
}

bool RangeSearch::decide() {
  for (u32 i = root_ + 1; i < end_; ++i) {
    if (decided_[i] != Part::Open || possible_[i] == 0 || state_[nodes_[i].parent] != Part::In) continue;
    decided_[i] = Part::In;
    path_.push_back(i);
    return true;
  }
  return false;
}

bool RangeSearch::next() {
  while (!path_.empty()) {
    Part& last = decided_[path_.back()];
    if (last == Part::In) {
      last = Part::Out;
      return true;
    }
    last = Part::Open;
    path_.pop_back();
  }
  return false;
}

}  // namespace

// Could a configuration within one of these be enabled?
bool Core::may_hold(const Plan& plan, u32 root, const std::vector<Bits>& largest) {
  RangeSearch search(tables_, plan, root, all_.data(), binds_.rows);
  return std::any_of(largest.begin(), largest.end(), [&](const Bits& bits) {
    ++search_work_.range_looks;
    search.start(bits);
    return search.look();
  });
}

// Adds enabled configurations within these, the maximal ones among them, to those that were found.
bool Core::search_ranges(const Plan& plan, u32 root, const std::vector<Bits>& largest, std::vector<Bits>& found) {
  RangeSearch search(tables_, plan, root, all_.data(), binds_.rows);
  u64 looks = 0;
  for (const Bits& from : largest) {
    search.start(from);
    bool goes_on = true;
    while (goes_on) {
      if (++looks > u64{options_.enumeration_bound} * 16)
        return fail_connector(FaultCode::TooManyInteractions, plan.connector);
      ++search_work_.range_looks;
      bool is_open = search.look();
      if (is_open) {
        const Bits bits = search.largest();
        is_open = std::none_of(found.begin(), found.end(), [&](const Bits& big) { return contains(big, bits); });
        if (is_open) {
          choose_bits(plan, bits.data());
          u32 failed = kNone;
          if (!evaluate(plan, root, bits, failed)) return false;
          if (failed == kNone) {
            if (found.size() == options_.enumeration_bound)
              return fail_connector(FaultCode::TooManyInteractions, plan.connector);
            found.push_back(bits);
            is_open = false;
          }
        }
      }
      goes_on = (is_open && search.decide()) || search.next();
    }
  }
  return true;
}

}  // namespace bip::rt
