// The shortest path to a goal state. Parents of states are not stored, but levels are: the states of level i that can
// step into a given set of level i + 1 are found by expanding level i again, from the level of the goals backward. Then
// a core runs from the initial state, each time by the first candidate that leads into the set. Cost: at most one more
// expansion of the levels, without the store.
#include <algorithm>

#include "bip/assert.hpp"
#include "bip/draws.hpp"

#include "runtime/core/final_state.hpp"
#include "runtime/explore/exploration.hpp"

namespace bip::rt {

namespace {

constexpr double kGraceSeconds = 5;       // for the paths, when the time was over before
constexpr std::size_t kShareOfPaths = 4;  // of the memory that is allowed: a quarter more for the paths

}  // namespace

// Adds the level's states of which is_hit(worker, state) holds. False: no time left, or a number that does not fit.
template <class IsHit>
bool Exploration::collect(u32 level, StateStore& hits, const IsHit& is_hit) {
  const u64 size = frontier_size(level);
  cursor_ = 0;
  is_batch_full_ = false;
  const auto job = [&](u32 k) {
    Worker& worker = workers_[k];
    worker.hits.clear();
    while (!is_batch_full_.load(std::memory_order_relaxed)) {
      const u64 from = cursor_.fetch_add(kStatesPerPiece);
      if (from >= size) break;
      each_state(worker, level, from, std::min(from + kStatesPerPiece, size), [&](Worker& at, const u64* state) {
        if (is_hit(at, state)) at.hits.insert(at.hits.end(), state, state + space_.layout.words());
        return !at.expander->is_too_narrow();
      });
      const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - started_;
      const bool is_late = report_.end != ExploreEnd::Complete && report_.end != ExploreEnd::States &&
                           spent.count() > report_.seconds + kGraceSeconds;
      if (worker.expander->is_too_narrow() || is_late) is_batch_full_.store(true, std::memory_order_relaxed);
    }
  };
  if (size <= kStatesPerPiece) job(0);
  else team_.run(job);
  bool has_room = true;
  for (Worker& worker : workers_) {
    has_room = hits.add(worker.hits.data(), worker.hits.size() / space_.layout.words()) && has_room;
    worker.hits.clear();
  }
  return has_room && !is_batch_full_.load();
}

bool Exploration::find_path(Goal goal, u32 level, Path& path) {
  std::vector<std::unique_ptr<StateStore>> near(level + 1);
  std::size_t used = 0;
  for (u32 at = level + 1; at-- > 0;) {
    const std::size_t allowed = options_.bytes / kShareOfPaths;
    if (options_.bytes != 0 && used >= allowed) return false;
    near[at] = std::make_unique<StateStore>(space_.layout.words(), options_.bytes == 0 ? 0 : allowed - used);
    const bool is_done = collect(at, *near[at], [&](Worker& worker, const u64* state) {
      if (at == level && goal == Goal::Match) return worker.evaluator->holds(state, *worker.expander);
      worker.out.clear();
      const Expander::Result result = worker.expander->expand(state, worker.out);
      if (at == level) return goal == Goal::Deadlock ? result.is_deadlock : result.has_error;
      for (const std::vector<u64>& list : worker.out.words) {
        for (std::size_t k = 0; k < list.size(); k += space_.layout.words()) {
          if (near[at + 1]->contains(list.data() + k)) return true;
        }
      }
      return false;
    });
    if (!is_done) return false;
    used += near[at]->bytes();
  }
  return walk(goal, near, path);
}

bool Exploration::walk(Goal goal, const std::vector<std::unique_ptr<StateStore>>& near, Path& path) {
  BIP_ASSERT(!near.empty() && near[0]->size() == 1, "paths from {} initial states", near[0]->size());
  Core core(image_, {.progress = options_.progress});
  State state = space_.initial;
  if (!core.restore(state)) return false;
  Expander& expander = *workers_[0].expander;
  std::vector<u64> packed(space_.layout.words()), scratch;
  path.clear();
  for (std::size_t level = 1; level < near.size(); ++level) {
    const u64 count = core.candidate_count();
    u64 k = 0;
    u64 drawn = 0;
    bool is_found = false;
    for (; k < count && !is_found; ++k) {
      DrawScript script;
      const FollowedScript follow(script);
      do {
        if (core.fire(k) && expander.pack(core, packed.data())) {
          if (symmetry_ != nullptr) symmetry_->normalize(packed.data(), space_.layout, scratch);
          is_found = near[level]->contains(packed.data());
          drawn = script.number();
        }
        if (!is_found && !core.restore(state)) return false;
      } while (!is_found && script.advance());
    }
    if (!is_found) return false;
    path.push_back(choice_of(k - 1, drawn));
    state = core.snapshot();
  }
  if (goal == Goal::Deadlock) return is_deadlock(core);
  if (goal == Goal::Match) return options_.predicate(core);
  const u64 count = core.candidate_count();
  for (u64 k = 0; k < count; ++k) {
    DrawScript script;
    const FollowedScript follow(script);
    do {
      if (!core.fire(k)) {
        path.push_back(choice_of(k, script.number()));
        return true;
      }
      if (!core.restore(state)) return false;
    } while (script.advance());
  }
  return false;
}

void Exploration::find_paths() {
  // The level after the last one may have been begun; only whole levels are looked at.
  const auto find = [&](Goal goal, u32 level, Path& path) {
    while (!find_path(goal, level, path)) {
      const bool is_narrow = std::any_of(workers_.begin(), workers_.end(),
                                         [](const Worker& worker) { return worker.expander->is_too_narrow(); });
      counts_before_level_ = counts_;
      if (!is_narrow || !widen()) {
        report_.are_paths_known = false;
        path.clear();
        return;
      }
    }
  };
  report_.has_deadlock = deadlock_level_ != kNone;
  report_.has_error = error_level_ != kNone;
  report_.has_match = match_level_ != kNone;
  if (report_.has_deadlock) find(Goal::Deadlock, deadlock_level_, report_.deadlock);
  if (report_.has_error) find(Goal::Error, error_level_, report_.error);
  if (report_.has_match) find(Goal::Match, match_level_, report_.match);
}

}  // namespace bip::rt
