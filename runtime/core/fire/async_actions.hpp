// Actions that run beside the others (`@async`; semantics.md, Codels). A step of such a transition moves the tokens;
// the atom is then at work, and offers nothing, until the action's result takes effect: all at once, at one instant.
//
// In logical time that is when the budget ends, and the action runs there (without a budget it is no different from
// others). In real time it is when the action returns from a thread of the pool; a replayed run takes it from the
// record. Cost: a job, and one look at the atom each way.
#pragma once
#include <vector>

#include "runtime/core/link/tables.hpp"
#include "runtime/core/time/interval.hpp"

namespace bip::rt {

struct CoreParts;
class ActionPool;

/// Has a component of the image actions that run beside the others?
[[nodiscard]] bool has_async(const Image& image);

/// An atom whose action runs beside the others.
struct AtWork {
  u32 transition = kNone;   // row of Tables::transitions; kNone: it is not
  u32 place = kNone;        // where it was before
  i64 until = kForever;     // the end of the budget
  u64 job = 0;              // of the pool; 0: none
  bool is_overrun = false;  // nothing is to be said of the budget any more
};

class AsyncActions {
 public:
  explicit AsyncActions(CoreParts& core) : core_(core) {}
  /// Finds whether a type has such actions. Once, of images with time.
  void link();
  void reset();

  /// Has a type such actions?
  [[nodiscard]] bool any() const { return !at_work_.empty(); }
  /// Before the first step: from now on actions end when return_action says so, not with their budget. pool: null: they
  /// run then.
  void await_returns(ActionPool* pool);
  /// The atoms whose actions have not taken effect, in the order in which they began.
  [[nodiscard]] const std::vector<u32>& working() const { return working_; }
  [[nodiscard]] bool is_at_work(u32 atom) const { return any() && at_work_[atom].transition != kNone; }
  /// Of an atom that is at work.
  [[nodiscard]] const AtWork& work_of(u32 atom) const { return at_work_[atom]; }
  void mark_overrun(u32 atom) { at_work_[atom].is_overrun = true; }
  /// The action takes effect at this instant; it is waited for. False: a fault.
  bool return_action(u32 atom);

  // ---- for the other parts of the core
  /// The transition's action if it is to run beside the others now, else null.
  [[nodiscard]] const Async* async_of(u32 atom, const LinkedTransition& transition) const;
  /// After `down`: tokens move, and the atom is at work.
  bool begin_action(u32 atom, const LinkedTransition& transition, const Async& async);
  /// The same of an atom whose tokens have moved from `place`; its ports are not found anew.
  void begin_work(u32 atom, const LinkedTransition& transition, const Async& async, u32 place);
  /// The budget is over: the atom is at work no longer. Returns the transition whose action is to be run.
  const LinkedTransition& end_work(u32 atom);
  /// What the action did takes effect now; the core is not settled. False: a fault.
  bool finish_action(u32 atom);
  /// After a restored state: what runs belongs to another one.
  void restart_jobs();
  static constexpr std::size_t kSavedWords = 5;
  /// Are these such words, of an atom that could be at work? kSavedWords of them.
  [[nodiscard]] bool is_saved(const i64* words) const;
  /// Appends what `save` says of an atom that is at work: kSavedWords words.
  void save_work(u32 atom, std::vector<i64>& out) const;
  /// Appends the atoms at work with their actions; reads the same, and returns what follows.
  void save(std::vector<i64>& out) const;
  const i64* load(const i64* in);
  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const { return at_work_.size() * sizeof(AtWork); }

 private:
  void begin_job(u32 atom);

  CoreParts& core_;
  std::vector<AtWork> at_work_;     // by atom; empty: no type has such actions
  std::vector<u32> working_;        // those at work, in the order in which they began
  bool waits_for_returns_ = false;  // real time, replay: returns come from outside
  ActionPool* pool_ = nullptr;      // where actions run; null: where they return
};

}  // namespace bip::rt
