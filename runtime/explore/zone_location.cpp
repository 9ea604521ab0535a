// See zone_location.hpp.
#include "runtime/explore/zone_location.hpp"

#include <algorithm>
#include <numeric>

#include "bip/assert.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/explore/heap_bytes.hpp"

namespace bip::rt {

namespace {

void append_row(std::string& key, const void* data, std::size_t bytes) {
  key.append(static_cast<const char*>(data), bytes);
}

template <class T>
void append_all(std::string& key, const std::vector<T>& values) {
  append_row(key, values.data(), values.size() * sizeof(T));
}

void sort_unique(Bounds& bounds) {
  std::sort(bounds.begin(), bounds.end());
  bounds.erase(std::unique(bounds.begin(), bounds.end()), bounds.end());
}

// A row of the hash table: its node with key, number and hash, and its bucket.
constexpr std::size_t kHashRowBytes = allocated(sizeof(std::string) + 3 * sizeof(void*)) + sizeof(void*);

// A bound that is open lies a tick beside the constant of the source.
i64 without_tick(i64 constant) {
  const i64 last = constant % 10;
  return last == 9 ? constant + 1 : last == 1 ? constant - 1 : constant;
}

}  // namespace

std::size_t Location::bytes() const {
  std::size_t sum = sizeof(Location) + heap_bytes(state.places) + heap_bytes(state.marks) +
                    heap_bytes(state.data.rows()) + heap_bytes(state.objects) + heap_bytes(state.time) +
                    heap_bytes(waits) + heap_bytes(leaders) + heap_bytes(invariants) + heap_bytes(interactions) +
                    heap_bytes(groups) + heap_bytes(cells) + heap_bytes(asked);
  for (const InteractionCondition& interaction : interactions) sum += heap_bytes(interaction.bounds);
  for (const WaitGroup& group : groups) sum += heap_bytes(group.bounds);
  return sum;
}

// Constants that can be known are noted at once, in the initial state: most limits are constants or parameters.
Locations::Locations(Core& core, const ExploreOptions& options, const TimedResponse* response)
    : core_(core),
      shapes_(shapes_of(core, options.progress)),
      asked_atoms_(options.predicate_atoms),
      unread_cells_(options.unread_cells) {
  for (const u32 connector : options.predicate_connectors)
    asked_interactions_.push_back(core.tables().interaction_of(connector));
  const Image& image = core.image();
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const AtomType& type = image.atom_types[image.atoms[atom].type];
    is_timed_.push_back(type.time != nullptr);
    if (type.time != nullptr) clocks_ += type.time->clocks.size;
  }
  if (response != nullptr) {
    in_time_ = {++clocks_, 0, response->within.value_or(1)};
    is_limited_ = response->within.has_value();
  }
  max_.assign(clocks_ + 1, 0);
  min_.assign(clocks_ + 1, 0);
  transitions_.resize(image.atoms.size);
  is_ruled_.assign(shapes_.interactions.size(), false);
  const PriorityTables rules = link_priorities(core.tables());
  for (const InteractionId interaction : rules.is_involved.ids()) {
    const bool is_connector = core.tables().is_of_connector(interaction);
    const u32 plan = is_connector ? core.tables().interactions[interaction].plan() : kNone;
    const bool has_witnesses = plan != kNone && !core.tables().plans[plan].witnesses.empty();
    if (rules.is_involved[interaction] == 0 && !has_witnesses) continue;
    is_ruled_[interaction] = true;
    for (const u32 atom : shapes_.atoms_of(interaction)) ruled_atoms_.push_back(atom);
  }
  std::sort(ruled_atoms_.begin(), ruled_atoms_.end());
  ruled_atoms_.erase(std::unique(ruled_atoms_.begin(), ruled_atoms_.end()), ruled_atoms_.end());
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const AtomType& type = image.atom_types[image.atoms[atom].type];
    if (!is_timed_[atom]) continue;
    MeasuredGuard guard;
    Bounds bounds;
    for (const TransitionTime& transition : type.time->transitions) {
      if (core.clock_constraints().measure(atom, transition.when, guard)) append(atom, guard, bounds);
      if (core.clock_constraints().measure(atom, transition.resume.when, guard)) append(atom, guard, bounds);
    }
    for (const TimeGuard& invariant : type.time->invariants) {
      if (core.clock_constraints().measure(atom, invariant, guard)) append(atom, guard, bounds);
    }
  }
  if (response != nullptr && !is_limited_) in_time_.limit = std::max<i64>(divisor_, 1);
  if (response != nullptr) note(in_time_);
  has_grown_ = false;
}

void Locations::clear() {
  rows_.clear();
  index_.clear();
  bytes_ = 0;
}

u32 Locations::find_or_add(State&& state, const std::vector<u32>& waits, const std::vector<u32>& leaders,
                           const Observed& observed) {
  BIP_ASSERT(waits.size() == is_timed_.size() && leaders.size() == is_timed_.size(), "{} waits", waits.size());
  BIP_ASSERT(index_.size() == rows_.size(), "{} keys of {} locations", index_.size(), rows_.size());
  for (const VariableId cell : unread_cells_) state.data[cell] = 0;
  std::string key;
  append_all(key, state.places);
  append_all(key, state.marks);
  append_all(key, state.data.rows());
  append_all(key, waits);
  append_all(key, leaders);
  if (observed.is_pending) key += '\1';
  for (u64 past = observed.past; past != 0; past >>= 8u) key += static_cast<char>(past & 0xffu);
  const std::size_t key_bytes = kHashRowBytes + allocated(key.capacity());
  const auto [at, is_new] = index_.try_emplace(std::move(key), static_cast<u32>(rows_.size()));
  if (!is_new) return at->second;
  Location row;
  row.state = std::move(state);
  row.waits = waits;
  row.leaders = leaders;
  row.observed = observed;
  bytes_ += key_bytes + row.bytes();
  rows_.push_back(std::move(row));
  return at->second;
}

// Doubled, so that a limit that grows step by step is met in few rounds.
void Locations::note(const ZoneBound& bound) {
  if (bound.i != 0 && bound.j != 0) {
    has_differences_ = true;
    return;
  }
  const u32 clock = std::max(bound.i, bound.j);
  const i64 constant = bound.i == 0 ? -bound.limit : bound.limit;
  if (constant > 0) divisor_ = std::gcd(divisor_, without_tick(constant));
  if (constant <= max_[clock]) return;
  max_[clock] = std::max(constant, std::min(2 * max_[clock], kFarLimit));
  has_grown_ = true;
}

void Locations::note_set(u32 clock, i64 value) {
  BIP_ASSERT(clock != 0 && clock <= clocks_, "clock {} of {}", clock, clocks_);
  if (value >= min_[clock]) return;
  min_[clock] = std::min(value, std::max(2 * min_[clock], -kFarLimit));
  has_grown_ = true;
}

void Locations::append(u32 atom, const MeasuredGuard& guard, Bounds& out) {
  const u32 first = core_.time().first_clock(atom) + 1;
  for (const ClockBound& bound : guard.bounds) {
    const u32 i = first + bound.clock;
    const u32 j = bound.minus == kNone ? 0 : first + bound.minus;
    for (const ZoneBound& side : {ZoneBound{i, j, bound.high}, ZoneBound{j, i, -bound.low}}) {
      if (side.limit == kNoBound) continue;
      out.push_back(side);
      note(side);
    }
  }
}

bool Locations::measure_interaction(Location& at, InteractionId interaction) {
  const Image& image = core_.image();
  const InteractionShape& shape = shapes_.interactions[interaction];
  InteractionCondition condition{interaction, shape.is_rendezvous && !is_ruled_[interaction], {}};
  bool is_urgent = false;
  const auto is_offered = [&](const InteractionLeaf& leaf) {
    if (!is_timed_[leaf.atom]) return core_.enabled_transition(leaf.atom, leaf.port) != kNone;
    return std::any_of(transitions_[leaf.atom].begin(), transitions_[leaf.atom].end(),
                       [&](const TimedTransition& t) { return t.port == leaf.port; });
  };
  const Span<InteractionLeaf> leaves = shapes_.leaves_of(interaction);
  const auto offered = std::count_if(leaves.begin(), leaves.end(), is_offered);
  if (offered == 0 || (shape.is_rendezvous && offered != static_cast<std::ptrdiff_t>(leaves.size))) return false;
  for (const InteractionLeaf& leaf : leaves) {
    if (!is_timed_[leaf.atom]) continue;
    std::size_t count = 0;
    for (const TimedTransition& transition : transitions_[leaf.atom]) {
      if (transition.port != leaf.port) continue;
      ++count;
      is_urgent = is_urgent || transition.urgency != Urgency::Lazy;
      append(leaf.atom, transition.when, condition.bounds);
    }
    // Two transitions of a port are alternatives; a port with a rule may be hidden by others.
    const bool has_rules = image.atom_types[image.atoms[leaf.atom].type].priorities.size != 0;
    if (count > 1 || has_rules) condition.is_conjunction = false;
    if (!has_rules) continue;
    for (const TimedTransition& transition : transitions_[leaf.atom])
      append(leaf.atom, transition.when, condition.bounds);
  }
  if (is_ruled_[interaction]) {
    for (const u32 atom : ruled_atoms_) {
      for (const TimedTransition& transition : transitions_[atom]) append(atom, transition.when, condition.bounds);
    }
  }
  sort_unique(condition.bounds);
  if (is_urgent || is_cut_by_all_) at.cells.insert(at.cells.end(), condition.bounds.begin(), condition.bounds.end());
  at.has_urgent = at.has_urgent || is_urgent;
  at.interactions.push_back(std::move(condition));
  return true;
}

// Candidates of an interaction depend on its condition; a port on its atom's transitions, for those of one port are
// alternatives and rules of the atom hide ports.
void Locations::measure_asked(Location& at) {
  for (const InteractionCondition& interaction : at.interactions) {
    if (std::find(asked_interactions_.begin(), asked_interactions_.end(), interaction.interaction) !=
        asked_interactions_.end())
      at.asked.insert(at.asked.end(), interaction.bounds.begin(), interaction.bounds.end());
  }
  for (const u32 atom : asked_atoms_) {
    for (const TimedTransition& transition : transitions_[atom]) append(atom, transition.when, at.asked);
  }
  sort_unique(at.asked);
}

// clocks: some that belong to it. Untimed ports, data and limits are the same at all of them.
bool Locations::measure(Location& at, const std::vector<i64>& clocks) {
  BIP_ASSERT(clocks.size() == clocks_ + 1, "{} clock values", clocks.size());
  if (at.is_measured) return true;
  bytes_ -= at.bytes();
  const bool is_good = measure_bounds(at, clocks);
  bytes_ += at.bytes();
  return is_good;
}

bool Locations::measure_bounds(Location& at, const std::vector<i64>& clocks) {
  // Whether a connector's guard faults may depend on the clocks: that is asked in each cell.
  if (!core_.restore_atoms(point(at, clocks))) return false;
  at.is_final = is_final_state(core_);
  std::vector<MeasuredGuard> guards;
  for (u32 atom = 0; atom < is_timed_.size(); ++atom) {
    transitions_[atom].clear();
    if (!is_timed_[atom]) continue;
    if (!core_.clock_constraints().timed_invariants(atom, guards)) return false;
    for (const MeasuredGuard& guard : guards) {
      at.may_go_on = at.may_go_on && guard.can_hold;
      append(atom, guard, at.invariants);
    }
    if (at.waits[atom] == kNone) {
      if (!core_.clock_constraints().timed_transitions(atom, transitions_[atom])) return false;
      continue;
    }
    auto group = std::find_if(at.groups.begin(), at.groups.end(),
                              [&](const WaitGroup& other) { return other.leader == at.leaders[atom]; });
    if (group == at.groups.end()) group = at.groups.insert(group, {at.leaders[atom], true, {}});
    MeasuredGuard guard;
    if (!core_.clock_constraints().measured_resume(atom, at.waits[atom] == kAfterInitial ? kNone : at.waits[atom],
                                                   guard))
      return false;
    group->ends = group->ends && guard.can_hold;
    append(atom, guard, group->bounds);
  }
  sort_unique(at.invariants);
  for (const WaitGroup& group : at.groups) {
    if (group.ends) at.cells.insert(at.cells.end(), group.bounds.begin(), group.bounds.end());
  }
  if (at.observed.is_pending && is_limited_) at.cells.push_back(in_time_);
  for (const InteractionId interaction : shapes_.interactions.ids()) (void)measure_interaction(at, interaction);
  sort_unique(at.cells);
  measure_asked(at);
  at.is_measured = true;
  return true;
}

State Locations::point(const Location& at, const std::vector<i64>& clocks) const {
  BIP_ASSERT(clocks.size() == clocks_ + 1, "{} clock values", clocks.size());
  State state = at.state;
  state.time.assign(1, 0);
  u32 clock = 1;
  for (u32 atom = 0; atom < is_timed_.size(); ++atom) {
    const AtomType& type = core_.image().atom_types[core_.image().atoms[atom].type];
    for (u32 k = 0; type.time != nullptr && k < type.time->clocks.size; ++k, ++clock) {
      state.time.push_back(clocks[clock]);
      state.time.push_back(kUnitSpeed);
    }
    state.time.push_back(at.waits[atom] == kNone ? 0 : kForever);
  }
  return state;
}

Bounds Locations::bounds_of(u32 atom) {
  Bounds bounds;
  std::vector<TimedTransition> transitions;
  if (!is_timed_[atom] || !core_.clock_constraints().timed_transitions(atom, transitions)) return bounds;
  for (const TimedTransition& transition : transitions) append(atom, transition.when, bounds);
  sort_unique(bounds);
  return bounds;
}

Bounds Locations::all_bounds(const Location& at) const {
  Bounds all = at.cells;
  all.insert(all.end(), at.asked.begin(), at.asked.end());
  all.insert(all.end(), at.invariants.begin(), at.invariants.end());
  for (const InteractionCondition& interaction : at.interactions)
    all.insert(all.end(), interaction.bounds.begin(), interaction.bounds.end());
  sort_unique(all);
  return all;
}

}  // namespace bip::rt
