// Data that move up and down a hierarchy of connectors, or through one connector, in one step.
//
// The variables of a connector are zero before each use and are not observed after the step. So only the values that
// atoms receive matter:
// - the old value of a variable, or many of them joined in any order (a sum, the largest): computed in one loop and
//   given to all receivers at once;
// - another value that an `up` computes: the `up`s run, and a value that `down`s only pass on is given to the receivers
//   at once;
// - otherwise all code runs, `up`s bottom up and `down`s top down, the connectors of one depth in the order of their
//   data, because the levels of regular trees are regular.
#include <algorithm>
#include <numeric>
#include <tuple>

#include "compiler/steps/deriver.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::steps {

// False: there is code that cannot be part of a step.
bool Deriver::order_uses(u32 count, const rt::PlanNode* nodes) {
  std::vector<u32> depth(count, 0);
  for (u32 i = 0; i < count; ++i) {
    const rt::ConnectorType& type = tables_.connector_type(uses_[i].connector);
    u32 bound = 0;
    for (const rt::ConnectorParam& param : type.params)
      bound = std::max(bound, param.first_bind + image_.port_types[param.type].vars.size);
    // It reads data of bystanders: those might have moved by then.
    if (image_.connectors[uses_[i].connector].bind_count > bound) return false;
    if (uses_[i].link != kNone) depth[i] = depth[nodes[nodes[uses_[i].link].parent].use] + 1;
    for (const Transfer transfer : {Transfer::Up, Transfer::Down}) {
      const u32 unit = unit_of(i, transfer);
      if (unit != kNone && facts_[unit].may_fault) return false;
    }
  }
  downs_.resize(count);
  std::iota(downs_.begin(), downs_.end(), 0u);
  const auto base = [&](u32 use) { return image_.connectors[uses_[use].connector].first_cell; };
  std::stable_sort(downs_.begin(), downs_.end(),
                   [&](u32 a, u32 b) { return depth[a] != depth[b] ? depth[a] < depth[b] : base(a) < base(b); });
  // Last levels first, but each in ascending order.
  ups_.clear();
  for (std::size_t end = downs_.size(); end > 0;) {
    std::size_t first = end - 1;
    while (first > 0 && depth[downs_[first - 1]] == depth[downs_[end - 1]]) --first;
    for (std::size_t i = first; i < end; ++i) ups_.push_back(downs_[i]);
    end = first;
  }
  BIP_ASSERT(ups_.size() == count && downs_.size() == count, "{} and {} of {} uses", ups_.size(), downs_.size(), count);
  return true;
}

u32 Deriver::unit_of(u32 use, Transfer transfer) const {
  if (uses_[use].clause == kNone) return kNone;
  const rt::Clause& clause = tables_.connector_type(uses_[use].connector).clauses[uses_[use].clause];
  return transfer == Transfer::Up ? clause.up : clause.down;
}

// Values of cells after all `up`s, where they are then, and after all `down`s.
void Deriver::evaluate_uses() {
  values_.begin();
  const auto run = [&](u32 use, Transfer transfer) {
    const rt::Connector& row = image_.connectors[uses_[use].connector];
    if (const u32 unit = unit_of(use, transfer); unit != kNone)
      values_.run(lowered_.units[unit].body, row.first_cell, binds_.rows + row.binds);
  };
  for (const u32 use : ups_) {
    values_.zero(image_.connectors[uses_[use].connector].first_cell,
                 tables_.connector_type(uses_[use].connector).variables.size);
    run(use, Transfer::Up);
  }
  homes_.assign(values_.count(), kNone);
  for (const u32 cell : values_.cells()) {
    if (cell >= tables_.atom_cells) homes_[values_.in(cell)] = cell;
  }
  for (const u32 use : downs_) run(use, Transfer::Down);
}

u32 Deriver::home_of(u32 value) const { return value < homes_.size() ? homes_[value] : kNone; }

// By type, variable and atom: those of one type are at equal distances, mostly. False: a variable would have to be read
// before another one is assigned.
bool Deriver::list_assigned() {
  std::vector<std::pair<u32, u32>> atoms;  // where data are, which
  for (const u32 port : ports_)
    atoms.emplace_back(image_.atoms[tables_.port_atom[port]].first_cell, tables_.port_atom[port]);
  std::sort(atoms.begin(), atoms.end());
  struct Row {
    u32 type, variable, cell, value;
  };
  std::vector<Row> rows;
  for (const u32 cell : values_.cells()) {
    const u32 value = values_.in(cell);
    if (cell >= tables_.atom_cells || (values_[value].kind == Values::Kind::Old && values_[value].a == cell)) continue;
    const auto after = std::upper_bound(atoms.begin(), atoms.end(), std::pair{cell, kNone});
    if (after == atoms.begin()) return false;
    const auto [base, atom] = *(after - 1);
    BIP_ASSERT(cell - base < image_.atom_types[image_.atoms[atom].type].variables.size,
               "cell {} is no variable of atom {}", cell, atom);
    rows.push_back({image_.atoms[atom].type, cell - base, cell, value});
  }
  std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
    return std::tie(a.type, a.variable, a.cell) < std::tie(b.type, b.variable, b.cell);
  });
  assigned_.clear();
  std::vector<u32> cells;
  for (const Row& row : rows) {
    assigned_.emplace_back(row.cell, row.value);
    cells.push_back(row.cell);
  }
  std::sort(cells.begin(), cells.end());
  return std::all_of(rows.begin(), rows.end(), [&](const Row& row) {
    const Values::Value& value = values_[row.value];
    return value.kind != Values::Kind::Old ||
           (value.a < tables_.atom_cells && !std::binary_search(cells.begin(), cells.end(), value.a));
  });
}

// No code at all: values are old ones, or joined in the cell of a connector that would have had them.
bool Deriver::add_joined(Instance& out) {
  copies_.clear();
  std::vector<u32> done, elements;
  for (const auto& [cell, value] : assigned_) {
    if (values_[value].kind == Values::Kind::Old) {
      copies_.emplace_back(cell, values_[value].a);
      continue;
    }
    const u32 home = home_of(value);
    if (home == kNone) return false;
    copies_.emplace_back(cell, home);
    if (std::find(done.begin(), done.end(), value) != done.end()) continue;
    constexpr std::size_t kMostJoined = 16;
    if (done.size() == kMostJoined || !values_.elements(value, elements) || elements.back() >= tables_.atom_cells)
      return false;
    done.push_back(value);
    BIP_ASSERT(std::is_sorted(elements.begin(), elements.end()) && elements.size() >= 2, "a value is joined of {}",
               elements.size());
    out.add(StepOpKind::Copy);
    out.ref(home);
    out.ref(elements[0]);
    for (std::size_t i = 1; i < elements.size(); ++i) {
      out.add(StepOpKind::Reduce).reduction = values_[value].by;
      out.ref(home);
      out.ref(elements[i]);
    }
  }
  add_copies(out);
  return true;
}

// `up`s alone, which change no atom.
bool Deriver::add_moved(Instance& out) {
  copies_.clear();
  for (const u32 use : ups_) {
    const u32 unit = unit_of(use, Transfer::Up);
    if (unit != kNone && facts_[unit].writes_binds) return false;
  }
  for (const auto& [cell, value] : assigned_) {
    const u32 from = values_[value].kind == Values::Kind::Old ? values_[value].a : home_of(value);
    if (from == kNone) return false;
    copies_.emplace_back(cell, from);
  }
  if (!add_ups(out)) return false;
  add_copies(out);
  return true;
}

bool Deriver::add_ups(Instance& out) {
  for (const u32 use : ups_) {
    const rt::Connector& row = image_.connectors[uses_[use].connector];
    const bool needs_zeroes = !values_.is_known() || values_.has_read_zero();
    const u32 zeroed = needs_zeroes ? tables_.connector_type(uses_[use].connector).variables.size : 0;
    const u32 unit = unit_of(use, Transfer::Up);
    if ((unit != kNone || zeroed != 0) && !add_code(unit, zeroed, row.first_cell, row.binds, out)) return false;
  }
  return true;
}

void Deriver::add_copies(Instance& out) {
  for (const auto& [to, from] : copies_) {
    out.add(StepOpKind::Copy);
    out.ref(to);
    out.ref(from);
  }
}

bool Deriver::add_plan_codes(const rt::Plan& plan, Instance& out) {
  return add_transfers(tables_.plan_uses.data() + plan.first_use, plan.use_count,
                       tables_.plan_nodes.data() + plan.first_node, out);
}

// out: empty. nodes: only of uses that are linked.
bool Deriver::add_transfers(const rt::PlanUse* uses, u32 count, const rt::PlanNode* nodes, Instance& out) {
  uses_ = uses;
  if (!order_uses(count, nodes)) return false;
  evaluate_uses();
  // A profile counts each call.
  if (values_.is_known() && !lowered_.calls_rows && list_assigned()) {
    if (add_joined(out)) return true;
    out.clear();
    if (add_moved(out)) return true;
    out.clear();
  }
  if (!add_ups(out)) return false;
  for (const u32 use : downs_) {
    const rt::Connector& row = image_.connectors[uses_[use].connector];
    const u32 unit = unit_of(use, Transfer::Down);
    if (unit != kNone && !add_code(unit, 0, row.first_cell, row.binds, out)) return false;
  }
  return true;
}

void inline_copies(Instance& folded, const std::vector<std::int32_t>& strides, u32 atom_cells) {
  for (std::size_t code = 1; code < folded.ops.size(); ++code) {
    const StepOp& op = folded.ops[code];
    // A count, self: the code of atoms.
    if (op.kind != StepOpKind::Code || !op.repeats || op.refs != 2 || op.unit == kNone || op.zeroed != 0) continue;
    const u32 self = folded.refs[op.first_ref + 1];
    const std::int32_t stride = strides[op.first_ref + 1];
    if (stride <= 0 || self >= atom_cells) continue;
    for (std::size_t i = code; i-- > 0;) {
      StepOp& copy = folded.ops[i];
      if (copy.kind != StepOpKind::Copy || !copy.repeats || folded.refs[copy.first_ref] != folded.refs[op.first_ref])
        break;
      const u32 to = folded.refs[copy.first_ref + 1];
      const bool moves_along = strides[copy.first_ref + 1] == stride && to - self < static_cast<u32>(stride);
      if (!moves_along || strides[copy.first_ref + 2] != 0 || copy.guarded != op.guarded) break;
      copy.inlined = true;
      copy.offset = to - self;
    }
  }
}

}  // namespace bip::steps
