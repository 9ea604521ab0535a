// See remembered_searches.hpp.
#include "runtime/core/search/remembered_searches.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"

namespace bip::rt {
namespace {

// Entries of a plan: a system goes around in few states, or in so many that none comes again soon.
constexpr std::size_t kEntries = 8;
// Words of the candidates of one entry.
constexpr std::size_t kMostWords = std::size_t{1} << 16;
// After so many misses a plan with less than a hit for sixteen of them is given up.
constexpr u32 kTrial = 256;

// Is all code of the plan a function of its ports' variables?
bool is_pure(const CoreParts& core, const Plan& plan) {
  const Tables& tables = core.tables;
  for (u32 use = 0; use < plan.use_count; ++use) {
    const u32 connector = tables.plan_uses[plan.first_use + use].connector;
    // Data of an atom that are read by their path, not through a port.
    if (tables.first_read(connector) < tables.image->connectors[connector].bind_count) return false;
    if (tables.image->ffi == nullptr) continue;
    for (const Clause& clause : tables.connector_type(connector).clauses) {
      if (clause.may_fault || clause.guard_may_fault) return false;
    }
  }
  return core.memory.ffi_data.empty();
}

// By bound row of the connector type: may a guard or an `up` read it? Code over ranges says which rows it reads.
std::vector<bool> read_rows(const ConnectorType& type, u32 rows) {
  std::vector<bool> is_read(rows, false);
  for (const Clause& clause : type.clauses) {
    if (!clause.has_ranges && (clause.guard != kNone || clause.up != kNone)) return std::vector<bool>(rows, true);
    for (const Span<RangeOp>& code : {clause.guard_ranges, clause.up_ranges}) {
      for (const RangeOp& op : code) {
        // A value of which nothing is known: it may come from anywhere.
        if (op.kind == RangeOpKind::Any) return std::vector<bool>(rows, true);
        if (op.kind == RangeOpKind::Bound && op.row < rows) is_read[op.row] = true;
      }
    }
  }
  return is_read;
}

// By node of the plan: which variables of a Leaf's port its search may read.
std::vector<std::vector<bool>> read_variables(const Tables& tables, const Plan& plan) {
  std::vector<std::vector<bool>> of_node(plan.node_count);
  for (u32 row = 0; row < plan.use_count; ++row) {
    const PlanUse& use = tables.plan_uses[plan.first_use + row];
    const ConnectorType& type = tables.connector_type(use.connector);
    const std::vector<bool> is_read = read_rows(type, tables.first_read(use.connector));
    for (u32 param = 0; param < type.params.size; ++param) {
      const u32 node = tables.plan_params[use.first_param + param];
      if (node == kNone) continue;
      const auto first = is_read.begin() + type.params[param].first_bind;
      of_node[node].assign(first, first + tables.image->port_types[type.params[param].type].vars.size);
    }
  }
  // The ports of a Choice have the same variables.
  for (u32 i = 0; i < plan.node_count; ++i) {
    const u32 parent = tables.plan_nodes[plan.first_node + i].parent;
    if (parent != kNone && tables.plan_nodes[plan.first_node + parent].kind == NodeKind::Choice)
      of_node[i] = of_node[parent];
  }
  return of_node;
}

}  // namespace

void RememberedSearches::link(const CoreParts& core) {
  const Tables& tables = core.tables;
  plans_.assign(tables.plans.size(), {});
  leaves_.assign(1, {});
  for (std::size_t row = 0; row < tables.plans.size(); ++row) {
    const Plan& plan = tables.plans[row];
    PlanMemory& memory = plans_[row];
    // Guards of rules that decide below connectors read data by their paths, too.
    if (plan.rigid || !plan.witnesses.empty()) continue;
    // Without guards only a choice needs a search, and that reads no data.
    if (plan.guarded ? !is_pure(core, plan) : !plan.has_choice) continue;
    memory.is_used = true;
    memory.first_leaf = static_cast<u32>(leaves_.size());
    const std::vector<std::vector<bool>> is_read =
        plan.guarded ? read_variables(tables, plan) : std::vector<std::vector<bool>>(plan.node_count);
    for (u32 i = 0; i < plan.node_count; ++i) {
      const PlanNode& node = tables.plan_nodes[plan.first_node + i];
      if (node.kind != NodeKind::Leaf) continue;
      const u32 atom = tables.port_atom[node.ref];
      const Port& port = tables.atom_type(atom).ports[node.ref - tables.port_base(atom)];
      BIP_ASSERT(!plan.guarded || is_read[i].size() == port.variables.size, "{} of {} variables of a port",
                 is_read[i].size(), port.variables.size);
      for (u32 k = 0; k < port.variables.size && plan.guarded; ++k) {
        if (is_read[i][k]) variables_.push_back(core.atoms[atom].first_cell + port.variables[k]);
      }
      leaves_.push_back({node.ref, static_cast<u32>(variables_.size())});
    }
    memory.end_leaf = static_cast<u32>(leaves_.size());
  }
}

// Which ports are enabled, as bits; after each 64 of them the variables of those. The others' may be written by a
// thread.
void RememberedSearches::read_inputs(const CoreParts& core, const PlanMemory& memory) {
  inputs_.clear();
  for (u32 first = memory.first_leaf; first < memory.end_leaf; first += 64) {
    const u32 end = std::min(memory.end_leaf, first + 64);
    const std::size_t at = inputs_.size();
    u64 enabled = 0;
    inputs_.push_back(0);
    for (u32 leaf = first; leaf < end; ++leaf) {
      if (core.ports.enabled_row(leaves_[leaf].port) == kNone) continue;
      enabled |= u64{1} << (leaf - first);
      for (u32 row = leaves_[leaf - 1].end_variable; row < leaves_[leaf].end_variable; ++row)
        inputs_.push_back(core.memory.cells[variables_[row]].bits);
    }
    inputs_[at] = enabled;
  }
  hash_ = 0;
  for (u64 word : inputs_) {
    hash_ = (hash_ ^ word) * 0x9e3779b97f4a7c15u;
    hash_ ^= hash_ >> 29;
  }
}

const std::vector<u64>* RememberedSearches::recall(const CoreParts& core, u32 plan) {
  PlanMemory& memory = plans_[plan];
  if (!memory.is_used) return nullptr;
  read_inputs(core, memory);
  for (const Entry& entry : memory.entries) {
    if (entry.hash != hash_ || entry.inputs != inputs_) continue;
    ++memory.hits;
    return &entry.configs;
  }
  if (++memory.misses < kTrial) return nullptr;
  if (memory.hits < memory.misses / 16) {
    memory.is_used = false;
    memory.entries = {};
  }
  memory.hits = memory.misses = 0;
  return nullptr;
}

void RememberedSearches::keep(u32 plan, const std::vector<u64>& configs) {
  PlanMemory& memory = plans_[plan];
  if (!memory.is_used || configs.size() > kMostWords) return;
  if (memory.entries.size() < kEntries) memory.entries.emplace_back();
  BIP_ASSERT(memory.next < memory.entries.size(), "entry {} of {}", memory.next, memory.entries.size());
  Entry& entry = memory.entries[memory.next];
  memory.next = static_cast<u32>((memory.next + 1) % kEntries);
  entry.hash = hash_;
  entry.inputs = inputs_;
  entry.configs = configs;
}

std::size_t RememberedSearches::bytes() const {
  std::size_t sum =
      plans_.size() * sizeof(PlanMemory) + leaves_.size() * sizeof(Leaf) + variables_.size() * sizeof(u32);
  for (const PlanMemory& memory : plans_) {
    sum += memory.entries.capacity() * sizeof(Entry);
    for (const Entry& entry : memory.entries) sum += (entry.inputs.size() + entry.configs.size()) * sizeof(u64);
  }
  return sum;
}

}  // namespace bip::rt
