// See node_process.hpp.
#include "runtime/engine/node_process.hpp"

#include <sys/resource.h>

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/engine/collect_strings.hpp"
#include "runtime/engine/fault_message.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/engine/step_follower.hpp"
#include "runtime/engine/waker.hpp"

namespace bip::rt {

namespace {

constexpr i64 kQuiet = 2000000;              // ns of rest before it is reported; with time none: each instant waits
constexpr i64 kSendWhile = 100000;           // ns of actions after which what is ready is sent
constexpr i64 kBeforeLook = 100000;          // ns of steps of atoms at home here before the node looks what came
constexpr u64 kQuickSteps = 32;              // steps from one reading of the clock to the next, if actions are short
constexpr i64 kQuick = 3000;                 // ns of a step up to which they are
constexpr u64 kLeastChunk = 64;              // steps of a batch, at least
constexpr u64 kMostTold = 256;               // steps in one message to the launcher, at most
constexpr std::size_t kMostText = 1u << 15;  // bytes of text in such a message: then no step is added
constexpr i64 kLastWords = 2000000000;       // ns to wait for the launcher to hear them
constexpr i64 kLastAnswer = 20000000;        // ns until the fabric has sent what confirms the last message of the run
constexpr i64 kLook = 1000000000;            // ns between looks whether the launcher is there
constexpr int kGoodbyes = 4, kGoodbye = 50;  // ms
constexpr i64 kLonger = 2000000000;          // ns that the launcher, which waits for all, is waited for longer
constexpr i64 kLeastParked = 1000000, kMostParked = 1000000000;  // ns for which an attempt waits before it is refused
constexpr std::size_t kMostBegun = 256;                          // steps before what is ready is sent

// Cuts the number that is not known yet out of the text; returns 1 + its place, or 0.
u64 cut_number(std::string& text) {
  static const std::string number = std::to_string(kStepToCome);
  const std::size_t place = text.find(number);
  if (place == std::string::npos) return 0;
  text.erase(place, number.size());
  return place + 1;
}

u64 cpu_microseconds() {
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto of = [](const timeval& time) {
    return static_cast<u64>(time.tv_sec) * 1000000 + static_cast<u64>(time.tv_usec);
  };
  return of(usage.ru_utime) + of(usage.ru_stime);
}

}  // namespace

NodeProcess::NodeProcess(const NodeSetup& setup, Fabric& fabric)
    : cpu_before_(cpu_microseconds()),
      setup_(setup),
      fabric_(fabric),
      launcher_(static_cast<u32>(setup.distribution.placement.nodes.size())),
      writes_(setup.output.writes_steps()),
      holds_(writes_ && setup.options.on_loss == OnLoss::GoOn),
      node_(setup.image, setup.core_options, setup.distribution, setup.self),
      is_followed_(can_follow_steps(node_.core(), setup.output)),
      says_interactions_(is_followed_ || setup.output.records_only()),
      codec_(node_.core().tables(), setup.distribution, setup.run),
      station_(fabric, codec_, setup.self, launcher_ + 1),
      scheduler_(setup.options.policy, setup.seed + setup.self),
      time_(plans_instants(node_.core(), setup.options), setup.seed + setup.self),
      is_remote_(setup.options.deployment != nullptr && setup.self != 0),
      fired_(node_.core().tables().interactions.size()),
      sent_(launcher_, 0),
      received_(launcher_, 0),
      chunk_(kLeastChunk),
      quiet_(node_.core().is_timed() ? 0 : kQuiet) {}

bool NodeProcess::run(const State& initial) {
  initial_ = &initial;
  scheduler_.start(node_.core());
  BIP_ENSURE(node_.start(initial), "the initial state has no fault");
  for (u32 peer = 0; peer < setup_.self; ++peer) station_.greet(peer);
  say(Control::Kind::Ready, {});
  started_ = wall_clock();
  if (!begin_watch()) return false;
  arrivals_ = setup_.early;
  take_arrivals(started_);
  bool has_work = true;
  i64 leave_at = kForever;
  bool is_leaving = false;
  for (;;) {
    i64 now = wall_clock();
    const bool has_said_all = told_end_ != kNotTold && station_.link(launcher_).unconfirmed().empty();
    // The launcher waits for a confirmation of its last message where it cannot see that this process has ended.
    if (is_finished_ && has_said_all && !std::exchange(is_leaving, true))
      leave_at = setup_.options.deployment != nullptr ? now + kLastAnswer : now;
    if (is_finished_ && now >= leave_at) return true;
    if (is_remote_ && must_leave(now)) return false;
    i64 due = next_due(has_work);
    if (is_finished_) due = std::min(due, leave_at);
    if (is_remote_) due = std::min(due, now + kLook);
    arrivals_.clear();
    (void)fabric_.wait(due == kForever ? -1 : static_cast<int>((std::max<i64>(due - now, 0) + 999999) / 1000000), {},
                       arrivals_);
    now = wall_clock();
    take_arrivals(now);
    end_parkings(now);
    has_work = has_worked(now);
    release_held();
    if (wants_collection(setup_.image)) free_strings();
    now = wall_clock();
    if (!has_work) report(now);
    send(now);
    station_.tick(now);
    if (is_finished_ && leave_at == kForever) leave_at = wall_clock() + kLastWords;
  }
}

// False: it cannot be watched.
bool NodeProcess::begin_watch() {
  const Deployment* const deployment = setup_.options.deployment;
  if (deployment == nullptr || deployment->stall.after <= 0) return true;
  watch_.emplace(deployment->stall, setup_.distribution.placement.nodes[setup_.self]);
  if (!watch_->start()) why_ = "the system has no thread for --stall-after";
  return why_.empty();
}

void NodeProcess::take_arrivals(i64 now) {
  heard_.clear();
  for (const Arrival& arrival : arrivals_) {
    if (is_greeting(arrival.bytes)) take_greeting(arrival);
    else station_.take(arrival, now, heard_);
  }
  for (const ReceivedMessage& heard : heard_) take(heard);
}

// A launcher that knocks again, with another number, has forgotten this run.
void NodeProcess::take_greeting(const Arrival& arrival) {
  Greeting greeting;
  if (!is_remote_ || arrival.from != launcher_ || !read(arrival.bytes, greeting)) return;
  if (greeting.kind == Greeting::Kind::Knock && greeting.number != setup_.run) why_ = "the launcher was started anew";
}

bool NodeProcess::must_leave(i64 now) {
  if (is_interrupted()) why_ = "ended by signal " + std::to_string(interrupting_signal());
  const i64 silence = now - std::max(started_, station_.last_heard(launcher_));
  if (silence > setup_.options.lost_after + kLonger)
    why_ = "no word of the launcher for " + std::to_string(silence / 1000000000) + " s";
  if (why_.empty()) return false;
  const std::string leave = text_of(Greeting{.kind = Greeting::Kind::Leave, .number = setup_.run, .model = why_});
  // Sockets forget what is unsent when they are closed. What still comes ends no wait early.
  for (int k = 0; k < kGoodbyes; ++k) {
    fabric_.send(launcher_, leave);
    const i64 until = wall_clock() + i64{kGoodbye} * 1000000;
    for (i64 left = until - wall_clock(); left > 0; left = until - wall_clock()) {
      arrivals_.clear();
      (void)fabric_.wait(static_cast<int>(left / 1000000 + 1), {}, arrivals_);
    }
  }
  return true;
}

i64 NodeProcess::next_due(bool has_work) const {
  if (has_work) return 0;
  i64 due = station_.due();
  if (!parked_.empty()) due = std::min(due, parked_.top().first);
  return idle_since_ == 0 ? due : std::min(due, idle_since_ + quiet_);
}

void NodeProcess::say(Control::Kind kind, std::vector<u64> numbers, std::vector<std::string> texts) {
  say_fired();
  station_.say(launcher_, Control{kind, std::move(numbers), std::move(texts)});
  has_unsent_ = true;
}

void NodeProcess::send(i64 now) {
  say_fired();
  station_.send(now);
  has_unsent_ = has_mail_ = false;
}

void NodeProcess::take(const ReceivedMessage& heard) {
  const auto* const control = std::get_if<Control>(&heard.message);
  if ((control != nullptr) != (heard.from == launcher_)) return;
  if (control != nullptr) return take_control(*control);
  ++received_[heard.from];
  is_idle_ = false;
  node_.take(heard.message);
}

void NodeProcess::take_control(const Control& control) {
  const u64 number = control.numbers.empty() ? 0 : control.numbers.front();
  Core& core = node_.core();
  switch (control.kind) {
    case Control::Kind::Credit:
      credit_ = number > ~u64{0} - credit_ ? ~u64{0} : credit_ + number;
      ++credits_;
      has_asked_ = false;
      is_idle_ = false;
      return;
    case Control::Kind::Recall: return give_back();
    case Control::Kind::Count: return count(number);
    case Control::Kind::Lost:
      if (number >= launcher_ || number == setup_.self) return;
      station_.close(static_cast<u32>(number));
      node_.forget_lost(static_cast<u32>(number));
      is_idle_ = false;
      return;
    case Control::Kind::Halt:
      is_halted_ = true;
      is_idle_ = false;
      return;
    case Control::Kind::Pause:
      is_paused_ = true;
      is_idle_ = false;
      return;
    case Control::Kind::Tell: say_state(); return say(Control::Kind::Told, {});
    case Control::Kind::GoOn:
      is_paused_ = false;
      is_idle_ = false;
      return;
    case Control::Kind::Limit:
      if (core.is_timed()) {
        const TimeLimit limit = time_.limit(core);
        say(Control::Kind::Limited, {static_cast<u64>(limit.last), static_cast<u64>(limit.change)});
      }
      return;
    case Control::Kind::Plan:
      if (core.is_timed() && number <= static_cast<u64>(kForever))
        say(Control::Kind::Planned, {static_cast<u64>(time_.plan(core, static_cast<i64>(number)))});
      return;
    case Control::Kind::Instant:
      if (!core.is_timed() || control.numbers.size() != 2 || number >= static_cast<u64>(kForever)) return;
      node_.pass_to({static_cast<i64>(number), control.numbers[1]});
      time_.begin(core.now());
      is_idle_ = false;
      idle_since_ = 0;
      return;
    case Control::Kind::Finish:
      if (!is_finished_) return say_last_state();
      if (control.numbers.size() == 2) told_end_ = control.numbers[0], told_steps_ = control.numbers[1];
      return station_.answer_at_once();
    case Control::Kind::Written: return unwritten_.remove_up_to(number);
    case Control::Kind::Beat: return say(Control::Kind::Beat, {station_.clock(), steps_, cpu_spent()});
    case Control::Kind::Ready:
    case Control::Kind::Idle:
    case Control::Kind::Want:
    case Control::Kind::Counted:
    case Control::Kind::Return:
    case Control::Kind::Begun:
    case Control::Kind::Took:
    case Control::Kind::Fired:
    case Control::Kind::Landed:
    case Control::Kind::Fault:
    case Control::Kind::Atom:
    case Control::Kind::Told:
    case Control::Kind::Limited:
    case Control::Kind::Planned:
    case Control::Kind::Finished: return;
  }
}

// Who could use it keeps half of it, so that a step begins before it is asked for again.
void NodeProcess::give_back() {
  const u64 given = is_idle_ && !wants_ ? credit_ : credit_ / 2;
  credit_ -= given;
  say(Control::Kind::Return, {given});
}

// An attempt waits for as long as the three messages of its refusal take: one and a half times the way to its
// coordinator and back.
void NodeProcess::end_parkings(i64 now) {
  const auto take_new = [&] {
    for (const Node::Parking& parking : node_.new_parkings()) {
      const u32 coordinator = setup_.distribution.coordinator_of[parking.interaction];
      const i64 parked = std::clamp(station_.round_trip(coordinator) * 3 / 2, kLeastParked, kMostParked);
      parked_.push({now + parked, parking.number});
    }
    node_.new_parkings().clear();
  };
  take_new();
  while (!parked_.empty() && parked_.top().first <= now) {
    const u64 number = parked_.top().second;
    parked_.pop();
    node_.end_parking(number);
    // Others go on, and may wait in their turn.
    take_new();
  }
}

// Takes turns until nothing is left to do, another node is to get a message, or a message may have come for a while: a
// look at the sockets costs as much as dozens of steps. The clock is read after each turn while actions are long.
// False: nothing is left to do.
bool NodeProcess::has_worked(i64 now) {
  const i64 until = now + kBeforeLook;
  u64 steps_before = steps_;
  while (has_taken_turn()) {
    const bool must_end = has_mail_ || wants_collection(setup_.image);
    const u64 steps = steps_ - steps_before;
    if (is_quick_ && steps < kQuickSteps && !must_end) continue;
    const i64 read_before = now;
    now = wall_clock();
    const i64 taken = now - read_before;
    is_quick_ = taken < kQuick * static_cast<i64>(std::max<u64>(steps, 1));
    if (taken < kBeforeLook / 4 && steps >= chunk_) chunk_ = std::min(2 * chunk_, Node::kMostCompiled);
    else if (taken > kBeforeLook / 2) chunk_ = std::max(chunk_ / 2, kLeastChunk);
    if (must_end || now >= until) return true;
    steps_before = steps_;
  }
  return false;
}

// Begins what may begin, then runs what is to be run. Where actions are short, steps of atoms at home here are taken as
// a whole; where they are long, all that other nodes are to do begins before them. False: there was nothing.
bool NodeProcess::has_taken_turn() {
  std::size_t begun = 0;
  const u64 most = steps_ + kMostBegun;
  while (begun < kMostBegun && steps_ < most && (has_tried() || has_begun())) ++begun;
  post();
  if (node_.work_count() != 0 && begun != 0 && has_unsent_) send(wall_clock());
  const std::size_t works = node_.work_count();
  if (works != 0) {
    // Since when something is to be sent.
    i64 ready_at = 0;
    while (node_.work_count() != 0) {
      node_.run(node_.work_count() - 1);
      if (watch_) watch_->note_steps();
      if (!writes_ && node_.outbox().empty()) continue;
      const i64 now = wall_clock();
      if (ready_at == 0) ready_at = now;
      if (now - ready_at <= kSendWhile) continue;
      post();
      send(now);
      ready_at = 0;
    }
    post();
  }
  const bool has_worked = begun != 0 || works != 0;
  // Actions may have made more steps possible.
  if (has_worked) {
    is_idle_ = false;
    idle_since_ = 0;
  }
  return has_worked;
}

// An attempt of what needs locks. Drawn, so that neither it nor what may begin here always comes first.
bool NodeProcess::has_tried() {
  if (node_.try_count() == 0) return false;
  const bool begins_first = node_.locked_interaction().is_valid() || scheduler_.prng().below(2) == 0;
  if (begins_first && has_begun()) return true;
  node_.try_lock(scheduler_.prng().below(node_.try_count()));
  return true;
}

// A node of which too much waits to be written does not rest: it begins more when that is written.
bool NodeProcess::may_begin() {
  is_full_ = false;
  if (is_halted_ || is_paused_ || node_.is_stopped()) return false;
  is_full_ = unwritten_.bytes() >= most_unwritten(launcher_);
  return !is_full_;
}

bool NodeProcess::takes_many() const { return is_quick_ && credit_ != 0 && !drawn_.is_valid() && node_.has_whole(); }

// Steps of atoms at home here, one after the other. No other node learns of them, so that they share one instant of the
// clock. If more is written about a step than its interaction, that needs the state before it: then there is no
// compiled code for many.
bool NodeProcess::has_taken_many() {
  const bool writes_texts = writes_ && !says_interactions_;
  const bool is_compiled = !writes_texts && scheduler_.is_uniform() && node_.has_compiled();
  const u64 most = steps_before_collection(node_.core(), std::min(credit_, writes_texts ? kMostTold : chunk_));
  // The node has neither sent nor received anything since the first step that the launcher does not know yet, so these
  // steps and the next ones share a number.
  const u64 step = fired_.count() != 0 ? fired_step_ : step_at(station_.tick_clock(), setup_.self);
  const u64 done = is_compiled ? node_.take_compiled(scheduler_.prng(), most, drawn_) : take_whole_steps(step, most);
  BIP_ASSERT(done <= most, "{} steps of {}", done, most);
  if (done == 0) return false;
  if (is_compiled && says_interactions_) {
    node_.core().history().visit_recent(done, [&](std::span<const u32> rows) { fired_.add(rows); });
    note_fired(step, done);
  }
  if (credit_ != ~u64{0}) credit_ -= done;
  steps_ += done;
  if (watch_) watch_->note_steps();
  return true;
}

// The same steps as compiled ones, one by one. Their actions may call C++ and take long without notice. A step with a
// fault has a number of its own, behind the others'.
u64 NodeProcess::take_whole_steps(u64 step, u64 most) {
  Core& core = node_.core();
  const u64 faulty = step_at(station_.tick_clock(), setup_.self);
  std::vector<u64> numbers{step};
  StepText told;
  u64 done = 0;
  i64 until = 0;
  const auto say_told = [&] {
    if (!writes_ || done == 0) return;
    if (says_interactions_) return note_fired(step, done);
    unwritten_.add(step, record_bytes(told, done));
    say(Control::Kind::Took, std::move(numbers), {std::move(told.out), std::move(told.trace)});
  };
  while (done < most && core.candidate_count() != 0 && told.out.size() + told.trace.size() < kMostText) {
    if (done % kQuickSteps == 0 && done != 0) {
      const i64 now = wall_clock();
      if (until == 0) until = now + kBeforeLook / 4;
      if (now >= until) break;
    }
    const EnabledSet::Position at = scheduler_.choose(core);
    if (!node_.is_whole(at.interaction)) {
      drawn_ = at.interaction;
      break;
    }
    describe(at);
    scheduler_.fired(at.interaction);
    if (!node_.take_whole(at, faulty)) {
      say_told();
      if (writes_) say_whole(at, faulty);
      return done + 1;
    }
    ++done;
    if (says_interactions_) fired_.add({&at.interaction.value, 1});
    if (!writes_ || says_interactions_) continue;
    const u64 out_number = cut_number(text_.out), trace_number = cut_number(text_.trace);
    numbers.insert(numbers.end(),
                   {at.interaction.value, out_number, trace_number, text_.out.size(), text_.trace.size()});
    told.out += text_.out;
    told.trace += text_.trace;
  }
  say_told();
  return done;
}

// Of steps of which nothing else is written: the last `count` of fired_, with the number that all of it has.
void NodeProcess::note_fired(u64 step, u64 count) {
  const bool is_first = fired_.count() == count;
  BIP_ASSERT(is_first || step == fired_step_, "step {} beside steps {}", step, fired_step_);
  fired_step_ = step;
  unwritten_.add(step, is_first ? fired_bytes(count) : sizeof(InteractionId) * count);
  has_unsent_ = true;
  if (fired_.size() >= kMostText) say_fired();
}

// Before anything else is said, and before anything is heard.
void NodeProcess::say_fired() {
  if (fired_.count() == 0) return;
  std::vector<u64> numbers{fired_step_, fired_.count()};
  say(Control::Kind::Fired, std::move(numbers), {fired_.take()});
}

// Of a step that was taken as a whole.
void NodeProcess::say_whole(EnabledSet::Position at, u64 step) {
  atoms_.clear();
  node_.note_landed(at.interaction, step, atoms_);
  say_begun(at, step, false);
}

// Of the step that was described: where its parts are.
void NodeProcess::say_begun(EnabledSet::Position at, u64 step, bool is_evaluated) {
  std::vector<u64> numbers{step, at.interaction.value};
  if (is_followed_) numbers.insert(numbers.end(), {at.rank, 0});
  else numbers.insert(numbers.end(), {cut_number(text_.out), cut_number(text_.trace)});
  for (const u32 atom : atoms_) numbers.push_back(setup_.distribution.home(atom));
  if (is_evaluated) numbers.push_back(setup_.self);
  unwritten_.add(step, record_bytes(text_));
  say(Control::Kind::Begun, std::move(numbers), {std::move(text_.out), std::move(text_.trace)});
}

// Chooses what begins next: what is locked, what was drawn before, or anew. False: nothing can.
bool NodeProcess::has_chosen(EnabledSet::Position& at) {
  Core& core = node_.core();
  const InteractionId drawn = std::exchange(drawn_, {});
  const InteractionId locked = node_.locked_interaction();
  if (locked.is_valid()) {
    at = scheduler_.choose_of(core, locked);
    return true;
  }
  if (!drawn.is_valid() || core.enabled().weight(drawn) == 0) return time_.choose(scheduler_, core, at);
  at = scheduler_.choose_of(core, drawn);
  return Scheduler::find_decided(core, at);
}

bool NodeProcess::has_begun() {
  EnabledSet::Position at{};
  if (!may_begin()) return false;
  if (takes_many() && has_taken_many()) {
    wants_ = false;
    if (!node_.outbox().empty()) post();
    return true;
  }
  wants_ = has_chosen(at);
  if (!wants_) return false;
  if (credit_ == 0) {
    if (!has_asked_) say(Control::Kind::Want, {});
    has_asked_ = true;
    return false;
  }
  wants_ = false;
  if (credit_ != ~u64{0}) --credit_;
  const u64 step = step_at(station_.tick_clock(), setup_.self);
  describe(at);
  scheduler_.fired(at.interaction);
  time_.fired(at.interaction);
  atoms_.clear();
  bool is_evaluated = false;
  if (is_quick_ && node_.is_whole(at.interaction)) {
    node_.take_whole(at, step);
    if (writes_) node_.note_landed(at.interaction, step, atoms_);
    if (watch_) watch_->note_steps();
  } else {
    is_evaluated = node_.begin(at, step, atoms_);
    const bool is_border = std::any_of(atoms_.begin(), atoms_.end(),
                                       [&](u32 atom) { return setup_.distribution.home(atom) != setup_.self; });
    border_steps_ += is_border ? 1 : 0;
  }
  ++steps_;
  if (writes_) say_begun(at, step, is_evaluated);
  if (!node_.outbox().empty()) post();
  return true;
}

// In the state before the step, unless what is written about it is made elsewhere.
void NodeProcess::describe(EnabledSet::Position at) {
  if (!writes_ || is_followed_) return;
  text_.out.clear();
  text_.trace.clear();
  setup_.output.describe(text_, node_.core(), at, kStepToCome, kNoChoice);
}

// Hands over what the node says. A fault comes before the news that its step has ended, so that no later step is
// written.
void NodeProcess::post() {
  report_fault();
  if (writes_ && !node_.landed().empty()) say(Control::Kind::Landed, node_.landed());
  node_.landed().clear();
  if (node_.outbox().empty()) return;
  say_fired();
  const Link& launcher = station_.link(launcher_);
  // The one with the last message that it is to have.
  const std::size_t unsaid = launcher.unsaid();
  const u64 frame = launcher.next_number() + (unsaid + Link::kMostMessages - 1) / Link::kMostMessages - 1;
  for (Outgoing& outgoing : node_.outbox()) {
    ++sent_[outgoing.to];
    has_mail_ = has_unsent_ = true;
    if (holds_) held_.push_back({frame, std::move(outgoing)});
    else station_.say(outgoing.to, std::move(outgoing.message));
  }
  node_.outbox().clear();
}

void NodeProcess::release_held() {
  const u64 confirmed = station_.link(launcher_).confirmed();
  while (!held_.empty() && held_.front().frame <= confirmed) {
    station_.say(held_.front().outgoing.to, std::move(held_.front().outgoing.message));
    held_.pop_front();
    has_unsent_ = true;
  }
}

void NodeProcess::report_fault() {
  const PartialState& state = *node_.core().partial().state();
  if (!state.fault || (state.fault_step == fault_step_ && state.fault_order == fault_order_)) return;
  fault_step_ = state.fault_step;
  fault_order_ = state.fault_order;
  say_fired();
  station_.say(launcher_, fault_message(fault_step_, fault_order_, state.fault));
  has_unsent_ = true;
}

void NodeProcess::free_strings() {
  // Actions that run beside the others have copies of their atoms' cells.
  if (!node_.core().actions().working().empty()) return;
  LiveStrings live;
  const auto add = [&live](const std::vector<u64>& cells) { live.add(cells); };
  live.add(node_.core());
  live.add(initial_->data.rows());
  node_.visit_kept_cells(add);
  station_.visit_kept_cells(add);
  for (const Held& held : held_) visit_cells(held.outgoing.message, add);
  live.keep_only(*setup_.image.ffi);
}

u64 NodeProcess::sum_of_open(const std::vector<u64>& counts) {
  u64 sum = 0;
  for (u32 peer = 0; peer < launcher_; ++peer) sum += station_.link(peer).is_closed() ? 0 : counts[peer];
  return sum;
}

// Of a node that rests for a while: what the launcher must know to tell the end of the run.
void NodeProcess::report(i64 now) {
  if (node_.has_parked() || is_full_) {
    is_idle_ = false;
    idle_since_ = 0;
    return;
  }
  if (is_idle_) {
    if (idle_since_ == 0 || now - idle_since_ < quiet_) return;
    idle_since_ = 0;
    return say(Control::Kind::Idle, {sum_of_open(sent_), sum_of_open(received_), station_.clock(), steps_, credits_});
  }
  is_idle_ = true;
  idle_since_ = now;
}

void NodeProcess::count(u64 round) {
  say(Control::Kind::Counted,
      {round, sum_of_open(sent_), sum_of_open(received_), is_idle_ && held_.empty() ? 1u : 0u, credits_});
}

void NodeProcess::say_state() {
  say_fired();
  State last = *initial_;
  SavedTime time;
  node_.save(last, time);
  const Tables& tables = node_.core().tables();
  for (u32 atom = 0; atom < setup_.image.atoms.size; ++atom) {
    if (setup_.distribution.home(atom) != setup_.self) continue;
    Control told{Control::Kind::Atom, {atom, last.places[atom]}, {}};
    const u32 words = tables.types[tables.atoms[atom].type].mark_words;
    for (u32 i = 0; i < words; ++i) told.numbers.push_back(last.marks[tables.first_mark(atom) + i]);
    told.numbers.push_back(node_.history(atom));
    told.numbers.push_back(node_.is_locked(atom) ? 1 : 0);
    const u32 variables = tables.atom_type(atom).variables.size;
    std::string values;
    ByteWriter writer(values);
    for (u32 i = 0; i < variables; ++i) {
      const VariableId cell = tables.atoms[atom].first_cell + i;
      codec_.write_cell(writer, cell, last.data[cell]);
    }
    told.texts.push_back(std::move(values));
    if (node_.core().is_timed()) {
      ByteWriter clocks(told.texts.emplace_back());
      append_clocks(clocks, atom, time);
    }
    station_.say(launcher_, std::move(told));
  }
}

// The instant, the atom's clocks, and how its action beside the others began.
void NodeProcess::append_clocks(ByteWriter& writer, u32 atom, const SavedTime& time) {
  writer.number(static_cast<u64>(time.now));
  writer.number(time.clocks[atom].size());
  for (const i64 word : time.clocks[atom]) writer.number(static_cast<u64>(word));
  for (const SavedTime::Beside& beside : time.beside) {
    if (beside.words[0] != i64{atom}) continue;
    writer.number(beside.step);
    writer.number(beside.order);
    for (const i64 word : beside.words) writer.number(static_cast<u64>(word));
  }
}

// Without what `bipc node` did before the run: loading, compiling, waiting for the others.
u64 NodeProcess::cpu_spent() const { return cpu_microseconds() - cpu_before_; }

void NodeProcess::say_last_state() {
  say_state();
  const NodeCounts& counts = node_.counts();
  const StationCounts& station = station_.counts();
  say(Control::Kind::Finished, {steps_, border_steps_, counts.offers, counts.begins, station.frames, station.again,
                                station.bytes, station.refused + counts.refused + fabric_.counts().refused, cpu_spent(),
                                counts.locks, counts.releases, counts.wakes});
  is_finished_ = true;
}

}  // namespace bip::rt
