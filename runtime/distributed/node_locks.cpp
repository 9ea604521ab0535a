// The locks of split sets: see node.hpp, and split_sets.hpp for who coordinates and who locks what.
//
// Deadlock-free: an attempt waits only for an atom that is at work, which ends, or that another attempt has locked; and
// of the atoms at their homes it locks those of earlier nodes first, at a node those of smaller numbers. What its
// coordinator holds besides, no other attempt waits for. An attempt that has all begins.
//
// Parked attempts wait until an atom can take part, perhaps for ever. An attempt is patient, and may be parked, if
// nothing else could take what it holds when it was locked: no other interaction that is coordinated there, and no
// attempt that waits, is parked or was refused there. An attempt that comes later waits at the atom, and RECALL follows
// the patient one from home to home, which then begins or is refused. So whatever is parked when nothing moves any more
// keeps nothing from being possible.
//
// Fair: attempts are served at an atom in the order in which they come, before anything else takes it. Parked ones come
// after these; every other time they are drawn among what else the node may do.
//
// Nothing is forgotten: an attempt is refused if the interaction is not possible, at an atom or, if all are there, in
// this state of all of them. It can become possible only by a change of that atom, or of one of them, and each of their
// nodes then tells the coordinator (Wake), or is it. One that its coordinator recalled is tried again when an atom of
// that node is offered there again, for two times in a row, and is like any other one that was refused after that.
//
// The messages end when no step is possible. Without a change there is no attempt but after a RECALL of the
// coordinator, and each of these is for an attempt with an earlier coordinator, as LOCK only goes to later nodes: by
// induction over the coordinators each makes finitely many attempts without a step.
//
// The cost of an attempt is that of its atoms' ports in each core that it visits.
#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/distributed/node.hpp"

namespace bip::rt {

// So many times in a row an attempt is tried again when its own atoms are back, and parked and recalled. Then it waits
// for a change of what it was parked at, which may never come. Measured: more do not save messages.
static constexpr std::uint8_t kMostOwnRecalls = 2;

// -- Tables --

void Node::link_locks() {
  const u32 atoms = core_.image().atoms.size;
  where_.assign(atoms, Where::Away);
  is_in_core_.assign(atoms, 0);
  if (!has_split()) return;
  waiting_.resize(atoms);
  parked_.resize(atoms);
  resumes_later_.assign(atoms, 0);
  watchers_.resize(atoms);
  taken_by_.assign(atoms, kNone);
  lent_.resize(atoms);
  const u32 interactions = static_cast<u32>(core_.tables().interactions.size());
  blocked_.assign(interactions, Blocked::No);
  is_awake_.assign(interactions, 0);
  is_listed_.assign(interactions, 0);
  passed_to_.assign(interactions, kNone);
  is_recalled_.assign(interactions, 0);
  own_recalls_.assign(interactions, 0);
  std::vector<Csr::Pair> tries, wanted;
  for (u32 interaction = 0; interaction < interactions; ++interaction) {
    const Span<u32> locks = distribution_.locks[interaction];
    const auto is_elsewhere = [this](u32 atom) { return distribution_.home(atom) != self_; };
    if (distribution_.coordinator_of[interaction] != self_) continue;
    for (const u32 atom : distribution_.needs[interaction]) wanted.push_back({atom, interaction});
    if (std::none_of(locks.begin(), locks.end(), is_elsewhere)) continue;
    for (const u32 atom : distribution_.needs[interaction]) tries.push_back({atom, interaction});
  }
  tries_of_ = Csr::build(atoms, tries);
  wanted_by_ = Csr::build(atoms, wanted);
}

void Node::start_locks() {
  for (u32 atom = 0; has_split() && atom < where_.size(); ++atom) {
    if (where_[atom] == Where::Here) list_tries(atom);
  }
}

// Can the interaction take the atom, which is offered here, in its state? Of what only looks at it, always.
bool Node::fits(u32 interaction, u32 atom) {
  if (core_.partial().state()->own_group[interaction] != kNone) return true;
  const Tables& tables = core_.tables();
  ports_of_interaction(tables, tables.interactions[interaction], ports_);
  bool is_participant = false;
  for (const u32 port : ports_) {
    if (tables.port_atom[port] != atom) continue;
    if (core_.enabled_transition(atom, port - tables.port_base(atom)) != kNone) return true;
    is_participant = true;
  }
  return !is_participant;
}

// -- What to try --

void Node::list_try(u32 interaction) {
  BIP_ASSERT(distribution_.coordinator_of[interaction] == self_, "interaction {} is coordinated elsewhere",
             interaction);
  if (is_listed_[interaction] != 0 || blocked_[interaction] != Blocked::No) return;
  is_listed_[interaction] = 1;
  tries_.push_back(interaction);
}

void Node::list_tries(u32 atom) {
  for (const u32 interaction : tries_of_[atom]) list_try(interaction);
}

void Node::unblock(u32 interaction) {
  is_awake_[interaction] = 1;
  blocked_[interaction] = Blocked::No;
  list_try(interaction);
}

// The atom is offered here for the first time since it took part. Of atoms from elsewhere: it is what was waited for,
// and an attempt that had it has succeeded, which the last home of that may not have told yet.
void Node::note_change(u32 atom) {
  if (!has_split()) return;
  taken_by_[atom] = kNone;
  const bool is_home = distribution_.home(atom) == self_;
  for (const u32 interaction : tries_of_[atom]) {
    if (!is_home || blocked_[interaction] == Blocked::ByAll) unblock(interaction);
    else list_try(interaction);
  }
}

// An attempt begun here has moved what it took along; its homes do not tell what was refused here for those atoms.
void Node::note_success(u32 interaction) {
  own_recalls_[interaction] = 0;
  const auto attempt = attempted_.find(interaction);
  if (attempt == attempted_.end()) return;
  for (const u32 atom : attempt->second) {
    if (taken_by_[atom] == interaction) taken_by_[atom] = kNone;
    for (const u32 other : tries_of_[atom]) unblock(other);
  }
  attempted_.erase(attempt);
}

// All that is offered here for good must be here; the rest is locked.
bool Node::may_try(u32 interaction) {
  const Span<u32> locks = distribution_.locks[interaction];
  bool is_whole = true;
  for (const u32 atom : distribution_.needs[interaction]) {
    if (where_[atom] == Where::Here) {
      if (!fits(interaction, atom)) return false;
      continue;
    }
    if (distribution_.home(atom) == self_ || taken_by_[atom] != kNone ||
        std::find(locks.begin(), locks.end(), atom) == locks.end())
      return false;
    is_whole = false;
  }
  return !is_whole;
}

void Node::try_lock(std::size_t k) {
  if (k >= tries_.size()) {
    const u32 atom = resumed_[k - tries_.size()];
    resumed_.erase(resumed_.begin() + static_cast<std::ptrdiff_t>(k - tries_.size()));
    resume(atom);
    return serve();
  }
  const u32 interaction = tries_[k];
  tries_[k] = tries_.back();
  tries_.pop_back();
  BIP_ASSERT(is_listed_[interaction] != 0, "interaction {} is tried twice", interaction);
  is_listed_[interaction] = 0;
  if (blocked_[interaction] != Blocked::No || !may_try(interaction)) return;
  is_awake_[interaction] = 0;
  Lock lock{interaction, 0, {}, may_park_};
  std::vector<u32> from_elsewhere;
  for (const u32 atom : distribution_.needs[interaction]) {
    if (where_[atom] != Where::Here) continue;
    lend(atom, lock);
    if (distribution_.home(atom) == self_) continue;
    taken_by_[atom] = interaction;
    from_elsewhere.push_back(atom);
  }
  if (!from_elsewhere.empty()) attempted_[interaction] = std::move(from_elsewhere);
  lock.own = static_cast<u32>(lock.held.size());
  BIP_ASSERT(lock.own != 0, "an attempt of interaction {} with nothing", interaction);
  if (!core_.partial().settle()) stop();
  go_on(std::move(lock), kNone);
  serve();
}

// -- Attempts on their way --

// Could anything but the interaction take the atom, which is offered here, as it is?
bool Node::is_wanted(u32 atom, u32 interaction) {
  if (distribution_.home(atom) == self_) {
    if (!waiting_[atom].empty() || !parked_[atom].empty()) return true;
    if (std::any_of(watchers_[atom].begin(), watchers_[atom].end(),
                    [&](const Watcher& watcher) { return watcher.interaction != interaction; }))
      return true;
  }
  const Span<u32> others = wanted_by_[atom];
  return std::any_of(others.begin(), others.end(),
                     [&](u32 other) { return other != interaction && fits(other, atom); });
}

// The atom, which is offered here, goes with the attempt. Settle follows.
void Node::lend(u32 atom, Lock& lock) {
  lock.is_patient = lock.is_patient && !is_wanted(atom, lock.interaction);
  const Tables& tables = core_.tables();
  const LinkedType& type = tables.types[tables.atoms[atom].type];
  PartialSteps& partial = core_.partial();
  BIP_ASSERT(is_in_core_[atom] != 0, "atom {} is not here", atom);
  tell(NodeEvent::Kind::Locked, atom, lock.interaction);
  AtomOffer& offer = lent_[atom];
  const auto marks = core_.parts().memory.marks.begin() + tables.first_mark(atom);
  offer.place = partial.place_at_rest(atom);
  offer.marks.assign(marks, marks + type.mark_words);
  offer.transitions.clear();
  for (u32 port = 0; port < tables.port_base(atom + 1) - tables.port_base(atom); ++port) {
    const u32 row = core_.enabled_transition(atom, port);
    if (row != kNone) offer.transitions.push_back(type.first_transition + row);
  }
  offer.step = partial.state()->last_step[atom];
  offer.order = partial.state()->order[atom];
  Offer& held = lock.held.emplace_back(Offer{atom, n_[atom], offer, {}});
  for (const u32 cell : distribution_.cells[atom]) held.cells.push_back(core_.cell(cell).bits);
  partial.send_away(atom);
  is_in_core_[atom] = 0;
  if (distribution_.home(atom) == self_) {
    where_[atom] = Where::Locked;
    taken_by_[atom] = lock.interaction;
  } else {
    where_[atom] = Where::Away;
  }
}

// The atom is offered here again as it was. Its data are here.
void Node::take_back(u32 atom, const AtomOffer& offer) {
  if (is_in_core_[atom] != 0) return;
  is_in_core_[atom] = 1;
  if (!core_.partial().receive(atom, offer)) stop();
}

void Node::take(const Lock& lock) {
  if (!may_hold(lock) || is_waiting(lock.interaction)) {
    ++counts_.refused;
    return;
  }
  tell(NodeEvent::Kind::Arrived, kNone, lock.interaction);
  go_on(lock, kNone);
}

// An interaction is attempted once at a time.
bool Node::is_waiting(u32 interaction) const {
  const auto is_it = [interaction](const Lock& lock) { return lock.interaction == interaction; };
  const Span<u32> locks = distribution_.locks[interaction];
  return std::any_of(ready_.begin(), ready_.end(), is_it) || std::any_of(locks.begin(), locks.end(), [&](u32 atom) {
           return std::any_of(waiting_[atom].begin(), waiting_[atom].end(), is_it) ||
                  std::any_of(parked_[atom].begin(), parked_[atom].end(), is_it);
         });
}

// What an attempt has is not offered here; if it is at home here, it is offered to the coordinator, or locked here.
bool Node::may_hold(const Lock& lock) const {
  return std::all_of(lock.held.begin(), lock.held.end(), [&](const Offer& offer) {
    const u32 atom = offer.atom;
    if (is_in_core_[atom] != 0) return false;
    if (distribution_.home(atom) != self_) return true;
    return offer.n == n_[atom] &&
           (where_[atom] == Where::Away || (where_[atom] == Where::Locked && taken_by_[atom] == lock.interaction));
  });
}

// Forgets an attempt that says what cannot be; what it locked here is offered here again.
void Node::drop(const Lock& lock) {
  ++counts_.refused;
  for (const Offer& offer : lock.held) {
    const u32 atom = offer.atom;
    if (distribution_.home(atom) != self_ || where_[atom] != Where::Locked || taken_by_[atom] != lock.interaction)
      continue;
    take_back(atom, lent_[atom]);
    where_[atom] = Where::Here;
    served_.push_back(atom);
  }
}

// Locks what is at home here, and passes the attempt on. `served`: the atom that is given to it now, which waited for
// it first.
void Node::go_on(Lock lock, u32 served) {
  for (const u32 atom : distribution_.locks[lock.interaction]) {
    const u32 home = distribution_.home(atom);
    if (home < self_ ||
        std::any_of(lock.held.begin(), lock.held.end(), [&](const Offer& at) { return at.atom == atom; }))
      continue;
    if (home != self_) {
      passed_to_[lock.interaction] = home;
      // An impatient one comes to an end by itself.
      is_recalled_[lock.interaction] = lock.is_patient ? 0 : 1;
      outbox_.push_back({home, std::move(lock)});
      ++counts_.locks;
      return;
    }
    const bool is_at_rest = where_[atom] == Where::Here || where_[atom] == Where::Away;
    if (!is_at_rest || (atom != served && !waiting_[atom].empty())) {
      waiting_[atom].push_back(std::move(lock));
      if (where_[atom] == Where::Locked) {
        const u32 holder = taken_by_[atom];
        const bool is_own = distribution_.coordinator_of[holder] == self_ && own_recalls_[holder] < kMostOwnRecalls;
        (void)recall(holder, is_own);
      }
      return;
    }
    if (where_[atom] == Where::Away || !fits(lock.interaction, atom)) {
      if (lock.is_patient) {
        tell(NodeEvent::Kind::Parked, atom, lock.interaction);
        parked_[atom].push_back(std::move(lock));
        return;
      }
      tell(NodeEvent::Kind::Refused, atom, lock.interaction);
      if (!lock.is_recalled) watch(atom, lock.interaction);
      return refuse(lock, false, lock.is_recalled);
    }
    std::erase_if(watchers_[atom], [&](const Watcher& at) { return at.interaction == lock.interaction; });
    lend(atom, lock);
    if (!core_.partial().settle()) stop();
  }
  hold_all(std::move(lock));
}

// All that the interaction needs is offered here. Faults that show now are those of the step that was the last of all.
void Node::hold_all(Lock lock) {
  const Span<u32> needs = distribution_.needs[lock.interaction];
  const bool is_whole = std::all_of(needs.begin(), needs.end(), [&](u32 atom) {
    return std::any_of(lock.held.begin(), lock.held.end(), [&](const Offer& offer) { return offer.atom == atom; });
  });
  if (!is_whole || !may_hold(lock)) return drop(lock);
  PartialSteps& partial = core_.partial();
  std::vector<const Offer*> offers;
  for (const Offer& offer : lock.held) offers.push_back(&offer);
  std::stable_sort(offers.begin(), offers.end(),
                   [](const Offer* a, const Offer* b) { return a->offer.step < b->offer.step; });
  for (const Offer* offer : offers) {
    if (distribution_.home(offer->atom) != self_) {
      receive(*offer);
      continue;
    }
    take_back(offer->atom, offer->offer);
    where_[offer->atom] = Where::Locked;
  }
  BIP_ASSERT(std::all_of(needs.begin(), needs.end(), [this](u32 atom) { return is_in_core_[atom] != 0; }),
             "not all that interaction {} needs is here", lock.interaction);
  if (core_.enabled().weight(lock.interaction) != 0 && partial.is_decided(lock.interaction)) {
    ready_.push_back(std::move(lock));
    return;
  }
  refuse(lock, true);
}

// The attempt ends here, without a step.
void Node::refuse(const Lock& lock, bool is_watched, bool is_recalled) {
  std::vector<u32> atoms;
  for (const Offer& offer : lock.held) atoms.push_back(offer.atom);
  release(lock, atoms, {lock.interaction, true, is_watched, {}, is_recalled});
}

// Another attempt waits for what this one has locked. False: it has ended, or this was said before.
bool Node::recall(u32 interaction, bool is_own) {
  const auto is_it = [interaction](const Lock& lock) { return lock.interaction == interaction; };
  bool has_atoms = false;
  for (const u32 atom : distribution_.locks[interaction]) {
    if (distribution_.home(atom) != self_) continue;
    has_atoms = has_atoms || (where_[atom] == Where::Locked && taken_by_[atom] == interaction);
    if (const auto at = std::find_if(parked_[atom].begin(), parked_[atom].end(), is_it); at != parked_[atom].end()) {
      const Lock lock = std::move(*at);
      parked_[atom].erase(at);
      tell(is_own ? NodeEvent::Kind::Ended : NodeEvent::Kind::EndedWatched, kNone, interaction);
      if (!is_own) watch(atom, interaction);
      refuse(lock, false, is_own);
      return true;
    }
    if (const auto at = std::find_if(waiting_[atom].begin(), waiting_[atom].end(), is_it); at != waiting_[atom].end()) {
      tell(is_own ? NodeEvent::Kind::Hurried : NodeEvent::Kind::HurriedWatched, kNone, interaction);
      at->is_patient = false;
      at->is_recalled = at->is_recalled || is_own;
      return true;
    }
  }
  // One that is ready begins next, whatever is said.
  const bool is_ready = std::any_of(ready_.begin(), ready_.end(), is_it);
  if (!has_atoms || is_ready || passed_to_[interaction] == kNone || is_recalled_[interaction] != 0) return false;
  is_recalled_[interaction] = 1;
  own_recalls_[interaction] = static_cast<std::uint8_t>(own_recalls_[interaction] + (is_own ? 1 : 0));
  tell(NodeEvent::Kind::Recalled, kNone, interaction);
  outbox_.push_back({passed_to_[interaction], Recall{interaction, is_own}});
  ++counts_.recalls;
  return true;
}

void Node::take(const Recall& said) {
  if (recall(said.interaction, said.is_own)) return;
  const bool is_ready =
      std::any_of(ready_.begin(), ready_.end(), [&](const Lock& lock) { return lock.interaction == said.interaction; });
  tell(is_ready ? NodeEvent::Kind::Hurried : NodeEvent::Kind::Ignored, kNone, said.interaction);
}

// The atom may be able to take part in what is parked at it.
void Node::resume(u32 atom) {
  for (std::size_t k = parked_[atom].size(); k != 0 && where_[atom] == Where::Here && !parked_[atom].empty(); --k) {
    Lock lock = std::move(parked_[atom].front());
    parked_[atom].pop_front();
    if (!fits(lock.interaction, atom)) {
      parked_[atom].push_back(std::move(lock));
      continue;
    }
    resumes_later_[atom] = 1;
    tell(NodeEvent::Kind::Resumed, atom, lock.interaction);
    go_on(std::move(lock), atom);
  }
}

// A step with the first of those that are ready has begun: what did not take part goes back.
void Node::end_attempt() {
  BIP_ASSERT(!ready_.empty() && !begun_.empty(), "{} attempts are ready, {} parts have begun", ready_.size(),
             begun_.size());
  const Lock lock = std::move(ready_.front());
  ready_.pop_front();
  std::vector<u32> atoms;
  for (const Offer& offer : lock.held) {
    const Where rest = distribution_.home(offer.atom) == self_ ? Where::Locked : Where::Here;
    if (where_[offer.atom] == rest) atoms.push_back(offer.atom);
  }
  release(lock, atoms, {lock.interaction, false, false, {}});
}

// Gives back to each node what it gave, and says how the attempt ended.
void Node::release(const Lock& lock, const std::vector<u32>& atoms, Release how) {
  const u32 coordinator = distribution_.coordinator_of[lock.interaction];
  std::map<u32, Release> releases;  // by node
  // Its coordinator hears of the end, by the BEGIN of an atom at home there or by this.
  const bool has_begun = !how.is_refused && std::any_of(begun_.begin(), begun_.end(), [&](const Work& work) {
    return distribution_.home(work.atom) == coordinator;
  });
  if (!has_begun) releases[coordinator];
  bool is_unsettled = false;
  for (const u32 atom : atoms) {
    const auto own = lock.held.begin() + lock.own;
    const bool is_own = std::any_of(lock.held.begin(), own, [&](const Offer& offer) { return offer.atom == atom; });
    const u32 to = is_own ? coordinator : distribution_.home(atom);
    releases[to].atoms.push_back(atom);
    // Offered here only if all was.
    if (is_in_core_[atom] == 0 || (to == self_ && distribution_.home(atom) == self_)) continue;
    core_.partial().send_away(atom);
    is_in_core_[atom] = 0;
    where_[atom] = Where::Away;
    is_unsettled = true;
  }
  if (is_unsettled && !core_.partial().settle()) stop();
  for (auto& [to, release] : releases) {
    how.atoms = std::move(release.atoms);
    release = how;
    if (to == self_) {
      take_back(release);
      continue;
    }
    outbox_.push_back({to, std::move(release)});
    ++counts_.releases;
  }
}

// The atom went with an attempt of the interaction, from here.
bool Node::may_come_back(u32 atom, u32 interaction) const {
  if (is_in_core_[atom] != 0 || taken_by_[atom] != interaction) return false;
  if (distribution_.home(atom) == self_) return where_[atom] == Where::Locked;
  return distribution_.coordinator_of[interaction] == self_;
}

void Node::take(const Release& release) {
  const bool may_come = std::all_of(release.atoms.begin(), release.atoms.end(),
                                    [&](u32 atom) { return may_come_back(atom, release.interaction); });
  if (may_come) take_back(release);
  else ++counts_.refused;
}

void Node::take_back(const Release& release) {
  const u32 interaction = release.interaction;
  const bool is_coordinator = distribution_.coordinator_of[interaction] == self_;
  for (const u32 atom : release.atoms) {
    const bool is_home = distribution_.home(atom) == self_;
    tell(NodeEvent::Kind::Released, atom, interaction);
    take_back(atom, lent_[atom]);
    where_[atom] = Where::Here;
    taken_by_[atom] = kNone;
    if (!is_home) continue;
    if (release.is_watched) watch(atom, interaction);
    served_.push_back(atom);
  }
  if (!is_coordinator) return;
  if (!release.is_refused) {
    note_success(interaction);
  } else {
    attempted_.erase(interaction);
    if (is_awake_[interaction] == 0) {
      blocked_[interaction] = release.is_recalled  ? Blocked::ByRecall
                              : release.is_watched ? Blocked::ByAll
                                                   : Blocked::ByAtom;
    }
  }
  for (const u32 atom : release.atoms) {
    if (distribution_.home(atom) != self_) list_tries(atom);
  }
}

// -- Refused interactions --

void Node::watch(u32 atom, u32 interaction) {
  BIP_ASSERT(distribution_.home(atom) == self_, "atom {} is watched where it is not at home", atom);
  for (Watcher& watcher : watchers_[atom]) {
    if (watcher.interaction != interaction) continue;
    watcher.n = n_[atom];
    return;
  }
  watchers_[atom].push_back({interaction, n_[atom]});
}

// The atom is offered at home.
void Node::wake_watchers(u32 atom) {
  std::erase_if(watchers_[atom], [&](const Watcher& watcher) {
    if (watcher.n == n_[atom] || !fits(watcher.interaction, atom)) return false;
    const u32 coordinator = distribution_.coordinator_of[watcher.interaction];
    tell(NodeEvent::Kind::Woken, atom, watcher.interaction);
    if (coordinator == self_) {
      unblock(watcher.interaction);
    } else {
      outbox_.push_back({coordinator, Wake{watcher.interaction}});
      ++counts_.wakes;
    }
    return true;
  });
}

void Node::take(const Wake& wake) {
  tell(NodeEvent::Kind::Heard, kNone, wake.interaction);
  unblock(wake.interaction);
}

// Gives the atoms that came to rest, or came back, to those that wait for them; what is left is offered here.
void Node::serve() {
  while (!served_.empty()) {
    const u32 atom = served_.front();
    served_.pop_front();
    const auto is_at_rest = [&] { return where_[atom] == Where::Here || where_[atom] == Where::Away; };
    while (is_at_rest() && !waiting_[atom].empty()) {
      Lock lock = std::move(waiting_[atom].front());
      waiting_[atom].pop_front();
      go_on(std::move(lock), atom);
    }
    if (where_[atom] != Where::Here) continue;
    if (!parked_[atom].empty() && resumes_later_[atom] == 0) resume(atom);
    if (where_[atom] != Where::Here) continue;
    if (!parked_[atom].empty() && std::find(resumed_.begin(), resumed_.end(), atom) == resumed_.end()) {
      resumes_later_[atom] = 0;
      resumed_.push_back(atom);
    }
    wake_watchers(atom);
    for (const u32 interaction : tries_of_[atom]) {
      if (blocked_[interaction] == Blocked::ByRecall) blocked_[interaction] = Blocked::No;
    }
    list_tries(atom);
  }
}

}  // namespace bip::rt
