// See async_actions.hpp.
#include "runtime/core/fire/async_actions.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "bip/ffi.hpp"
#include "runtime/core/core_parts.hpp"
#include "runtime/core/fire/action_pool.hpp"

namespace bip::rt {

bool has_async(const Image& image) {
  for (const Atom& atom : image.atoms) {
    const AtomTime* time = image.atom_types[atom.type].time;
    if (time != nullptr && std::any_of(time->transitions.begin(), time->transitions.end(),
                                       [](const TransitionTime& transition) { return transition.async.present; }))
      return true;
  }
  return false;
}

void AsyncActions::link() {
  const Image& image = core_.image();
  if (has_async(image)) at_work_.resize(image.atoms.size);
}

void AsyncActions::reset() {
  at_work_.assign(at_work_.size(), {});
  working_.clear();
}

void AsyncActions::save(std::vector<i64>& out) const {
  for (const u32 atom : working_) save_work(atom, out);
  if (any()) out.push_back(-1);
}

void AsyncActions::save_work(u32 atom, std::vector<i64>& out) const {
  const AtWork& work = at_work_[atom];
  for (const i64 word : {i64{atom}, i64{work.transition}, i64{work.place}, work.until, i64{work.is_overrun}})
    out.push_back(word);
}

bool AsyncActions::is_saved(const i64* words) const {
  if (!any() || words[0] < 0 || words[0] >= static_cast<i64>(at_work_.size())) return false;
  const u32 type = core_.atoms[static_cast<u32>(words[0])].type;
  const LinkedType& linked = core_.tables.types[type];
  const i64 row = words[1] - linked.first_transition;
  if (row < 0 || row >= i64{linked.transition_count}) return false;
  const AtomTime* const time = core_.image().atom_types[type].time;
  if (time == nullptr || !time->transitions[static_cast<u32>(row)].async.present) return false;
  const bool is_place = words[2] >= 0 && words[2] < i64{core_.image().atom_types[type].places.size};
  return is_place && words[3] >= 0 && (words[4] == 0 || words[4] == 1);
}

const i64* AsyncActions::load(const i64* in) {
  reset();
  if (!any()) return in;
  for (; *in >= 0; in += kSavedWords) {
    BIP_ASSERT(static_cast<std::size_t>(in[0]) < at_work_.size() && !is_at_work(static_cast<u32>(in[0])),
               "atom {} is at work twice", in[0]);
    working_.push_back(static_cast<u32>(in[0]));
    at_work_[working_.back()] = {static_cast<u32>(in[1]), static_cast<u32>(in[2]), in[3], 0, in[4] != 0};
  }
  return in + 1;
}

void AsyncActions::await_returns(ActionPool* pool) {
  if (!any()) return;
  waits_for_returns_ = true;
  pool_ = pool;
}

const Async* AsyncActions::async_of(u32 atom, const LinkedTransition& transition) const {
  const AtomTime& time = *core_.tables.atom_type(atom).time;
  const u32 row = static_cast<u32>(&transition - core_.tables.transitions.data()) -
                  core_.tables.types[core_.atoms[atom].type].first_transition;
  BIP_ASSERT(row < core_.tables.types[core_.atoms[atom].type].transition_count, "transition {} of atom {}", row, atom);
  const Async& async = time.transitions[row].async;
  return async.present && (waits_for_returns_ || async.budget > 0) ? &async : nullptr;
}

// Into the pool, with a copy of what it works on.
void AsyncActions::begin_job(u32 atom) {
  AtWork& work = at_work_[atom];
  const LinkedTransition& transition = core_.tables.transitions[work.transition];
  if (pool_ == nullptr) return;
  ActionJob job;
  job.atom = atom;
  job.action = transition.action;
  job.ffi = core_.image().ffi;
  const Span<Var>& vars = core_.tables.atom_type(atom).variables;
  const Cell* self = core_.memory.cells.from(core_.atoms[atom].first_cell);
  job.self.assign(self, self + vars.size);
  for (u32 i = 0; i < vars.size; ++i) {
    if (is_ffi(vars[i].type))
      job.objects.emplace_back(ffi_type(core_.image(), vars[i].type),
                               reinterpret_cast<const void*>(static_cast<std::uintptr_t>(self[i].bits)));
  }
  std::size_t object = 0;
  for (u32 i = 0; i < vars.size; ++i) {
    if (is_ffi(vars[i].type)) job.self[i] = object_cell(job.objects[object++].object());
  }
  BIP_ASSERT(work.job == 0 && object == job.objects.size(), "{} objects of {}", object, job.objects.size());
  work.job = pool_->begin(std::move(job));
}

// After `down`: tokens move, and the atom is at work.
bool AsyncActions::begin_action(u32 atom, const LinkedTransition& transition, const Async& async) {
  const u32 before = core_.memory.places[atom];
  BIP_ASSERT(!is_at_work(atom), "atom {} is at work already", atom);
  if (!core_.atom_steps.move_tokens(atom, transition)) return false;
  begin_work(atom, transition, async, before);
  if (!core_.clocks.look_at_time(atom)) return false;
  if (core_.atoms[atom].watched != 0) core_.ports.touch(atom);
  return true;
}

void AsyncActions::begin_work(u32 atom, const LinkedTransition& transition, const Async& async, u32 place) {
  core_.clocks.show_clocks(atom);
  const i64 until =
      async.budget < 0 || async.budget >= kForever - core_.clocks.now() ? kForever : core_.clocks.now() + async.budget;
  BIP_ASSERT(until >= core_.clocks.now(), "a budget that ended at {}", until);
  at_work_[atom] = {static_cast<u32>(&transition - core_.tables.transitions.data()), place, until, 0, false};
  working_.push_back(atom);
  core_.clocks.set_busy_until(atom, waits_for_returns_ ? kForever : until);
  begin_job(atom);
}

const LinkedTransition& AsyncActions::end_work(u32 atom) {
  const LinkedTransition& transition = core_.tables.transitions[at_work_[atom].transition];
  at_work_[atom] = {};
  BIP_ASSERT(std::count(working_.begin(), working_.end(), atom) == 1, "atom {} is listed {} times", atom,
             std::count(working_.begin(), working_.end(), atom));
  working_.erase(std::find(working_.begin(), working_.end(), atom));
  return transition;
}

// What the action did takes effect now.
bool AsyncActions::finish_action(u32 atom) {
  BIP_ASSERT(is_at_work(atom), "atom {} is not at work", atom);
  const AtWork work = at_work_[atom];
  const LinkedTransition& transition = end_work(atom);
  const Span<Var>& vars = core_.tables.atom_type(atom).variables;
  Cell* self = core_.memory.cells.from(core_.atoms[atom].first_cell);
  std::int32_t status = 1;
  if (work.job != 0) {
    const ActionJob job = pool_->take(work.job);
    BIP_ASSERT(job.atom == atom && job.self.size() == vars.size, "a job of atom {} with {} variables", job.atom,
               job.self.size());
    status = job.status;
    if (status >= 2 && job.ffi != nullptr) job.ffi->set_message(job.message.c_str());
    std::size_t object = 0;
    for (u32 i = 0; i < vars.size; ++i) {
      if (!is_ffi(vars[i].type)) self[i] = job.self[i];
      else
        ffi_type(core_.image(), vars[i].type)
            .copy(reinterpret_cast<void*>(static_cast<std::uintptr_t>(self[i].bits)), job.objects[object++].object());
    }
  } else if (transition.action.fn != nullptr) {
    status = transition.action.fn(transition.action.context, self, core_.memory.cells.all(), nullptr);
  }
  if (status >= 2) return core_.faults.fail_code(status, atom, kNone, transition.source);
  if (!core_.clocks.read_clocks(atom, transition.source)) return false;
  if (core_.tables.types[core_.atoms[atom].type].has_invariants &&
      !core_.atom_steps.check_invariants(atom, &transition))
    return false;
  if (!core_.atom_steps.settle_atom(atom, work.place, &transition)) return false;
  if (core_.atoms[atom].watched != 0) core_.ports.touch(atom);
  return true;
}

bool AsyncActions::return_action(u32 atom) {
  BIP_ASSERT(waits_for_returns_, "the budget ends the action of atom {}", atom);
  if (!finish_action(atom)) return false;
  return core_.settle();
}

// What runs belongs to another state.
void AsyncActions::restart_jobs() {
  if (pool_ == nullptr) return;
  pool_->drop();
  for (const u32 atom : working_) begin_job(atom);
}

}  // namespace bip::rt
