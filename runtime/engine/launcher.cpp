// See launcher.hpp.
#include "runtime/engine/launcher.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <random>

#include "bip/assert.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/distributed/station.hpp"
#include "runtime/engine/checkpoints.hpp"
#include "runtime/engine/collect_strings.hpp"
#include "runtime/engine/fault_message.hpp"
#include "runtime/engine/gathering.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/engine/loss_story.hpp"
#include "runtime/engine/node_process.hpp"
#include "runtime/engine/node_time.hpp"
#include "runtime/engine/node_team.hpp"
#include "runtime/engine/silence_watch.hpp"
#include "runtime/engine/step_merge.hpp"
#include "runtime/engine/told_state.hpp"
#include "runtime/engine/unwritten_steps.hpp"
#include "runtime/engine/waker.hpp"

namespace bip::rt {

namespace {

constexpr i64 kStale = 20000000;       // ns that a step may wait for nodes to say that they have no earlier one
constexpr i64 kAskAgain = 5000000;     // ns until credit is asked for again
constexpr i64 kPatience = 3000000000;  // ns for nodes to end their actions after Ctrl-C
constexpr u64 kInfinite = ~u64{0};

enum class RunPhase : std::uint8_t { Running, Counting, Telling, Limiting, Planning, Ending };

// What the launcher knows of a node, by the node's messages. Credit is the number of steps that a node may begin.
struct Member {
  bool is_there = false;       // it has joined the run
  bool is_lost = false;        // its process has ended, or its host is silent for too long
  bool has_finished = false;   // it has sent its last state
  bool is_idle = false;        // it rests: it has nothing to do until a message comes
  bool wants = false;          // it could begin a step, and has no credit
  bool owes_credit = false;    // it was asked to give credit back, and has not answered
  bool has_counted = false;    // it has answered in this round of counting messages
  bool has_told = false;       // it has sent its state for this checkpoint
  bool has_answered = false;   // it has answered the question about time that was asked last
  u64 sent = 0, received = 0;  // messages to and from other nodes
  u64 steps = 0;               // that it began
  u64 cpu = 0;                 // microseconds, as last heard
  u64 granted = 0;             // credit that it was given, without what it gave back
  u64 credits = 0;             // number of messages that gave it credit
};

class Launcher {
 public:
  Launcher(Core& core, const Distribution& distribution, const RunOptions& options, u64 seed, Output& output,
           u64 resumed)
      : core_(core),
        distribution_(distribution),
        options_(options),
        seed_(seed),
        output_(output),
        writes_(output.writes_steps()),
        run_(draw_run()),
        codec_(core.tables(), distribution, run_),
        told_(core, distribution, codec_),
        merge_(core, distribution, output),
        plans_(plans_instants(core, options)),
        now_(core.now()),
        members_(distribution.placement.nodes.size()),
        checkpoints_(options, resumed) {}

  DistributedResult run() {
    const State initial = core_.snapshot();
    told_.start(initial);
    const bool is_followed = can_follow_steps(core_, output_);
    const i64 began = wall_clock();
    if (!open(initial)) {
      if (result_.error.empty()) result_.end = End::Interrupted;
      return std::move(result_);
    }
    if (is_followed) merge_.follow(initial);
    share_out();
    beat_at_ = began + kBeat;
    began_ = began;
    silences_.emplace(static_cast<u32>(members_.size()), wall_clock());
    while (!has_ended()) {
      const i64 now = wall_clock();
      advance(now);
      i64 due = std::min({station_->due(), next_due(), beat_at_, checkpoint_due()});
      arrivals_.clear();
      if (gathering_) due = std::min(due, gathering_->due());
      const bool any_ended =
          fabric_->wait(static_cast<int>((std::max<i64>(due - now, 0) + 999999) / 1000000), team_.files(), arrivals_);
      const i64 woken = wall_clock();
      heard_.clear();
      for (const Arrival& arrival : arrivals_) {
        if (gathering_ && is_greeting(arrival.bytes)) take_greeting(arrival);
        else station_->take(arrival, woken, heard_);
      }
      for (const ReceivedMessage& heard : heard_) take(heard, woken);
      if (any_ended) take_ended();
      if (result_.started == 0 &&
          std::all_of(members_.begin(), members_.end(), [](const Member& m) { return m.is_there; }))
        result_.started = woken - began;
    }
    station_->send(wall_clock());
    end(initial);
    // All of their messages have arrived, so the nodes may end.
    const u64 ended = static_cast<u64>(result_.lost_nodes.empty() ? result_.end : End::Interrupted);
    say_all(Control::Kind::Finish, {ended, result_.steps});
    station_->send(wall_clock());
    if (gathering_) wait_for_confirmations();
    team_.wait_for_all(1000);
    return std::move(result_);
  }

 private:
  static u64 draw_run() {
    std::random_device device;
    return (u64{device()} << 32 | device()) >> 1;
  }

  // ---- the beginning

  bool open(const State& initial) {
    const u32 nodes = static_cast<u32>(members_.size());
    BIP_ENSURE(options_.fabrics != nullptr, "a run without a network was refused");
    const auto live = [&](u32 node, const FabricPlan& plan) {
      const Result<std::unique_ptr<Fabric>> fabric = options_.fabrics->open(plan);
      if (!fabric) {
        std::fprintf(stderr, "error: node `%s`: %s\n", distribution_.placement.nodes[node].c_str(),
                     fabric.error().c_str());
        return 1;
      }
      const NodeSetup setup{core_.image(), core_.parts().options, distribution_, node, run_, seed_, options_, output_};
      return NodeProcess(setup, **fabric).run(initial) ? 0 : 1;
    };
    const Deployment* const deployment = options_.deployment;
    result_.error = deployment == nullptr ? team_.start(nodes, *options_.fabrics, live)
                                          : team_.start_first(launcher_plan(*deployment),
                                                              [&] { return live(0, node_plan(*deployment)); });
    if (!result_.error.empty()) return false;
    Result<std::unique_ptr<Fabric>> fabric = options_.fabrics->open(team_.plan());
    if (!fabric) {
      result_.error = fabric.error();
      return false;
    }
    fabric_ = std::move(*fabric);
    if (deployment != nullptr && !gather(*deployment)) return false;
    station_ = std::make_unique<Station>(*fabric_, codec_, nodes, nodes);
    // With --on-loss=go-on and a trace, a node holds its messages to other nodes until the launcher has confirmed the
    // steps that they depend on: a confirmation that waits for other messages would delay all of them.
    if (writes_ && options_.on_loss == OnLoss::GoOn) station_->answer_at_once();
    for (u32 node = 0; node < nodes; ++node) station_->greet(node);
    return true;
  }

  // Waits until all nodes are there. False: interrupted, or the node beside this one has ended.
  bool gather(const Deployment& deployment) {
    gathering_ = std::make_unique<Gathering>(deployment, *fabric_, welcome());
    while (!gathering_->is_complete()) {
      const i64 now = wall_clock();
      gathering_->tick(now);
      arrivals_.clear();
      const i64 wait = std::max<i64>(gathering_->due() - now, 0) / 1000000 + 1;
      if (fabric_->wait(static_cast<int>(wait), team_.files(), arrivals_)) {
        result_.error = "node `" + deployment.names[0] + "` has ended before the run began";
        return false;
      }
      for (const Arrival& arrival : arrivals_) (void)gathering_->take(arrival, wall_clock());
      if (is_interrupted()) return false;
    }
    gathering_->welcome(wall_clock());
    return true;
  }

  [[nodiscard]] Greeting welcome() const {
    return {.kind = Greeting::Kind::Welcome,
            .number = run_,
            .model = options_.deployment->model,
            .seed = seed_,
            .policy = static_cast<u32>(options_.policy),
            .format = static_cast<u32>(options_.format),
            .is_silent = options_.silent,
            .is_traced = !options_.trace_path.empty(),
            .goes_on = options_.on_loss == OnLoss::GoOn,
            .has_maximal_progress = options_.maximal_progress,
            .is_asap = options_.asap};
  }

  void take_greeting(const Arrival& arrival) {
    const std::string gone = gathering_->take(arrival, wall_clock());
    if (!gone.empty() && !members_[arrival.from].has_finished) lose(arrival.from, gone);
  }

  // A node on another host is lost when it is silent for too long. The end of a process of this machine is observed.
  [[nodiscard]] bool is_remote(u32 node) const { return options_.deployment != nullptr && node != 0; }

  void look_for_silence(i64 now) {
    silences_->begin_look(now);
    for (u32 node = 0; node < members_.size(); ++node) {
      if (members_[node].is_lost || members_[node].has_finished) continue;
      const i64 heard = station_->last_heard(node);
      const std::string seconds = std::to_string(silences_->silence(heard) / kBeat) + " s";
      switch (silences_->sign(node, heard, is_remote(node) ? options_.lost_after : kForever)) {
        case Sign::Same: break;
        case Sign::Silent: tell_silence(node, seconds); break;
        case Sign::Heard: tell("node `" + distribution_.placement.nodes[node] + "` is heard again"); break;
        case Sign::Lost: lose(node, "gave no sign for " + seconds); break;
      }
    }
  }

  void tell_silence(u32 node, const std::string& seconds) const {
    std::string text = "node `" + distribution_.placement.nodes[node] + "` gives no sign for " + seconds;
    if (!is_remote(node)) text += ": " + team_.state_of(node);
    tell(text + '\n' + silence_story(core_, distribution_, node));
  }

  static void tell(const std::string& text) {
    std::fprintf(stderr, "bipc: %s%s", text.c_str(), text.back() == '\n' ? "" : "\n");
    std::fflush(stderr);
  }

  void wait_for_confirmations() {
    const i64 until = wall_clock() + kBeat;
    for (i64 now = wall_clock(); now < until; now = wall_clock()) {
      bool are_confirmed = true;
      for (u32 node = 0; node < members_.size(); ++node)
        are_confirmed = are_confirmed && (members_[node].is_lost || station_->link(node).unconfirmed().empty());
      if (are_confirmed) return;
      arrivals_.clear();
      heard_.clear();
      (void)fabric_->wait(static_cast<int>((until - now) / 1000000 + 1), {}, arrivals_);
      for (const Arrival& arrival : arrivals_) station_->take(arrival, wall_clock(), heard_);
      station_->tick(wall_clock());
    }
  }

  void say(u32 node, Control::Kind kind, std::vector<u64> numbers = {}) {
    if (!members_[node].is_lost) station_->say(node, Control{kind, std::move(numbers), {}});
  }
  void say_all(Control::Kind kind, const std::vector<u64>& numbers = {}) {
    for (u32 node = 0; node < members_.size(); ++node) say(node, kind, numbers);
  }

  // ---- credit: how many steps may begin

  [[nodiscard]] bool is_limited() const { return options_.limit != kInfinite; }

  // A node that reports that it rests says how many messages with credit had reached it by then. If one more is on its
  // way, the node will go on, and does not count as idle.
  static bool has_all_credit(const Member& member, u64 credits) { return credits == member.credits; }

  void grant(u32 node, u64 credit) {
    if (credit == 0) return;
    say(node, Control::Kind::Credit, {credit});
    members_[node].granted += credit;
    ++members_[node].credits;
    members_[node].wants = members_[node].is_idle = false;
    pool_ -= credit;
  }

  void share_out() {
    if (!is_limited()) {
      for (Member& member : members_) ++member.credits;
      return say_all(Control::Kind::Credit, {kInfinite});
    }
    pool_ = options_.limit;
    const u64 share = pool_ / (2 * members_.size());
    for (u32 node = 0; node < members_.size(); ++node) grant(node, share);
  }

  void serve_wants(i64 now) {
    if (!is_limited() || is_halted_ || is_pausing_) return;
    bool is_wanted = false;
    for (u32 node = 0; node < members_.size(); ++node) {
      if (!members_[node].wants || members_[node].is_lost) continue;
      if (pool_ != 0) grant(node, std::max<u64>(1, pool_ / (2 * members_.size())));
      else is_wanted = true;
    }
    // A node wants credit and none is left: the other nodes give back what they do not need.
    if (!is_wanted || ask_at_ > now) return;
    ask_at_ = now + kAskAgain;
    for (u32 node = 0; node < members_.size(); ++node) {
      Member& member = members_[node];
      if (member.is_lost || member.wants || member.owes_credit || member.granted == 0) continue;
      if (member.is_idle && member.granted == member.steps) continue;
      member.owes_credit = true;
      say(node, Control::Kind::Recall);
    }
  }

  // ---- what nodes say

  void take(const ReceivedMessage& heard, i64 now) {
    const auto* const control = std::get_if<Control>(&heard.message);
    if (control == nullptr || members_[heard.from].is_lost) return;
    Member& member = members_[heard.from];
    const std::vector<u64>& numbers = control->numbers;
    const auto number = [&](std::size_t k) { return k < numbers.size() ? numbers[k] : 0; };
    switch (control->kind) {
      case Control::Kind::Ready:
        member.is_there = true;
        if (gathering_) gathering_->note_in_run(heard.from);
        return;
      case Control::Kind::Idle:
        member.is_idle = has_all_credit(member, number(4));
        member.sent = number(0);
        member.received = number(1);
        member.steps = number(3);
        merge_.raise_bound(heard.from, bound_of(number(2)));
        is_changed_ = true;
        return;
      case Control::Kind::Want:
        member.wants = true;
        ask_at_ = 0;
        return serve_wants(now);
      case Control::Kind::Beat:
        merge_.raise_bound(heard.from, bound_of(number(0)));
        member.steps = number(1);
        member.cpu = number(2);
        return;
      case Control::Kind::Counted:
        if (number(0) != round_) return;
        member.has_counted = true;
        member.sent = number(1);
        member.received = number(2);
        if (number(3) == 0 || !has_all_credit(member, number(4))) member.is_idle = false;
        return end_round();
      case Control::Kind::Return: {
        const u64 given = std::min(number(0), member.granted);
        member.granted -= given;
        member.owes_credit = false;
        pool_ += given;
        is_changed_ = true;
        return serve_wants(now);
      }
      case Control::Kind::Begun:
        member.is_idle = false;
        ++member.steps;
        if (writes_ && !merge_.take_begun(heard.from, *control)) ++odd_;
        return;
      case Control::Kind::Took:
      case Control::Kind::Fired: {
        member.is_idle = false;
        u64 steps = 0;
        if (writes_) {
          steps = control->kind == Control::Kind::Took ? merge_.take_many(heard.from, *control)
                                                       : merge_.take_fired(heard.from, *control);
        }
        member.steps += steps;
        if (steps == 0) ++odd_;
        return;
      }
      case Control::Kind::Landed:
        if (writes_) merge_.take_landed(heard.from, numbers);
        return;
      case Control::Kind::Fault: return take_fault(*control);
      case Control::Kind::Atom:
        if (!told_.take(heard.from, *control)) ++odd_;
        return;
      case Control::Kind::Told: member.has_told = true; return save_checkpoint(now);
      case Control::Kind::Limited:
      case Control::Kind::Planned: return take_time(member, *control);
      case Control::Kind::Finished:
        member.has_finished = true;
        member.steps = number(0);
        result_.border_steps += number(1);
        result_.offers += number(2);
        result_.begins += number(3);
        result_.network.frames += number(4);
        result_.network.again += number(5);
        result_.bytes += number(6);
        result_.refused += number(7);
        member.cpu = number(8);
        result_.locks += number(9);
        result_.releases += number(10);
        result_.wakes += number(11);
        return;
      case Control::Kind::Credit:
      case Control::Kind::Recall:
      case Control::Kind::Count:
      case Control::Kind::Lost:
      case Control::Kind::Halt:
      case Control::Kind::Pause:
      case Control::Kind::Tell:
      case Control::Kind::GoOn:
      case Control::Kind::Limit:
      case Control::Kind::Plan:
      case Control::Kind::Instant:
      case Control::Kind::Written:
      case Control::Kind::Finish: return;
    }
  }

  static u64 bound_of(u64 clock) { return step_at(clock, kMostNodes - 1); }

  void take_fault(const Control& control) {
    std::optional<FaultOfStep> told = read_fault_message(control, core_.image());
    if (!told) return;
    if (has_fault_ && (fault_step_ < told->step || (fault_step_ == told->step && fault_order_ <= told->order))) return;
    has_fault_ = true;
    fault_step_ = told->step;
    fault_order_ = told->order;
    fault_ = std::move(told->fault);
  }

  // ---- losses

  void take_ended() {
    for (const EndedNode& ended : team_.take_ended()) {
      if (!members_[ended.node].has_finished) lose(ended.node, ended.how);
    }
  }

  void lose(u32 node, const std::string& how) {
    Member& member = members_[node];
    if (member.is_lost) return;
    if (!has_lost_) lost_after_ = writes_ ? merge_.written() : steps();
    has_lost_ = true;
    if (gathering_) tell("node `" + distribution_.placement.nodes[node] + "` is lost: " + how);
    how_ += (how_.empty() ? ": " : "; ") + ('`' + distribution_.placement.nodes[node] + "` " + how);
    member.is_lost = true;
    station_->close(node);
    merge_.lose(node);
    if (options_.on_loss == OnLoss::Stop) {
      // Later steps may depend on a step that the lost node began and could not report, so none of them is written.
      cut_ = std::min(cut_, merge_.bound(node));
      halt();
    } else if (is_limited()) {
      pool_ += member.granted - std::min(member.granted, member.steps);
    }
    say_all(Control::Kind::Lost, {node});
    if (is_pausing_) say_all(Control::Kind::GoOn);
    is_pausing_ = false;
    phase_ = phase_ == RunPhase::Ending ? RunPhase::Ending : RunPhase::Running;
    limit_ = {};
    planned_ = kForever;
    is_changed_ = true;
  }

  void halt() {
    if (is_halted_) return;
    is_halted_ = true;
    is_pausing_ = false;
    for (Member& member : members_) member.is_idle = false;
    say_all(Control::Kind::Halt);
  }

  // ---- the end

  // Of all that are there.
  template <class Predicate>
  [[nodiscard]] bool all(const Predicate& predicate) const {
    return std::all_of(members_.begin(), members_.end(),
                       [&](const Member& member) { return member.is_lost || predicate(member); });
  }

  [[nodiscard]] bool is_balanced() const {
    u64 sent = 0, received = 0;
    for (const Member& member : members_) {
      if (member.is_lost) continue;
      sent += member.sent;
      received += member.received;
    }
    return sent == received;
  }

  // Returns whether a node that wants credit can still get some: what is left, or what another node gives back.
  [[nodiscard]] bool is_credit_coming() const {
    if (!is_limited() || is_halted_ || is_pausing_ || has_fault_ ||
        all([](const Member& member) { return !member.wants; }))
      return false;
    return pool_ != 0 || !all([](const Member& member) { return member.granted == member.steps; });
  }

  void advance(i64 now) {
    if (is_interrupted() && !is_interrupted_) {
      is_interrupted_ = true;
      patience_until_ = now + kPatience;
      halt();
    }
    if (now >= patience_until_) {
      for (u32 node = 0; node < members_.size(); ++node) {
        if (!members_[node].has_finished) lose(node, "was at work for too long");
      }
    }
    if (gathering_) gathering_->tick(now);
    look_for_silence(now);
    if (phase_ == RunPhase::Running && !is_pausing_ && !is_halted_ && !has_lost_ && !has_fault_ &&
        checkpoints_.take_due(now - began_))
      pause();
    serve_wants(now);
    if (phase_ == RunPhase::Running && is_changed_ && !is_credit_coming() && is_balanced() &&
        all([](const Member& member) { return member.is_idle; }))
      begin_round();
    is_changed_ = false;
    if (writes_) write(now);
    if (now >= beat_at_) {
      say_all(Control::Kind::Beat);
      beat_at_ = now + kBeat;
    }
    station_->send(now);
    station_->tick(now);
  }

  void begin_round() {
    phase_ = RunPhase::Counting;
    ++round_;
    first_sum_ = sum_of_sent();
    for (Member& member : members_) member.has_counted = false;
    say_all(Control::Kind::Count, {round_});
  }

  [[nodiscard]] u64 sum_of_sent() const {
    u64 sum = 0;
    for (const Member& member : members_) sum += member.is_lost ? 0 : member.sent;
    return sum;
  }

  void end_round() {
    if (phase_ != RunPhase::Counting || !all([](const Member& member) { return member.has_counted; })) return;
    const bool is_over = all([](const Member& member) { return member.is_idle; }) && is_balanced() &&
                         sum_of_sent() == first_sum_ && !is_credit_coming();
    // Nodes that rest have reported it already and do not report it again, so the next look must not wait for a report.
    is_changed_ = true;
    if (is_over && is_pausing_ && !has_fault_) {
      phase_ = RunPhase::Telling;
      for (Member& member : members_) member.has_told = false;
      told_.begin();
      return say_all(Control::Kind::Tell);
    }
    if (is_over && may_pass_time()) {
      phase_ = RunPhase::Limiting;
      return ask_of_time(Control::Kind::Limit, {});
    }
    phase_ = is_over ? RunPhase::Ending : RunPhase::Running;
    if (is_over) say_all(Control::Kind::Finish);
  }

  // ---- time; it passes when all nodes rest and no message is on its way

  [[nodiscard]] bool may_pass_time() const {
    // The atoms of a lost node count as at work for ever, and time cannot pass while an atom is at work.
    return core_.is_timed() && !has_fault_ && !has_lost_ && !is_halted_ && steps() != options_.limit;
  }

  void ask_of_time(Control::Kind kind, const std::vector<u64>& numbers) {
    for (Member& member : members_) member.has_answered = false;
    say_all(kind, numbers);
  }

  void take_time(Member& member, const Control& control) {
    const bool are_limits = control.kind == Control::Kind::Limited;
    if (phase_ != (are_limits ? RunPhase::Limiting : RunPhase::Planning) || member.has_answered) return;
    if (control.numbers.size() != (are_limits ? 2u : 1u)) return;
    const auto instant = [&](std::size_t k) {
      return static_cast<i64>(std::min(control.numbers[k], static_cast<u64>(kForever)));
    };
    member.has_answered = true;
    if (are_limits) limit_.meet({instant(0), instant(1)});
    else planned_ = std::min(planned_, instant(0));
    if (!all([](const Member& each) { return each.has_answered; })) return;
    if (are_limits && plans_) {
      phase_ = RunPhase::Planning;
      return ask_of_time(Control::Kind::Plan, {static_cast<u64>(limit_.last)});
    }
    pass_time();
  }

  void pass_time() {
    const i64 next = std::min(limit_.change, planned_);
    // A planned step is possible at the node that planned it, and only a step of that node or a later instant can
    // change that. So if the same instant comes twice with no step in between, it would come for ever.
    stands_still_ = may_pass_time() && next == now_ && steps() == steps_at_again_;
    const bool is_over = !may_pass_time() || next == kForever || next > limit_.last || stands_still_;
    steps_at_again_ = next == now_ ? steps() : ~u64{0};
    limit_ = {};
    planned_ = kForever;
    is_changed_ = true;
    phase_ = is_over ? RunPhase::Ending : RunPhase::Running;
    if (is_over) return say_all(Control::Kind::Finish);
    if (next != now_) instant_step_ = step_at(station_->tick_clock(), kMostNodes - 1);
    now_ = next;
    for (Member& member : members_) member.is_idle = false;
    say_all(Control::Kind::Instant, {static_cast<u64>(next), instant_step_});
  }

  // ---- checkpoints: nothing begins, all rest as at the end, all tell their states, and go on

  [[nodiscard]] i64 checkpoint_due() const {
    const i64 due = checkpoints_.due();
    return is_pausing_ || due > kForever - began_ ? kForever : began_ + due;
  }

  void pause() {
    is_pausing_ = true;
    for (Member& member : members_) member.is_idle = false;
    say_all(Control::Kind::Pause);
  }

  void save_checkpoint(i64 now) {
    if (phase_ != RunPhase::Telling || !all([](const Member& member) { return member.has_told; })) return;
    checkpoints_.write(core_, told_.checkpoint(steps()));
    if (wants_collection(core_.image())) free_strings();
    phase_ = RunPhase::Running;
    is_pausing_ = false;
    for (Member& member : members_) member.is_idle = false;
    say_all(Control::Kind::GoOn);
    serve_wants(now);
  }

  // Frees the strings that only states of earlier checkpoints hold. The core, which stays in the initial state until
  // the end of the run, keeps its own.
  void free_strings() {
    LiveStrings live;
    live.add(core_);
    live.add(told_.state().data.rows());
    live.keep_only(*core_.image().ffi);
  }

  [[nodiscard]] bool has_ended() const {
    return all([](const Member& member) { return member.has_finished; });
  }

  [[nodiscard]] i64 next_due() const {
    i64 due = patience_until_;
    if (writes_ && stale_at_ != 0) due = std::min(due, stale_at_);
    const bool is_wanted = !all([](const Member& member) { return !member.wants; });
    if (is_limited() && is_wanted && !is_halted_ && phase_ == RunPhase::Running && is_credit_coming())
      due = std::min(due, ask_at_);
    return due;
  }

  // Writes the steps that can be written. If some have waited for a while, asks the nodes that have not reported a
  // number as large as theirs for their clocks: a node that rests reports nothing by itself.
  void write(i64 now) {
    if (!has_fault_ && cut_ == ~u64{0}) merge_.write_ready();
    if (!merge_.is_sound()) halt();
    // Nodes begin nothing while too many of their steps are unwritten, so they must hear what is written
    // (unwritten_steps.hpp).
    if (merge_.written_bytes() - told_bytes_ >= written_to_tell(members_.size())) {
      told_bytes_ = merge_.written_bytes();
      say_all(Control::Kind::Written, {merge_.last_written()});
    }
    if (merge_.waiting() == 0 || phase_ == RunPhase::Ending) {
      stale_at_ = 0;
      return;
    }
    if (stale_at_ == 0) stale_at_ = now + kStale;
    if (now < stale_at_) return;
    stale_at_ = now + kStale;
    const u64 step = merge_.first_waiting();
    for (u32 node = 0; node < members_.size(); ++node) {
      if (merge_.bound(node) < step) say(node, Control::Kind::Beat);
    }
  }

  [[nodiscard]] u64 steps() const {
    u64 sum = 0;
    for (const Member& member : members_) sum += member.steps;
    return sum;
  }

  void end(const State& initial) {
    add_own_counts();
    for (const Member& member : members_) result_.use.push_back({member.steps, member.cpu, member.is_lost});
    result_.checkpoints = checkpoints_.count();
    result_.checkpoint = checkpoints_.steps();
    result_.most_waiting_bytes = merge_.most_waiting_bytes();
    const State last = told_.finish();
    if (writes_) merge_.write_until(has_fault_ ? fault_step_ : cut_);
    if (!merge_.is_sound()) {
      // A step of a lost node may have ended in an error that the node could not report.
      return end_with_nonsense(merge_.has_met_fault()
                                   ? "a step ended in a run-time error of which its node did not tell"
                                   : "they told of a step that is none of the model",
                               initial);
    }
    if (has_fault_) {
      result_.end = End::Fault;
      // The step with the fault is not counted. A fault that the passing of time brings is that of no step.
      const u64 faulty = instant_step_ != 0 && fault_step_ == instant_step_ ? 0 : 1;
      result_.steps = writes_ ? std::max<u64>(merge_.written(), faulty) - faulty : steps();
      (void)core_.restore(last);
      core_.fail(fault_);
      return;
    }
    result_.steps = writes_ ? merge_.written() : steps();
    const bool is_sound = core_.restore(last);
    if (has_lost_) return end_with_loss(is_sound, initial);
    // C++ objects stay at the homes of their components, so this process cannot evaluate what depends on them.
    const bool is_known = last.objects.empty();
    if (!is_sound && is_known) return end_with_nonsense("they told of a state that ends in a run-time error", initial);
    if (result_.steps == options_.limit) result_.end = End::Limit;
    else if (is_interrupted_) result_.end = End::Interrupted;
    else if (is_time_locked(core_)) result_.end = End::Fault;
    else result_.end = end_without_step(core_);
    const bool is_over = result_.end == End::Limit || result_.end == End::Interrupted || core_.candidate_count() == 0;
    if (stands_still_) return end_with_nonsense("they plan steps for an instant and begin none", initial);
    if (is_known && !is_over) end_with_nonsense("they rest in a state in which a step is possible", initial);
  }

  // The nodes contradict each other or the model, which correct nodes never do: the run ends with an error.
  void end_with_nonsense(const char* what, const State& initial) {
    result_.error = std::string("the nodes do not say what happened: ") + what;
    BIP_ENSURE(core_.restore(initial), "the initial state has no fault");
  }

  void add_own_counts() {
    const StationCounts& own = station_->counts();
    result_.network.frames += own.frames;
    result_.network.again += own.again;
    result_.bytes += own.bytes;
    result_.refused += own.refused + odd_ + fabric_->counts().refused;
  }

  void end_with_loss(bool is_sound, const State& initial) {
    result_.end = result_.steps == options_.limit ? End::Limit : End::Interrupted;
    if (!is_sound) BIP_ENSURE(core_.restore(initial), "the initial state has no fault");
    std::vector<bool> lost;
    for (const Member& member : members_) lost.push_back(member.is_lost);
    std::string& story = result_.end == End::Limit ? result_.warning : result_.lost_nodes;
    story = loss_story(core_, distribution_, Survivors(core_, distribution_, std::move(lost)), told_.locked(),
                       lost_after_, how_);
    core_.partial().allow();
  }

  Core& core_;
  const Distribution& distribution_;
  const RunOptions& options_;
  u64 seed_;
  Output& output_;
  bool writes_;
  u64 run_;
  Codec codec_;
  ToldState told_;
  StepMerge merge_;
  bool plans_;  // instants of steps
  i64 now_;     // the instant
  std::vector<Member> members_;
  Checkpoints checkpoints_;
  DistributedResult result_;
  // Declared before the fabric, so that the fabric is closed before the processes at its other ends are waited for.
  NodeTeam team_;
  std::unique_ptr<Fabric> fabric_;
  std::unique_ptr<Station> station_;
  std::unique_ptr<Gathering> gathering_;  // of nodes on several hosts
  std::optional<SilenceWatch> silences_;

  RunPhase phase_ = RunPhase::Running;
  u64 pool_ = 0;  // credit that is granted to no node
  u64 round_ = 0, first_sum_ = 0;
  u64 odd_ = 0;  // messages that say what cannot be
  bool is_changed_ = false, is_halted_ = false, is_interrupted_ = false;
  bool is_pausing_ = false;  // for a checkpoint
  u64 instant_step_ = 0;     // its number among the steps; 0: there was only the first one
  TimeLimit limit_;          // of the nodes that answered
  i64 planned_ = kForever;
  u64 steps_at_again_ = ~u64{0};  // steps when the current instant was last announced again
  bool stands_still_ = false;     // it would be announced for ever
  i64 began_ = 0;
  bool has_fault_ = false, has_lost_ = false;
  u64 fault_step_ = 0, fault_order_ = 0;
  Fault fault_;
  u64 cut_ = ~u64{0};  // no step after this one is written
  u64 lost_after_ = 0;
  std::string how_;
  u64 told_bytes_ = 0;  // of written steps that the nodes know of
  i64 beat_at_ = 0, stale_at_ = 0, ask_at_ = 0, patience_until_ = kForever;
  // Scratch.
  std::vector<Arrival> arrivals_;
  std::vector<ReceivedMessage> heard_;
};

}  // namespace

DistributedResult run_distributed(Core& core, const Distribution& distribution, const RunOptions& options, u64 seed,
                                  Output& output, u64 resumed) {
  return Launcher(core, distribution, options, seed, output, resumed).run();
}

}  // namespace bip::rt
