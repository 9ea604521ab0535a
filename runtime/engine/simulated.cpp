// The simulated engine: see simulated.hpp.
#include "runtime/engine/simulated.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "bip/assert.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/distributed/node.hpp"
#include "runtime/engine/checkpoints.hpp"
#include "runtime/engine/collect_strings.hpp"
#include "runtime/engine/flights.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/engine/loss_story.hpp"
#include "runtime/engine/node_time.hpp"
#include "runtime/engine/scheduler.hpp"

namespace bip::rt {

namespace {

// A node, and what is around it.
struct Seat {
  std::unique_ptr<Node> node;
  Scheduler scheduler;
  NodeTime time;
  std::vector<Link> links;       // by peer
  std::vector<u64> again_until;  // by peer: frames up to this number are sent again; 0: none
  bool has_turn = false;
  bool is_lost = false;
};

class SimulatedRun {
 public:
  SimulatedRun(Core& core, const Distribution& distribution, const NetworkFaults& faults, const RunOptions& options,
               u64 seed, Output& output, u64 resumed, const NodeObserver& observer)
      : core_(core),
        distribution_(distribution),
        options_(options),
        writes_(output.writes_steps()),
        plans_(plans_instants(core, options)),
        moment_{core.now(), 0},
        network_(faults, seed),
        draws_(seed + 1),
        flights_(output),
        checkpoints_(options, resumed) {
    const u32 nodes = static_cast<u32>(distribution.placement.nodes.size());
    const CoreOptions how = core.parts().options;
    for (u32 node = 0; node < nodes; ++node) {
      Seat& seat = seats_.emplace_back(Seat{std::make_unique<Node>(core.image(), how, distribution, node),
                                            Scheduler(options.policy, seed + node),
                                            NodeTime(plans_, seed + node),
                                            {},
                                            {}});
      for (u32 peer = 0; peer < nodes; ++peer) seat.links.emplace_back(node, peer);
      seat.again_until.assign(nodes, 0);
      seat.node->observe(observer);
    }
  }

  SimulatedResult run() {
    const State initial = core_.snapshot();
    for (u32 node = 0; node < seats_.size(); ++node) {
      seats_[node].scheduler.start(seats_[node].node->core());
      BIP_ENSURE(seats_[node].node->start(initial), "the initial state has no fault");
      wake(node);
    }
    while (true) {
      for (NetworkEvent event; network_.next(event);) {
        take(event);
        if (wants_collection(core_.image())) free_strings();
        const bool may_pause = !is_pausing_ && !has_lost() && steps_ != options_.limit;
        if (may_pause && checkpoints_.take_due(network_.now())) is_pausing_ = true;
      }
      // No atom is at work, no message is on its way.
      if (std::exchange(is_pausing_, false)) take_checkpoint(initial);
      else if (!has_passed_time()) break;
    }
    SimulatedResult result;
    result.border_steps = border_steps_;
    for (const Seat& seat : seats_) {
      BIP_ENSURE(seat.node->counts().refused == 0, "a node refuses what another one said");
      result.offers += seat.node->counts().offers;
      result.begins += seat.node->counts().begins;
      result.locks += seat.node->counts().locks;
      result.releases += seat.node->counts().releases;
      result.wakes += seat.node->counts().wakes;
    }
    result.network = network_.counts();
    result.time = network_.now();
    result.checkpoints = checkpoints_.count();
    result.checkpoint = checkpoints_.steps();
    end(initial, result);
    return result;
  }

 private:
  void take(NetworkEvent& event) {
    Seat& seat = seats_[event.node];
    switch (event.kind) {
      case NetworkEvent::Kind::Crash:
        if (!seat.is_lost) lost_after_ = steps_;
        seat.is_lost = true;
        return;
      case NetworkEvent::Kind::Loss:
        for (Seat& other : seats_) {
          other.links[event.node].close();
          other.node->forget_lost(event.node);
        }
        if (options_.on_loss == OnLoss::Stop) is_stopping_ = true;
        return;
      case NetworkEvent::Kind::Turn:
        seat.has_turn = false;
        if (seat.is_lost) return;
        if (has_taken_turn(event.node)) wake(event.node);
        return send(event.node);
      case NetworkEvent::Kind::Instant:
        if (seat.is_lost) return;
        seat.node->pass_to(moment_);
        seat.time.begin(moment_.instant);
        wake(event.node);
        return send(event.node);
      case NetworkEvent::Kind::Again:
        if (!seat.is_lost) send_again(event.node, event.peer);
        return;
      case NetworkEvent::Kind::Parked:
        if (seat.is_lost) return;
        seat.node->end_parking(event.number);
        wake(event.node);
        return send(event.node);
      case NetworkEvent::Kind::Arrival:
        if (seat.is_lost) return;
        heard_.clear();
        seat.links[event.peer].take(event.frame, heard_);
        for (const Message& message : heard_) seat.node->take(message);
        land(*seat.node);
        if (!heard_.empty()) wake(event.node);
        return send(event.node);
    }
  }

  void wake(u32 node) {
    if (seats_[node].has_turn) return;
    seats_[node].has_turn = true;
    network_.await_turn(node);
  }

  // False: there was nothing to do.
  bool has_taken_turn(u32 node) {
    Node& at = *seats_[node].node;
    const bool works_first = at.work_count() != 0 && draws_.below(2) == 0;
    if (!works_first) {
      const bool tries_first = at.try_count() != 0 && draws_.below(2) == 0;
      if (!tries_first && has_begun(seats_[node])) return true;
      if (at.try_count() != 0) {
        at.try_lock(draws_.below(at.try_count()));
        return true;
      }
    }
    if (at.work_count() == 0) return false;
    at.run(draws_.below(at.work_count()));
    land(at);
    return true;
  }

  bool has_begun(Seat& seat) {
    Node& node = *seat.node;
    EnabledSet::Position at{};
    if (is_stopping_ || is_pausing_ || node.is_stopped() || steps_ == options_.limit || is_interrupted()) return false;
    if (node.locked_interaction().is_valid()) at = seat.scheduler.choose_of(node.core(), node.locked_interaction());
    else if (!seat.time.choose(seat.scheduler, node.core(), at)) return false;
    if (writes_) flights_.depart(node.core(), at);
    seat.scheduler.fired(at.interaction);
    seat.time.fired(at.interaction);
    core_.remember(at.interaction);
    atoms_.clear();
    const bool is_evaluated = node.begin(at, steps_ + instants_, atoms_);
    if (writes_) flights_.set_parts(static_cast<u32>(atoms_.size()) + (is_evaluated ? 1 : 0));
    const u32 self = static_cast<u32>(&seat - seats_.data());
    const bool is_border =
        std::any_of(atoms_.begin(), atoms_.end(), [&](u32 atom) { return distribution_.home(atom) != self; });
    border_steps_ += is_border ? 1 : 0;
    ++steps_;
    return true;
  }

  // Requires that no atom is at work and no message on its way: tells all nodes the next instant. False: there is none.
  bool has_passed_time() {
    const bool is_stopped =
        std::any_of(seats_.begin(), seats_.end(), [](const Seat& seat) { return seat.node->is_stopped(); });
    // The atoms of a lost node are at work for ever, at this instant.
    if (!core_.is_timed() || is_stopped || has_lost() || steps_ == options_.limit || is_interrupted()) return false;
    TimeLimit limit;
    for (Seat& seat : seats_) limit.meet(seat.time.limit(seat.node->core()));
    i64 next = limit.change;
    for (Seat& seat : seats_) next = std::min(next, seat.time.plan(seat.node->core(), limit.last));
    if (next == kForever || next > limit.last) return false;
    // Progress: what a node plans is decided there, and only a step of that node or a later instant can take it away.
    BIP_ENSURE(next > moment_.instant || steps_ != steps_at_again_, "no step began at the instant {}", next);
    steps_at_again_ = next > moment_.instant ? ~u64{0} : steps_;
    if (next != moment_.instant) {
      moment_ = {next, steps_ + instants_};
      ++instants_;
      if (writes_) flights_.skip();
    }
    network_.tell_instant(static_cast<u32>(seats_.size()));
    return true;
  }

  void land(Node& node) {
    for (const u64 step : node.landed()) {
      if (writes_) flights_.land(step);
    }
    node.landed().clear();
    if (writes_ && std::none_of(seats_.begin(), seats_.end(), [](const Seat& seat) { return seat.node->is_stopped(); }))
      flights_.write_landed();
  }

  void send(u32 node) {
    Seat& seat = seats_[node];
    for (Outgoing& outgoing : seat.node->outbox()) seat.links[outgoing.to].say(std::move(outgoing.message));
    seat.node->outbox().clear();
    for (const Node::Parking& parking : seat.node->new_parkings())
      network_.await_end_of_parking(node, distribution_.coordinator_of[parking.interaction], parking.number);
    seat.node->new_parkings().clear();
    for (u32 peer = 0; peer < seats_.size(); ++peer) {
      if (!seat.links[peer].next_frame(frame_)) continue;
      network_.send(frame_);
      await_again(node, peer);
    }
  }

  void await_again(u32 node, u32 peer) {
    Seat& seat = seats_[node];
    if (seat.again_until[peer] != 0 || seat.links[peer].unconfirmed().empty()) return;
    seat.again_until[peer] = seat.links[peer].unconfirmed().back().number;
    network_.await_again(node, peer);
  }

  void send_again(u32 node, u32 peer) {
    Seat& seat = seats_[node];
    const Link& link = seat.links[peer];
    for (std::size_t k = 0; k < link.unconfirmed().size(); ++k) {
      if (link.unconfirmed()[k].number <= seat.again_until[peer]) network_.send_again(link.again(k));
    }
    seat.again_until[peer] = 0;
    await_again(node, peer);
  }

  // The homes together are a state, unless one was lost or stopped meanwhile. Then all go on.
  void take_checkpoint(const State& initial) {
    for (u32 node = 0; node < seats_.size(); ++node) wake(node);
    if (std::any_of(seats_.begin(), seats_.end(),
                    [](const Seat& seat) { return seat.is_lost || seat.node->is_stopped(); }))
      return;
    Checkpoint checkpoint{steps_, initial, std::vector<u32>(core_.image().atoms.size, kNone)};
    for (u32 node = 0; node < seats_.size(); ++node) {
      seats_[node].node->save(checkpoint.state, checkpoint.time);
      for (u32 atom = 0; atom < checkpoint.history.size(); ++atom) {
        if (distribution_.home(atom) == node) checkpoint.history[atom] = seats_[node].node->history(atom);
      }
    }
    checkpoints_.write(core_, std::move(checkpoint));
  }

  // All nodes share the strings. The core of the run is in the initial state until the end.
  void free_strings() {
    // Actions that run beside the others have copies of their atoms' cells.
    const auto works = [](const Seat& seat) { return !seat.node->core().actions().working().empty(); };
    if (std::any_of(seats_.begin(), seats_.end(), works)) return;
    LiveStrings live;
    const auto add = [&live](const std::vector<u64>& cells) { live.add(cells); };
    live.add(core_);
    for (const Seat& seat : seats_) {
      live.add(seat.node->core());
      seat.node->visit_kept_cells(add);
      for (const Link& link : seat.links) link.visit_kept_cells(add);
    }
    network_.visit_kept_cells(add);
    live.keep_only(*core_.image().ffi);
  }

  // -- The end --

  [[nodiscard]] bool has_lost() const {
    return std::any_of(seats_.begin(), seats_.end(), [](const Seat& seat) { return seat.is_lost; });
  }

  [[nodiscard]] std::vector<bool> lost_nodes() const {
    std::vector<bool> lost;
    for (const Seat& seat : seats_) lost.push_back(seat.is_lost);
    return lost;
  }

  void end(const State& initial, SimulatedResult& result) {
    const PartialState* fault = nullptr;
    for (const Seat& seat : seats_) {
      const PartialState* at = seat.node->core().partial().state();
      if (at->fault && (fault == nullptr || at->fault_step < fault->fault_step ||
                        (at->fault_step == fault->fault_step && at->fault_order < fault->fault_order)))
        fault = at;
    }
    State last = initial;
    for (const Seat& seat : seats_) seat.node->save(last, time_);
    add_time(core_, std::move(time_), last);
    result.steps = steps_;
    if (fault != nullptr) {
      // The step that ends in a fault is in the trace, as in any run.
      if (writes_) flights_.write_until(fault->fault_step);
      // Instants have numbers among the steps; all but the last one are before every fault.
      BIP_ASSERT(instants_ == 0 || fault->fault_step >= moment_.step, "a fault of step {} at the instant {}",
                 fault->fault_step, moment_.step);
      result.steps = fault->fault_step - instants_ + (instants_ != 0 && fault->fault_step == moment_.step ? 1 : 0);
      result.end = End::Fault;
      (void)core_.restore(last);
      core_.fail(fault->fault);
      return;
    }
    if (writes_) flights_.write_until(steps_ + instants_);
    const bool is_sound = core_.restore(last);
    if (has_lost()) return end_with_loss(is_sound, initial, result);
    BIP_ENSURE(is_sound, "the last state has no fault");
    if (steps_ == options_.limit) result.end = End::Limit;
    else if (is_interrupted()) result.end = End::Interrupted;
    else if (is_time_locked(core_)) result.end = End::Fault;
    else result.end = end_without_step(core_);
    BIP_ENSURE(result.end == End::Limit || result.end == End::Interrupted || core_.candidate_count() == 0,
               "a node waits for what never comes");
  }

  // What was at work when nodes were lost stays so. It may have left data behind that no state of the model has.
  void end_with_loss(bool is_sound, const State& initial, SimulatedResult& result) {
    result.end = steps_ == options_.limit ? End::Limit : End::Interrupted;
    if (!is_sound) BIP_ENSURE(core_.restore(initial), "the initial state has no fault");
    const Survivors survivors(core_, distribution_, lost_nodes());
    if (is_sound && !is_stopping_ && !is_interrupted() && steps_ != options_.limit && !core_.is_timed())
      ensure_no_node_waits_in_vain(survivors);
    std::string& story = result.end == End::Limit ? result.warning : result.lost_nodes;
    story = loss_story(core_, distribution_, survivors, locked_atoms(), lost_after_, {});
    core_.partial().allow();
  }

  // Atoms at home on the nodes that are left, in attempts that went on to lost nodes.
  [[nodiscard]] std::vector<bool> locked_atoms() const {
    std::vector<bool> locked(core_.image().atoms.size, false);
    for (u32 atom = 0; atom < locked.size(); ++atom) {
      const Seat& home = seats_[distribution_.home(atom)];
      locked[atom] = !home.is_lost && home.node->is_locked(atom);
    }
    return locked;
  }

  // What needs no lost node went on until it could no more. Attempts at interactions of split sets may have ended at a
  // lost node.
  void ensure_no_node_waits_in_vain(const Survivors& survivors) const {
    for (u64 k = 0; k < core_.candidate_count(); ++k) {
      const InteractionId interaction = core_.position(k).interaction;
      const bool is_split = distribution_.is_split[distribution_.sets.of_interaction[interaction]] != 0;
      BIP_ENSURE(is_split || !survivors.is_whole(interaction), "a node waits for what never comes");
    }
  }

  Core& core_;
  const Distribution& distribution_;
  const RunOptions& options_;
  bool writes_;
  bool plans_;  // instants of steps
  Moment moment_;
  Network network_;
  Prng draws_;
  Flights flights_;
  std::vector<Seat> seats_;
  u64 steps_ = 0, border_steps_ = 0, lost_after_ = 0;
  u64 instants_ = 0;              // to which time has passed
  u64 steps_at_again_ = ~u64{0};  // steps when the current instant was last announced again
  bool is_stopping_ = false;      // a node was lost
  bool is_pausing_ = false;       // nothing begins until a checkpoint can be taken
  Checkpoints checkpoints_;
  // Scratch.
  std::vector<Message> heard_;
  std::vector<u32> atoms_;
  SavedTime time_;
  Frame frame_;
};

}  // namespace

SimulatedResult run_simulated(Core& core, const Distribution& distribution, const NetworkFaults& faults,
                              const RunOptions& options, u64 seed, Output& output, u64 resumed,
                              const NodeObserver& observer) {
  return SimulatedRun(core, distribution, faults, options, seed, output, resumed, observer).run();
}

}  // namespace bip::rt
