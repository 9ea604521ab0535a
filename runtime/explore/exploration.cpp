// Levels and batches; see exploration.hpp.
#include "runtime/explore/exploration.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/explore/follow_path.hpp"

namespace bip::rt {

namespace {

constexpr u64 kSmall = 512;                    // a frontier that one thread does alone
constexpr u64 kStatesPerLook = 16;             // at the clock: where the core is asked, a state can take milliseconds
constexpr std::size_t kBatchWords = 1u << 18;  // of successors a thread: a batch ends, limits are looked at

u64 count_of(const std::vector<std::unique_ptr<StateStore>>& owners) {
  u64 sum = 0;
  for (const auto& owner : owners) sum += owner->size();
  return sum;
}

}  // namespace

Exploration::Exploration(const Image& image, const ExploreOptions& options)
    : image_(image),
      options_(options),
      team_(image.ffi != nullptr || options.limit != ~u64{0} ? 1 : std::max(1u, options.threads)) {}

u64 Exploration::states() const { return count_of(owners_); }

std::size_t Exploration::kept_bytes() const {
  std::size_t sum = space_.locals->bytes();
  for (const auto& owner : owners_) sum += owner->bytes();
  for (const Worker& worker : workers_) {
    sum += worker.expander->bytes() + (worker.evaluator ? worker.evaluator->bytes() : 0);
    for (const auto& list : worker.out.words) sum += list.capacity() * sizeof(u64);
  }
  return sum;
}

void Exploration::make_owners() {
  owners_.clear();
  for (u32 k = 0; k < team_.size(); ++k) {
    owners_.push_back(std::make_unique<StateStore>(space_.layout.words(), options_.bytes / team_.size()));
  }
}

void Exploration::begin() {
  report_.has_final_states = has_final_states(image_);
  Core core(image_, {.progress = options_.progress});
  if (!begins(core)) {
    report_.errors = 1;
    report_.has_error = true;
    return;
  }
  space_.image = &image_;
  space_.progress = options_.progress;
  space_.shapes = shapes_of(core, options_.progress);
  space_.locals = std::make_unique<Locals>(core, options_.unread_cells);
  space_.initial = core.snapshot();
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) (void)space_.locals->number(atom, core);
  space_.layout = Layout(*space_.locals);
  if (options_.reduction == StateReduction::Por) stubborn_ = std::make_unique<Stubborn>(core, space_.shapes);
  if (options_.reduction == StateReduction::Symmetry) {
    symmetry_ = std::make_unique<Symmetry>(image_, *space_.locals, options_.symmetry);
    symmetry_->index_interactions(space_.shapes);
    report_.groups = symmetry_->names();
  }
  space_.stubborn = stubborn_.get();
  space_.symmetry = symmetry_.get();
  make_owners();
  workers_.resize(team_.size());
  for (Worker& worker : workers_) {
    worker.expander = std::make_unique<Expander>(space_, team_.size());
    if (options_.predicate) worker.evaluator = std::make_unique<PredicateEvaluator>(space_, options_);
    worker.out.words.resize(team_.size());
  }
  std::vector<u64> state(space_.layout.words()), scratch;
  (void)workers_[0].expander->pack(core, state.data());
  if (symmetry_ != nullptr) symmetry_->normalize(state.data(), space_.layout, scratch);
  level_first_.assign(team_.size(), 0);
  (void)owners_[team_.size() == 1 ? 0 : workers_[0].expander->owner_of(state.data())]->add(state.data(), 1);
}

// Every state anew in a wider layout, level by level: which level a state belongs to stays. The current level's steps
// are taken again, for its states may have other owners now.
bool Exploration::widen() {
  bool is_done = true;
  const Layout before = space_.layout;
  std::vector<std::unique_ptr<StateStore>> old = std::move(owners_);
  space_.layout = Layout(*space_.locals);
  make_owners();
  for (Worker& worker : workers_) {
    worker.expander->relayout();
    if (worker.evaluator) worker.evaluator->relayout();
    worker.out.clear();
    worker.counts = {};
  }
  const u32 count = team_.size();
  const u32 levels = static_cast<u32>(level_first_.size()) / count;
  std::vector<u32> first;
  std::vector<u64> from(before.words()), to(space_.layout.words()), scratch;
  for (u32 level = 0; level < levels; ++level) {
    for (u32 owner = 0; owner < count; ++owner) first.push_back(owners_[owner]->size());
    for (u32 owner = 0; owner < count; ++owner) {
      const u32 end = level + 1 < levels ? level_first_[std::size_t{level + 1} * count + owner] : old[owner]->size();
      for (u32 row = level_first_[std::size_t{level} * count + owner]; row < end; ++row) {
        old[owner]->read(row, from.data(), scratch);
        std::fill(to.begin(), to.end(), u64{0});
        for (u32 atom = 0; atom < space_.locals->atoms(); ++atom)
          space_.layout.set(to.data(), atom, before.get(from.data(), atom));
        is_done = owners_[count == 1 ? 0 : workers_[0].expander->owner_of(to.data())]->add(to.data(), 1) && is_done;
      }
    }
  }
  BIP_ASSERT(first.size() == level_first_.size(), "{} levels became {}", level_first_.size(), first.size());
  BIP_ASSERT(!is_done || count_of(old) == states(), "{} states of {}", states(), count_of(old));
  level_first_ = std::move(first);
  counts_ = counts_before_level_;
  return is_done;
}

u64 Exploration::frontier_size(u32 level) const {
  u64 sum = 0;
  const std::size_t count = owners_.size();
  for (std::size_t owner = 0; owner < count; ++owner)
    sum += level_first_[(level + 1) * count + owner] - level_first_[level * count + owner];
  return sum;
}

ExploreEnd Exploration::end_by_now() const {
  if (options_.is_stopped && options_.is_stopped()) return ExploreEnd::Stopped;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - started_;
  return options_.seconds > 0 && spent.count() > options_.seconds ? ExploreEnd::Time : ExploreEnd::Complete;
}

bool Exploration::is_over() {
  if (report_.end != ExploreEnd::Complete) return true;
  report_.end = end_by_now();
  if (report_.end != ExploreEnd::Complete) return true;
  if (options_.bytes != 0 && kept_bytes() > options_.bytes) report_.end = ExploreEnd::Memory;
  return report_.end != ExploreEnd::Complete;
}

bool Exploration::insert(bool is_small) {
  std::atomic<bool> is_done{true};
  const auto job = [&](u32 owner) {
    for (const Worker& worker : workers_) {
      const std::vector<u64>& list = worker.out.words[owner];
      if (!owners_[owner]->add(list.data(), list.size() / space_.layout.words())) is_done = false;
    }
  };
  if (is_small) {
    for (u32 owner = 0; owner < owners_.size(); ++owner) job(owner);
  } else {
    team_.run(job);
  }
  return is_done;
}

// One state's successors, in the order of the candidates; a new one beyond the limit ends it, and its step does not
// count.
bool Exploration::insert_up_to_limit() {
  BIP_ASSERT(workers_.size() == 1, "a limit of states with {} threads", workers_.size());
  const std::vector<u64>& list = workers_[0].out.words[0];
  const u32 words = space_.layout.words();
  u64 steps = 0;
  for (std::size_t at = 0; at < list.size(); at += words, ++steps) {
    if (owners_[0]->contains(list.data() + at)) continue;
    if (states() >= options_.limit) {
      report_.end = ExploreEnd::States;
      break;
    }
    if (!owners_[0]->add(list.data() + at, 1)) return false;
  }
  workers_[0].counts.steps = steps;
  return true;
}

// Expands states of the frontier from `done` on. False: the search is over.
bool Exploration::run_batch(u64 frontier, u64& done) {
  BIP_ASSERT(done < frontier, "{} of {} states are expanded", done, frontier);
  const u64 end = is_one_by_one_ ? done + 1 : frontier;
  const bool is_small = end - done <= kSmall || team_.size() == 1;
  cursor_ = done;
  is_batch_full_ = false;
  const auto job = [&](u32 k) {
    Worker& worker = workers_[k];
    u64 looked = 0;
    while (!is_batch_full_.load(std::memory_order_relaxed)) {
      const u64 from = cursor_.fetch_add(kStatesPerPiece);
      if (from >= end) break;
      each_state(worker, level_, from, std::min(from + kStatesPerPiece, end), [&](Worker& at, const u64* state) {
        // Whatever of the batch is done then counts; the search is over after it.
        if (++looked % kStatesPerLook == 0 && end_by_now() != ExploreEnd::Complete) {
          is_batch_full_.store(true, std::memory_order_relaxed);
          return false;
        }
        const Expander::Result result = at.expander->expand(state, at.out);
        at.counts.steps += result.steps;
        at.counts.deadlocks += result.is_deadlock ? 1 : 0;
        at.counts.finals += result.is_final ? 1 : 0;
        at.counts.errors += result.has_error ? 1 : 0;
        at.counts.matches += at.evaluator && at.evaluator->holds(state, *at.expander) ? 1 : 0;
        return !at.expander->is_too_narrow();
      });
      if (worker.expander->is_too_narrow() || worker.out.size() > kBatchWords)
        is_batch_full_.store(true, std::memory_order_relaxed);
    }
  };
  if (is_small) job(0);
  else team_.run(job);

  if (std::any_of(workers_.begin(), workers_.end(),
                  [](const Worker& worker) { return worker.expander->is_too_narrow(); })) {
    // Both layouts are there for a moment.
    const bool has_room = options_.bytes == 0 || 2 * kept_bytes() <= options_.bytes;
    if (!has_room || !widen()) report_.end = ExploreEnd::Memory;
    done = 0;
    return report_.end == ExploreEnd::Complete;
  }
  bool is_added = true;
  if (options_.limit != ~u64{0} && states() + workers_[0].out.size() / space_.layout.words() > options_.limit) {
    if (!is_one_by_one_) {
      is_one_by_one_ = true;
      workers_[0].out.clear();
      workers_[0].counts = {};
      return true;
    }
    is_added = insert_up_to_limit();
  } else {
    is_added = insert(is_small);
  }
  if (!is_added) report_.end = ExploreEnd::Memory;
  for (Worker& worker : workers_) {
    counts_.steps += worker.counts.steps;
    counts_.deadlocks += worker.counts.deadlocks;
    counts_.finals += worker.counts.finals;
    counts_.errors += worker.counts.errors;
    counts_.matches += worker.counts.matches;
    worker.counts = {};
    worker.out.clear();
  }
  if (counts_.deadlocks != 0) deadlock_level_ = std::min(deadlock_level_, level_);
  if (counts_.errors != 0) error_level_ = std::min(error_level_, level_);
  if (counts_.matches != 0) match_level_ = std::min(match_level_, level_);
  done = std::min(cursor_.load(), end);
  return report_.end == ExploreEnd::Complete;
}

void Exploration::report_progress(u64 expanded_of_level) const {
  if (!options_.on_progress) return;
  std::size_t bytes = 0;
  for (const auto& owner : owners_) bytes += owner->bytes();
  options_.on_progress({.states = states(),
                        .expanded = expanded_before_ + expanded_of_level,
                        .steps = counts_.steps,
                        .deadlocks = counts_.deadlocks,
                        .errors = counts_.errors,
                        .matches = counts_.matches,
                        .depth = level_,
                        .bytes = bytes});
}

void Exploration::run_levels() {
  for (;; ++level_) {
    for (const auto& owner : owners_) level_first_.push_back(owner->size());
    const u64 frontier = frontier_size(level_);
    if (frontier == 0) return;
    counts_before_level_ = counts_;
    report_.depth = level_;
    for (u64 done = 0; done < frontier;) {
      const bool goes_on = run_batch(frontier, done);
      report_progress(done);
      if (!goes_on || is_over()) return;
    }
    expanded_before_ += frontier;
  }
}

ExploreReport Exploration::run() {
  begin();
  if (!report_.has_error) {
    run_levels();
    report_.states = states();
    BIP_ASSERT(report_.states <= options_.limit, "{} states, a limit of {}", report_.states, options_.limit);
    report_.steps = counts_.steps;
    report_.deadlocks = counts_.deadlocks;
    report_.finals = counts_.finals;
    report_.errors = counts_.errors;
    report_.bits = space_.layout.bits();
    report_.words = space_.layout.words();
    for (const auto& owner : owners_) report_.bytes += owner->bytes();
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - started_;
    report_.seconds = spent.count();
    find_paths();
  }
  report_.threads = team_.size();
  return std::move(report_);
}

ExploreReport explore_states(const Image& image, const ExploreOptions& options) {
  return Exploration(image, options).run();
}

}  // namespace bip::rt
