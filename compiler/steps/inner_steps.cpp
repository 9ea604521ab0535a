// Derives steps in inner order, see inner_steps.hpp.
//
// An interaction's operations are those of the source's order with other numbers, except that values and the list are
// separate operations: values in inner order, which is the same for all interactions of a class, and the list in the
// order of the source, by operations that do not know what will change. So interactions of a class have one shape.
// Their operands are affine in their rank in the class; those that differ in the order of the list are runs of their
// own.
#include "compiler/steps/inner_steps.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "compiler/steps/derive_steps.hpp"
#include "compiler/steps/inner_order.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::steps {

namespace {

constexpr u32 kOrderBits = 4, kMostInOrder = 8;
constexpr u32 kMostInnerShapes = 16;
constexpr std::size_t kFewInteractions = 64;  // whose tables stay at hand in any order
constexpr std::size_t kMostSamples = 8;
constexpr std::size_t kFewRuns = 1024;  // whose operands stay at hand

std::vector<u32> inverse(const std::vector<u32>& numbers) {
  std::vector<u32> to(numbers.size());
  for (u32 inner = 0; inner < numbers.size(); ++inner) to[numbers[inner]] = inner;
  return to;
}

class InnerDeriver {
 public:
  InnerDeriver(Deriver& deriver, const lower::LoweredSystem& lowered)
      : deriver_(deriver),
        lowered_(lowered),
        order_(find_inner_order(lowered.image, deriver.tables())),
        atom_to_(inverse(order_.atoms)),
        interaction_to_(inverse(order_.interactions)),
        cell_to_(inverse(order_.cells)) {
    // The self of code without variables may be the end of all cells.
    cell_to_.push_back(static_cast<u32>(cell_to_.size()));
  }

  bool derive(InnerOrders where, lower::Steps& steps) {
    const bool wherever = where == InnerOrders::WherePossible;
    if (order_.interactions.size() <= kFewInteractions && !wherever) return false;
    if (!describe_all()) return false;
    const std::size_t shapes_before = steps.shapes.size();
    find_runs(steps);
    const std::size_t shapes = shapes_.size();
    if (shapes == 0) return false;
    const bool has_few_rows = runs_.size() <= std::max(kFewRuns, order_.interactions.size() / 4);
    const bool is_better = shapes < shapes_before || runs_.size() * 4 <= order_.interactions.size();
    if (!wherever && (shapes > kMostInnerShapes || !has_few_rows || !is_better)) return false;
    for (lower::StepShape& shape : shapes_) steps.shapes.push_back(std::move(shape));
    steps.operands.insert(steps.operands.end(), operands_.begin(), operands_.end());
    // Arrays are filled and emptied once a run, a look at each element.
    constexpr std::size_t kElementsPerStep = 8;
    const std::size_t elements = order_.atoms.size() + 2 * order_.interactions.size() + order_.cells.size();
    steps.inner.pay = static_cast<u32>(1 + elements / kElementsPerStep);
    steps.inner.atoms = std::move(order_.atoms);
    steps.inner.interactions = std::move(order_.interactions);
    steps.inner.cells = std::move(order_.cells);
    list_loop(steps);
    steps.inner.run_of = std::move(run_of_);
    if (has_orders_) steps.inner.run_of.insert(steps.inner.run_of.end(), orders_.begin(), orders_.end());
    steps.inner.runs = std::move(runs_);
    return true;
  }

 private:
  // Interactions of one class whose operations are alike.
  struct Group {
    std::vector<u32> key;
    std::vector<StepOp> ops;
    std::vector<std::int32_t> strides;
    std::vector<u32> slopes;   // by operand: from one interaction of the class to the next
    std::vector<u32> samples;  // some of its members
  };

  bool describe_all() {
    std::map<std::pair<u32, std::vector<u32>>, u32> known;  // by class
    Instance instance, renamed, folded;
    std::vector<std::int32_t> strides;
    group_of_.assign(order_.interactions.size(), kNone);
    first_ref_.assign(1, 0);
    orders_.assign(2 * order_.interactions.size(), 0);
    // Steps of broadcasts need the scratch for what is ready.
    for (const rt::InteractionId interaction : deriver_.tables().interactions.ids())
      has_orders_ = has_orders_ && deriver_.tables().interactions[interaction].kind != rt::InteractionKind::Star;
    for (u32 inner = 0; inner < order_.interactions.size(); ++inner) {
      const Deriver::Found found = deriver_.describe(rt::InteractionId(order_.interactions[inner]), instance);
      if (found == Deriver::Found::No) return false;
      if (found == Deriver::Found::Yes) {
        rename(instance);
        separate(instance, inner, renamed);
        fold(renamed, kLeastRepeats, folded, strides);
        inline_copies(folded, strides, deriver_.atom_cells());
        if (folded.ops.size() > kMostOps) return false;
        std::vector<u32> key = shape_key(folded, strides);
        const auto [at, is_new] =
            known.try_emplace({order_.first_of_class[inner], key}, static_cast<u32>(groups_.size()));
        if (is_new) groups_.push_back({std::move(key), folded.ops, strides, {}, {}});
        Group& group = groups_[at->second];
        if (group.samples.size() < kMostSamples) group.samples.push_back(inner);
        group_of_[inner] = at->second;
        refs_.insert(refs_.end(), folded.refs.begin(), folded.refs.end());
      }
      first_ref_.push_back(static_cast<u32>(refs_.size()));
    }
    return true;
  }

  [[nodiscard]] bool has_no_self(const StepOp& op) const {
    if (op.unit == kNone || op.zeroed != 0) return false;
    const lower::CodeUnit& unit = lowered_.units[op.unit];
    const rt::Image& image = lowered_.image;
    return (unit.owner == lower::CodeOwner::Atom && image.atom_types[unit.owner_row].variables.size == 0) ||
           (unit.owner == lower::CodeOwner::Connector && image.connector_types[unit.owner_row].variables.size == 0);
  }

  // Not folded yet: no operand is a count.
  void rename(Instance& in) const {
    for (const StepOp& op : in.ops) {
      u32* const refs = in.refs.data() + op.first_ref;
      const auto rename_data = [&](u32 first, u32 end) {
        for (u32 k = first; k < end; ++k) refs[k] = cell_to_[refs[k]];
      };
      switch (op.kind) {
        case StepOpKind::Reduce:
        case StepOpKind::Copy:
        case StepOpKind::Code:
          rename_data(0, op.refs);
          if (op.kind == StepOpKind::Code && has_no_self(op)) refs[0] = 0;
          break;
        case StepOpKind::At:
        case StepOpKind::Away:
        case StepOpKind::Place: refs[0] = atom_to_[refs[0]]; break;
        case StepOpKind::Ready:
          refs[0] = atom_to_[refs[0]];
          if (op.unit != kNone) refs[1] = has_no_self(op) ? 0 : cell_to_[refs[1]];
          if (op.delta != 0) refs[op.refs - 1] = interaction_to_[refs[op.refs - 1]];
          break;
        case StepOpKind::Interaction:
          refs[0] = interaction_to_[refs[0]];
          if (op.unit != kNone) {
            rename_data(1, op.refs - op.hiders);
            if (has_no_self(op)) refs[1] = 0;
          }
          for (u32 k = op.refs - op.hiders; k < op.refs; ++k) refs[k] = interaction_to_[refs[k]];
          break;
        case StepOpKind::Count:
        case StepOpKind::Settle:
        case StepOpKind::SettleInOrder: BIP_UNREACHABLE("an operation of inner steps");
      }
    }
  }

  // Interactions without guards that nothing hides: values first, by difference and inner number; then the list.
  void separate(const Instance& in, u32 inner, Instance& out) {
    out.clear();
    const auto is_separate = [](const StepOp& op) {
      return op.kind == StepOpKind::Interaction && op.unit == kNone && op.hiders == 0;
    };
    std::vector<std::pair<std::int32_t, u32>> values;
    for (const StepOp& op : in.ops) {
      if (is_separate(op) && op.delta != 0) values.emplace_back(op.delta, in.refs[op.first_ref]);
    }
    std::sort(values.begin(), values.end());
    const auto copy = [&](const StepOp& op) {
      const u32 first = out.add(op.kind).first_ref;
      out.ops.back() = op;
      out.ops.back().first_ref = first;
      out.refs.insert(out.refs.end(), in.refs.begin() + op.first_ref, in.refs.begin() + op.first_ref + op.refs);
    };
    for (const StepOp& op : in.ops) {
      if (op.kind != StepOpKind::Interaction) copy(op);
    }
    for (const auto& [delta, interaction] : values) {
      StepOp& made = out.add(StepOpKind::Count);
      made.delta = delta;
      made.change = change_of(in, interaction);
      out.ref(interaction);
    }
    const bool all_separate = std::all_of(in.ops.begin(), in.ops.end(), [&](const StepOp& op) {
      return op.kind != StepOpKind::Interaction || (is_separate(op) && op.delta != 0);
    });
    if (has_orders_ && all_separate && values.size() > 1 && values.size() <= kMostInOrder) {
      out.add(StepOpKind::SettleInOrder);
      out.ref(inner);
      for (const auto& [delta, interaction] : values) out.ref(interaction);
      std::vector<u32> order;
      for (const StepOp& op : in.ops) {
        if (op.kind != StepOpKind::Interaction) continue;
        const auto at = std::find(values.begin(), values.end(), std::pair{op.delta, in.refs[op.first_ref]});
        order.push_back(static_cast<u32>(at - values.begin()));
      }
      add_order(order, in, values, inner, out.ops.back());
      return;
    }
    for (const StepOp& op : in.ops) {
      if (is_separate(op)) {
        out.add(StepOpKind::Settle);
        out.ref(in.refs[op.first_ref]);
      } else if (op.kind == StepOpKind::Interaction) {
        copy(op);
      }
    }
  }

  static InteractionChange change_of(const Instance& in, u32 interaction) {
    const auto at = std::find_if(in.ops.begin(), in.ops.end(), [&](const StepOp& op) {
      return op.kind == StepOpKind::Interaction && in.refs[op.first_ref] == interaction;
    });
    return at->change;
  }
  // Numbers of values, in the order in which the list changes.
  void add_order(const std::vector<u32>& order, const Instance& in,
                 const std::vector<std::pair<std::int32_t, u32>>& values, u32 inner, StepOp& op) {
    constexpr std::uint32_t kUnsure = 1, kGrows = 2, kShrinks = 4;
    const auto pack = [&](std::uint32_t without) {
      u32 packed = 0, count = 0;
      for (const u32 value : order) {
        const auto [delta, interaction] = values[value];
        const bool is_sure = change_of(in, interaction) != InteractionChange::Look;
        const std::uint32_t kind = is_sure ? 0 : kUnsure | (delta > 0 ? kGrows : kShrinks);
        if ((kind & without) == 0) packed |= value << (kOrderBits * count++);
      }
      return std::pair{packed, count};
    };
    using lower::OrderParts;
    const auto [all, count] = pack(0);
    const auto [sure, sure_count] = pack(kUnsure);
    const auto [growing, growing_count] = pack(kShrinks);
    const auto [shrinking, shrinking_count] = pack(kGrows);
    orders_[inner] = all;
    // Values of others may be above 0.
    const bool are_exact = std::all_of(values.begin(), values.end(), [&](const auto& value) {
      const rt::InteractionId interaction(order_.interactions[value.second]);
      const rt::InteractionKind kind = deriver_.tables().interactions[interaction].kind;
      return kind == rt::InteractionKind::Flat || kind == rt::InteractionKind::Port;
    });
    if (!are_exact || count > OrderParts::kMost || sure_count == count || sure_count > OrderParts::kMostSure ||
        growing_count > OrderParts::kMostWith || shrinking_count > OrderParts::kMostWith)
      return;
    op.to = static_cast<u32>(order_.interactions.size());
    orders_[inner] |= sure << OrderParts::kSureAt;
    orders_[inner + op.to] = growing | shrinking << OrderParts::kShrinkingAt;
  }

  // How far the operands of an operation move from one interaction to the next, if they do.
  void add_slopes(const StepOp& op, const u32* refs, std::vector<u32>& slopes) const {
    if (op.repeats) slopes.push_back(0);
    const u32 count = op.refs - (op.repeats ? 1 : 0);
    for (u32 k = 0; k < count; ++k) {
      const u32 ref = refs[op.first_ref + (op.repeats ? 1 : 0) + k];
      const bool is_data = op.kind == StepOpKind::Reduce || op.kind == StepOpKind::Copy ||
                           op.kind == StepOpKind::Code ||
                           (op.kind == StepOpKind::Ready && k == 1 && op.unit != kNone) ||
                           (op.kind == StepOpKind::Interaction && k > 0 && k < count - op.hiders);
      if (is_data) slopes.push_back(ref < order_.cell_distance.size() ? order_.cell_distance[ref] : 0);
      else slopes.push_back(op.kind == StepOpKind::Place && k == 1 ? 0 : 1);
    }
  }

  void find_runs(const lower::Steps& steps) {
    std::map<std::vector<u32>, u32> known_shapes, known_runs;
    std::vector<u32> shape_of_group;
    for (Group& group : groups_) {
      const u32* const first = refs_.data() + first_ref_[group.samples.front()];
      for (const StepOp& op : group.ops) add_slopes(op, first, group.slopes);
      for (std::size_t k = 0; k < group.slopes.size() && group.samples.size() > 1; ++k) {
        // What all of them share.
        const bool rests = std::all_of(group.samples.begin(), group.samples.end(),
                                       [&](u32 member) { return refs_[first_ref_[member] + k] == first[k]; });
        if (rests) group.slopes[k] = 0;
      }
      group.key.insert(group.key.end(), group.slopes.begin(), group.slopes.end());
      const auto [at, is_new] = known_shapes.try_emplace(group.key, static_cast<u32>(shapes_.size()));
      if (is_new) shapes_.push_back({group.ops, group.strides, group.slopes});
      shape_of_group.push_back(static_cast<u32>(steps.shapes.size()) + at->second);
    }
    std::vector<u32> key;
    run_of_.assign(order_.interactions.size(), kNone);
    for (u32 inner = 0; inner < order_.interactions.size(); ++inner) {
      if (group_of_[inner] == kNone) continue;
      const Group& group = groups_[group_of_[inner]];
      const u32 first = order_.first_of_class[inner];
      key.assign({group_of_[inner], first});
      for (std::size_t k = 0; k < group.slopes.size(); ++k)
        key.push_back(refs_[first_ref_[inner] + k] - group.slopes[k] * (inner - first));
      const auto [at, is_new] = known_runs.try_emplace(key, static_cast<u32>(runs_.size()));
      if (is_new) {
        runs_.push_back({first, 0, 1, shape_of_group[group_of_[inner]],
                         static_cast<u32>(steps.operands.size() + operands_.size())});
        for (std::size_t k = 0; k < group.slopes.size(); ++k) operands_.push_back({key[k + 2], group.slopes[k]});
      }
      rt::StepRun& run = runs_[at->second];
      run.count = inner - first + 1;
      run_of_[inner] = at->second;
    }
  }

  // Runs without gaps, with operands that count from their own first interaction.
  void list_loop(lower::Steps& steps) const {
    std::vector<u32> begins(runs_.size(), kNone), members(runs_.size(), 0), ends(runs_.size(), 0);
    u32 with_steps = 0;
    for (u32 inner = 0; inner < run_of_.size(); ++inner) {
      const u32 run = run_of_[inner];
      if (run == kNone) continue;
      begins[run] = std::min(begins[run], inner);
      ends[run] = inner + 1;
      ++members[run];
      ++with_steps;
    }
    std::vector<rt::StepRun> without_gaps;
    for (std::size_t k = 0; k < runs_.size(); ++k) {
      if (members[k] == ends[k] - begins[k])
        without_gaps.push_back({begins[k], members[k], 1, runs_[k].shape, static_cast<u32>(k)});
    }
    steps.inner.loop = choose_loop(std::move(without_gaps), with_steps);
    for (rt::StepRun& run : steps.inner.loop) {
      const rt::StepRun& of = runs_[run.operands];
      run.operands = static_cast<u32>(steps.operands.size());
      for (std::size_t k = 0; k < steps.shapes[run.shape].strides.size(); ++k) {
        const rt::StepOperand row = steps.operands[of.operands + k];
        steps.operands.push_back({row.at(run.first - of.first), row.stride});
      }
    }
  }

  Deriver& deriver_;
  const lower::LoweredSystem& lowered_;
  InnerOrder order_;
  std::vector<u32> atom_to_, interaction_to_, cell_to_;  // by number of the core: the inner one
  std::vector<Group> groups_;
  std::vector<u32> group_of_, first_ref_, refs_;  // by inner interaction
  std::vector<lower::StepShape> shapes_;
  std::vector<rt::StepRun> runs_;
  std::vector<rt::StepOperand> operands_;
  std::vector<u32> run_of_;
  std::vector<u32> orders_;  // by inner interaction, then the second numbers
  bool has_orders_ = true;
};

}  // namespace

void derive_inner_steps(Deriver& deriver, const lower::LoweredSystem& lowered, InnerOrders where, lower::Steps& steps) {
  (void)InnerDeriver(deriver, lowered).derive(where, steps);
}

}  // namespace bip::steps
