// The locks of split sets: see node.hpp, and split_sets.hpp for who coordinates and who locks what.
//
// Deadlock-free: an attempt waits only for an atom that is at work, which ends, that another attempt has locked, or at
// which it is parked, which the caller ends; and of the atoms at their homes it locks those of earlier nodes first, at
// a node those of smaller numbers. What its coordinator holds besides, no other attempt waits for. An attempt that has
// all begins. Fair: attempts are served at an atom in the order in which they come, before anything else takes it.
// Nothing is forgotten: an attempt is refused only if the interaction is not possible, at an atom or, if all are there,
// in this state of all of them. It can become possible only by a change of that atom, or of one of them, and each of
// their nodes then tells the coordinator (Wake), or is it. No change, no attempt: so the messages end when no step is
// possible.
// Cheap: a refusal costs LOCK, RELEASE and WAKE. An attempt that waits for about as long as these take before it is
// refused costs at most twice what it would cost if the future were known, in the time for which it has others wait
// (Karlin, Li, Manasse, Owicki, "Empirical studies of competitive spinning for a shared-memory multiprocessor", SOSP
// 1991, section 2); most go on before.
// The cost of an attempt is that of its atoms' ports in each core that it visits.
#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/distributed/node.hpp"

namespace bip::rt {

// -- Tables --

void Node::link_locks() {
  const u32 atoms = core_.image().atoms.size;
  where_.assign(atoms, Where::Away);
  is_in_core_.assign(atoms, 0);
  offered_for_.assign(atoms, kNone);
  if (!has_split()) return;
  waiting_.resize(atoms);
  parked_.resize(atoms);
  watchers_.resize(atoms);
  taken_by_.assign(atoms, {});
  lent_.resize(atoms);
  const u32 interactions = static_cast<u32>(core_.tables().interactions.size());
  blocked_.assign(interactions, Blocked::No);
  is_awake_.assign(interactions, 0);
  is_listed_.assign(interactions, 0);
  std::vector<InteractionsBy::Pair> tries;
  for (const InteractionId interaction : core_.tables().interactions.ids()) {
    const Span<u32> locks = distribution_.locks[interaction];
    const auto is_elsewhere = [this](u32 atom) { return distribution_.home(atom) != self_; };
    if (distribution_.coordinator_of[interaction] != self_ || std::none_of(locks.begin(), locks.end(), is_elsewhere))
      continue;
    for (const u32 atom : distribution_.needs[interaction]) tries.push_back({atom, interaction});
  }
  tries_of_ = InteractionsBy::build(atoms, tries);
}

void Node::start_locks() {
  for (u32 atom = 0; has_split() && atom < where_.size(); ++atom) {
    if (where_[atom] == Where::Here) list_tries(atom);
  }
}

// Can the interaction take the atom, which is offered here, in its state? Of what only looks at it, always.
bool Node::fits(InteractionId interaction, u32 atom) {
  if (core_.partial().state()->own_group[interaction] != kNone) return true;
  const Tables& tables = core_.tables();
  ports_of_interaction(tables, tables.interactions[interaction], ports_);
  bool is_participant = false;
  for (const u32 port : ports_) {
    if (tables.port_atom[port] != atom) continue;
    const u32 of_atom = port - tables.port_base(atom);
    if (core_.enabled_transition(atom, of_atom) != kNone) return is_offered_for(interaction, atom, of_atom);
    is_participant = true;
  }
  return !is_participant;
}

// Can the interaction take the atom through this enabled port, by what is known of its history? If it cannot, the atom
// is offered for another set, which must not wait for attempts of this one: they may end at a lost node.
bool Node::is_offered_for(InteractionId interaction, u32 atom, u32 port) const {
  const ConflictSets& sets = distribution_.sets;
  if (sets.by_situation[atom] == 0) return true;
  const u32 set = distribution_.home(atom) != self_
                      ? offered_for_[atom]
                      : sets.set_of(atom, core_.partial().place_at_rest(atom), history_[atom], port);
  return set == sets.of_interaction[interaction];
}

// -- What to try --

void Node::list_try(InteractionId interaction) {
  BIP_ASSERT(distribution_.coordinator_of[interaction] == self_, "interaction {} is coordinated elsewhere",
             interaction);
  if (is_listed_[interaction] != 0 || blocked_[interaction] != Blocked::No) return;
  is_listed_[interaction] = 1;
  tries_.push_back(interaction);
}

void Node::list_tries(u32 atom) {
  for (const InteractionId interaction : tries_of_[atom]) list_try(interaction);
}

void Node::unblock(InteractionId interaction) {
  is_awake_[interaction] = 1;
  blocked_[interaction] = Blocked::No;
  list_try(interaction);
}

// The atom is offered here for the first time since it took part. Of atoms from elsewhere: it is what was waited for,
// and an attempt that had it has succeeded, which the last home of that may not have told yet.
void Node::note_change(u32 atom) {
  if (!has_split()) return;
  taken_by_[atom] = {};
  const bool is_home = distribution_.home(atom) == self_;
  for (const InteractionId interaction : tries_of_[atom]) {
    if (!is_home || blocked_[interaction] == Blocked::ByAll) unblock(interaction);
    else list_try(interaction);
  }
}

// An attempt begun here has moved what it took along; its homes do not tell what was refused here for those atoms.
void Node::note_success(InteractionId interaction) {
  const auto attempt = attempted_.find(interaction);
  if (attempt == attempted_.end()) return;
  for (const u32 atom : attempt->second) {
    if (taken_by_[atom] == interaction) taken_by_[atom] = {};
    for (const InteractionId other : tries_of_[atom]) unblock(other);
  }
  attempted_.erase(attempt);
}

// All that is offered here for good must be here; the rest is locked.
bool Node::may_try(InteractionId interaction) {
  const Span<u32> locks = distribution_.locks[interaction];
  bool is_whole = true;
  for (const u32 atom : distribution_.needs[interaction]) {
    if (where_[atom] == Where::Here) {
      if (!fits(interaction, atom)) return false;
      continue;
    }
    if (distribution_.home(atom) == self_ || taken_by_[atom].is_valid() ||
        std::find(locks.begin(), locks.end(), atom) == locks.end())
      return false;
    is_whole = false;
  }
  return !is_whole;
}

void Node::try_lock(std::size_t k) {
  const InteractionId interaction = tries_[k];
  tries_[k] = tries_.back();
  tries_.pop_back();
  BIP_ASSERT(is_listed_[interaction] != 0, "interaction {} is tried twice", interaction);
  is_listed_[interaction] = 0;
  if (blocked_[interaction] != Blocked::No || !may_try(interaction)) return;
  is_awake_[interaction] = 0;
  Lock lock{interaction, 0, {}};
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

// The atom, which is offered here, goes with the attempt. Settle follows.
void Node::lend(u32 atom, Lock& lock) {
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
  const u32 set =
      distribution_.sets.by_situation[atom] != 0 ? distribution_.sets.of_interaction[lock.interaction] : kNone;
  Offer& held = lock.held.emplace_back(Offer{atom, participations_[atom], offer, {}, {}, set});
  for (const VariableId cell : distribution_.cells[atom]) held.cells.push_back(core_.cell(cell).bits);
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
bool Node::is_waiting(InteractionId interaction) const {
  const auto is_it = [interaction](const Lock& lock) { return lock.interaction == interaction; };
  const Span<u32> locks = distribution_.locks[interaction];
  return std::any_of(ready_.begin(), ready_.end(), is_it) || std::any_of(locks.begin(), locks.end(), [&](u32 atom) {
           return std::any_of(waiting_[atom].begin(), waiting_[atom].end(), is_it) ||
                  std::any_of(parked_[atom].begin(), parked_[atom].end(),
                              [&](const ParkedLock& at) { return is_it(at.lock); });
         });
}

// What an attempt has is not offered here; if it is at home here, it is offered to the coordinator, or locked here.
bool Node::may_hold(const Lock& lock) const {
  return std::all_of(lock.held.begin(), lock.held.end(), [&](const Offer& offer) {
    const u32 atom = offer.atom;
    if (is_in_core_[atom] != 0) return false;
    if (distribution_.home(atom) != self_) return true;
    return offer.n == participations_[atom] &&
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
      outbox_.push_back({home, std::move(lock)});
      ++counts_.locks;
      return;
    }
    const bool is_at_rest = where_[atom] == Where::Here || where_[atom] == Where::Away;
    if (!is_at_rest || (atom != served && !waiting_[atom].empty())) {
      waiting_[atom].push_back(std::move(lock));
      return;
    }
    if (where_[atom] == Where::Away || !fits(lock.interaction, atom)) {
      // At its coordinator a refusal costs no message: what it has is offered here.
      if (distribution_.coordinator_of[lock.interaction] != self_) return park(atom, std::move(lock));
      tell(NodeEvent::Kind::Refused, atom, lock.interaction);
      watch(atom, lock.interaction, participations_[atom]);
      return refuse(lock, false);
    }
    std::erase_if(watchers_[atom], [&](const Watcher& at) { return at.interaction == lock.interaction; });
    lend(atom, lock);
    if (!core_.partial().settle()) stop();
  }
  hold_all(std::move(lock));
}

// The atom, at home here and at rest, cannot take part.
void Node::park(u32 atom, Lock lock) {
  tell(NodeEvent::Kind::Parked, atom, lock.interaction);
  const u64 number = ++parkings_;
  new_parkings_.push_back({number, lock.interaction});
  parked_at_[number] = atom;
  parked_[atom].push_back({number, std::move(lock)});
}

Lock Node::take_parked(u32 atom, std::size_t k) {
  const auto at = parked_[atom].begin() + static_cast<std::ptrdiff_t>(k);
  Lock lock = std::move(at->lock);
  parked_at_.erase(at->number);
  parked_[atom].erase(at);
  return lock;
}

// Gives the atom, which is at rest, to the first of those parked at it in which it can take part.
void Node::serve_parked(u32 atom) {
  for (std::size_t k = 0; where_[atom] == Where::Here && k < parked_[atom].size();) {
    if (fits(parked_[atom][k].lock.interaction, atom)) go_on(take_parked(atom, k), atom);
    else ++k;
  }
}

void Node::end_parking(u64 number) {
  const auto at = parked_at_.find(number);
  if (at == parked_at_.end()) return;
  const u32 atom = at->second;
  const auto parked_lock = std::find_if(parked_[atom].begin(), parked_[atom].end(),
                                        [number](const ParkedLock& parked) { return parked.number == number; });
  BIP_ASSERT(parked_lock != parked_[atom].end(), "no attempt {} is parked at atom {}", number, atom);
  const Lock lock = take_parked(atom, static_cast<std::size_t>(parked_lock - parked_[atom].begin()));
  tell(NodeEvent::Kind::GivenUp, atom, lock.interaction);
  // It was not asked in this state if the atom is at work, where it is counted as taking part for the next time
  // already, or locked by another attempt, which may give it back as it is.
  const bool was_asked = where_[atom] == Where::Here || where_[atom] == Where::Away;
  watch(atom, lock.interaction, was_asked ? participations_[atom] : participations_[atom] - 1);
  refuse(lock, false);
  serve();
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
void Node::refuse(const Lock& lock, bool is_watched) {
  std::vector<u32> atoms;
  for (const Offer& offer : lock.held) atoms.push_back(offer.atom);
  release(lock, atoms, true, is_watched);
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
  release(lock, atoms, false, false);
}

// Gives back to each node what it gave.
void Node::release(const Lock& lock, const std::vector<u32>& atoms, bool is_refused, bool is_watched) {
  const u32 coordinator = distribution_.coordinator_of[lock.interaction];
  std::map<u32, Release> releases;  // by node
  // Its coordinator hears of the end, by the BEGIN of an atom at home there or by this.
  const bool has_begun = !is_refused && std::any_of(begun_.begin(), begun_.end(), [&](const Work& work) {
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
    release.interaction = lock.interaction;
    release.is_refused = is_refused;
    release.is_watched = is_watched;
    if (to == self_) {
      take_back(release);
      continue;
    }
    outbox_.push_back({to, std::move(release)});
    ++counts_.releases;
  }
}

// The atom went with an attempt of the interaction, from here.
bool Node::may_come_back(u32 atom, InteractionId interaction) const {
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
  const InteractionId interaction = release.interaction;
  const bool is_coordinator = distribution_.coordinator_of[interaction] == self_;
  for (const u32 atom : release.atoms) {
    const bool is_home = distribution_.home(atom) == self_;
    tell(NodeEvent::Kind::Released, atom, interaction);
    take_back(atom, lent_[atom]);
    where_[atom] = Where::Here;
    taken_by_[atom] = {};
    if (!is_home) continue;
    if (release.is_watched) watch(atom, interaction, participations_[atom]);
    served_.push_back(atom);
  }
  if (!is_coordinator) return;
  if (!release.is_refused) {
    note_success(interaction);
  } else {
    attempted_.erase(interaction);
    if (is_awake_[interaction] == 0) blocked_[interaction] = release.is_watched ? Blocked::ByAll : Blocked::ByAtom;
  }
  for (const u32 atom : release.atoms) {
    if (distribution_.home(atom) != self_) list_tries(atom);
  }
}

// -- Refused interactions --

// WAKE when the atom can take part, and has changed since it took part for the n-th time.
void Node::watch(u32 atom, InteractionId interaction, u64 n) {
  BIP_ASSERT(distribution_.home(atom) == self_, "atom {} is watched where it is not at home", atom);
  for (Watcher& watcher : watchers_[atom]) {
    if (watcher.interaction != interaction) continue;
    watcher.n = n;
    return;
  }
  watchers_[atom].push_back({interaction, n});
}

// The atom is offered at home.
void Node::wake_watchers(u32 atom) {
  std::erase_if(watchers_[atom], [&](const Watcher& watcher) {
    if (watcher.n == participations_[atom] || !fits(watcher.interaction, atom)) return false;
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
    serve_parked(atom);
    const auto is_at_rest = [&] { return where_[atom] == Where::Here || where_[atom] == Where::Away; };
    while (is_at_rest() && !waiting_[atom].empty()) {
      Lock lock = std::move(waiting_[atom].front());
      waiting_[atom].pop_front();
      go_on(std::move(lock), atom);
    }
    if (where_[atom] != Where::Here) continue;
    wake_watchers(atom);
    list_tries(atom);
  }
}

}  // namespace bip::rt
