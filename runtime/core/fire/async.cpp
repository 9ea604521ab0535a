// Actions that run beside the others (`@async`; semantics.md, Codels). A step of such a transition moves the tokens;
// the atom is then at work, and offers nothing, until the action's result takes effect: all at once, at one instant.
//
// In logical time that is when the budget ends, and the action runs there (without a budget it is no different from
// others). In real time it is when the action returns from a thread of the pool; a replayed run is told. Cost: a job,
// and one look at the atom each way.
#include <algorithm>

#include "bip/ffi.hpp"
#include "runtime/core/fire/action_pool.hpp"
#include "runtime/core/core.hpp"

namespace bip::rt {

void Core::await_returns(ActionPool* pool) {
  if (!has_async()) return;
  time_->waits_for_returns = true;
  time_->pool = pool;
}

const Async* Core::async_of(u32 atom, const LinkedTransition& transition) const {
  const AtomTime& time = *tables_.atom_type(atom).time;
  const u32 row =
      static_cast<u32>(&transition - tables_.transitions.data()) - tables_.types[atoms_[atom].type].first_transition;
  const Async& async = time.transitions[row].async;
  return async.present && (time_->waits_for_returns || async.budget > 0) ? &async : nullptr;
}

// Into the pool, with a copy of what it works on.
void Core::begin_job(u32 atom) {
  AtWork& work = time_->at_work[atom];
  const LinkedTransition& transition = tables_.transitions[work.transition];
  if (time_->pool == nullptr) return;
  ActionJob job;
  job.atom = atom;
  job.action = transition.action;
  job.ffi = image().ffi;
  const Span<Var>& vars = tables_.atom_type(atom).variables;
  const Cell* self = all_.data() + atoms_[atom].first_cell;
  job.self.assign(self, self + vars.size);
  for (u32 i = 0; i < vars.size; ++i) {
    if (is_ffi(vars[i].type))
      job.objects.emplace_back(ffi_type(image(), vars[i].type),
                               reinterpret_cast<const void*>(static_cast<std::uintptr_t>(self[i].bits)));
  }
  std::size_t object = 0;
  for (u32 i = 0; i < vars.size; ++i) {
    if (is_ffi(vars[i].type)) job.self[i] = object_cell(job.objects[object++].object());
  }
  work.job = time_->pool->begin(std::move(job));
}

// After `down`: tokens move, and the atom is at work.
bool Core::begin_action(u32 atom, const LinkedTransition& transition, const Async& async) {
  TimeState& t = *time_;
  const u32 before = places_[atom];
  if (!move_tokens(atom, transition)) return false;
  const i64 until = async.budget < 0 || async.budget >= kForever - t.now ? kForever : t.now + async.budget;
  t.at_work[atom] = {static_cast<u32>(&transition - tables_.transitions.data()), before, until, 0, false};
  t.working.push_back(atom);
  t.busy_until[atom] = t.waits_for_returns ? kForever : until;
  begin_job(atom);
  if (!look_at_time(atom)) return false;
  if (atoms_[atom].watched != 0) touch(atom);
  return true;
}

// What the action did takes effect now.
bool Core::finish_action(u32 atom) {
  TimeState& t = *time_;
  const AtWork work = t.at_work[atom];
  t.at_work[atom] = {};
  t.working.erase(std::find(t.working.begin(), t.working.end(), atom));
  const LinkedTransition& transition = tables_.transitions[work.transition];
  const Span<Var>& vars = tables_.atom_type(atom).variables;
  Cell* self = all_.data() + atoms_[atom].first_cell;
  std::int32_t status = 1;
  if (work.job != 0) {
    const ActionJob job = t.pool->take(work.job);
    status = job.status;
    if (status >= 2 && job.ffi != nullptr) job.ffi->set_message(job.message.c_str());
    std::size_t object = 0;
    for (u32 i = 0; i < vars.size; ++i) {
      if (!is_ffi(vars[i].type)) self[i] = job.self[i];
      else
        ffi_type(image(), vars[i].type)
            .copy(reinterpret_cast<void*>(static_cast<std::uintptr_t>(self[i].bits)), job.objects[object++].object());
    }
  } else if (transition.action.fn != nullptr) {
    status = transition.action.fn(transition.action.context, self, all_.data(), nullptr);
  }
  if (status >= 2) return fail_code(status, atom, kNone, transition.source);
  if (!read_clocks(atom, transition.source)) return false;
  if (tables_.types[atoms_[atom].type].has_invariants && !check_invariants(atom, &transition)) return false;
  if (!settle_atom(atom, work.place, &transition)) return false;
  if (atoms_[atom].watched != 0) touch(atom);
  return true;
}

bool Core::return_action(u32 atom) {
  if (!finish_action(atom)) return false;
  return dirty_.empty() && dirty_rules_.empty() ? true : settle();
}

// What runs belongs to another state.
void Core::restart_jobs() {
  if (time_->pool == nullptr) return;
  time_->pool->drop();
  for (const u32 atom : time_->working) begin_job(atom);
}

}  // namespace bip::rt
