// One exploration: levels, batches of a level, and the paths to what was found. Internal to runtime/explore.
//
// A batch has two phases whose shared data are read-only. First each thread expands states of the frontier and sorts
// the successors by owner; then each owner adds to its own store. So no word is written by two threads, counts do not
// depend on timing, and the set of states is the same for any number of threads. The order within a level is not, and
// no output depends on it.
#pragma once
#include <atomic>
#include <chrono>
#include <memory>

#include "bip/assert.hpp"

#include "runtime/explore/expander.hpp"
#include "runtime/explore/explore.hpp"
#include "runtime/explore/state_predicate.hpp"
#include "runtime/explore/state_store.hpp"
#include "runtime/core/programs/team.hpp"

namespace bip::rt {

/// States that a thread takes at a time.
inline constexpr u64 kStatesPerPiece = 128;

class Exploration {
 public:
  Exploration(const Image& image, const ExploreOptions& options);
  ExploreReport run();

 private:
  struct Counts {
    u64 steps = 0, deadlocks = 0, finals = 0, errors = 0, matches = 0;
  };
  struct Worker {
    std::unique_ptr<Expander> expander;
    std::unique_ptr<PredicateEvaluator> evaluator;  // null: no predicate
    Outbox out;
    Counts counts;
    std::vector<u64> state, scratch;
    std::vector<u64> hits;  // states, while paths are looked for
  };
  enum class Goal : std::uint8_t { Deadlock, Error, Match };

  // exploration.cpp
  void begin();
  void run_levels();
  bool run_batch(u64 frontier, u64& done);
  bool insert(bool is_small);
  bool insert_up_to_limit();
  bool widen();
  void make_owners();
  void report_progress(u64 expanded_of_level) const;
  [[nodiscard]] bool is_over();
  [[nodiscard]] ExploreEnd end_by_now() const;  // any thread
  [[nodiscard]] u64 states() const;
  [[nodiscard]] u64 frontier_size(u32 level) const;
  [[nodiscard]] std::size_t kept_bytes() const;
  // Calls visit(worker, state) for items [begin, end) of the level.
  template <class Visit>
  void each_state(Worker& worker, u32 level, u64 begin, u64 end, const Visit& visit);

  // counterexample_paths.cpp
  void find_paths();
  bool find_path(Goal goal, u32 level, Path& path);
  template <class IsHit>
  bool collect(u32 level, StateStore& hits, const IsHit& is_hit);
  bool walk(Goal goal, const std::vector<std::unique_ptr<StateStore>>& near, Path& path);

  const Image& image_;
  ExploreOptions options_;
  StateSpace space_;
  std::unique_ptr<Stubborn> stubborn_;
  std::unique_ptr<Symmetry> symmetry_;
  Team team_;
  std::vector<Worker> workers_;
  std::vector<std::unique_ptr<StateStore>> owners_;
  std::vector<u32> level_first_;  // by level and owner: the first row
  u32 level_ = 0;                 // the one that is expanded
  Counts counts_, counts_before_level_;
  u64 expanded_before_ = 0;  // states of the levels before
  u32 deadlock_level_ = kNone, error_level_ = kNone, match_level_ = kNone;
  bool is_one_by_one_ = false;  // the limit of states is near
  std::atomic<u64> cursor_{0};
  std::atomic<bool> is_batch_full_{false};
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  ExploreReport report_;
};

template <class Visit>
void Exploration::each_state(Worker& worker, u32 level, u64 begin, u64 end, const Visit& visit) {
  const u32 count = static_cast<u32>(owners_.size());
  BIP_ASSERT(std::size_t{level + 1} * count < level_first_.size(), "level {} is not complete", level);
  worker.state.resize(space_.layout.words());
  u64 base = 0;
  for (u32 owner = 0; owner < count; ++owner) {
    const u32 first = level_first_[std::size_t{level} * count + owner];
    const u64 size = level_first_[std::size_t{level + 1} * count + owner] - first;
    for (u64 item = std::max(begin, base); item < std::min(end, base + size); ++item) {
      owners_[owner]->read(first + static_cast<u32>(item - base), worker.state.data(), worker.scratch);
      if (!visit(worker, worker.state.data())) return;
    }
    base += size;
  }
}

}  // namespace bip::rt
