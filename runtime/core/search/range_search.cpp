// See range_search.hpp.
#include "runtime/core/search/range_search.hpp"

#include <algorithm>

namespace bip::rt {

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
      decided_(plan.node_count, PlanPart::In),
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
  BIP_ASSERT(largest.size() == plan_.words, "{} words of {}", largest.size(), plan_.words);
  path_.clear();
  std::fill(in_largest_.begin(), in_largest_.end(), std::uint8_t{0});
  for (u32 i = end_; i-- > root_;) {
    const u32 leaf = nodes_[i].leaf;
    if (nodes_[i].kind == NodeKind::Leaf) in_largest_[i] = largest[leaf >> 6] >> (leaf & 63) & 1;
    if (in_largest_[i] != 0 && i != root_) in_largest_[nodes_[i].parent] = 1;
    decided_[i] = is_optional_[i] != 0 ? PlanPart::Open : PlanPart::In;
  }
}

bool RangeSearch::look() {
  for (u32 i = root_; i < end_; ++i) {
    const PlanPart above = i == root_ ? PlanPart::In : state_[nodes_[i].parent];
    state_[i] = in_largest_[i] == 0 ? PlanPart::Out : std::max(above, decided_[i]);
  }
  for (u32 i = end_; i-- > root_;) {
    bool possible = state_[i] != PlanPart::Out;
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
    if (!possible && state_[i] == PlanPart::In) return false;
  }
  return possible_[root_] != 0;
}

// The ranges of a connector's variables if it takes part. False: it cannot.
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
      must &= decided_[i] == PlanPart::In;
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
  for (u32 i = 0; i < connector.bind_count; ++i) bound_[i].cell = all_ + binds_[connector.binds + i];
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
  BIP_ASSERT(path_.size() <= plan_.node_count, "{} decisions about {} nodes", path_.size(), plan_.node_count);
  for (u32 i = root_ + 1; i < end_; ++i) {
    if (decided_[i] != PlanPart::Open || possible_[i] == 0 || state_[nodes_[i].parent] != PlanPart::In) continue;
    decided_[i] = PlanPart::In;
    path_.push_back(i);
    return true;
  }
  return false;
}

bool RangeSearch::next() {
  while (!path_.empty()) {
    PlanPart& last = decided_[path_.back()];
    if (last == PlanPart::In) {
      last = PlanPart::Out;
      return true;
    }
    last = PlanPart::Open;
    path_.pop_back();
  }
  return false;
}

}  // namespace bip::rt
