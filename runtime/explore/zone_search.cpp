// See zone_search.hpp.
#include "runtime/explore/zone_search.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/text.hpp"
#include "runtime/explore/heap_bytes.hpp"
#include "runtime/explore/zone_moves.hpp"

namespace bip::rt {

std::vector<Zone> cut(const Zone& zone, const Bounds& bounds) {
  std::vector<Zone> cells{zone};
  for (const ZoneBound& bound : bounds) {
    const std::size_t count = cells.size();
    for (std::size_t k = 0; k < count; ++k) {
      if (!cells[k].is_cut_by(bound)) continue;
      Zone beyond = cells[k];
      if (!beyond.meet(bound.opposite()) || !cells[k].meet(bound)) continue;
      cells.push_back(std::move(beyond));
    }
  }
  for ([[maybe_unused]] const Zone& cell : cells) {
    BIP_ASSERT(zone.includes(cell), "a cell outside of its zone");
    BIP_ASSERT(std::none_of(bounds.begin(), bounds.end(), [&](const ZoneBound& b) { return cell.is_cut_by(b); }),
               "a cell in which a bound changes its truth");
  }
  return cells;
}

bool agree(Zone& zone, const Zone& part, const Bounds& bounds) {
  return std::all_of(bounds.begin(), bounds.end(),
                     [&](const ZoneBound& bound) { return zone.meet(part.implies(bound) ? bound : bound.opposite()); });
}

ZoneSearch::ZoneSearch(const Image& image, const ExploreOptions& options, const PartQuestion* part,
                       const TimedResponse* response, const TimedMonitor* monitor)
    : image_(image),
      options_(options),
      core_(image, {.progress = options.progress}),
      locations_((static_cast<void>(core_.initialize()), core_), options, response),
      part_(part),
      response_(response),
      monitor_(monitor) {
  core_.time().wait_for_resume_at();
  if (part_ == nullptr) return;
  is_sure_.assign(locations_.shapes().interactions.size(), 1);
  for (u32 connector = 0; connector < image.connectors.size; ++connector) {
    const InteractionId interaction = core_.tables().interaction_of(connector);
    if (interaction.is_valid()) is_sure_[interaction] = part_->is_whole[connector];
  }
}

// What a step (or `initial`) did to the clocks. False: they do what cannot be followed.
bool ZoneSearch::follow_clocks(Zone& zone) {
  u32 row = 0;
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
    const AtomTime* time = image_.atom_types[image_.atoms[atom].type].time;
    for (u32 k = 0; time != nullptr && k < time->clocks.size; ++k, ++row) {
      const ClockState& clock = core_.time().clock_state(row);
      const bool is_far = std::max(clock.value, -clock.value) > kFarLimit;
      if (clock.speed == kUnitSpeed && !is_far) continue;
      const SourceLine& loc = time->clocks[k].loc;
      report_.inexact = "clock `" + std::string(time->clocks[k].name) + "` of `" + image_.atoms[atom].path() + "` (" +
                        image_.files[loc.file] + ":" + std::to_string(loc.line) + ") " +
                        (is_far ? "is set to a value beyond 18 years" : "runs at another speed than 1");
      return false;
    }
  }
  for (const u32 set : core_.time().set_clocks()) {
    const i64 value = core_.time().clock_state(set).value;
    locations_.note_set(set + 1, value);
    zone.set_clock(set + 1, value);
  }
  return true;
}

bool ZoneSearch::begin() {
  nodes_.clear();
  arcs_.clear();
  moves_.clear();
  locations_.clear();
  next_ = 0;
  next_look_ = kFirstLook;
  node_bytes_ = 0;
  deadlock_ = time_lock_ = error_ = match_ = {};
  open_ = kNone;
  impossible_ = 0;
  report_ = {};
  if (report_.inexact = what_zones_cannot_follow(image_); !report_.inexact.empty()) return false;
  if (!core_.initialize()) {
    report_.errors = 1;
    report_.has_error = true;
    return false;
  }
  Zone zone(locations_.clocks());
  if (!follow_clocks(zone)) return false;
  std::vector<u32> waits, leaders;
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
    const AtomTime* time = image_.atom_types[image_.atoms[atom].type].time;
    const bool waits_now = time != nullptr && time->initial.present;
    waits.push_back(waits_now ? kAfterInitial : kNone);
    leaders.push_back(waits_now ? atom : 0);
  }
  bool is_pending = false, is_requested = false;
  if (response_ != nullptr) {
    observe(nullptr, is_pending, is_requested);
    if (!is_pending) zone.forget_clock(locations_.in_time().i);
  }
  const u64 past = monitor_ != nullptr ? monitor_->next(core_, nullptr, 0) : 0;
  enter(locations_.find_or_add(core_.snapshot(), waits, leaders, {is_pending, past}), std::move(zone),
        {.is_requested = is_requested, .origin = {}, .zone = Zone(0)});
  return true;
}

bool ZoneSearch::is_inside(const Location& at, const Zone& zone) const {
  return at.may_go_on && std::all_of(at.invariants.begin(), at.invariants.end(),
                                     [&](const ZoneBound& bound) { return zone.implies(bound); });
}

// A group whose bounds hold in the cell.
bool ZoneSearch::wakes(const WaitGroup& group, const Zone& zone) {
  return group.ends && std::all_of(group.bounds.begin(), group.bounds.end(),
                                   [&](const ZoneBound& bound) { return zone.implies(bound); });
}

bool ZoneSearch::wakes(const Location& at, const Zone& zone) const {
  return std::any_of(at.groups.begin(), at.groups.end(), [&](const WaitGroup& group) { return wakes(group, zone); });
}

// Without the points at which a busy atom goes on because no later instant lets it.
std::vector<Zone> ZoneSearch::without_last(u32 node, std::vector<Zone> zones) {
  for (const WaitGroup& group : locations_[nodes_[node].location].groups) {
    if (!wakes(group, nodes_[node].zone)) continue;
    for (const ZoneBound& bound : group.bounds) {
      Zone last = nodes_[node].zone;
      if (bound.j != 0 || !last.meet({0, bound.i, -bound.limit})) continue;
      std::vector<Zone> left;
      for (const Zone& zone : zones) subtract(zone, last, left);
      zones = std::move(left);
    }
  }
  return zones;
}

bool ZoneSearch::is_eager(const Location& at, const std::vector<i64>& point) {
  if (!at.has_urgent || !enter_core(at, point)) return false;
  for (u64 k = 0; k < core_.candidate_count(); ++k) {
    if (core_.time().time_of(core_.candidate(k)).urgency == Urgency::Eager) return true;
  }
  return false;
}

// Does a run end in an error at these clock values? Known only once a guard has faulted.
bool ZoneSearch::is_faulty(const Location& at, const std::vector<i64>& point) {
  return locations_.is_cut_by_all() && !enter_core(at, point);
}

// Zones with these points become nodes: cut into cells, each with the time that may pass in it.
void ZoneSearch::enter(u32 row, Zone&& zone, ZoneNode&& label) {
  label.location = row;
  {
    Location& at = locations_[row];
    if (!locations_.measure(at, zone.least_point())) {
      // The fault shows wherever the step led.
      if (label.parent == kNone) {
        ++report_.errors, report_.has_error = true;
      } else if (label.edge == ZoneEdge::GoOn) {
        // Only after that move: a node of its own, from which nothing goes on.
        label.is_covered = label.is_faulty = true;
        label.zone = std::move(zone);
        const std::vector<i64> point = label.zone.least_point();
        nodes_.push_back(std::move(label));
        note_error(static_cast<u32>(nodes_.size() - 1), point, ErrorIn::State, {}, 0);
      } else {
        note_error(label.parent, label.origin, label.edge == ZoneEdge::Step ? ErrorIn::Step : ErrorIn::State,
                   label.interaction, label.config);
      }
      return;
    }
  }
  if (part_ != nullptr && is_impossible(row)) return;
  Bounds bounds = locations_[row].cells;
  bounds.insert(bounds.end(), locations_[row].invariants.begin(), locations_[row].invariants.end());
  for (Zone& cell : cut(zone, bounds)) {
    const Location& at = locations_[row];
    ZoneNode node = label;
    const bool is_inside_now = is_inside(at, cell);
    node.is_waking = wakes(at, cell);
    node.is_faulty = is_faulty(at, cell.least_point());
    node.is_still = !is_inside_now || node.is_faulty || is_eager(at, cell.least_point());
    if (!node.is_still) {
      const Zone part = cell;
      cell.let_time_pass();
      [[maybe_unused]] const bool has_points = agree(cell, part, bounds);
      BIP_ASSERT(has_points && cell.includes(part), "a cell loses points while time passes");
    }
    if (!locations_.has_differences()) cell.extrapolate(locations_.max(), locations_.min());
    node.zone = std::move(cell);
    insert(std::move(node));
  }
}

void ZoneSearch::insert(ZoneNode&& node) {
  BIP_ASSERT(node.zone.is_canonical(), "node {}", nodes_.size());
  BIP_ASSERT(node.parent == kNone || node.parent < nodes_.size(), "parent {} of node {}", node.parent, nodes_.size());
  BIP_ASSERT((node.edge == ZoneEdge::Initial) == (node.parent == kNone), "edge {}", node.edge);
  std::vector<u32>& others = locations_[node.location].nodes;
  // A cycle through a larger zone need not be one of its parts.
  const bool is_apart = is_without_limit() && locations_[node.location].observed.is_pending;
  for (const u32 other : others) {
    if (is_apart ? nodes_[other].zone != node.zone : !nodes_[other].zone.includes(node.zone)) continue;
    if (is_apart) note_arc(node, other);
    note_arrival(other);
    return;
  }
  std::erase_if(others, [&](u32 other) {
    if (is_apart || !node.zone.includes(nodes_[other].zone)) return false;
    BIP_ASSERT(other < nodes_.size(), "node {}", other);
    nodes_[other].is_covered = other >= next_;
    if (nodes_[other].is_covered) nodes_[other].covered_by = static_cast<u32>(nodes_.size());
    return true;
  });
  if (report_.zones >= options_.limit) {
    report_.end = ExploreEnd::States;
    return;
  }
  if (is_apart) note_arc(node, static_cast<u32>(nodes_.size()));
  note_arrival(static_cast<u32>(nodes_.size()));
  node_bytes_ -= heap_bytes(others);
  others.push_back(static_cast<u32>(nodes_.size()));
  node_bytes_ += heap_bytes(others) + sizeof(ZoneNode) + node.zone.bytes() + heap_bytes(node.origin);
  report_.depth = std::max(report_.depth, node.depth);
  nodes_.push_back(std::move(node));
  ++report_.zones;
}

void ZoneSearch::note_error(u32 node, const std::vector<i64>& point, ErrorIn where, InteractionId interaction,
                            u32 config) {
  if (!is_node_faulty_) ++report_.errors;
  is_node_faulty_ = report_.has_error = true;
  if (error_.node == kNone)
    error_ = {node, point, true, where == ErrorIn::Step, interaction, config, false, false, false};
}

// Takes a candidate from a cell of the node. False: the search has to end.
bool ZoneSearch::fire(u32 node, const Zone& cell, const std::vector<i64>& point, u64 k) {
  BIP_ASSERT(k < core_.candidate_count(), "candidate {} of {}", k, core_.candidate_count());
  BIP_ASSERT(nodes_[node].zone.includes(cell), "a step from outside of node {}", node);
  const Location& at = locations_[nodes_[node].location];
  const EnabledSet::Position position = core_.position(k);
  const Candidate candidate = core_.candidate(position);
  std::vector<Participant> participants;
  core_.participants(candidate, participants);
  const bool is_sync = candidate.connector != kNone && core_.tables().connector_type(candidate.connector).resume_sync;
  std::vector<u32> waits = at.waits, leaders = at.leaders, timed;
  u32 leader = kNone;
  bool waits_now = false;
  for (const Participant& participant : participants) {
    const AtomTime* time = core_.tables().atom_type(participant.atom).time;
    if (time == nullptr) continue;
    const u32 row = core_.enabled_transition(participant.atom, participant.port);
    const bool is_busy = time->transitions[row].resume.present;
    waits[participant.atom] = is_busy ? row : kNone;
    leaders[participant.atom] = is_busy ? participant.atom : 0;
    waits_now = waits_now || is_busy;
    leader = std::min(leader, participant.atom);
    timed.push_back(participant.atom);
    if (is_sync) waits[participant.atom] = row;
  }
  for (const u32 atom : timed) {
    if (!is_sync) break;
    if (!waits_now) waits[atom] = kNone;
    leaders[atom] = waits_now ? leader : 0;
  }
  ++report_.steps;
  bool is_pending = at.observed.is_pending, is_requested = false;
  const bool was_pending = is_pending;
  u64 past = at.observed.past;
  if (response_ != nullptr) observe(&candidate, is_pending, is_requested);
  if (monitor_ != nullptr) past = monitor_->next(core_, &candidate, past);
  NotedMove move(*this, node, ZoneEdge::Step, cell);
  move.add_atoms(participants);
  // Whether the state that it leads to has a fault may depend on the clocks: that is asked in each of its cells.
  if (!core_.time().take(position) && !core_.fault().is_of_state) {
    note_error(node, point, ErrorIn::Step, candidate.interaction, candidate.config);
    return true;
  }
  Zone zone = cell;
  if (!follow_clocks(zone)) return false;
  move.add_set_clocks();
  if (response_ != nullptr) {
    observe(nullptr, is_pending, is_requested);
    if (!is_pending) zone.forget_clock(locations_.in_time().i);
    else if (is_requested) zone.set_clock(locations_.in_time().i, 0);
  }
  if (monitor_ != nullptr) past = monitor_->next(core_, nullptr, past);
  ZoneNode label{.parent = node,
                 .depth = nodes_[node].depth + 1,
                 .edge = ZoneEdge::Step,
                 .interaction = candidate.interaction,
                 .config = candidate.config,
                 .is_requested = is_requested,
                 .origin = point,
                 .zone = Zone(0)};
  const u32 row = locations_.find_or_add(core_.snapshot(), waits, leaders, {is_pending, past});
  if (is_without_limit() && was_pending && is_pending && !is_requested) enter_later(row, zone, label);
  enter(row, std::move(zone), std::move(label));
  return true;
}

// All candidates of an interaction; what has one is taken out of `rest`.
bool ZoneSearch::step_from(u32 node, const InteractionCondition& condition, std::vector<Zone>& rest) {
  std::vector<Zone> cells;
  if (condition.is_conjunction) {
    Zone cell = nodes_[node].zone;
    for (const ZoneBound& bound : condition.bounds) {
      if (!cell.meet(bound)) return true;
    }
    cells.push_back(std::move(cell));
  } else {
    cells = cut(nodes_[node].zone, condition.bounds);
  }
  for (const Zone& cell : cells) {
    const std::vector<i64> point = cell.least_point();
    if (!enter_core(locations_[nodes_[node].location], point)) {
      note_error(node, point, ErrorIn::State, condition.interaction, 0);
      // A part steps on, as if there were no fault: that is more than the whole does.
      if (part_ == nullptr) locations_.cut_by_all();
      continue;
    }
    u64 first = 0, end = 0;
    for (u64 k = 0; k < core_.candidate_count(); ++k) {
      const InteractionId interaction = core_.candidate(k).interaction;
      if (interaction < condition.interaction) first = k + 1;
      if (interaction <= condition.interaction) end = k + 1;
    }
    if (first == end) continue;
    if (part_ == nullptr || is_sure_[condition.interaction] != 0) {
      std::vector<Zone> left;
      for (const Zone& part : rest) subtract(part, cell, left);
      rest = std::move(left);
    }
    for (u64 k = first; k < end; ++k) {
      if (k != first && !enter_core(locations_[nodes_[node].location], point)) break;
      if (!fire(node, cell, point, k)) return false;
    }
  }
  return true;
}

// Beyond these bounds delayable candidates of the point let no time pass.
Bounds ZoneSearch::deadlines(const Location& at, const std::vector<i64>& point) {
  Bounds out;
  if (!at.has_urgent || !enter_core(at, point)) return out;
  std::vector<Participant> participants;
  std::vector<TimedTransition> transitions;
  for (u64 k = 0; k < core_.candidate_count(); ++k) {
    const Candidate candidate = core_.candidate(k);
    if (core_.time().time_of(candidate).urgency != Urgency::Delayable) continue;
    core_.participants(candidate, participants);
    for (const Participant& participant : participants) {
      if (core_.tables().atom_type(participant.atom).time == nullptr) continue;
      if (!core_.clock_constraints().timed_transitions(participant.atom, transitions)) return out;
      const u32 first = core_.time().first_clock(participant.atom) + 1;
      // Of two transitions of the port that are both enabled (to take it is an error) the interval is what they share.
      const auto holds = [&](const ClockBound& bound) {
        const i64 value = point[first + bound.clock] - (bound.minus == kNone ? 0 : point[first + bound.minus]);
        return bound.low <= value && value <= bound.high;
      };
      for (const TimedTransition& transition : transitions) {
        if (transition.port != participant.port ||
            !std::all_of(transition.when.bounds.begin(), transition.when.bounds.end(), holds))
          continue;
        for (const ClockBound& bound : transition.when.bounds) {
          if (bound.high != kNoBound && bound.minus == kNone) out.push_back({first + bound.clock, 0, bound.high});
        }
      }
    }
  }
  return out;
}

// The points of the neighbour cells that are reached after a tick, unless a deadline or an invariant is in the way.
std::vector<Zone> ZoneSearch::cells_ahead(u32 node) {
  std::vector<Zone> ahead;
  const u32 row = nodes_[node].location;
  if (nodes_[node].is_still || locations_[row].cells.empty()) return ahead;
  Zone next = nodes_[node].zone;
  const Bounds ends = deadlines(locations_[row], next.least_point());
  next.shift(1);
  for (const Bounds* bounds : {&ends, static_cast<const Bounds*>(&locations_[row].invariants)}) {
    for (const ZoneBound& bound : *bounds) {
      if (!next.meet(bound)) return ahead;
    }
  }
  // Who may go on does so at the last instant at the latest.
  for (const WaitGroup& group : locations_[row].groups) {
    if (!wakes(group, nodes_[node].zone)) continue;
    for (const ZoneBound& bound : group.bounds) {
      if (!next.meet(bound)) return ahead;
    }
  }
  for (Zone& cell : cut(next, locations_[row].cells)) {
    Zone same = cell;
    if (!agree(same, nodes_[node].zone, locations_[row].cells)) ahead.push_back(std::move(cell));
  }
  return ahead;
}

// Takes out of `ahead` the cells that an eager candidate with an open bound closes; returns the points of the node, a
// tick before, at which time has to stop. A part of a system lets time pass: another component may be missing.
std::vector<Zone> ZoneSearch::take_closed(u32 node, std::vector<Zone>& ahead) {
  std::vector<Zone> ends;
  const Location& at = locations_[nodes_[node].location];
  if (part_ != nullptr || !at.has_urgent || !core_.time().has_open_eager()) return ends;
  std::erase_if(ahead, [&](const Zone& cell) {
    if (!enter_core(at, cell.least_point()) || core_.time().opened_eager() == core_.candidate_count()) return false;
    ends.push_back(cell);
    ends.back().shift(-1);
    return true;
  });
  return ends;
}

void ZoneSearch::pass_time(u32 node, std::vector<Zone>& ahead) {
  const u32 row = nodes_[node].location;
  for (Zone& cell : ahead) {
    const NotedMove move(*this, node, ZoneEdge::Time, cell);
    enter(row, std::move(cell),
          {.parent = node, .depth = nodes_[node].depth, .edge = ZoneEdge::Time, .origin = {}, .zone = Zone(0)});
  }
}

// At any instant at which its `resume` holds a busy atom goes on, or does not yet.
void ZoneSearch::go_on(u32 node) {
  BIP_ASSERT(nodes_[node].is_waking, "no atom waits in node {}", node);
  const u32 row = nodes_[node].location;
  for (std::size_t k = 0; k < locations_[row].groups.size(); ++k) {
    const Location& at = locations_[row];
    const WaitGroup& group = at.groups[k];
    if (!wakes(group, nodes_[node].zone)) continue;
    std::vector<u32> waits = at.waits, leaders = at.leaders;
    for (u32 atom = 0; atom < waits.size(); ++atom) {
      if (at.waits[atom] == kNone || at.leaders[atom] != group.leader) continue;
      waits[atom] = kNone;
      leaders[atom] = 0;
    }
    State state = at.state;
    Zone zone = nodes_[node].zone;
    const NotedMove move(*this, node, ZoneEdge::GoOn, zone);
    enter(locations_.find_or_add(std::move(state), waits, leaders, at.observed), std::move(zone),
          {.parent = node, .depth = nodes_[node].depth, .edge = ZoneEdge::GoOn, .origin = {}, .zone = Zone(0)});
  }
}

void ZoneSearch::expand(u32 node) {
  BIP_ASSERT(node < nodes_.size() && !nodes_[node].is_covered, "node {}", node);
  is_node_faulty_ = false;
  if (find_match(node) || find_late(node) || find_violated(node)) return;
  if (part_ != nullptr && is_asked_for(node)) {
    open_ = nodes_[node].location;
    return;
  }
  if (nodes_[node].is_waking) go_on(node);
  if (nodes_[node].is_faulty) {
    note_error(node, nodes_[node].zone.least_point(), ErrorIn::State, {}, 0);
    return;
  }
  std::vector<Zone> rest{nodes_[node].zone};
  const std::size_t interactions = locations_[nodes_[node].location].interactions.size();
  for (std::size_t k = 0; k < interactions; ++k) {
    const InteractionCondition condition = locations_[nodes_[node].location].interactions[k];
    if (!step_from(node, condition, rest)) return;
  }
  if (find_idle(node)) return;
  std::vector<Zone> ahead = cells_ahead(node);
  const std::vector<Zone> ends = take_closed(node, ahead);
  if (nodes_[node].is_waking) rest = without_last(node, std::move(rest));
  if (part_ == nullptr) {
    classify_dead_points(node, rest, ends);
  } else if (is_held_up(locations_[nodes_[node].location], rest)) {
    open_ = nodes_[node].location;
    return;
  }
  pass_time(node, ahead);
}

bool ZoneSearch::is_over() {
  if (report_.end != ExploreEnd::Complete || !report_.inexact.empty() || match_.node != kNone || open_ != kNone)
    return true;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - started_;
  report_.bytes = node_bytes_ + locations_.bytes();
  if (options_.is_stopped && options_.is_stopped()) report_.end = ExploreEnd::Stopped;
  else if (options_.seconds > 0 && spent.count() > options_.seconds) report_.end = ExploreEnd::Time;
  else if (options_.bytes != 0 && report_.bytes > options_.bytes) report_.end = ExploreEnd::Memory;
  if (options_.on_progress && next_ % 256 == 0) {
    options_.on_progress({.states = report_.zones,
                          .expanded = next_,
                          .steps = report_.steps,
                          .deadlocks = report_.deadlocks + report_.time_locks,
                          .errors = report_.errors,
                          .depth = report_.depth,
                          .bytes = report_.bytes});
  }
  return report_.end != ExploreEnd::Complete;
}

// Anew whenever a constant has grown: what was forgotten by the smaller one may matter.
void ZoneSearch::search() {
  for (;;) {
    const bool has_begun = begin();
    if (locations_.take_growth()) continue;
    if (!has_begun) return;
    bool has_grown = false;
    for (; !has_grown && next_ < nodes_.size() && !is_over(); ++next_) {
      if (!nodes_[next_].is_covered) expand(next_);
      if (next_ == next_look_) find_lasso(), next_look_ *= 2;
      has_grown = locations_.take_growth();
    }
    if (!has_grown) return;
  }
}

void ZoneSearch::sum_up() {
  report_.locations = locations_.size();
  report_.bytes = node_bytes_ + locations_.bytes();
  report_.has_deadlock = deadlock_.node != kNone;
  report_.has_final_states = has_final_states(core_.image());
  report_.has_time_lock = time_lock_.node != kNone;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - started_;
  report_.seconds = spent.count();
}

ZoneReport ZoneSearch::run() {
  search();
  find_lasso();
  sum_up();
  if (report_.has_deadlock) find_path(deadlock_, report_.deadlock);
  if (report_.has_time_lock) find_path(time_lock_, report_.time_lock);
  if (error_.node != kNone) find_path(error_, report_.error);
  report_.has_match = match_.node != kNone;
  if (report_.has_match) find_path(match_, report_.match);
  return std::move(report_);
}

ZoneReport explore_zones(const Image& image, const ExploreOptions& options) { return ZoneSearch(image, options).run(); }

void ZoneSearch::visit_locations(ZoneReport& report, const std::function<void(const ListedLocation&)>& visit) {
  if (report.end != ExploreEnd::Complete || !report.inexact.empty() || report.has_match) return;
  std::vector<u32> rank_of;
  if (is_without_limit()) rank_of = ranks(report);
  for (u32 row = 0; row < locations_.size(); ++row) {
    const Location& at = locations_[row];
    if (at.nodes.empty()) continue;
    ListedLocation listed{&at.state, {}, at.leaders, {}, at.observed.is_pending};
    for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
      const u32 transitions = image_.atom_types[image_.atoms[atom].type].transitions.size;
      const u32 waits = at.waits[atom];
      listed.waits.push_back(waits == kNone ? 0 : waits == kAfterInitial ? transitions + 1 : waits + 1);
    }
    for (const u32 node : at.nodes) listed.zones.push_back(&nodes_[node].zone);
    for (const u32 node : at.nodes) {
      if (!rank_of.empty() && at.observed.is_pending) listed.ranks.push_back(rank_of[node]);
    }
    visit(listed);
  }
}

ZoneReport explore_zones(const Image& image, const ExploreOptions& options,
                         const std::function<void(const ListedLocation&)>& visit) {
  ZoneSearch search(image, options);
  ZoneReport report = search.run();
  search.visit_locations(report, visit);
  return report;
}

}  // namespace bip::rt
