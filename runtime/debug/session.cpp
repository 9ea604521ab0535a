// See session.hpp.
#include "runtime/debug/session.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "bip/assert.hpp"
#include "bip/ffi.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/engine/collect_strings.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/engine/output.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

namespace {

// The flag of Ctrl-C is looked at after so many moves.
constexpr std::uint64_t kMovesPerLook = 1024;

}  // namespace

DebugSession::DebugSession(const Image& image, const SessionOptions& options)
    : options_(options),
      core_(image, {.progress = options.progress}),
      feed_(core_),
      scheduler_(options.policy, options.asap, options.seed) {
  feed_.note_into(&delivered_);
}

Halt DebugSession::refuse(std::string why) {
  problem_ = std::move(why);
  return Halt::Refused;
}

std::string DebugSession::fault() const {
  return is_faulty_ ? fault_text(core_, options_.seed, position_ - (is_fault_a_move_ ? 1 : 0)) : std::string();
}

std::string DebugSession::back_refusal() const {
  if (core_.image().ffi != nullptr && !options_.trusts_cpp)
    return "the model calls C++, and what it remembers is part of no state";
  return {};
}

Halt DebugSession::start() {
  if (core_.image().ffi != nullptr) std::srand(static_cast<unsigned>(options_.seed));
  core_.seed_draws(options_.seed);
  if (options_.draws_resumes) scheduler_.prepare(core_);
  is_faulty_ = !core_.initialize();
  is_fault_a_move_ = false;
  if (is_faulty_) return Halt::Fault;
  scheduler_.start(core_);
  take_snapshot();
  return Halt::Done;
}

// -- Moves --

void DebugSession::record(Move move, i64 instant) {
  BIP_ASSERT(!has_ahead(), "a move is appended before recorded ones");
  BIP_ASSERT(instants_.empty() || instants_.back() <= instant, "a move at {} after one at {}", instant,
             instants_.back());
  moves_.push_back(move);
  if (core_.is_timed()) instants_.push_back(instant);
}

bool DebugSession::advance(i64 to) {
  while (core_.now() < to) {
    if (!core_.time().advance(std::min(to, core_.time().next_change()))) return false;
  }
  return true;
}

// A state that differs in one cell; what is enabled in it is found anew.
bool DebugSession::assign_cell(const Assignment& assignment) {
  const std::vector<InteractionId> order = core_.enabled().list_order();
  State state = core_.snapshot();
  state.data[assignment.variable] = assignment.value.bits;
  if (!core_.restore(state)) return false;
  core_.set_list_order(order);
  return true;
}

// Makes the move; the state is the one in which it was recorded. False: a fault.
bool DebugSession::apply(const Move& move, i64 instant, Track track) {
  if (core_.is_timed() && !advance(instant)) {
    (void)fail();
    return false;
  }
  const bool is_tracked = track == Track::Yes || tracking_ == Tracking::Every || !back_refusal().empty();
  if (is_tracked) begin_tracking(move);
  bool is_sound = true;
  if (move.interaction == kEvent) {
    is_sound = feed_.redeliver(core_, events_[move.rank].event);
  } else if (move.interaction == kAssign) {
    is_sound = assign_cell(assignments_[move.rank]);
  } else if (move.interaction != kDelay) {
    const EnabledSet::Position at{move.interaction, move.rank};
    BIP_ASSERT(core_.enabled().has(at), "move {} of interaction {} is no candidate", position_, move.interaction);
    if (watches_steps_) note_step(core_.candidate(at));
    is_sound = core_.is_timed() ? core_.time().take(at) : core_.take(at);
    if (is_sound) collect_strings(core_);
  }
  ++position_;
  if (is_tracked) end_tracking();
  is_tracked_ = is_tracked;
  is_faulty_ = !is_sound;
  is_fault_a_move_ = !is_sound;
  if (is_sound && position_ % stride_ == 0) take_snapshot();
  return is_sound;
}

// Repeats the next recorded move.
Halt DebugSession::forward(Track track) {
  BIP_ASSERT(has_ahead() && !is_faulty_, "no move is ahead of {}", position_);
  const std::uint64_t at = position_;
  const Move move = moves_[at];
  return apply(move, core_.is_timed() ? instants_[at] : 0, track) ? Halt::Done : Halt::Fault;
}

Halt DebugSession::fail() {
  is_faulty_ = true;
  is_fault_a_move_ = false;
  is_tracked_ = false;
  return Halt::Fault;
}

// The feed has delivered events while time passed: each is a move.
void DebugSession::record_delivered(std::size_t first) {
  for (std::size_t k = first; k < delivered_.size(); ++k) {
    events_.push_back({delivered_[k], false});
    record({kEvent, static_cast<u32>(events_.size() - 1)}, core_.now());
    ++position_;
  }
  delivered_.clear();
  is_tracked_ = false;
}

// The scheduler passes time and chooses; events come on the way.
Halt DebugSession::step_at_tip() {
  BIP_ASSERT(!has_ahead() && !is_faulty_, "the scheduler chooses at the end of the moves");
  while (true) {
    const i64 before = core_.now();
    delivered_.clear();
    const Due due = scheduler_.wait(core_, feed_);
    const bool is_event = !delivered_.empty();
    record_delivered(0);
    switch (due) {
      case Due::Event: continue;
      case Due::Fault:
        (void)fail();
        is_fault_a_move_ = is_event;
        return Halt::Fault;
      case Due::Stopped:
      case Due::Deadlock:
        if (core_.now() != before) {
          record({kDelay, 0}, core_.now());
          ++position_;
          is_tracked_ = false;
        }
        return due == Due::Deadlock ? Halt::Deadlock : Halt::Interrupted;
      case Due::Step: break;
    }
    const EnabledSet::Position at = scheduler_.choice();
    record({at.interaction, at.rank}, core_.now());
    const Halt halt = forward(Track::No);
    scheduler_.fired(at.interaction);
    return halt;
  }
}

Halt DebugSession::step_once() {
  if (is_faulty_) return Halt::Fault;
  return has_ahead() ? forward(Track::No) : step_at_tip();
}

Halt DebugSession::step() {
  const InterruptGuard guard(&feed_.waker());
  return step_once();
}

Halt DebugSession::choose(std::uint64_t k) {
  if (is_faulty_) return Halt::Fault;
  if (k >= core_.candidate_count()) return refuse("there is no candidate " + std::to_string(k));
  const EnabledSet::Position at = core_.position(k);
  const Move move{at.interaction, at.rank};
  const bool is_recorded =
      has_ahead() && moves_[position_] == move && (!core_.is_timed() || instants_[position_] == core_.now());
  if (is_recorded) return forward(Track::No);
  branch();
  record(move, core_.now());
  const Halt halt = forward(Track::No);
  scheduler_.fired(at.interaction);
  return halt;
}

bool DebugSession::is_legal_delay(i64 to) {
  std::vector<i64> ends;
  const DebugSession::Snapshot before{position_, core_.snapshot(), core_.enabled().list_order(), 0};
  bool is_legal = true;
  while (is_legal && core_.now() < to) {
    is_legal = to <= core_.time().wait_limit(ends) || core_.time().next_change() <= core_.time().wait_limit(ends);
    is_legal = is_legal && core_.time().advance(std::min(to, core_.time().next_change()));
  }
  restore(before);
  return is_legal;
}

Halt DebugSession::delay(i64 to) {
  if (is_faulty_) return Halt::Fault;
  if (!core_.is_timed()) return refuse("the model has no time");
  if (to <= core_.now()) return refuse("the instant is not after now");
  if (!is_legal_delay(to)) return refuse("time may not pass so far in this state");
  branch();
  record({kDelay, 0}, to);
  return forward(Track::No);
}

Halt DebugSession::post(const std::string& port, std::vector<EventValue> values) {
  if (is_faulty_) return Halt::Fault;
  const u32 row = feed_.ports().find(port);
  if (row == kNone) return refuse("there is no port `" + port + "` for events from outside");
  if (const std::string wrong = feed_.ports().check(row, values); !wrong.empty()) return refuse(wrong);
  branch();
  events_.push_back({{core_.now(), row, kAnyLook, std::move(values), EventKind::Port, 0}, true});
  record({kEvent, static_cast<u32>(events_.size() - 1)}, core_.now());
  return forward(Track::No);
}

Halt DebugSession::assign(u32 atom, u32 variable, Cell value) {
  if (is_faulty_) return Halt::Fault;
  BIP_ASSERT(atom < core_.image().atoms.size, "atom {} of {}", atom, core_.image().atoms.size);
  const Var& declared = core_.tables().atom_type(atom).variables[variable];
  if (is_ffi(declared.type)) return refuse("an object of C++ cannot be set");
  branch();
  // The move may be repeated when no state has the string any more.
  if (core_.image().ffi != nullptr && declared.type == CellType::String) core_.image().ffi->pin({&value.i, 1});
  assignments_.push_back({core_.image().atoms[atom].variable(variable), value});
  record({kAssign, static_cast<u32>(assignments_.size() - 1)}, core_.now());
  return forward(Track::No);
}

Halt DebugSession::run(std::uint64_t count) {
  reached_.clear();
  prepare_breakpoints();
  const InterruptGuard guard(&feed_.waker());
  for (std::uint64_t k = 0; k < count; ++k) {
    if (k % kMovesPerLook == 0 && (is_interrupted() || (is_stopped && is_stopped()))) return Halt::Interrupted;
    const Halt halt = step_once();
    if (halt != Halt::Done) return halt;
    if (check_breakpoints()) return Halt::Breakpoint;
  }
  return Halt::Limit;
}

void DebugSession::branch() {
  if (!has_ahead()) return;
  const auto at = static_cast<std::ptrdiff_t>(position_);
  if (!marks_.empty() && marks_.back().tail.empty()) {
    Mark& last = marks_.back();
    last.cut = position_;
    last.tail.assign(moves_.begin() + at, moves_.end());
    if (core_.is_timed()) last.instants.assign(instants_.begin() + at, instants_.end());
  }
  drop_ahead();
}

// Events of the file that the dropped moves contained come again.
void DebugSession::drop_ahead() {
  moves_.resize(position_);
  if (core_.is_timed()) instants_.resize(position_);
  while (!snapshots_.empty() && snapshots_.back().position > position_) {
    snapshot_bytes_ -= snapshots_.back().bytes;
    snapshots_.pop_back();
  }
  rewind_feed();
}

// The feed goes on after the events that the recorded moves contain.
void DebugSession::rewind_feed() {
  if (events_.empty()) return;
  std::size_t delivered = 0;
  for (const Move& move : moves_) {
    if (move.interaction == kEvent && !events_[move.rank].is_posted) ++delivered;
  }
  feed_.rewind(delivered);
}

std::optional<std::uint64_t> DebugSession::recorded_choice() const {
  if (!has_ahead() || is_faulty_) return std::nullopt;
  const Move& next = moves_[position_];
  if (next.interaction >= kAssign || (core_.is_timed() && instants_[position_] != core_.now())) return std::nullopt;
  return core_.enabled().number({next.interaction, next.rank});
}

// -- Back --

void DebugSession::take_snapshot() {
  if (!back_refusal().empty() || (!snapshots_.empty() && snapshots_.back().position >= position_)) return;
  pin_strings(core_);
  Snapshot made{position_, core_.snapshot(), core_.enabled().list_order(), 0};
  made.bytes = sizeof made + made.state.places.size() * sizeof(u32) + made.state.marks.size() * sizeof(u64) +
               made.state.data.size() * sizeof(u64) + made.state.time.size() * sizeof(i64) +
               made.state.objects.size() * sizeof(FfiValue) + made.order.size() * sizeof(u32);
  snapshot_bytes_ += made.bytes;
  snapshots_.push_back(std::move(made));
  while (snapshot_bytes_ > options_.snapshot_bytes && snapshots_.size() > 2) {
    stride_ *= 2;
    snapshot_bytes_ = 0;
    std::erase_if(snapshots_, [this](const Snapshot& s) { return s.position % stride_ != 0; });
    for (const Snapshot& s : snapshots_) snapshot_bytes_ += s.bytes;
  }
  BIP_ASSERT(snapshots_.front().position == 0, "the first snapshot is at {}", snapshots_.front().position);
}

void DebugSession::restore(const Snapshot& snapshot) {
  [[maybe_unused]] const bool is_sound = core_.restore(snapshot.state);
  BIP_ASSERT(is_sound, "the state at {} ends in a fault", snapshot.position);
  core_.set_list_order(snapshot.order);
}

const DebugSession::Snapshot& DebugSession::nearest(std::uint64_t position) const {
  const auto after = std::upper_bound(snapshots_.begin(), snapshots_.end(), position,
                                      [](std::uint64_t at, const Snapshot& s) { return at < s.position; });
  BIP_ASSERT(after != snapshots_.begin(), "no snapshot before {}", position);
  return *(after - 1);
}

// To a position that is not ahead, or to here after a fault.
Halt DebugSession::return_to(std::uint64_t position) {
  if (snapshots_.empty()) return refuse("the model has no initial state");
  const Snapshot& from = nearest(position);
  restore(from);
  is_faulty_ = false;
  is_tracked_ = false;
  position_ = from.position;
  BIP_ASSERT(position_ <= position && position <= moves_.size(), "from {} to {} of {}", position_, position,
             moves_.size());
  while (position_ < position) {
    if (forward(Track::No) == Halt::Fault) return Halt::Fault;
  }
  return Halt::Done;
}

Halt DebugSession::go_to(std::uint64_t position) {
  if (position > moves_.size()) return refuse("there are " + std::to_string(moves_.size()) + " recorded moves");
  if (position < position_ || is_faulty_) {
    if (std::string why = back_refusal(); !why.empty()) return refuse(std::move(why));
    return return_to(position);
  }
  // A snapshot ahead may be nearer than here.
  if (position > position_ && back_refusal().empty() && nearest(position).position > position_)
    return return_to(position);
  while (position_ < position) {
    if (forward(Track::No) == Halt::Fault) return Halt::Fault;
  }
  return Halt::Done;
}

Halt DebugSession::back(std::uint64_t count) {
  if (count == 0) return Halt::Done;
  // A fault while time passed is no move: one step back from it is the state before.
  if (is_faulty_ && !is_fault_a_move_) --count;
  else if (position_ == 0) return Halt::Begin;
  const std::uint64_t target = count > position_ ? 0 : position_ - count;
  return go_to(target);
}

// From snapshot to snapshot: the last breakpoint before here is in the first part, from behind, that has one.
Halt DebugSession::run_back() {
  if (std::string why = back_refusal(); !why.empty()) return refuse(std::move(why));
  if (position_ == 0 && !is_faulty_) return Halt::Begin;
  reached_.clear();
  std::uint64_t end = is_faulty_ && !is_fault_a_move_ ? position_ : position_ - 1;
  const InterruptGuard guard(&feed_.waker());
  const std::vector<Breakpoint> before = breakpoints_;
  const auto log = std::exchange(on_log, nullptr);
  std::uint64_t found = 0;
  std::vector<u32> reached;
  bool has_found = false;
  while (end > 0 && !has_found && !is_interrupted() && !(is_stopped && is_stopped())) {
    const std::uint64_t begin = nearest(end - 1).position;
    (void)return_to(begin);
    prepare_breakpoints();
    while (position_ < end) {
      if (forward(Track::No) == Halt::Fault) break;
      if (!check_breakpoints()) continue;
      has_found = true;
      found = position_;
      reached = reached_;
    }
    end = begin;
  }
  breakpoints_ = before;
  on_log = log;
  (void)return_to(has_found ? found : end);
  reached_ = std::move(reached);
  return has_found ? Halt::Breakpoint : end == 0 ? Halt::Begin : Halt::Interrupted;
}

void DebugSession::mark() {
  if (marks_.size() == kMaxMarks) marks_.erase(marks_.begin());
  marks_.push_back({position_, ~std::uint64_t{0}, {}, {}});
}

void DebugSession::drop_mark() {
  if (!marks_.empty()) marks_.pop_back();
}

bool DebugSession::undo() {
  if (marks_.empty() || !back_refusal().empty()) return false;
  Mark last = std::move(marks_.back());
  marks_.pop_back();
  if (!last.tail.empty()) {
    (void)go_to(last.cut);
    BIP_ASSERT(position_ == last.cut, "the moves were dropped at {}, and this is {}", last.cut, position_);
    drop_ahead();
    moves_.insert(moves_.end(), last.tail.begin(), last.tail.end());
    instants_.insert(instants_.end(), last.instants.begin(), last.instants.end());
    rewind_feed();
  }
  (void)go_to(std::min<std::uint64_t>(last.position, moves_.size()));
  return true;
}

// -- Runs recorded by others --

Halt DebugSession::follow(i64 instant, const std::function<std::optional<EnabledSet::Position>(Core&)>& find) {
  if (is_faulty_) return refuse("a run-time error ends the model there: " + core_.fault().what);
  if (core_.is_timed() && instant > core_.now()) {
    if (!is_legal_delay(instant)) return refuse("time may not pass so far in the model");
    if (!advance(instant)) return fail();
  }
  if (core_.is_timed() && instant < core_.now()) return refuse("the instant is before the one of the step before");
  const std::optional<EnabledSet::Position> at = find(core_);
  if (!at) return refuse("the step is not possible in the model there");
  record({at->interaction, at->rank}, core_.now());
  const Halt halt = forward(Track::No);
  scheduler_.fired(at->interaction);
  return halt;
}

Halt DebugSession::follow_record(const std::string& path, const Record& record) {
  if (record.tells_returns) return refuse("it holds actions that ran in real time (`@async`)");
  if (const Result<bool> is_read = feed_.replay(path); !is_read) return refuse(is_read.error());
  const InterruptGuard guard(&feed_.waker());
  std::uint64_t steps = 0;
  while (record.has_end ? steps < record.steps : !feed_.is_record_over(core_)) {
    const Halt halt = step_at_tip();
    if (halt == Halt::Done) ++steps;
    else if (halt == Halt::Interrupted) return halt;
    else break;
  }
  if (record.has_end && steps != record.steps && !is_faulty_)
    return refuse("it has " + std::to_string(record.steps) + " steps, the model ends after " + std::to_string(steps));
  return is_faulty_ ? Halt::Fault : Halt::Done;
}

bool DebugSession::append_trace(std::string& out, TraceFormat format) {
  return append_trace(out, format, *row_of(format).make());
}

bool DebugSession::append_trace(std::string& out, TraceFormat format, TraceSink& sink) {
  if (std::string why = back_refusal(); !why.empty()) {
    problem_ = std::move(why);
    return false;
  }
  const auto end = moves_.begin() + static_cast<std::ptrdiff_t>(position_);
  if (std::any_of(moves_.begin(), end, [](const Move& m) { return m.interaction == kAssign; })) {
    problem_ = "a variable was set by hand: no run of the model has these steps";
    return false;
  }
  if (is_faulty_) {
    problem_ = "the run ends here with an error: go back one step";
    return false;
  }
  const std::uint64_t saved_position = position_;
  RunOptions run;
  run.policy = options_.policy;
  run.asap = options_.asap;
  run.draws_resumes = options_.draws_resumes;
  run.format = format;
  run.maximal_progress = options_.progress == MaximalProgress::On;
  sink.begin(out, head_of(core_.image(), run, options_.seed));
  (void)return_to(0);
  std::uint64_t steps = 0;
  while (position_ < saved_position) {
    const Move move = moves_[position_];
    if (move.interaction < kAssign) {
      if (core_.is_timed()) sink.foresee(core_);
      if (core_.is_timed()) (void)advance(instants_[position_]);
      const EnabledSet::Position at{move.interaction, move.rank};
      sink.step(out, core_, at, steps++, core_.enabled().number(at));
    }
    (void)forward(Track::No);
  }
  const bool is_end = core_.candidate_count() == 0 && !core_.is_timed();
  sink.end(out, core_, is_end ? end_without_step(core_) : End::Limit, steps);
  return true;
}

// -- The last move --

std::string DebugSession::move_text(std::uint64_t row) const {
  BIP_ASSERT(row < moves_.size(), "move {} of {}", row, moves_.size());
  const Move& move = moves_[row];
  std::string text;
  if (move.interaction == kDelay) {
    text = "time passes to ";
    append_time(text, instants_[row]);
  } else if (move.interaction == kEvent) {
    const Event& event = events_[move.rank].event;
    if (event.kind == EventKind::Port) text = "an event arrives at " + feed_.ports().path(event.row);
    else text = "the action returns in " + core_.image().atoms[event.row].path();
  } else if (move.interaction == kAssign) {
    const VariableId variable = assignments_[move.rank].variable;
    const u32 atom = atom_of(variable);
    text = "a person sets ";
    append_relative(text, core_.image().atoms[atom]);
    const AtomType& type = core_.tables().atom_type(atom);
    text += std::string(".") + type.variables[variable - core_.tables().atoms[atom].first_cell].name;
  }
  return text;
}

const LastMove* DebugSession::last_move() {
  if (position_ == 0) return nullptr;
  if (is_tracked_) return &last_;
  if (!back_refusal().empty() || (is_faulty_ && !is_fault_a_move_)) return nullptr;
  const std::uint64_t saved_position = position_;
  (void)return_to(saved_position - 1);
  (void)forward(Track::Yes);
  return &last_;
}

// The atom that has the variable: their variables follow each other.
u32 DebugSession::atom_of(VariableId variable) const {
  const Image& image = core_.image();
  u32 atom = 0;
  while (atom + 1 < image.atoms.size && image.atoms[atom + 1].variable(0) <= variable) ++atom;
  BIP_ASSERT(variable - image.atoms[atom].variable(0) < core_.tables().atom_type(atom).variables.size,
             "variable {} is none of atom {}", variable, atom);
  return atom;
}

void DebugSession::note_atom(u32 atom) {
  if (std::any_of(before_.begin(), before_.end(), [&](const Before& b) { return b.atom == atom; })) return;
  Before before{atom, places_of(core_, atom), {}, {}};
  const AtomType& type = core_.tables().atom_type(atom);
  const VariableId first = core_.tables().atoms[atom].first_cell;
  // Hidden variables come last.
  const u32 shown = visible_variables(type);
  for (u32 k = 0; k < shown; ++k) {
    before.cells.push_back(core_.cell(first + k));
    before.values.emplace_back();
    append_value(before.values.back(), core_.image(), type.variables[k].type, core_.cell(first + k));
  }
  before_.push_back(std::move(before));
}

void DebugSession::note_part(const Participant& part) {
  const u32 row = core_.enabled_transition(part.atom, part.port);
  const AtomType& type = core_.tables().atom_type(part.atom);
  last_.parts.push_back({part.atom, part.port, row == kNone ? type.ports[part.port].loc : type.transitions[row].loc});
  note_atom(part.atom);
}

void DebugSession::begin_tracking(const Move& move) {
  last_ = {};
  before_.clear();
  if (move.interaction == kDelay) {
    last_.kind = MoveKind::Delay;
    last_.text = move_text(position_);
    return;
  }
  if (move.interaction == kEvent) {
    const Event& event = events_[move.rank].event;
    last_.kind = MoveKind::Event;
    last_.text = move_text(position_);
    if (event.kind != EventKind::Port) note_atom(event.row);
    return;
  }
  if (move.interaction == kAssign) {
    last_.kind = MoveKind::Assign;
    last_.text = move_text(position_);
    note_atom(atom_of(assignments_[move.rank].variable));
    return;
  }
  const Candidate candidate = core_.candidate(EnabledSet::Position{move.interaction, move.rank});
  StepWriter().step(last_.text, core_, candidate, position_);
  last_.text.pop_back();
  last_.connector = candidate.connector;
  if (candidate.connector != kNone) last_.loc = core_.image().connectors[candidate.connector].loc;
  std::vector<Participant> parts;
  core_.participants(candidate, parts);
  for (const Participant& part : parts) note_part(part);
}

void DebugSession::end_tracking() {
  for (const Before& before : before_) {
    AtomChange change{before.atom, {}, {}, {}};
    if (places_of(core_, before.atom) != before.places) change.places = before.places;
    const VariableId first = core_.tables().atoms[before.atom].first_cell;
    const AtomType& type = core_.tables().atom_type(before.atom);
    for (u32 k = 0; k < before.cells.size(); ++k) {
      std::string now;
      append_value(now, core_.image(), type.variables[k].type, core_.cell(first + k));
      if (now == before.values[k]) continue;
      change.variables.push_back(k);
      change.values.push_back(before.values[k]);
    }
    if (!change.places.empty() || !change.variables.empty()) last_.changes.push_back(std::move(change));
  }
  before_.clear();
}

// -- Breakpoints --

void DebugSession::note_step(const Candidate& candidate) {
  parts_.clear();
  connector_ = candidate.connector;
  core_.participants(candidate, participants_);
  for (const Participant& part : participants_) {
    const u32 row = core_.enabled_transition(part.atom, part.port);
    const AtomType& type = core_.tables().atom_type(part.atom);
    parts_.push_back({part.atom, part.port, row == kNone ? SourceLine{} : type.transitions[row].loc});
  }
}

void DebugSession::prepare_breakpoints() {
  watches_steps_ = false;
  for (Breakpoint& b : breakpoints_) {
    switch (b.kind) {
      case BreakKind::Interaction:
      case BreakKind::Port:
      case BreakKind::Line: watches_steps_ = true; break;
      case BreakKind::Place: b.was = core_.is_marked(b.owner, b.row) ? 1 : 0; break;
      case BreakKind::Data: b.was = core_.cell(core_.tables().atoms[b.owner].first_cell + b.row).bits; break;
      case BreakKind::Condition: b.was = b.condition(core_) ? 1 : 0; break;
      case BreakKind::Time: b.was = core_.now() >= b.instant ? 1 : 0; break;
    }
  }
}

bool DebugSession::check_breakpoints() {
  if (breakpoints_.empty()) return false;
  BIP_ASSERT(position_ != 0 && position_ <= moves_.size(), "no move led to {}", position_);
  reached_.clear();
  bool stops = false;
  const Move& move = moves_[position_ - 1];
  const bool is_step = move.interaction < kAssign;
  for (u32 k = 0; k < breakpoints_.size(); ++k) {
    Breakpoint& b = breakpoints_[k];
    const auto became = [&b](bool now) { return std::exchange(b.was, now ? 1 : 0) == 0 && now; };
    bool is_hit = false;
    switch (b.kind) {
      case BreakKind::Interaction: is_hit = is_step && connector_ == b.owner; break;
      case BreakKind::Port:
        is_hit = is_step && std::any_of(parts_.begin(), parts_.end(), [&b](const MovePart& part) {
                   return part.atom == b.owner && part.port == b.row;
                 });
        break;
      case BreakKind::Line: {
        const auto is_here = [&b](SourceLine loc) { return loc.line == b.row && loc.file == b.owner; };
        is_hit =
            is_step && std::any_of(parts_.begin(), parts_.end(), [&](const MovePart& p) { return is_here(p.loc); });
        if (is_step && connector_ != kNone) {
          is_hit = is_hit || is_here(core_.image().connectors[connector_].loc) ||
                   is_here(core_.tables().connector_type(connector_).loc);
        }
        break;
      }
      case BreakKind::Place: is_hit = became(core_.is_marked(b.owner, b.row)); break;
      case BreakKind::Data: {
        const u64 now = core_.cell(core_.tables().atoms[b.owner].first_cell + b.row).bits;
        is_hit = std::exchange(b.was, now) != now;
        break;
      }
      case BreakKind::Condition: is_hit = became(b.condition(core_)); break;
      case BreakKind::Time: is_hit = became(core_.now() >= b.instant); break;
    }
    if (!is_hit || (b.kind != BreakKind::Condition && b.condition && !b.condition(core_))) continue;
    if (b.hits++ < b.hits_before) continue;
    if (!b.message.empty()) {
      if (on_log) on_log(b);
      continue;
    }
    reached_.push_back(k);
    stops = true;
  }
  return stops;
}

}  // namespace bip::rt
