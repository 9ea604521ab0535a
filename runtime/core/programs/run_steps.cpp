// The short way: steps by the image's step functions (bip/steps.hpp), one after the other, drawn uniformly.
//
// A step costs a draw, two loads to find its run, one indirect call; less if the image has a function for many steps.
// Meanwhile ranks and rules are not kept up to date; rules are brought up to date at the end, which costs as much as
// the system is large if it has priorities. What flat connectors with guards offer the list of the enabled says;
// nothing else that is searched depends on an atom that a compiled step moves (compiler/steps), so an interaction
// without step function is fired by the core in between.
#include <algorithm>
#include <limits>
#include <map>
#include <type_traits>

#include "runtime/core/core.hpp"
#include "runtime/core/profile.hpp"

namespace bip::rt {

namespace {

struct Unwatched {
  void begin_step() const {}
  void end_step(u32) const {}
};

void fill_cells(const Image& image, const Cell* all, std::vector<ColumnCell>& cells) {
  cells.resize(image.step_cells);
  for (const StepColumn& column : image.step_columns) {
    const Cell* const from = all + column.cell;
    ColumnCell* const to = cells.data() + column.column_cell;
    for (std::size_t k = 0; k < column.count; ++k) to[k].bits = static_cast<u32>(from[k * column.distance].bits);
  }
}

void empty_cells(const Image& image, const std::vector<ColumnCell>& cells, Cell* all) {
  for (const StepColumn& column : image.step_columns) {
    const ColumnCell* const from = cells.data() + column.column_cell;
    Cell* const to = all + column.cell;
    for (std::size_t k = 0; k < column.count; ++k) to[k * column.distance].bits = from[k].bits;
  }
}

}  // namespace

// Finds the runs. An interaction without one is fired by the core; if somebody might look at rules then, all
// interactions that can fire have one (derive_steps).
void Core::link_steps() {
  const Image& image = *tables_.image;
  runs_.clear();
  run_of_ = {};
  if (image.step_fns.size == 0 || options_.progress == MaximalProgress::Off || is_weighted_) return;
  std::vector<u32> rows(tables_.interactions.size(), kNone);
  u32 most = 0;
  for (u32 row = 0; row < image.step_runs.size; ++row) {
    const StepRun& run = image.step_runs[row];
    // Division by the distance as a multiplication, which is exact for offsets up to 2^32 / distance.
    const u64 inverse = ((u64{1} << 32) + run.distance - 1) / run.distance;
    if (u64{run.count} * run.distance * run.distance > std::numeric_limits<u32>::max()) return;
    runs_.push_back({image.step_fns[run.shape], image.step_operands.data + run.operands, run.first, inverse});
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
  for (const ConnectorType& type : image.connector_types) most = std::max(most, type.params.size);
  step_scratch_.assign(std::size_t{most} + 1, 0);
}

template <class Watch>
u64 Core::run_watched_steps(Prng& prng, u64 limit, bool (*is_stopped)(), bool& sound, Watch& watch) {
  constexpr u64 kBetweenLooks = 4096;
  EnabledSet::List list = enabled_.open_list();
  StepState s{all_.data(),   places_.data(),       values_.data(), list.members,
              list.position, step_scratch_.data(), *list.count};
  // Copies that nobody else can change.
  Prng numbers = prng;
  u32* const history = history_.data();
  u32 history_at = history_at_;
  const u32* const blocks = run_of_.blocks.data();
  const u32* const rows = run_of_.rows.data();
  const CompiledRun* const runs = runs_.data();
  u64 done = 0;
  u64 look = 0;
  sound = true;
  const Image& image = *tables_.image;
  const bool has_cells = image.step_cells != 0;
  const StepsFn takes_many =
      std::is_same_v<Watch, Unwatched> && (!has_cells || limit >= image.step_cells_pay) ? image.steps_fn : nullptr;
  std::vector<ColumnCell> cells;
  bool in_cells = false;  // are data there, and not in all_?
  while (done < limit && s.count != 0) {
    if (done >= look) {
      if (is_stopped()) break;
      look = done + kBetweenLooks;
    }
    u32 interaction = kAbsentInteraction;
    if (takes_many != nullptr) {
      if (has_cells && !in_cells) {
        fill_cells(image, all_.data(), cells);
        s.cells = cells.data();
        in_cells = true;
      }
      StepHistory recent{history, history_at};
      const StepsTaken taken = takes_many(s, numbers, recent, std::min(limit, look) - done);
      history_at = recent.at;
      done += taken.count;
      interaction = taken.interaction;
      if (interaction == kAbsentInteraction) continue;
      if (in_cells) empty_cells(image, cells, all_.data());
      in_cells = false;
    } else {
      interaction = s.members[s.count == 1 ? 0 : numbers.below(s.count)];
    }
    const u32 row = RunRows::find(blocks, rows, interaction);
    watch.begin_step();
    if (row != kNone) {
      const CompiledRun& run = runs[row];
      history[history_at] = interaction;
      history_at = (history_at + 1) % kHistory;
      run.fn(s, run.operands, static_cast<u32>((interaction - run.first) * run.inverse >> 32));
    } else {
      enabled_.close_list(s.count);
      history_at_ = history_at;
      sound = take({interaction, 0});
      history_at = history_at_;
      if (!sound) break;
      s.count = *list.count;
    }
    watch.end_step(interaction);
    ++done;
  }
  if (in_cells) empty_cells(image, cells, all_.data());
  prng = numbers;
  history_at_ = history_at;
  if (!sound) return done;
  enabled_.close_list(s.count);
  for (u32 interaction = direct_.below; interaction < direct_.is_direct.size() && rules_.count != 0; ++interaction) {
    if (direct_.is_direct[interaction] == 0) mark_dirty(interaction);
  }
  sound = settle();
  return done;
}

u64 Core::run_steps(Prng& prng, u64 limit, bool (*is_stopped)(), bool& sound, Profile* profile) {
  Unwatched nobody;
  return profile == nullptr ? run_watched_steps(prng, limit, is_stopped, sound, nobody)
                            : run_watched_steps(prng, limit, is_stopped, sound, *profile);
}

}  // namespace bip::rt
