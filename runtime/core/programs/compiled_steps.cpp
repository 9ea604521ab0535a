// See compiled_steps.hpp.
#include "runtime/core/programs/compiled_steps.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <thread>
#include <type_traits>

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"
#include "runtime/core/profile.hpp"
#include "runtime/core/programs/batch_plan.hpp"
#include "runtime/core/programs/team.hpp"
#include "runtime/core/state/state_memory.hpp"

namespace bip::rt {

namespace {

struct Unwatched {
  void begin_step() const {}
  void end_step(InteractionId) const {}
};

// ---- the choice of the next interaction, a parameter of the loop; the loop has a copy, so that it stays in registers
// Uniformly.
struct Drawn {
  static constexpr bool kMarks = false;
  Prng numbers;
  [[nodiscard]] InteractionId choose(const StepState& s) {
    return InteractionId(s.members[s.count == 1 ? 0 : numbers.below(s.count)]);
  }
  // By a function of the image for many steps.
  static StepsFn function_of(const Image& image) { return image.steps_fn; }
  [[nodiscard]] bool takes_many(const StepState&) const { return true; }
  StepsTaken take_many(StepsFn take, StepState& s, StepHistory& history, u64 limit) {
    return take(s, numbers, history, limit);
  }
  void took(InteractionId) const {}
  void mark_all(const StepState&) const {}
};
// By order; marks what the step has put into the list. A short list is searched, and nothing is marked meanwhile.
struct InOrder {
  static constexpr bool kMarks = true;
  static constexpr u32 kShortAgain = StepOrder::kShort / 2;
  StepOrder order;
  MemberOrder* members;
  bool marks = true;
  [[nodiscard]] bool is_short(const StepState& s) const { return s.count <= (marks ? kShortAgain : StepOrder::kShort); }
  [[nodiscard]] InteractionId choose(const StepState& s) {
    if (!is_short(s)) {
      mark_all(s);
      return members->next(InteractionId(order.from), s.position);
    }
    marks = false;
    // The least distance from there, modulo 2^32.
    u32 least = s.members[0] - order.from;
    for (u32 k = 1; k < s.count; ++k) least = std::min(least, s.members[k] - order.from);
    return InteractionId(order.from + least);
  }
  /// What was not marked while the list was short.
  void mark_all(const StepState& s) {
    for (u32 k = 0; k < s.count && !marks; ++k) members->mark(InteractionId(s.members[k]));
    marks = true;
  }
  static OrderedStepsFn function_of(const Image& image) { return image.ordered_steps_fn; }
  [[nodiscard]] bool takes_many(const StepState& s) const { return is_short(s); }
  StepsTaken take_many(OrderedStepsFn take, StepState& s, StepHistory& history, u64 limit) {
    marks = false;
    return take(s, order, history, limit);
  }
  void took(InteractionId interaction) {
    if (order.follows) order.from = interaction.value + 1;
  }
  void mark(const StepState& s, const StepOperand* operands, u32 i, const StepEntry* entry, const StepEntry* end) {
    if (!marks) return;
    for (; entry != end; ++entry) {
      u32 interaction = operands[entry->operand].at(i);
      u32 left = entry->repeats == StepEntry::kOnce ? 1 : operands[entry->repeats].at(i);
      for (; left != 0; --left, interaction += entry->stride) {
        if (s.position[interaction] != kAbsentInteraction) members->mark(InteractionId(interaction));
      }
    }
  }
};

void fill_cells(const Image& image, const Cell* all, CacheLineVector<ColumnCell>& cells) {
  cells.resize(image.step_cells);
  for (const StepColumn& column : image.step_columns) {
    const Cell* const from = all + column.cell;
    ColumnCell* const to = cells.data() + column.column_cell;
    for (std::size_t k = 0; k < column.count; ++k) to[k].bits = static_cast<u32>(from[k * column.distance].bits);
  }
}

void empty_cells(const Image& image, const CacheLineVector<ColumnCell>& cells, Cell* all) {
  for (const StepColumn& column : image.step_columns) {
    const ColumnCell* const from = cells.data() + column.column_cell;
    Cell* const to = all + column.cell;
    for (std::size_t k = 0; k < column.count; ++k) to[k * column.distance].bits = from[k].bits;
  }
}

}  // namespace

namespace {

constexpr u64 kMostEpoch = 1u << 22;
constexpr u32 kTriesPerStep = 16;  // draws among the shared interactions until one is enabled

void wait_a_little(u64 seed) {
  const u64 how = Prng(seed).below(8);
  if (how == 0) std::this_thread::sleep_for(std::chrono::microseconds(20));
  else if (how < 4) std::this_thread::yield();
}

}  // namespace

// Finds the runs. An interaction without one is fired by the core; if rules might be read then, all
// interactions that can fire have one (derive_steps).
void CompiledSteps::link() {
  const Image& image = *core_.tables.image;
  runs_.clear();
  inner_runs_.clear();
  run_of_ = {};
  if (image.step_fns.size == 0 || core_.options.progress == MaximalProgress::Off || core_.search.is_weighted()) return;
  // Steps may have been derived for which there is no code yet: then there are no functions, but entries.
  first_entry_.assign(std::size_t{image.step_fns.size} + 1, 0);
  for (const StepEntry& entry : image.step_entries) {
    BIP_ASSERT(entry.shape < image.step_fns.size, "shape {} of {}", entry.shape, image.step_fns.size);
    ++first_entry_[entry.shape + 1];
  }
  for (u32 shape = 0; shape < image.step_fns.size; ++shape) first_entry_[shape + 1] += first_entry_[shape];
  std::vector<u32> rows(core_.tables.interactions.size(), kNone);
  u32 most = 0;
  for (u32 row = 0; row < image.step_runs.size; ++row) {
    const StepRun& run = image.step_runs[row];
    BIP_ASSERT(run.shape < image.step_fns.size && run.distance != 0, "shape {} of {}", run.shape, image.step_fns.size);
    // Division by the distance as a multiplication, which is exact for offsets up to 2^32 / distance.
    const u64 inverse = ((u64{1} << 32) + run.distance - 1) / run.distance;
    if (u64{run.count} * run.distance * run.distance > std::numeric_limits<u32>::max()) return;
    runs_.push_back(
        {image.step_fns[run.shape], image.step_operands.data + run.operands, InteractionId(run.first), inverse});
    BIP_ASSERT(run.count != 0 && run.first + u64{run.count - 1} * run.distance < rows.size(),
               "run {} goes beyond {} interactions", row, rows.size());
    for (u32 i = 0; i < run.count; ++i) rows[run.first + i * run.distance] = row;
  }
  std::map<std::vector<u32>, u32> known;  // connectors that take turns are alike in block after block
  for (std::size_t first = 0; first < rows.size(); first += 64) {
    const auto begin = rows.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = rows.begin() + static_cast<std::ptrdiff_t>(std::min(first + 64, rows.size()));
    if (std::all_of(begin, end, [&](u32 row) { return row == *begin; })) {
      run_of_.blocks.push_back(*begin);
      continue;
    }
    const auto [at, is_new] = known.try_emplace(std::vector<u32>(begin, end), static_cast<u32>(run_of_.rows.size()));
    run_of_.blocks.push_back(RunRows::kInteractionsDiffer + at->second);
    if (is_new) run_of_.rows.insert(run_of_.rows.end(), begin, end);
  }
  for (const StepRun& run : image.inner_steps.runs) {
    BIP_ASSERT(run.shape < image.step_fns.size && run.distance == 1, "shape {} of {}", run.shape, image.step_fns.size);
    inner_runs_.push_back(
        {image.step_fns[run.shape], image.step_operands.data + run.operands, InteractionId(run.first), 0});
  }
  for (const ConnectorType& type : image.connector_types) most = std::max(most, type.params.size);
  step_scratch_.assign(std::size_t{most} + 1, 0);
}

StepState CompiledSteps::state_of(const EnabledSet::List& list) {
  return {core_.memory.cells.all(),
          core_.memory.places.data(),
          core_.ports.values(),
          list.members,
          list.position,
          step_scratch_.data(),
          *list.count};
}

template <class Choose, class Watch>
u64 CompiledSteps::run_watched(Choose& given, u64 limit, bool (*is_stopped)(), bool& sound, Watch& watch) {
  constexpr u64 kBetweenLooks = 4096;
  EnabledSet::List list = core_.enabled.open_list();
  StepState s = state_of(list);
  // Copies: no call can change them.
  Choose choose = given;
  u32* const history = core_.history.ring();
  u32 history_at = core_.history.next();
  const u32* const blocks = run_of_.blocks.data();
  const u32* const rows = run_of_.rows.data();
  const CompiledRun* const runs = runs_.data();
  u64 done = 0;
  u64 look = 0;
  sound = true;
  const Image& image = *core_.tables.image;
  const bool has_cells = image.step_cells != 0;
  auto takes_many = Choose::function_of(image);
  if (!std::is_same_v<Watch, Unwatched> || (has_cells && limit < image.step_cells_pay)) takes_many = nullptr;
  CacheLineVector<ColumnCell> cells;
  bool in_cells = false;  // are data there, and not in core_.memory.cells?
  while (done < limit && s.count != 0) {
    if (done >= look) {
      if (is_stopped()) break;
      look = done + kBetweenLooks;
    }
    InteractionId interaction;  // none yet; as a plain number kAbsentInteraction
    if (takes_many != nullptr && choose.takes_many(s)) {
      if (has_cells && !in_cells) {
        fill_cells(image, core_.memory.cells.all(), cells);
        s.cells = cells.data();
        in_cells = true;
      }
      StepHistory recent{history, history_at};
      const StepsTaken taken = choose.take_many(takes_many, s, recent, std::min(limit, look) - done);
      history_at = recent.at;
      done += taken.count;
      interaction = InteractionId(taken.interaction);
      if (!interaction.is_valid()) continue;
    }
    if (in_cells) {
      empty_cells(image, cells, core_.memory.cells.all());
      in_cells = false;
      // A list that is short again and again would fill and empty the columns as often.
      if (!interaction.is_valid()) takes_many = nullptr;
    }
    if (!interaction.is_valid()) interaction = choose.choose(s);
    const u32 row = RunRows::find(blocks, rows, interaction);
    watch.begin_step();
    if (row != kNone) {
      const CompiledRun& run = runs[row];
      history[history_at] = interaction.value;
      history_at = (history_at + 1) % FiringHistory::kSize;
      BIP_ASSERT(interaction >= run.first, "interaction {} is no row of its run", interaction);
      const u32 i = run.index_of(interaction);
      run.fn(s, run.operands, i);
      if constexpr (Choose::kMarks) {
        const u32* const entries = first_entry_.data() + image.step_runs[row].shape;
        choose.mark(s, run.operands, i, image.step_entries.data + entries[0], image.step_entries.data + entries[1]);
      }
    } else {
      core_.enabled.close_list(s.count);
      core_.history.set_next(history_at);
      sound = core_.firing.take({interaction, 0});
      history_at = core_.history.next();
      if (!sound) break;
      s.count = *list.count;
    }
    choose.took(interaction);
    watch.end_step(interaction);
    ++done;
  }
  if (in_cells) empty_cells(image, cells, core_.memory.cells.all());
  choose.mark_all(s);
  given = choose;
  core_.history.set_next(history_at);
  if (!sound) return done;
  sound = close_run(s.count);
  return done;
}

bool CompiledSteps::close_run(u32 count) {
  core_.enabled.close_list(count);
  // What is marked waits for atoms that are away, and no step touched it.
  if (core_.partial.is_on()) return true;
  const DirectInteractions& direct = core_.ports.direct();
  if (core_.priorities.tables().count != 0 && !direct.of_crossing.empty()) {
    for (const InteractionId interaction : IdRange<InteractionId>(direct.below, direct.of_crossing.size())) {
      if (!direct.has(Tables::node_of(interaction))) core_.ports.mark_dirty(interaction);
    }
  }
  return core_.settle();
}

bool CompiledSteps::takes_inner(u64 limit) const {
  return !inner_runs_.empty() && limit >= core_.tables.image->inner_steps.pay;
}

// The core's arrays are filled from the inner ones at the end; interactions are renamed in the ring as well.
u64 CompiledSteps::run_inner(Prng& prng, u64 limit, bool (*is_stopped)()) {
  constexpr u64 kBetweenLooks = 4096;
  const InnerSteps& inner = core_.tables.image->inner_steps;
  const EnabledSet::List list = core_.enabled.open_list();
  const StepState outer = state_of(list);
  CacheLineVector<Cell> cells;
  CacheLineVector<u32> places, members, position;
  CacheLineVector<std::int32_t> values;
  cells.reserve(std::size_t{inner.cells.size} + 1);
  for (const u32 cell : inner.cells) cells.push_back(outer.all[cell]);
  cells.push_back({});
  places.reserve(inner.atoms.size);
  for (const u32 atom : inner.atoms) places.push_back(outer.places[atom]);
  members.assign(std::size_t{inner.interactions.size} + 1, 0);
  position.reserve(inner.interactions.size);
  values.reserve(inner.interactions.size);
  for (u32 k = 0; k < inner.interactions.size; ++k) {
    const u32 interaction = inner.interactions[k], at = outer.position[interaction];
    values.push_back(outer.values[interaction]);
    position.push_back(at);
    if (at != kAbsentInteraction) members[at] = k;
  }
  // Orders, or what broadcasts need.
  std::vector<u32> scratch = step_scratch_;
  if (inner.run_of.size > inner.interactions.size)
    scratch.assign(inner.run_of.begin() + inner.interactions.size, inner.run_of.end());
  StepState s{cells.data(), places.data(), values.data(), members.data(), position.data(), scratch.data(), outer.count};
  Prng numbers = prng;
  u32* const history = core_.history.ring();
  u32 history_at = core_.history.next();
  const u32* const run_of = inner.run_of.data;
  const CompiledRun* const runs = inner_runs_.data();
  const StepsFn takes_many = inner.steps_fn;
  u64 done = 0;
  for (u64 look = 0; done < limit && s.count != 0;) {
    if (done >= look) {
      if (is_stopped()) break;
      look = done + kBetweenLooks;
    }
    u32 interaction = kAbsentInteraction;  // an inner number
    if (takes_many != nullptr) {
      StepHistory recent{history, history_at};
      const StepsTaken taken = takes_many(s, numbers, recent, std::min(limit, look) - done);
      history_at = recent.at;
      done += taken.count;
      interaction = taken.interaction;
      if (interaction == kAbsentInteraction) continue;
    } else {
      interaction = s.members[s.count == 1 ? 0 : numbers.below(s.count)];
    }
    BIP_ASSERT(run_of[interaction] < inner_runs_.size(), "inner interaction {} has no run", interaction);
    const CompiledRun& run = runs[run_of[interaction]];
    history[history_at] = interaction;
    history_at = (history_at + 1) % FiringHistory::kSize;
    run.fn(s, run.operands, interaction - run.first.value);
    ++done;
  }
  prng = numbers;
  for (u32 k = 0; k < inner.cells.size; ++k) outer.all[inner.cells[k]] = cells[k];
  for (u32 k = 0; k < inner.atoms.size; ++k) outer.places[inner.atoms[k]] = places[k];
  for (u32 k = 0; k < inner.interactions.size; ++k) {
    outer.values[inner.interactions[k]] = values[k];
    outer.position[inner.interactions[k]] = position[k];
  }
  for (u32 k = 0; k < s.count; ++k) outer.members[k] = inner.interactions[members[k]];
  for (u64 k = 0; k < std::min<u64>(done, FiringHistory::kSize); ++k) {
    u32& fired = history[(history_at + FiringHistory::kSize - 1 - k) % FiringHistory::kSize];
    fired = inner.interactions[fired];
  }
  core_.history.set_next(history_at);
  *list.count = s.count;
  return done;
}

u64 CompiledSteps::run(Prng& prng, u64 limit, bool (*is_stopped)(), bool& sound, Profile* profile) {
  if (profile == nullptr && takes_inner(limit)) {
    const u64 done = run_inner(prng, limit, is_stopped);
    sound = close_run(*core_.enabled.open_list().count);
    return done;
  }
  Unwatched none;
  Drawn drawn{prng};
  const u64 done = profile == nullptr ? run_watched(drawn, limit, is_stopped, sound, none)
                                      : run_watched(drawn, limit, is_stopped, sound, *profile);
  prng = drawn.numbers;
  return done;
}

u64 CompiledSteps::run_among(const IndexVector<InteractionId, std::uint8_t>& takes, Prng& prng, u64 limit,
                             InteractionId& drawn) {
  BIP_ASSERT(core_.partial.is_on() && core_.priorities.tables().count == 0, "{} rules",
             core_.priorities.tables().count);
  EnabledSet::List list = core_.enabled.open_list();
  StepState s = state_of(list);
  Prng numbers = prng;
  u32* const history = core_.history.ring();
  u32 history_at = core_.history.next();
  drawn = {};
  u64 done = 0;
  for (; done < limit && s.count != 0; ++done) {
    const InteractionId interaction(s.members[s.count == 1 ? 0 : numbers.below(s.count)]);
    if (takes[interaction] == 0) {
      drawn = interaction;
      break;
    }
    const CompiledRun& run = runs_[run_of_[interaction]];
    history[history_at] = interaction.value;
    history_at = (history_at + 1) % FiringHistory::kSize;
    run.fn(s, run.operands, run.index_of(interaction));
  }
  prng = numbers;
  core_.history.set_next(history_at);
  core_.enabled.close_list(s.count);
  return done;
}

u64 CompiledSteps::run(StepOrder& order, u64 limit, bool (*is_stopped)(), bool& sound, Profile* profile) {
  Unwatched none;
  InOrder in_order{order, &core_.enabled.order()};
  const u64 done = profile == nullptr ? run_watched(in_order, limit, is_stopped, sound, none)
                                      : run_watched(in_order, limit, is_stopped, sound, *profile);
  order = in_order.order;
  return done;
}

void CompiledSteps::drop_programs() {
  if (!can_batch()) return;
  core_.programs.drop();
  if (!core_.looks_at_binds()) core_.memory.binds = {};
}

bool CompiledSteps::has_steps() const { return !run_of_.blocks.empty(); }

bool CompiledSteps::can_batch() const {
  if (!has_steps()) return false;
  for (const InteractionId interaction : core_.tables.interactions.ids()) {
    if (run_of_[interaction] == kNone) return false;
  }
  return true;
}

// The part's share: whom it draws among the shared ones is left to the end of the epoch.
void CompiledSteps::run_part(const BatchPlan& plan, BatchPart& part, bool records) {
  StepState s{core_.memory.cells.all(),
              core_.memory.places.data(),
              core_.ports.values(),
              part.members.data(),
              core_.enabled.open_list().position,
              part.scratch.data(),
              part.count};
  Prng numbers = part.prng;
  u64 steps = 0;
  for (u64 draw = 0; draw < part.draws && s.count != 0; ++draw) {
    const InteractionId interaction(s.members[numbers.below(s.count)]);
    if (plan.is_shared[interaction] != 0) continue;
    const CompiledRun& run = runs_[run_of_[interaction]];
    run.fn(s, run.operands, run.index_of(interaction));
    if (records) part.fired.push_back(interaction);
    ++steps;
  }
  part.prng = numbers;
  part.count = s.count;
  part.steps = steps;
  BIP_ASSERT(steps <= part.draws, "{} steps, {} draws", steps, part.draws);
}

void CompiledSteps::cut_list(const BatchPlan& plan, std::vector<BatchPart>& parts, u64 draws) {
  const EnabledSet::List list = core_.enabled.open_list();
  for (BatchPart& part : parts) part.count = 0;
  for (u32 i = 0; i < *list.count; ++i) {
    const InteractionId interaction(list.members[i]);
    BatchPart& part = parts[plan.part[interaction]];
    BIP_ASSERT(plan.part[interaction] < parts.size() && list.position[interaction.value] == i,
               "interaction {} is not at {}", interaction, i);
    list.position[interaction.value] = part.count;
    part.members[part.count++] = interaction.value;
    BIP_ASSERT(part.count < part.members.size(), "{} members of a part", part.count);
  }
  for (BatchPart& part : parts) {
    part.draws = draws * part.count / *list.count;
    part.fired.clear();
  }
}

void CompiledSteps::join_list(const std::vector<BatchPart>& parts) {
  const EnabledSet::List list = core_.enabled.open_list();
  u32 count = 0;
  for (const BatchPart& part : parts) {
    for (u32 i = 0; i < part.count; ++i) {
      const InteractionId interaction(part.members[i]);
      list.position[interaction.value] = count;
      list.members[count++] = interaction.value;
    }
  }
  BIP_ASSERT(count <= core_.tables.interactions.size(), "{} members", count);
  core_.enabled.close_list(count);
}

// Up to `draws` steps among the shared interactions.
u64 CompiledSteps::run_shared(const BatchPlan& plan, Prng& prng, u64 draws, std::vector<InteractionId>& fired) {
  const EnabledSet::List list = core_.enabled.open_list();
  StepState s = state_of(list);
  u64 steps = 0;
  for (u64 tries = draws * kTriesPerStep; steps < draws && tries > 0 && !plan.shared.empty(); --tries) {
    const InteractionId interaction = plan.shared[prng.below(plan.shared.size())];
    if (s.position[interaction.value] == kAbsentInteraction) continue;
    const CompiledRun& run = runs_[run_of_[interaction]];
    run.fn(s, run.operands, run.index_of(interaction));
    fired.push_back(interaction);
    ++steps;
  }
  core_.enabled.close_list(s.count);
  return steps;
}

u64 CompiledSteps::run_batch(const BatchPlan& plan, Team& team, Prng& prng, u64 limit, bool (*is_stopped)(),
                             const std::function<void(const std::vector<InteractionId>&)>& record) {
  BIP_ASSERT(can_batch() && plan.parts <= team.size(), "{} parts for {} threads", plan.parts, team.size());
  const u64 epoch = std::min(std::max<u64>(core_.tables.interactions.size() * 2, plan.least_epoch), kMostEpoch);
  std::vector<BatchPart> parts(plan.parts);
  for (u32 k = 0; k < plan.parts; ++k) {
    parts[k].prng = Prng(prng.next());
    parts[k].members.assign(std::size_t{plan.size[k]} + 1, 0);
    parts[k].scratch = step_scratch_;
  }
  std::vector<InteractionId> fired;
  u64 done = 0;
  while (core_.enabled.listed_count() != 0 && limit - done >= plan.least_epoch && !is_stopped()) {
    BIP_ASSERT(done <= limit, "{} steps, a limit of {}", done, limit);
    const u64 draws = std::min(epoch, limit - done);
    cut_list(plan, parts, draws);
    team.run([&](u32 k) {
      if (k >= plan.parts) return;
      if (plan.perturb != 0) wait_a_little(plan.perturb + done * kMostParts + k);
      run_part(plan, parts[k], record != nullptr);
    });
    join_list(parts);
    u64 steps = 0, left = draws;
    for (const BatchPart& part : parts) {
      steps += part.steps;
      left -= std::min(left, part.draws);
      left += part.draws - part.steps;
      if (record) record(part.fired);
    }
    fired.clear();
    steps += run_shared(plan, prng, std::min(left, draws - steps), fired);
    if (record) record(fired);
    done += steps;
    // Too little to do beside each other: the short way takes over.
    if (steps * 2 < draws) break;
  }
  // The ring of interactions fired last knows nothing of these.
  if (done != 0) core_.history.clear();
  return done;
}

}  // namespace bip::rt
