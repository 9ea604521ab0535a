// The protocol as a model and as a program are one: what happens to each atom in simulated runs, whatever the network
// does, is a run of models/protocol/offer_begin.bip, and of runs with locks also one of models/protocol/lock_chain.bip.
// Both are proved.
#include <catch2/catch.hpp>

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/interp/interp.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/verify/conflicts/next_moves.hpp"
#include "runtime/core/core.hpp"
#include "runtime/distributed/faults.hpp"
#include "runtime/engine/output.hpp"
#include "runtime/engine/run_file.hpp"
#include "runtime/engine/simulated.hpp"

namespace {

using namespace bip;
using rt::u32;

// A model of the repository, ready to run.
struct Ready {
  Ready(const std::string& name, const std::string& root) : c(options_of(root)) {
    REQUIRE(compile(c, std::string(BIP_TEST_SOURCE_DIR) + "/models/" + name, pipeline::Stage::Image));
    interpreter = std::make_unique<interp::Interpreter>(*c.lowered);
  }
  [[nodiscard]] const rt::Image& image() const { return c.lowered->image; }
  pipeline::Compilation c;
  std::unique_ptr<interp::Interpreter> interpreter;

 private:
  static pipeline::CompileOptions options_of(const std::string& root) {
    pipeline::CompileOptions options;
    options.root = root;
    return options;
  }
};

// A run of a model by given steps.
class Follower {
 public:
  explicit Follower(const rt::Image& image) : core_(image) { REQUIRE(core_.initialize()); }
  void take(const std::string& name) { take_one(name, name); }
  // Of two steps the one that is possible.
  void take_one(const std::string& name, const std::string& other) {
    if (!problem_.empty()) return;
    for (std::uint64_t k = 0; k < core_.candidate_count(); ++k) {
      const std::string path = core_.image().connectors[core_.candidate(k).connector].path();
      if (path != "ROOT." + name && path != "ROOT." + other) continue;
      problem_ = core_.fire(k) ? "" : "a fault in " + path;
      return;
    }
    problem_ = name + " is no step there";
  }
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  rt::Core core_;
  std::string problem_;
};

// One atom's protocol, as the model tells it.
class Protocol : public Follower {
 public:
  explicit Protocol(const rt::Image& image) : Follower(image) {
    // The initial state is offered, and known to all.
    take("offer");
    take("hear_offer");
  }
  using Follower::take;
  void take(rt::NodeEvent::Kind kind) {
    switch (kind) {
      case rt::NodeEvent::Kind::Begun: take("decide"); return take("begin");
      case rt::NodeEvent::Kind::Taken: return take("hear_begin");
      case rt::NodeEvent::Kind::Rested: return take("work");
      case rt::NodeEvent::Kind::Offered: return take("offer");
      case rt::NodeEvent::Kind::Received: return take("hear_offer");
      case rt::NodeEvent::Kind::Locked:
      case rt::NodeEvent::Kind::Arrived:
      case rt::NodeEvent::Kind::Parked:
      case rt::NodeEvent::Kind::GivenUp:
      case rt::NodeEvent::Kind::Refused:
      case rt::NodeEvent::Kind::Released:
      case rt::NodeEvent::Kind::Woken:
      case rt::NodeEvent::Kind::Heard: return;  // of locks
    }
  }
};

// The locks of a ring of components, each on a node of its own, as `Ordered` tells them: the first and the last one
// have names of their own, and so has the interaction between them. The interactions of the ring come first.
class LockChain : public Follower {
 public:
  using Kind = rt::NodeEvent::Kind;
  LockChain(const rt::Image& image, u32 size) : Follower(image), size_(size) {}
  using Follower::take;

  void take(const rt::NodeEvent& event) {
    const bool is_local = event.interaction.is_valid() && event.interaction.value >= size_;
    switch (event.kind) {
      case Kind::Begun:
      case Kind::Offered:
      case Kind::Received: return;
      case Kind::Taken:
        if (is_local) return take_one(of_component(event.atom, "local"), of_component(event.atom, "local_away"));
        return take(is_first(event) ? of_first(event, "begin") : of_second(event, "take"));
      case Kind::Rested: return take(of_component(event.atom, event.place == 0 ? "rest" : "rest_away"));
      // The second one is locked until the step begins, which is one step of the model.
      case Kind::Locked: return is_first(event) ? take(of_first(event, "lock")) : void();
      case Kind::Arrived: return take("arrive[" + std::to_string(event.interaction.value) + "]");
      case Kind::Parked: ++parked_; return take(of_second(event, "park"));
      case Kind::GivenUp: return take("give_up[" + std::to_string(event.interaction.value) + "]");
      // That is at a coordinator, where of this ring's interactions nothing is asked for.
      case Kind::Refused: return take(of_second(event, "refuse"));
      case Kind::Released: return take(of_first(event, "release"));
      case Kind::Woken: return take(of_second(event, "wake"));
      case Kind::Heard: return take("hear_wake[" + std::to_string(event.interaction.value) + "]");
    }
  }
  [[nodiscard]] std::uint64_t parked() const { return parked_; }

 private:
  [[nodiscard]] std::string of_component(u32 atom, const std::string& what) const {
    if (atom == 0) return "first_" + what;
    if (atom + 1 == size_) return "last_" + what;
    return what + "[" + std::to_string(atom - 1) + "]";
  }
  // Is it about the component that the interaction locks first? That is the one with its number, but for the last
  // interaction, which takes the last component and the first one.
  [[nodiscard]] bool is_first(const rt::NodeEvent& event) const {
    return event.atom == (event.interaction.value + 1 == size_ ? 0 : event.interaction.value);
  }
  [[nodiscard]] std::string of_first(const rt::NodeEvent& event, const std::string& what) const {
    if (event.interaction.value + 1 == size_) return "around_" + what;
    return of_component(event.interaction.value, what);
  }
  [[nodiscard]] std::string of_second(const rt::NodeEvent& event, const std::string& what) const {
    if (event.interaction.value + 1 == size_) return "around_" + what;
    return event.interaction.value + 2 == size_ ? "last_" + what
                                                : what + "[" + std::to_string(event.interaction.value) + "]";
  }

  u32 size_;
  std::uint64_t parked_ = 0;
};

struct Followed {
  std::uint64_t steps = 0, messages = 0;
  std::string problem;  // of the first atom that has one
};

Followed follow_messages(const Ready& model, const Ready& protocol, u32 nodes, std::uint64_t seed, const char* text,
                         std::uint64_t forged = 0) {
  rt::RunOptions options;
  options.limit = 400;
  options.silent = true;
  options.on_loss = rt::OnLoss::GoOn;
  std::FILE* out = std::tmpfile();
  rt::RunFile no_trace({}, stderr);
  rt::Output output(options, seed, out, no_trace, model.image());
  rt::Core core(model.image());
  REQUIRE(core.initialize());
  rt::Placement placement = rt::place_atoms(core.tables(), core.priorities(), nodes);
  placement.next_moves = verify::find_next_moves(*model.c.system, verify::within_seconds(10)).moves;
  const rt::Distribution distribution = rt::distribute(core.tables(), core.priorities(), placement);
  const Result<rt::NetworkFaults> faults = rt::read_faults(text, placement.nodes);
  REQUIRE(faults);
  std::vector<std::unique_ptr<Protocol>> protocols;
  for (u32 atom = 0; atom < model.image().atoms.size; ++atom)
    protocols.push_back(std::make_unique<Protocol>(protocol.image()));
  Followed result;
  std::uint64_t events = 0;
  const rt::SimulatedResult run =
      rt::run_simulated(core, distribution, *faults, options, seed, output, 0, [&](rt::NodeEvent event) {
        Protocol& of_atom = *protocols[event.atom];
        of_atom.take(event.kind);
        if (++events == forged) of_atom.take(event.kind);
      });
  std::fclose(out);
  result.steps = run.steps;
  result.messages = run.offers + run.begins;
  for (const std::unique_ptr<Protocol>& one : protocols) {
    if (result.problem.empty()) result.problem = one->problem();
  }
  return result;
}

// A run of the ring whose steps and messages are followed in the model of locks. `change` may spoil who coordinates
// what; the event with the number `forged` reaches the model twice.
struct LockedRun {
  rt::SimulatedResult run;
  std::uint64_t events = 0, parked = 0;
  std::string problem;
};
template <class Change>
LockedRun follow_locks(const Ready& ring, const rt::Image& protocol, u32 size, std::uint64_t seed, const char* text,
                       Change change, std::uint64_t forged = 0) {
  rt::RunOptions options;
  options.limit = 3000;
  options.silent = true;
  options.on_loss = rt::OnLoss::GoOn;
  std::FILE* out = std::tmpfile();
  rt::RunFile no_trace({}, stderr);
  rt::Output output(options, seed, out, no_trace, ring.image());
  rt::Core core(ring.image());
  REQUIRE(core.initialize());
  rt::Placement placement;
  for (u32 atom = 0; atom < size; ++atom) {
    placement.nodes.push_back(std::to_string(atom + 1));
    placement.home.push_back(atom);
  }
  placement.split_above = 1;
  rt::Distribution distribution = rt::distribute(core.tables(), core.priorities(), placement);
  REQUIRE(distribution.sets.count == 1);
  REQUIRE(distribution.is_split[0] != 0);
  for (u32 row = 0; row < size; ++row)
    REQUIRE(ring.image().connectors[core.tables().connector_of(rt::InteractionId(row))].path() ==
            "ROOT.both[" + std::to_string(row) + "]");
  change(distribution);
  const Result<rt::NetworkFaults> faults = rt::read_faults(text, placement.nodes);
  REQUIRE(faults);
  LockChain chain(protocol, size);
  LockedRun result;
  result.run =
      rt::run_simulated(core, distribution, *faults, options, seed, output, 0, [&](const rt::NodeEvent& event) {
        chain.take(event);
        if (++result.events == forged) chain.take(event);
      });
  std::fclose(out);
  result.problem = chain.problem();
  result.parked = chain.parked();
  return result;
}

}  // namespace

TEST_CASE("messages of simulated runs are steps of the model of the protocol") {
  const Ready protocol("protocol/offer_begin.bip", "Run(true, true)");
  const Ready table("bench/philosophers.bip", "Table(6)"), station("classic/gas_station.bip", ""),
      broadcast("bench/broadcast.bip", "");
  std::uint64_t messages = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const char* const faults = seed % 3 == 0   ? ""
                               : seed % 3 == 1 ? "lose 20%, double 20%, cut 1-2 3ms..60ms, slow 2 x5"
                                               : "crash 2 20ms, lose 10%";
    for (const Ready* model : {&table, &station, &broadcast}) {
      const Followed run = follow_messages(*model, protocol, 3, seed, faults);
      CHECK(run.problem == "");
      CHECK(run.steps > (seed % 3 == 2 ? 0u : 300u));
      messages += run.messages;
    }
  }
  CHECK(messages > 1000);
}

TEST_CASE("a message that is heard twice is no step of the model of the protocol") {
  const Ready protocol("protocol/offer_begin.bip", "Run(true, true)");
  const Ready table("bench/philosophers.bip", "Table(6)");
  for (std::uint64_t forged = 50; forged < 60; ++forged) {
    // An offer that is said twice is one: the model says it until it is heard.
    const Followed run = follow_messages(table, protocol, 3, 1, "", forged);
    CHECK((run.problem.empty() || run.problem.find("is no step there") != std::string::npos));
  }
  CHECK_FALSE(follow_messages(table, protocol, 3, 1, "", 51).problem.empty());
}

TEST_CASE("locks of simulated runs are steps of the model of the protocol") {
  const auto as_it_is = [](const rt::Distribution&) {};
  std::uint64_t locks = 0, releases = 0, wakes = 0, parked = 0;
  for (const u32 size : {4u, 5u, 8u}) {
    const Ready ring("protocol/lock_chain.bip", "Ring(" + std::to_string(size) + ")");
    const Ready ordered("protocol/lock_chain.bip", "Ordered(" + std::to_string(size - 2) + ", true, true)");
    for (std::uint64_t seed = 1; seed <= 15; ++seed) {
      const char* const faults = seed % 3 == 0   ? ""
                                 : seed % 3 == 1 ? "lose 20%, double 20%, cut 1-2 3ms..60ms, slow 3 x5"
                                                 : "crash 2 20ms, lose 10%";
      const LockedRun followed = follow_locks(ring, ordered.image(), size, seed, faults, as_it_is);
      CHECK(followed.problem == "");
      CHECK(followed.run.steps > (seed % 3 == 2 ? 0u : 300u));
      locks += followed.run.locks;
      releases += followed.run.releases;
      wakes += followed.run.wakes;
      parked += followed.parked;
    }
  }
  CHECK(locks > 1000);
  CHECK(releases > 100);
  CHECK(wakes > 100);
  CHECK(parked > releases + 100);
}

TEST_CASE("split sets: steps of three nodes cost a little more than the least number of messages") {
  const Ready table("bench/philosophers.bip", "Table(16)"), large("bench/philosophers.bip", "Table(60)");
  struct Case {
    const Ready* model;
    u32 nodes;
    double most;
    std::int64_t time;  // ns of the simulation for 3000 steps
  };
  // Where most steps are of three nodes the least is 3.74 and 3.93.
  for (const Case& one :
       {Case{&table, 8, 2.4, 700'000'000}, Case{&table, 16, 4.0, 950'000'000}, Case{&large, 60, 4.1, 330'000'000}}) {
    std::uint64_t messages = 0, border = 0;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      rt::RunOptions options;
      options.limit = 3000;
      options.silent = true;
      std::FILE* out = std::tmpfile();
      rt::RunFile no_trace({}, stderr);
      rt::Output output(options, seed, out, no_trace, one.model->image());
      rt::Core core(one.model->image());
      REQUIRE(core.initialize());
      rt::Placement placement = rt::place_atoms(core.tables(), core.priorities(), one.nodes);
      placement.next_moves = verify::find_next_moves(*one.model->c.system, verify::within_seconds(10)).moves;
      placement.split_above = 1;
      const rt::Distribution distribution = rt::distribute(core.tables(), core.priorities(), placement);
      const rt::SimulatedResult run = rt::run_simulated(core, distribution, {}, options, seed, output);
      std::fclose(out);
      messages += run.messages();
      border += run.border_steps;
      CHECK(run.time < one.time);
    }
    INFO(one.nodes << " nodes: " << static_cast<double>(messages) / static_cast<double>(border));
    CHECK(border > 3000);
    CHECK(static_cast<double>(messages) <= one.most * static_cast<double>(border));
  }
}

TEST_CASE("what is no lock is no step of the model of the protocol") {
  const Ready ring("protocol/lock_chain.bip", "Ring(5)"), ordered("protocol/lock_chain.bip", "Ordered(3, true, true)");
  const auto as_it_is = [](const rt::Distribution&) {};
  REQUIRE(follow_locks(ring, ordered.image(), 5, 1, "", as_it_is).problem == "");
  // Nothing may be said twice.
  for (std::uint64_t forged = 50; forged < 80; ++forged) {
    const LockedRun followed = follow_locks(ring, ordered.image(), 5, 1, "", as_it_is, forged);
    CHECK((followed.problem.empty() || followed.problem.find("is no step there") != std::string::npos));
  }
  // A component that two nodes' interactions take is offered to one of them, which takes it without a lock.
  const LockedRun offered = follow_locks(ring, ordered.image(), 5, 1, "", [](rt::Distribution& distribution) {
    distribution.offered_at[distribution.sets.row_of_place(2, 0)] = 1;
  });
  CHECK(offered.problem.find("is no step there") != std::string::npos);
}
