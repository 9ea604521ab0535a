// Distributed runs: links and faults alone, conflict sets, messages of a step, and runs of the simulated engine, which
// are sequential runs whatever goes wrong.
#include <catch2/catch.hpp>

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <memory>
#include <numeric>
#include <utility>

#include "runtime/distributed/checkpoint.hpp"
#include "runtime/distributed/codec.hpp"
#include "runtime/distributed/deployment.hpp"
#include "runtime/distributed/greeting.hpp"
#include "runtime/distributed/node.hpp"
#include "runtime/distributed/fired_interactions.hpp"
#include "runtime/distributed/place_free_atoms.hpp"
#include "runtime/distributed/station.hpp"
#include "runtime/engine/checkpoints.hpp"
#include "runtime/engine/node_process.hpp"
#include "runtime/engine/loss_story.hpp"
#include "runtime/engine/replay_record.hpp"
#include "runtime/engine/simulated.hpp"
#include "runtime/engine/step_merge.hpp"
#include "runtime/engine/unwritten_steps.hpp"
#include "runtime/trace/recorded.hpp"
#include "tests/unit/base/contents.hpp"
#include "tests/unit/runtime/odd_checkpoints.hpp"
#include "tests/unit/runtime/helpers.hpp"
#include "tests/unit/runtime/models.hpp"

using namespace bip::rt;
using namespace bip::rt::testing;
using bip::testing::contents;

namespace {

// Each atom on a node of its own.
Placement apart(const Image& image) {
  Placement placement;
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    placement.nodes.push_back(std::to_string(atom + 1));
    placement.home.push_back(atom);
  }
  return placement;
}

// A model in its initial state, each atom on a node of its own.
struct Scattered {
  template <class Build>
  explicit Scattered(const Build& build, u32 split_above = kSplitAbove, CoreOptions how = {}) {
    build(builder);
    core = std::make_unique<Core>(builder.image(), how);
    REQUIRE(core->initialize());
    Placement placement = apart(builder.image());
    placement.split_above = split_above;
    distribution = distribute(core->tables(), core->priorities(), placement);
  }
  [[nodiscard]] const Image& image() { return builder.image(); }

  ImageBuilder builder;
  std::unique_ptr<Core> core;
  Distribution distribution;
};
// Of so many atoms.
Scattered scattered_pairs(int atoms) {
  return Scattered([atoms](ImageBuilder& b) { build_pairs(b, atoms); });
}

// Steps that a node took, which share a number, of a model with two interactions.
Control fired_message(u64 step, const std::vector<u32>& rows) {
  FiredPacker packer(2);
  packer.add(rows);
  return {Control::Kind::Fired, {step, rows.size()}, {packer.take()}};
}

SimulatedResult simulated(const Image& image, const Placement& placement, std::uint64_t seed, std::uint64_t limit) {
  RunOptions options;
  options.limit = limit;
  options.silent = true;
  std::FILE* out = std::tmpfile();
  RunFile no_trace({}, stderr);
  Output output(options, seed, out, no_trace, image);
  Core core(image);
  REQUIRE(core.initialize());
  const Distribution distribution = distribute(core.tables(), core.priorities(), placement);
  const SimulatedResult result = run_simulated(core, distribution, {}, options, seed, output);
  std::fclose(out);
  return result;
}

struct RunOutput {
  RunResult result;
  std::string trace, out, err;
};
RunOutput output_of(const Image& image, std::uint64_t seed, std::uint64_t limit, const char* faults, OnLoss on_loss,
                    RunOptions options = {}) {
  options.seed = seed;
  options.has_seed = true;
  options.limit = limit;
  options.engine = Engine::Simulated;
  options.nodes = 3;
  options.network_faults = faults;
  options.on_loss = on_loss;
  options.format = TraceFormat::Binary;
  std::FILE* out = std::tmpfile();
  std::FILE* err = std::tmpfile();
  std::FILE* trace = std::tmpfile();
  options.trace_path = "/proc/self/fd/" + std::to_string(fileno(trace));
  RunOutput result{run(image, options, out, err), "", "", ""};
  result.trace = contents(trace);
  result.out = contents(out);
  result.err = contents(err);
  return result;
}
// `resumed`: the checkpoint from which the run went on; empty: from none.
Followed check(const Image& image, const RunOutput& run, const std::string& resumed = {}) {
  std::FILE* out = std::tmpfile();
  RunOptions quiet;
  quiet.silent = true;
  quiet.resume_path = resumed;
  const Followed followed = follow(image, run.trace, quiet, out);
  std::fclose(out);
  INFO(followed.problem << followed.candidates);
  CHECK(followed.problem.empty());
  CHECK(followed.steps == run.result.steps);
  return followed;
}

// Runs of 300 steps at most, each second one on a bad network, are accepted. Returns how many ended in a deadlock.
int check_runs(const Image& image, std::uint64_t seeds, const RunOptions& options) {
  int deadlocks = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const char* const faults = seed % 2 == 0 ? "" : "lose 20%, double 20%, cut 1-3 2ms..40ms, slow 2 x5";
    const RunOutput run = output_of(image, seed, 300, faults, OnLoss::Stop, options);
    CHECK(check(image, run).end == run.result.end);
    CHECK(run.result.exit_code == 0);
    CHECK(run.result.end == (run.result.steps == 300 ? End::Limit : End::Deadlock));
    deadlocks += run.result.end == End::Deadlock ? 1 : 0;
  }
  return deadlocks;
}

// Of some nodes in blocks, with every conflict set split that has several interactions.
Placement split(const Image& image, u32 nodes) {
  const Tables tables = link(image, MaximalProgress::On);
  Placement placement = place_atoms(tables, link_priorities(tables), nodes);
  placement.split_above = 1;
  return placement;
}

// Servers that clients take in any combination, for one step each time.
void build_match(ImageBuilder& b, int n) {
  b.atom_type({.name = "One",
               .ports = {{.name = "meet"}},
               .places = {"S"},
               .initial = {"S"},
               .transitions = {{"meet", {"S"}, {"S"}}}});
  b.connector_type({.name = "Two", .params = {{"p", 0}, {"q", 0}}, .define = "p q"});
  for (const char* kind : {"c", "s"}) {
    for (int i = 0; i < n; ++i) b.atom(kind + std::to_string(i), "One");
  }
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      const std::string client = "c" + std::to_string(i), server = "s" + std::to_string(k);
      b.connector(client + server, "Two", {client + ".meet", server + ".meet"});
    }
  }
}

}  // namespace

TEST_CASE("every message arrives once and in order, whatever happens to its frame") {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Prng draws(seed);
    Link here(0, 1), there(1, 0);
    std::vector<Frame> on_the_way;  // to there
    std::vector<Message> heard;
    u64 said = 0;
    const auto said_now = [&] {
      for (std::size_t k = 0; k < heard.size(); ++k) REQUIRE(std::get<Stop>(heard[k]).step == k + 1);
    };
    for (int turn = 0; turn < 400; ++turn) {
      if (turn < 300 && draws.below(2) == 0) here.say(Stop{++said});
      Frame frame;
      while (here.next_frame(frame)) {
        if (draws.below(3) != 0) on_the_way.push_back(frame);
        if (draws.below(3) == 0) on_the_way.push_back(frame);
      }
      if (turn % 7 == 0 || turn >= 300) {
        for (std::size_t k = 0; k < here.unconfirmed().size(); ++k) on_the_way.push_back(here.again(k));
      }
      for (u64 n = draws.below(3); n > 0 && !on_the_way.empty(); --n) {
        std::swap(on_the_way[draws.below(on_the_way.size())], on_the_way.back());
        there.take(on_the_way.back(), heard);
        on_the_way.pop_back();
      }
      if (there.next_frame(frame) && draws.below(2) == 0) here.take(frame, heard);
      said_now();
    }
    for (std::size_t k = 0; k < here.unconfirmed().size(); ++k) there.take(here.again(k), heard);
    said_now();
    CHECK(heard.size() == said);
    Frame answer;
    CHECK(there.next_frame(answer) != here.unconfirmed().empty());
    here.take(answer, heard);
    CHECK(here.unconfirmed().empty());
  }
}

TEST_CASE("greetings come back as they were, and are no frames") {
  const Greeting welcome{.kind = Greeting::Kind::Welcome,
                         .number = 77,
                         .model = "a model",
                         .seed = ~u64{0},
                         .policy = 2,
                         .format = 3,
                         .is_silent = true,
                         .is_traced = false,
                         .goes_on = true,
                         .has_maximal_progress = false};
  for (const Greeting& greeting : {welcome, Greeting{.kind = Greeting::Kind::Leave, .number = 1, .model = "why"}}) {
    const std::string bytes = text_of(greeting);
    CHECK(is_greeting(bytes));
    Greeting read_back;
    REQUIRE(read(bytes, read_back));
    CHECK(text_of(read_back) == bytes);
    for (std::size_t size = 0; size < bytes.size(); ++size)
      CHECK_FALSE(read(std::string_view(bytes).substr(0, size), read_back));
    CHECK_FALSE(read(bytes + '\0', read_back));
  }
  // Of another version only that is understood.
  std::string later = text_of(welcome);
  later[1] = static_cast<char>(kProtocol + 1);
  Greeting read_back;
  REQUIRE(read(later.substr(0, 4), read_back));
  CHECK(read_back.protocol == kProtocol + 1);
  CHECK(read_back.model.empty());
  CHECK_FALSE(is_greeting(std::string(1, static_cast<char>(kProtocol))));
}

TEST_CASE("plans of nodes on several hosts") {
  Deployment deployment;
  deployment.names = {"a", "b"};
  deployment.addresses = {"10.0.0.1:7701", "lab:7701"};
  deployment.open_keys = {"A", "B", "L"};
  deployment.self = 1;
  deployment.listen = "*:7701";
  const FabricPlan plan = node_plan(deployment);
  CHECK(plan.self == 1);
  CHECK(plan.addresses == std::vector<std::string>{"tcp://10.0.0.1:7701", "tcp://*:7701", ""});
  deployment.self = 0;
  deployment.launcher_keys = {"L", "l"};
  const FabricPlan launcher = launcher_plan(deployment);
  CHECK(launcher.self == 2);
  CHECK(launcher.keys.secret == "l");
  CHECK(launcher.addresses == std::vector<std::string>{"tcp://10.0.0.1:7701", "tcp://lab:7701", ""});
}

TEST_CASE("frames come back as they were, and odd bytes are refused") {
  Scattered pairs = scattered_pairs(3);
  Core& core = *pairs.core;
  const Distribution& distribution = pairs.distribution;
  const u32 peers = pairs.image().atoms.size;
  const Codec codec(core.tables(), distribution, 42);
  Prng draws(1);
  // Messages as nodes say them: each atom's offer at rest, and a step of it.
  Frame frame{0, 1, 7, 3, 99, {}};
  const auto cells_of = [&](u32 atom) {
    std::vector<u64> cells;
    for (const VariableId cell : distribution.cells[atom]) cells.push_back(core.cell(cell).bits + (u64{1} << 40));
    return cells;
  };
  const auto first_of = [&](u32 atom) { return core.tables().types[core.tables().atoms[atom].type].first_transition; };
  const u32 row = first_of(0), taken_row = first_of(1);
  AtomOffer at_rest{core.tables().transitions[row].from, {}, {row}, 5, 1};
  frame.messages = {Offer{0, 4, at_rest, cells_of(0)}, Begin{12, {Part{1, 2, taken_row, 1, cells_of(1)}}},
                    Stop{~u64{0}}, Control{Control::Kind::Begun, {1, ~u64{0}, 0}, {"a text", ""}}};
  std::string bytes;
  codec.write(frame, bytes);
  Frame read;
  REQUIRE(codec.read(bytes, 0, 1, read));
  std::string again;
  codec.write(read, again);
  CHECK(again == bytes);
  CHECK(read.number == 7);
  CHECK(read.received == 3);
  CHECK(read.stamp == 99);
  REQUIRE(read.messages.size() == 4);
  CHECK(std::get<Offer>(read.messages[0]).cells == cells_of(0));
  CHECK(std::get<Begin>(read.messages[1]).parts[0].cells == cells_of(1));
  CHECK(std::get<Control>(read.messages[3]).numbers[1] == ~u64{0});

  // From another peer, to another node, of another run.
  CHECK_FALSE(codec.read(bytes, 1, 1, read));
  CHECK_FALSE(codec.read(bytes, 0, 0, read));
  CHECK_FALSE(Codec(core.tables(), distribution, 43).read(bytes, 0, 1, read));
  // Cut anywhere, or with more behind it.
  for (std::size_t size = 0; size < bytes.size(); ++size)
    CHECK_FALSE(codec.read(std::string_view(bytes).substr(0, size), 0, 1, read));
  CHECK_FALSE(codec.read(bytes + '\0', 0, 1, read));
  // An offer of another's atom, and rows that there are not.
  const auto refused = [&](const Message& message) {
    Frame odd{0, 1, 1, 0, 0, {message}};
    std::string text;
    codec.write(odd, text);
    return !codec.read(text, 0, 1, read);
  };
  CHECK(refused(Offer{1, 4, at_rest, cells_of(1)}));
  CHECK(refused(Begin{12, {Part{0, 2, row, 1, cells_of(0)}}}));
  CHECK(refused(Begin{12, {Part{1, 2, static_cast<u32>(core.tables().transitions.size()), 1, cells_of(1)}}}));
  // Of an atom of another type: its code would touch what is not the atom's.
  REQUIRE(row != taken_row);
  CHECK(refused(Begin{12, {Part{1, 2, row, 1, cells_of(1)}}}));
  AtomOffer odd_place = at_rest;
  odd_place.place = 1000;
  CHECK(refused(Offer{0, 4, odd_place, cells_of(0)}));
  CHECK(refused(Control{static_cast<Control::Kind>(200), {}, {}}));

  // Attempts: of interactions with locks, from their coordinator or after it, with what they need.
  const Scattered match([](ImageBuilder& b) { build_match(b, 2); }, 1);
  const Tables& of_match = match.core->tables();
  const Codec lock_codec(of_match, match.distribution, 42);
  const u32 meets = of_match.types[of_match.atoms[0].type].first_transition;
  const Offer client{0, 4, {0, {}, {meets}, 5, 1}, {}};
  const auto reads = [&](const Message& message, u32 from, u32 to) {
    std::string text;
    lock_codec.write({from, to, 1, 0, 0, {message}}, text);
    for (std::size_t size = 0; size < text.size(); ++size)
      CHECK_FALSE(lock_codec.read(std::string_view(text).substr(0, size), from, to, read));
    if (!lock_codec.read(text, from, to, read)) return false;
    std::string copy;
    lock_codec.write(read, copy);
    return copy == text;
  };
  CHECK(reads(Lock{0_i, 1, {client}}, 0, 2));
  CHECK_FALSE(reads(Lock{0_i, 1, {client}}, 0, 3));
  CHECK_FALSE(reads(Lock{0_i, 1, {client}}, 1, 0));
  CHECK_FALSE(reads(Lock{0_i, 0, {client}}, 0, 2));
  CHECK_FALSE(reads(Lock{0_i, 2, {client}}, 0, 2));
  CHECK_FALSE(reads(Lock{0_i, 2, {client, client}}, 0, 2));
  CHECK_FALSE(reads(Lock{3_i, 1, {client}}, 0, 3));
  // A simple atom offers each port of its place, once.
  CHECK_FALSE(reads(Lock{0_i, 1, {{0, 4, {0, {}, {}, 5, 1}, {}}}}, 0, 2));
  CHECK_FALSE(reads(Lock{0_i, 1, {{0, 4, {0, {}, {meets, meets}, 5, 1}, {}}}}, 0, 2));
  CHECK(reads(Release{0_i, true, false, {0}}, 2, 0));
  CHECK(reads(Release{0_i, false, true, {2}}, 0, 2));
  CHECK_FALSE(reads(Release{0_i, true, false, {1}}, 2, 0));
  CHECK_FALSE(reads(Release{0_i, true, false, {0}}, 1, 2));
  CHECK(reads(Wake{0_i}, 2, 0));
  CHECK_FALSE(reads(Wake{0_i}, 2, 1));
  CHECK_FALSE(reads(Wake{4_i}, 2, 0));

  // Any bytes: read without a fault, and what is read can be written.
  std::size_t taken = 0;
  for (int k = 0; k < 100000; ++k) {
    std::string odd = bytes;
    for (u64 edits = 1 + draws.below(4); edits > 0; --edits) {
      const std::size_t at = draws.below(odd.size());
      switch (draws.below(4)) {
        case 0: odd[at] = static_cast<char>(draws.below(256)); break;
        case 1: odd.erase(at, 1 + draws.below(8)); break;
        case 2: odd.insert(at, 1 + draws.below(12), static_cast<char>(draws.below(256))); break;
        default: odd[at] = static_cast<char>(odd[at] ^ (1 << draws.below(8))); break;
      }
      if (odd.empty()) odd = "x";
    }
    if (!codec.read(odd, static_cast<u32>(draws.below(peers)), static_cast<u32>(draws.below(peers)), read)) continue;
    ++taken;
    again.clear();
    codec.write(read, again);
  }
  CHECK(taken != 0);
}

namespace {

// Two ends in one process; frames wait until they are asked for, or get lost.
class LossyFabric final : public Fabric {
 public:
  LossyFabric(u32 self, Prng& draws, std::vector<std::pair<u32, std::string>>& on_the_way)
      : self_(self), draws_(draws), on_the_way_(on_the_way) {}
  void send(u32 peer, std::string_view bytes) override {
    if (draws_.below(4) != 0) on_the_way_.emplace_back(peer, std::string(bytes));
    if (draws_.below(8) == 0) on_the_way_.emplace_back(peer, std::string(bytes));
  }
  bool wait(int, const std::vector<int>&, std::vector<Arrival>& arrivals) override {
    for (std::size_t k = 0; k < on_the_way_.size();) {
      if (on_the_way_[k].first != self_ || draws_.below(2) == 0) {
        ++k;
        continue;
      }
      arrivals.push_back({1 - self_, on_the_way_[k].second});
      on_the_way_.erase(on_the_way_.begin() + static_cast<std::ptrdiff_t>(k));
    }
    return false;
  }
  FabricCounts counts() override { return {}; }

 private:
  u32 self_;
  Prng& draws_;
  std::vector<std::pair<u32, std::string>>& on_the_way_;
};

// Keeps what is sent.
class KeptFabric final : public Fabric {
 public:
  void send(u32, std::string_view bytes) override { sent.emplace_back(bytes); }
  bool wait(int, const std::vector<int>&, std::vector<Arrival>&) override { return false; }
  FabricCounts counts() override { return {}; }

  std::vector<std::string> sent;
};

}  // namespace

TEST_CASE("stations hand over what is said once and in order, and rest when all is confirmed") {
  const Scattered pairs = scattered_pairs(3);
  const Codec codec(pairs.core->tables(), pairs.distribution, 1);
  for (u64 seed = 1; seed <= 20; ++seed) {
    Prng draws(seed);
    std::vector<std::pair<u32, std::string>> on_the_way;
    LossyFabric fabrics[] = {{0, draws, on_the_way}, {1, draws, on_the_way}};
    Station stations[] = {{fabrics[0], codec, 0, 2}, {fabrics[1], codec, 1, 2}};
    u64 said[] = {0, 0}, heard[] = {0, 0};
    i64 now = 1;
    stations[1].greet(0);
    for (int turn = 0; turn < 3000; ++turn, now += 1000000) {
      for (u32 self = 0; self < 2; ++self) {
        std::vector<Arrival> arrivals;
        (void)fabrics[self].wait(0, {}, arrivals);
        arrivals.push_back({1 - self, "odd"});
        std::vector<ReceivedMessage> messages;
        for (const Arrival& arrival : arrivals) stations[self].take(arrival, now, messages);
        for (const ReceivedMessage& message : messages) REQUIRE(std::get<Stop>(message.message).step == ++heard[self]);
        // More than one frame may carry.
        if (turn < 200 && draws.below(8) == 0) {
          for (u64 n = draws.below(3000); n > 0; --n) stations[self].say(1 - self, Stop{++said[self]});
        }
        (void)stations[self].tick_clock();
        stations[self].send(now);
        stations[self].tick(now);
      }
    }
    // Frames get lost, and are repeated every two seconds at least.
    for (int turn = 0; turn < 200; ++turn, now += 500000000) {
      for (u32 self = 0; self < 2; ++self) {
        std::vector<Arrival> arrivals;
        (void)fabrics[self].wait(0, {}, arrivals);
        std::vector<ReceivedMessage> messages;
        for (const Arrival& arrival : arrivals) stations[self].take(arrival, now, messages);
        for (const ReceivedMessage& message : messages) REQUIRE(std::get<Stop>(message.message).step == ++heard[self]);
        stations[self].tick(now);
      }
    }
    CHECK(heard[0] == said[1]);
    CHECK(heard[1] == said[0]);
    CHECK(stations[0].due() == kForever);
    CHECK(stations[1].due() == kForever);
    CHECK(stations[0].counts().refused >= 3000);
    CHECK(stations[0].clock() + 1 >= stations[1].clock());
  }
}

namespace {

/// Two stations, the frames between them that have not arrived yet, and the messages that have.
struct TwoStations {
  Scattered pairs = scattered_pairs(3);
  Codec codec{pairs.core->tables(), pairs.distribution, 1};
  KeptFabric fabrics[2];
  Station stations[2] = {{fabrics[0], codec, 0, 2}, {fabrics[1], codec, 1, 2}};
  std::vector<ReceivedMessage> heard;

  void carry(u32 from, i64 now) {
    for (const std::string& bytes : std::exchange(fabrics[from].sent, {}))
      stations[1 - from].take({from, bytes}, now, heard);
  }
  void greet() {
    for (const u32 self : {0u, 1u}) stations[self].greet(1 - self);
    for (const u32 self : {0u, 1u}) carry(self, 1);
  }
};

}  // namespace

TEST_CASE("stations measure round trips, but not of frames that came late on purpose or were sent again") {
  TwoStations two;
  KeptFabric(&fabrics)[2] = two.fabrics;
  Station(&stations)[2] = two.stations;
  const auto carry = [&](u32 from, i64 now) { two.carry(from, now); };
  const auto say = [&](u32 from, i64 now) {
    stations[from].say(1 - from, Stop{1});
    stations[from].send(now);
  };
  // What each has said before it heard of the other is sent again.
  two.greet();
  CHECK(stations[0].round_trip(1) == 0);
  const auto ask = [&](i64 now, i64 there) {
    say(0, now);
    carry(0, now + there);
    say(1, now + there);
    carry(1, now + 2 * there);
  };
  ask(1000000, 400000);
  CHECK(stations[0].round_trip(1) == 800000);
  ask(2000000, 800000);
  CHECK(stations[0].round_trip(1) == 900000);
  // An answer without messages.
  say(0, 4000000);
  carry(0, 4100000);
  stations[1].tick(4100000 + Station::kAnswerAfter);
  CHECK(fabrics[1].sent.size() == 1);
  carry(1, 4200000 + Station::kAnswerAfter);
  CHECK(stations[0].round_trip(1) == 900000);
  CHECK(stations[0].due() == kForever);
  // A frame that is lost.
  say(0, 30000000);
  fabrics[0].sent.clear();
  stations[0].tick(30000000 + Station::kAgainAfter);
  carry(0, 30000000 + Station::kAgainAfter);
  say(1, 30000000 + Station::kAgainAfter);
  carry(1, 30000000 + Station::kAgainAfter);
  CHECK(stations[0].round_trip(1) == 900000);
  CHECK(stations[0].link(1).unconfirmed().empty());
}

TEST_CASE("what is lost before a peer is connected is sent again soon, and later with patience") {
  TwoStations two;
  Station(&stations)[2] = two.stations;
  const auto lose = [&](i64 now) {
    stations[0].say(1, Stop{1});
    stations[0].send(now);
    two.fabrics[0].sent.clear();
  };
  lose(1000000);
  CHECK(stations[0].due() == 1000000 + Station::kFirstAgainAfter);
  stations[0].tick(stations[0].due());
  CHECK(stations[0].counts().again == 1);
  two.carry(0, 20000000);
  stations[1].tick(20000000 + Station::kAnswerAfter);
  two.carry(1, 20000000 + Station::kAnswerAfter);
  CHECK(stations[0].link(1).unconfirmed().empty());
  lose(50000000);
  CHECK(stations[0].due() == 50000000 + Station::kAgainAfter);
}

TEST_CASE("stations repeat one frame to learn whether the others were lost") {
  TwoStations two;
  KeptFabric(&fabrics)[2] = two.fabrics;
  Station(&stations)[2] = two.stations;
  const auto carry = [&](u32 from, i64 now) { two.carry(from, now); };
  two.greet();
  i64 now = 1000000;
  for (u64 n = 1; n <= 100; ++n, now += 1000) {
    stations[0].say(1, Stop{n});
    stations[0].send(now);
  }
  now += Station::kAgainAfter;
  SECTION("a peer that is only slow gets one frame a second time") {
    stations[0].tick(now);
    CHECK(stations[0].counts().again == 1);
    carry(0, now);
    stations[1].tick(now + Station::kAnswerAfter);
    carry(1, now + Station::kAnswerAfter);
    CHECK(stations[0].counts().again == 1);
  }
  SECTION("what was lost is sent again as soon as the first frame is confirmed") {
    fabrics[0].sent.clear();
    stations[0].tick(now);
    carry(0, now);
    stations[1].tick(now + Station::kAnswerAfter);
    carry(1, now + Station::kAnswerAfter);
    CHECK(stations[0].counts().again == 100);
    carry(0, now + 2 * Station::kAnswerAfter);
    stations[1].tick(now + 3 * Station::kAnswerAfter);
    carry(1, now + 3 * Station::kAnswerAfter);
  }
  SECTION("a peer that is gone gets one frame each time") {
    fabrics[0].sent.clear();
    for (int k = 0; k < 5; ++k, now += Station::kAgainAtMost) stations[0].tick(now);
    CHECK(stations[0].counts().again == 5);
    return;
  }
  CHECK(two.heard.size() == 100);
  CHECK(stations[0].link(1).unconfirmed().empty());
  CHECK(stations[0].due() == kForever);
}

TEST_CASE("faults are read, or told what is wrong with them") {
  const std::vector<std::string> nodes{"1", "lab"};
  const auto read = read_faults("cut 1-lab 3s..1min, crash lab 5s500ms,slow 1 x10, lose 5%, double 7%", nodes);
  REQUIRE(read);
  const NetworkFaults& faults = *read;
  REQUIRE(faults.cuts.size() == 1);
  CHECK(faults.cuts[0].from == 3'000'000'000);
  CHECK(faults.cuts[0].until == 60'000'000'000);
  REQUIRE(faults.crashes.size() == 1);
  CHECK(faults.crashes[0].node == 1);
  CHECK(faults.crashes[0].at == 5'500'000'000);
  CHECK(faults.slowness_of(0) == 10);
  CHECK(faults.slowness_of(1) == 1);
  CHECK(faults.lost_percent == 5);
  CHECK(faults.doubled_percent == 7);
  for (const char* wrong :
       {"cat 1-lab 1s..2s", "cut 1-1 1s..2s", "cut 1-lab 2s..1s", "cut 1-lab 1s", "cut 1 1s..2s", "cut 1-lab 1..2",
        "crash 3 5s", "crash lab", "crash lab 5 s", "crash lab 99999999999999999999s", "slow 1 10", "slow 1 x0",
        "slow 1 x1001", "lose 51%", "lose 5", "double 5%,", ",", "lose 5% now"}) {
    INFO(wrong);
    CHECK_FALSE(read_faults(wrong, nodes));
  }
}

TEST_CASE("an interaction of n nodes costs 2(n-1) messages") {
  for (int n = 2; n <= 6; ++n) {
    ImageBuilder b;
    b.atom_type({.name = "A",
                 .ports = {{.name = "go"}},
                 .places = {"S"},
                 .initial = {"S"},
                 .transitions = {{"go", {"S"}, {"S"}}}});
    ConnectorTypeSpec all{.name = "All"};
    std::vector<std::string> ports;
    for (int i = 0; i < n; ++i) {
      all.params.push_back({"p" + std::to_string(i), 0});
      all.define += " p" + std::to_string(i);
      b.atom("a" + std::to_string(i), "A");
      ports.push_back("a" + std::to_string(i) + ".go");
    }
    b.connector_type(all);
    b.connector("all", "All", ports);
    const SimulatedResult result = simulated(b.image(), apart(b.image()), 1, 100);
    CHECK(result.border_steps == 100);
    CHECK(result.begins == 100u * static_cast<unsigned>(n - 1));
    CHECK(result.offers == 100u * static_cast<unsigned>(n - 1));
  }
}

TEST_CASE("what does not compete costs two messages, however much there is of it") {
  for (const bool is_ring : {false, true}) {
    ImageBuilder b;
    if (is_ring) build_ring(b, 12);
    else build_pairs(b, 12);
    const SimulatedResult result = simulated(b.image(), apart(b.image()), 3, 600);
    CHECK(result.steps == 600);
    CHECK(result.border_steps == 600);
    CHECK(result.begins == 600);
    // A station of the ring offers to the next one's coordinator: to itself, or to another node.
    CHECK(result.offers <= 600u + (is_ring ? 600u : 0u));
  }
}

TEST_CASE("conflict sets: places tell what competes") {
  const auto sets_of = [](ImageBuilder& b) {
    const Core core(b.image());
    return conflict_sets(core.tables(), core.priorities());
  };
  {
    ImageBuilder b;
    build_pairs(b, 8);
    CHECK(sets_of(b).count == 8);
  }
  {
    ImageBuilder b;
    build_ring(b, 8);
    CHECK(sets_of(b).count == 8);
  }
  {
    // Each fork's two neighbours compete for it while it lies there; and by places, all that put forks down.
    ImageBuilder b;
    build_philosophers(b, 8, true);
    const ConflictSets sets = sets_of(b);
    CHECK(sets.count == 8 + 1);
    u32 largest = 0;
    for (u32 set = 0; set < sets.count; ++set) largest = std::max<u32>(largest, sets.interactions[set].size);
    CHECK(largest == 8);
  }
}

TEST_CASE("a checkpoint is the state after its steps, and a run goes on from it") {
  ImageBuilder b;
  build_philosophers(b, 6, false);
  const Image& image = b.image();
  std::size_t odd_states = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    char name[] = "/tmp/bip-checkpoint-XXXXXX";
    const int file = mkstemp(name);
    REQUIRE(file >= 0);
    close(file);
    RunOptions options;
    options.limit = 300;
    options.checkpoint_every = 30000000;
    options.checkpoint_path = name;
    const RunOutput first = output_of(image, seed, options.limit, "lose 10%, slow 2 x3", OnLoss::Stop, options);
    (void)check(image, first);
    CHECK(first.err.find("bipc: go on after step ") == 0);
    // The recorded steps before it lead there.
    Core core(image), followed(image);
    REQUIRE(core.initialize());
    REQUIRE(followed.initialize());
    Checkpoint checkpoint;
    REQUIRE(resume(core, name, checkpoint) == "");
    CHECK(checkpoint.steps > 0);
    CHECK(checkpoint.steps < options.limit);
    RecordedReader reader;
    RecordedBegin begin;
    RecordedEnd end;
    REQUIRE(reader.open(first.trace, begin).empty());
    for (u64 step = 0; step < checkpoint.steps; ++step) {
      EnabledSet::Position at{};
      REQUIRE(reader.next(at, end) == RecordedReader::Next::Step);
      REQUIRE(followed.take(at));
    }
    CHECK(followed.snapshot() == checkpoint.state);
    odd_states += bip::testing::check_odd_checkpoints(image, core, checkpoint, seed);
    RunOptions more;
    more.resume_path = name;
    const RunOutput second = output_of(image, seed + 1, 200, "double 20%", OnLoss::Stop, more);
    CHECK(second.result.steps == 200);
    (void)check(image, second, name);
    std::remove(name);
  }
  CHECK(odd_states != 0);
}

TEST_CASE("messages that come again change nothing") {
  Scattered pairs = scattered_pairs(2);
  Node nodes[] = {{pairs.image(), {}, pairs.distribution, 0}, {pairs.image(), {}, pairs.distribution, 1}};
  for (Node& node : nodes) REQUIRE(node.start(pairs.core->snapshot()));
  u64 steps = 0;
  std::vector<u32> atoms;
  for (int turn = 0; turn < 200; ++turn) {
    for (Node& node : nodes) {
      if (node.work_count() != 0) node.run(0);
      if (node.core().candidate_count() != 0 && node.core().partial().is_decided(node.core().position(0).interaction))
        node.begin(node.core().position(0), steps++, atoms);
      const std::vector<Outgoing> said = std::exchange(node.outbox(), {});
      for (const Outgoing& outgoing : said) {
        nodes[outgoing.to].take(outgoing.message);
        nodes[outgoing.to].take(outgoing.message);
      }
    }
  }
  CHECK(steps > 50);
  CHECK(nodes[0].counts().stale + nodes[1].counts().stale ==
        nodes[0].counts().offers + nodes[1].counts().offers + nodes[0].counts().begins + nodes[1].counts().begins);
}

namespace {

// Nodes that hear each other at once. With `is_odd` each also hears what no sound peer says, which it has to refuse.
struct OddTalk {
  const Image& image;
  const Distribution& distribution;
  bool is_odd;
  std::vector<std::unique_ptr<Node>> nodes;
  std::vector<InteractionId> steps;
  u64 refused = 0;

  OddTalk(const Core& core, const Distribution& with, bool odd) : image(core.image()), distribution(with), is_odd(odd) {
    for (u32 node = 0; node < with.placement.nodes.size(); ++node) {
      nodes.push_back(std::make_unique<Node>(image, CoreOptions{}, with, node));
      REQUIRE(nodes.back()->start(core.snapshot()));
    }
    for (int turn = 0; turn < 300; ++turn) {
      for (const auto& node : nodes) go_on(*node);
    }
    for (const auto& node : nodes) CHECK_FALSE(node->is_stopped());
  }

  void go_on(Node& node) {
    std::vector<u32> atoms;
    if (node.try_count() != 0) node.try_lock(0);
    const InteractionId locked = node.locked_interaction();
    for (u64 k = 0; k < node.core().candidate_count(); ++k) {
      const EnabledSet::Position at = node.core().position(k);
      if (locked.is_valid() ? at.interaction != locked : !node.core().partial().is_decided(at.interaction)) continue;
      node.begin(at, steps.size(), atoms);
      steps.push_back(at.interaction);
      break;
    }
    if (node.work_count() != 0) node.run(0);
    const std::vector<Outgoing> said = std::exchange(node.outbox(), {});
    for (const Outgoing& outgoing : said) {
      Node& to = *nodes[outgoing.to];
      if (is_odd) say_before(to, outgoing.message);
      to.take(outgoing.message);
      if (is_odd) say_after(to, outgoing.message);
    }
  }

  void say_odd(Node& to, const Message& message) {
    const u64 before = to.counts().refused;
    const std::size_t said = to.outbox().size();
    to.take(message);
    CHECK(to.counts().refused == before + 1);
    CHECK(to.outbox().size() == said);
    ++refused;
  }
  void say_before(Node& to, const Message& message) {
    if (const auto* const begin = std::get_if<Begin>(&message)) {
      // A transition that leaves another place.
      Begin odd = *begin;
      odd.parts.resize(1);
      const Tables& tables = to.core().tables();
      const LinkedType& type = tables.types[tables.atoms[odd.parts[0].atom].type];
      const u32 from = tables.transitions[odd.parts[0].transition].from;
      for (u32 row = type.first_transition; row < type.first_transition + type.transition_count; ++row) {
        odd.parts[0].transition = row;
        if (tables.transitions[row].from != from) return say_odd(to, odd);
      }
    } else if (const auto* const release = std::get_if<Release>(&message);
               release != nullptr && !release->atoms.empty()) {
      // Of an attempt that did not take the atom.
      for (const InteractionId other : distribution.coordinator_of.ids()) {
        const Span<u32> needs = distribution.needs[other];
        if (other != release->interaction && std::find(needs.begin(), needs.end(), release->atoms[0]) != needs.end())
          return say_odd(to, Release{other, true, false, {release->atoms[0]}});
      }
    } else if (const auto* const lock = std::get_if<Lock>(&message)) {
      // It has what is to be locked, of another time.
      Lock odd = *lock;
      for (const u32 atom : distribution.needs[odd.interaction]) {
        if (distribution.home(atom) != number_of(to)) continue;
        odd.held.push_back({atom, ~u64{0}, {}, {}});
        return say_odd(to, odd);
      }
    }
  }
  void say_after(Node& to, const Message& message) {
    if (const auto* const offer = std::get_if<Offer>(&message)) {
      Offer odd = *offer;
      ++odd.n;
      say_odd(to, odd);
    } else if (const auto* const begin = std::get_if<Begin>(&message)) {
      Begin odd = *begin;
      odd.parts.resize(1);
      ++odd.parts[0].n;
      say_odd(to, odd);
      odd.parts[0].n = ~u64{0};
      say_odd(to, odd);
    }
  }
  [[nodiscard]] u32 number_of(const Node& to) const {
    for (u32 node = 0; node < nodes.size(); ++node) {
      if (nodes[node].get() == &to) return node;
    }
    return kNone;
  }
};

}  // namespace

TEST_CASE("what no sound peer says is refused and counted, and changes nothing") {
  for (const bool is_split : {false, true}) {
    const Scattered model = is_split ? Scattered([](ImageBuilder& b) { build_match(b, 3); }, 1) : scattered_pairs(6);
    const OddTalk quiet(*model.core, model.distribution, false), disturbed(*model.core, model.distribution, true);
    CHECK(quiet.steps.size() > 100);
    CHECK(disturbed.steps == quiet.steps);
    CHECK(disturbed.refused > 200);
  }
}

namespace {

// Nodes whose messages take any time, but come in order; attempts that are parked give up at any time.
struct Impatient {
  const Distribution& distribution;
  Prng draws;
  std::vector<std::unique_ptr<Node>> nodes;
  std::vector<std::deque<Message>> links;   // by from * nodes + to
  std::vector<std::pair<u32, u64>> parked;  // node, number
  bip::IndexVector<InteractionId, u64> steps;
  u64 step = 0, ended = 0, at_work = 0;

  Impatient(const Core& core, const Distribution& with, u64 seed)
      : distribution(with), draws(seed), steps(core.tables().interactions.size(), 0) {
    const u32 count = static_cast<u32>(with.placement.nodes.size());
    links.resize(u64{count} * count);
    for (u32 node = 0; node < count; ++node) {
      nodes.push_back(std::make_unique<Node>(core.image(), CoreOptions{}, with, node));
      REQUIRE(nodes.back()->start(core.snapshot()));
    }
  }
  void go_on() {
    const u32 count = static_cast<u32>(nodes.size());
    const u32 self = static_cast<u32>(draws.below(count));
    Node& node = *nodes[self];
    switch (draws.below(5)) {
      case 0:
        if (node.try_count() != 0) node.try_lock(draws.below(node.try_count()));
        break;
      case 1: begin(node); break;
      case 2:
        if (node.work_count() != 0) node.run(draws.below(node.work_count()));
        break;
      case 3: end_parking(); break;
      default: take_message();
    }
    hand_over();
  }
  void take_message() {
    std::vector<std::size_t> full;
    for (std::size_t link = 0; link < links.size(); ++link) {
      if (!links[link].empty()) full.push_back(link);
    }
    if (full.empty()) return;
    const std::size_t at = full[draws.below(full.size())];
    nodes[at % nodes.size()]->take(links[at].front());
    links[at].pop_front();
  }
  void end_parking() {
    if (parked.empty()) return;
    // Rather where the component is at work, which its node alone knows.
    std::size_t k = 0;
    while (k < parked.size() && nodes[parked[k].first]->work_count() == 0) ++k;
    if (k == parked.size()) {
      if (draws.below(4) != 0) return;
      k = draws.below(parked.size());
    }
    const auto [at, number] = parked[k];
    parked.erase(parked.begin() + static_cast<std::ptrdiff_t>(k));
    Node& node = *nodes[at];
    const u64 releases = node.counts().releases;
    node.end_parking(number);
    if (node.counts().releases == releases) return;
    ++ended;
    if (node.work_count() != 0) ++at_work;
    // It has ended.
    const u64 said = node.counts().releases;
    node.end_parking(number);
    CHECK(node.counts().releases == said);
  }
  void begin(Node& node) {
    std::vector<u32> atoms;
    const InteractionId locked = node.locked_interaction();
    std::vector<EnabledSet::Position> all;
    for (u64 k = 0; k < node.core().candidate_count(); ++k) {
      const EnabledSet::Position at = node.core().position(k);
      if (locked.is_valid() ? at.interaction == locked : node.core().partial().is_decided(at.interaction))
        all.push_back(at);
    }
    if (all.empty()) return;
    const EnabledSet::Position at = all[draws.below(all.size())];
    ++steps[at.interaction];
    node.begin(at, step++, atoms);
  }
  void hand_over() {
    const u32 count = static_cast<u32>(nodes.size());
    for (u32 from = 0; from < count; ++from) {
      for (Outgoing& said : std::exchange(nodes[from]->outbox(), {}))
        links[from * count + said.to].push_back(std::move(said.message));
      for (const Node::Parking& one : std::exchange(nodes[from]->new_parkings(), {}))
        parked.emplace_back(from, one.number);
    }
  }
};

}  // namespace

TEST_CASE("attempts that give up at any time are not forgotten") {
  u64 ended = 0, at_work = 0;
  for (u64 seed = 1; seed <= 12; ++seed) {
    const Scattered table([](ImageBuilder& b) { build_philosophers(b, 5, false); }, 1);
    Impatient run(*table.core, table.distribution, seed);
    for (int turn = 0; turn < 40000; ++turn) run.go_on();
    for (const u64 count : run.steps) CHECK(count > 20);
    for (const auto& node : run.nodes) {
      CHECK(node->counts().refused == 0);
      CHECK_FALSE(node->is_stopped());
    }
    ended += run.ended;
    at_work += run.at_work;
  }
  CHECK(ended > 1000);
  CHECK(at_work > 10);
}

namespace {

// Who can always meet, and who can only once it is back.
void add_types_of_who_is_away(ImageBuilder& b) {
  b.atom_type({.name = "One",
               .ports = {{.name = "meet"}, {.name = "other"}},
               .places = {"S"},
               .initial = {"S"},
               .transitions = {{"meet", {"S"}, {"S"}}, {"other", {"S"}, {"S"}}}});
  b.atom_type({.name = "Away",
               .ports = {{.name = "meet"}, {.name = "back"}},
               .places = {"AWAY", "FREE"},
               .initial = {"AWAY"},
               .transitions = {{"meet", {"FREE"}, {"FREE"}}, {"back", {"AWAY"}, {"FREE"}}}});
  b.connector_type({.name = "Alone", .params = {{"p", 0}}, .define = "p"});
  b.connector_type({.name = "Two", .params = {{"p", 0}, {"q", 0}}, .define = "p q"});
}

}  // namespace

TEST_CASE("an attempt that gives up at a component at work is woken when that rests") {
  const Scattered model(
      [](ImageBuilder& b) {
        add_types_of_who_is_away(b);
        for (const char* name : {"a", "c", "d"}) b.atom(name, "One");
        b.atom("b", "Away");
        b.connector("ab", "Two", {"a.meet", "b.meet"});
        b.connector("cb", "Two", {"c.meet", "b.meet"});
        b.connector("ad", "Two", {"a.other", "d.meet"});
        b.connector("back", "Alone", {"b.back"});
      },
      1);
  // Atoms a, c, d, b are at home on the nodes 0 to 3; a coordinates ab, and b is shared.
  REQUIRE(model.distribution.coordinator_of[0_i] == 0);
  REQUIRE(model.distribution.locks[0_i].size == 1);
  Node here(model.core->image(), {}, model.distribution, 0), there(model.core->image(), {}, model.distribution, 3);
  REQUIRE(here.start(model.core->snapshot()));
  REQUIRE(there.start(model.core->snapshot()));
  const auto carry = [](Node& from, u32 self, Node& to) {
    std::size_t count = 0;
    for (const Outgoing& said : std::exchange(from.outbox(), {})) {
      if (said.to != self) continue;
      to.take(said.message);
      ++count;
    }
    return count;
  };
  const auto try_ab = [&] {
    while (here.try_count() != 0 && here.counts().locks == 0) here.try_lock(0);
  };
  try_ab();
  REQUIRE(here.counts().locks == 1);
  REQUIRE(carry(here, 3, there) == 1);
  REQUIRE(there.new_parkings().size() == 1);
  CHECK(there.has_parked());
  std::vector<u32> atoms;
  REQUIRE(there.core().candidate_count() == 1);
  there.begin(there.core().position(0), 0, atoms);
  REQUIRE(there.work_count() == 1);
  there.end_parking(there.new_parkings()[0].number);
  CHECK_FALSE(there.has_parked());
  CHECK(carry(there, 0, here) == 1);
  CHECK(here.try_count() == 0);
  there.run(0);
  CHECK(there.counts().wakes == 1);
  CHECK(carry(there, 0, here) == 1);
  REQUIRE(here.try_count() == 1);
  here.try_lock(0);
  REQUIRE(carry(here, 3, there) == 1);
  CHECK(there.locked_interaction() == 0_i);
  // What was said of the one before is of none.
  there.end_parking(there.new_parkings()[0].number);
  CHECK(there.locked_interaction() == 0_i);
  CHECK(here.counts().refused + there.counts().refused == 0);
}

TEST_CASE("an attempt that gives up at a component that another has locked is woken when that is given back") {
  const Scattered model(
      [](ImageBuilder& b) {
        add_types_of_who_is_away(b);
        b.connector_type({.name = "Three", .params = {{"p", 0}, {"q", 0}, {"r", 0}}, .define = "p q r"});
        for (const char* name : {"a", "c", "d", "e", "f"}) b.atom(name, "One");
        for (const char* name : {"x", "z"}) b.atom(name, "Away");
        b.connector("axz", "Three", {"a.meet", "x.meet", "z.meet"});
        b.connector("cx", "Two", {"c.meet", "x.meet"});
        b.connector("ad", "Two", {"a.other", "d.meet"});
        b.connector("ce", "Two", {"c.other", "e.meet"});
        b.connector("fz", "Two", {"f.meet", "z.meet"});
        b.connector("x_back", "Alone", {"x.back"});
        b.connector("z_back", "Alone", {"z.back"});
      },
      1);
  constexpr u32 kA = 0, kC = 1, kX = 5, kZ = 6;
  REQUIRE(model.distribution.coordinator_of[0_i] == kA);
  REQUIRE(model.distribution.coordinator_of[1_i] == kC);
  REQUIRE(model.distribution.locks[0_i].size == 2);
  REQUIRE(model.distribution.locks[1_i].size == 1);
  std::vector<std::unique_ptr<Node>> nodes;
  for (u32 self = 0; self < 7; ++self) {
    nodes.push_back(std::make_unique<Node>(model.core->image(), CoreOptions{}, model.distribution, self));
    REQUIRE(nodes.back()->start(model.core->snapshot()));
  }
  Node &a = *nodes[kA], &c = *nodes[kC], &x = *nodes[kX], &z = *nodes[kZ];
  const auto carry_all = [&] {
    for (bool is_quiet = false; !is_quiet;) {
      is_quiet = true;
      for (const auto& from : nodes) {
        for (const Outgoing& said : std::exchange(from->outbox(), {})) {
          nodes[said.to]->take(said.message);
          is_quiet = false;
        }
      }
    }
  };
  while (a.try_count() != 0 && a.counts().locks == 0) a.try_lock(0);
  carry_all();
  while (c.try_count() != 0 && c.counts().locks == 0) c.try_lock(0);
  carry_all();
  REQUIRE(x.new_parkings().size() == 2);
  // x comes back, and goes to the first, which waits for z.
  std::vector<u32> atoms;
  REQUIRE(x.core().candidate_count() == 1);
  x.begin(x.core().position(0), 0, atoms);
  x.run(0);
  carry_all();
  REQUIRE(z.new_parkings().size() == 1);
  CHECK(x.has_parked());
  x.end_parking(x.new_parkings()[1].number);
  carry_all();
  CHECK(c.try_count() == 0);
  CHECK(x.counts().wakes == 0);
  // The first gives up, too, and x is as it was.
  z.end_parking(z.new_parkings()[0].number);
  carry_all();
  CHECK(x.counts().wakes == 1);
  CHECK(c.try_count() == 1);
}

TEST_CASE("a step that a node tells of is one, or is refused") {
  Scattered pairs = scattered_pairs(2);
  RunOptions options;
  std::FILE* out = std::tmpfile();
  RunFile no_trace({}, stderr);
  Output output(options, 1, out, no_trace, pairs.image());
  StepMerge merge(*pairs.core, pairs.distribution, output);
  const auto is_taken = [&](std::vector<u64> numbers, std::vector<std::string> texts) {
    return merge.take_begun(0, Control{Control::Kind::Begun, std::move(numbers), std::move(texts)});
  };
  const u64 first = step_at(1, 0), second = step_at(2, 0);
  CHECK_FALSE(is_taken({first, 0, 0}, {"a", "b"}));
  CHECK_FALSE(is_taken({first, 0, 0, 0}, {"a"}));
  CHECK_FALSE(is_taken({step_at(1, 1), 0, 0, 0}, {"a", "b"}));
  CHECK_FALSE(is_taken({first, 1000, 0, 0}, {"a", "b"}));
  // A number that would stand behind the end of its text; a part at home on no node.
  CHECK_FALSE(is_taken({first, 0, 3, 0}, {"a", "b"}));
  CHECK_FALSE(is_taken({first, 0, 0, 99}, {"a", "b"}));
  CHECK_FALSE(is_taken({first, 0, 0, 0, 7}, {"a", "b"}));
  merge.write_until(second);
  CHECK(merge.written() == 0);
  CHECK(is_taken({first, 0, 2, 0}, {"at the end ", ""}));
  CHECK(is_taken({second, 0, 1, 1}, {" steps before", ""}));
  const u64 bytes = record_bytes({"at the end ", ""}) + record_bytes({" steps before", ""});
  CHECK(merge.waiting_bytes() == bytes);
  merge.write_until(second);
  CHECK(merge.written() == 2);
  CHECK(merge.last_written() == second);
  CHECK(merge.waiting_bytes() == 0);
  CHECK(merge.written_bytes() == bytes);
  CHECK(merge.most_waiting_bytes() == bytes);
  const auto many = [&](std::vector<u64> numbers, std::vector<std::string> texts) {
    return merge.take_many(0, Control{Control::Kind::Took, std::move(numbers), std::move(texts)});
  };
  const u64 third = step_at(3, 0);
  CHECK(many({third}, {"", ""}) == 0);
  CHECK(many({third, 0, 0, 0, 1}, {"a", ""}) == 0);
  CHECK(many({second, 0, 0, 0, 1, 0}, {"a", ""}) == 0);
  CHECK(many({step_at(3, 1), 0, 0, 0, 1, 0}, {"a", ""}) == 0);
  CHECK(many({third, 1000, 0, 0, 1, 0}, {"a", ""}) == 0);
  // A number behind its own text; lengths that are not those of the texts.
  CHECK(many({third, 0, 3, 0, 1, 0, 0, 0, 0, 1, 0}, {"ab", ""}) == 0);
  CHECK(many({third, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0}, {"ab", ""}) == 0);
  CHECK(many({third, 0, 0, 0, 1, 0}, {"ab", ""}) == 0);
  CHECK(many({third, 0, 0, 0, 1, 0}, {"a", "b"}) == 0);
  CHECK(many({third, 0, 0, 0, 1, ~u64{0}}, {"a", "b"}) == 0);
  CHECK(many({third, 0, 2, 0, 1, 0, 0, 1, 0, 1, 0}, {"ab", ""}) == 2);
  CHECK(many({third, 0, 0, 0, 1, 0}, {"a", ""}) == 0);
  CHECK(merge.waiting_bytes() == record_bytes({"ab", ""}, 2));
  merge.write_until(third);
  CHECK(merge.written() == 4);
  // Texts are written: interactions alone are not enough.
  CHECK(merge.take_fired(0, fired_message(step_at(4, 0), {0, 1})) == 0);
  std::fclose(out);
}

TEST_CASE("steps of which the launcher has only the interactions are written as one by one") {
  Scattered pairs = scattered_pairs(2);
  const auto trace_of = [&](bool at_once) {
    const std::string path = "merge_fired.trace";
    RunOptions options;
    options.silent = true;
    options.trace_path = path;
    options.format = TraceFormat::Binary;
    {
      RunFile trace(path, stderr);
      REQUIRE(trace.open());
      std::FILE* out = std::tmpfile();
      Output output(options, 1, out, trace, pairs.image());
      REQUIRE(output.records_only());
      StepMerge merge(*pairs.core, pairs.distribution, output);
      const u64 first = step_at(1, 0), second = step_at(2, 0);
      CHECK(merge.take_fired(0, fired_message(first, {})) == 0);
      CHECK(merge.take_fired(0, fired_message(step_at(1, 1), {0, 1})) == 0);
      CHECK(merge.take_fired(0, Control{Control::Kind::Fired, {first}, {"\x01"}}) == 0);
      CHECK(merge.take_fired(0, Control{Control::Kind::Fired, {first, 1, 0}, {"\x01"}}) == 0);
      CHECK(merge.take_fired(0, Control{Control::Kind::Fired, {first, 1}, {}}) == 0);
      CHECK(merge.take_fired(0, Control{Control::Kind::Fired, {first, 1}, {""}}) == 0);
      CHECK(merge.take_fired(0, Control{Control::Kind::Fired, {first, 1}, {"\x02"}}) == 0);
      CHECK(merge.take_fired(0, Control{Control::Kind::Fired, {first, ~u64{0}}, {"\x01"}}) == 0);
      CHECK(merge.waiting() == 0);
      if (at_once) {
        CHECK(merge.take_fired(0, fired_message(first, {0, 1, 0})) == 3);
        CHECK(merge.waiting_bytes() == fired_bytes(3));
        // Again, and one of an earlier number.
        CHECK(merge.take_fired(0, fired_message(first, {0, 1})) == 0);
        CHECK(merge.take_fired(0, fired_message(second, {1})) == 1);
      } else {
        for (u64 k = 0; k < 4; ++k)
          CHECK(merge.take_fired(0, fired_message(step_at(1 + k, 0), {static_cast<u32>(k % 2)})) == 1);
      }
      merge.write_until(step_at(9, 0));
      CHECK(merge.written() == 4);
      CHECK(merge.waiting_bytes() == 0);
      output.end(*pairs.core, End::Limit, merge.written());
      REQUIRE(trace.close());
      std::fclose(out);
    }
    std::string bytes = bip::testing::contents(std::fopen(path.c_str(), "rb"));
    std::remove(path.c_str());
    return bytes;
  };
  const std::string at_once = trace_of(true);
  CHECK(at_once.size() > 4);
  CHECK(at_once == trace_of(false));
}

TEST_CASE("steps of which nodes send only the interactions are described where they are written") {
  Scattered pairs = scattered_pairs(2);
  const auto lines_of = [&](const std::vector<std::vector<u32>>& fired, bool is_sound) {
    std::FILE* out = std::tmpfile();
    RunOptions options;
    RunFile no_trace({}, stderr);
    Output output(options, 1, out, no_trace, pairs.image());
    REQUIRE(can_follow_steps(*pairs.core, output));
    StepMerge merge(*pairs.core, pairs.distribution, output);
    merge.follow(pairs.core->snapshot());
    const u64 first = step_at(1, 0);
    // Neither texts nor numbers in them, and no rank that none is.
    const auto begun = [&](std::vector<u64> numbers, std::vector<std::string> texts) {
      return merge.take_begun(0, Control{Control::Kind::Begun, std::move(numbers), std::move(texts)});
    };
    CHECK_FALSE(begun({first, 0, 0, 0}, {"a", ""}));
    CHECK_FALSE(begun({first, 0, 0, 1}, {"", ""}));
    CHECK_FALSE(begun({first, 0, kNone, 0}, {"", ""}));
    CHECK(merge.take_many(0, Control{Control::Kind::Took, {first, 0, 0, 0, 1, 0}, {"a", ""}}) == 0);
    CHECK(begun({first, 0, 0, 0}, {"", ""}));
    for (u64 k = 0; k < fired.size(); ++k)
      CHECK(merge.take_fired(0, fired_message(step_at(2 + k, 0), fired[k])) == fired[k].size());
    merge.write_until(step_at(99, 0));
    CHECK(merge.is_sound() == is_sound);
    CHECK(merge.waiting_bytes() == 0);
    output.flush();
    return bip::testing::contents(out);
  };
  const std::string lines = lines_of({{1, 0, 1}, {0}}, true);
  CHECK(std::count(lines.begin(), lines.end(), '\n') == 5);
  CHECK(lines.find("#4  ") != std::string::npos);
  CHECK(lines.find("  @" + pairs.distribution.placement.nodes[0] + '\n') != std::string::npos);
  CHECK(lines_of({{1}, {0, 0}}, false).find("#2  ") != std::string::npos);
  CHECK(lines_of({{1}, {0}, {1, 0}}, true) == lines_of({{1, 0, 1, 0}}, true));
  // A candidate that is none: it is not written, nor is what follows.
  std::FILE* out = std::tmpfile();
  RunOptions options;
  RunFile no_trace({}, stderr);
  Output output(options, 1, out, no_trace, pairs.image());
  StepMerge merge(*pairs.core, pairs.distribution, output);
  merge.follow(pairs.core->snapshot());
  CHECK(merge.take_begun(0, Control{Control::Kind::Begun, {step_at(1, 0), 0, 0, 0}, {"", ""}}));
  CHECK(merge.take_begun(0, Control{Control::Kind::Begun, {step_at(2, 0), 1, 7, 0}, {"", ""}}));
  CHECK(merge.take_fired(0, fired_message(step_at(3, 0), {0})) == 1);
  merge.write_until(step_at(9, 0));
  CHECK_FALSE(merge.is_sound());
  CHECK_FALSE(merge.has_met_fault());
  CHECK(merge.written() == 1);
  CHECK(merge.waiting_bytes() == 0);
  std::fclose(out);
}

TEST_CASE("a node counts the bytes of its unwritten steps, and is told of written ones early enough") {
  for (const std::size_t nodes : {std::size_t{1}, std::size_t{4}, std::size_t{kMostNodes}}) {
    const u64 most = most_unwritten(nodes), each = record_bytes({"a step\n", ""});
    CHECK(most * nodes <= kMostUnwritten);
    UnwrittenSteps steps;
    u64 last = 0;
    while (steps.bytes() < most) steps.add(last += 3, each);
    CHECK(steps.bytes() == last / 3 * each);
    // All but the last steps, of so many bytes that the launcher does not say yet that they are written.
    const u64 untold = written_to_tell(nodes) / each + 1;
    steps.remove_up_to(last - 3 * untold);
    CHECK(steps.bytes() < most / 2);
    CHECK(steps.bytes() >= untold * each);
    steps.remove_up_to(last - 1);
    CHECK(steps.bytes() != 0);
    steps.remove_up_to(last);
    CHECK(steps.bytes() == 0);
  }
}

TEST_CASE("split sets: what one coordinator's interactions take is offered to it, what is shared is locked") {
  ImageBuilder b;
  build_match(b, 4);
  const Core core(b.image());
  Placement placement = apart(b.image());
  const Distribution whole = distribute(core.tables(), core.priorities(), placement);
  CHECK(whole.sets.count == 1);
  CHECK(whole.is_split[0] == 0);
  CHECK(whole.locks.items.empty());
  placement.split_above = 16;
  CHECK(distribute(core.tables(), core.priorities(), placement).is_split[0] == 0);
  placement.split_above = 15;
  const Distribution parts = distribute(core.tables(), core.priorities(), placement);
  REQUIRE(parts.is_split[0] != 0);
  for (const InteractionId interaction : parts.coordinator_of.ids()) {
    // Clients come first: each is taken by interactions that it coordinates, and servers are shared.
    const u32 client = interaction.value / 4, server = 4 + interaction.value % 4;
    CHECK(parts.coordinator_of[interaction] == client);
    REQUIRE(parts.locks[interaction].size == 1);
    CHECK(parts.locks[interaction][0] == server);
    CHECK(parts.coordinator_at(client, 0) == client);
    CHECK(parts.coordinator_at(server, 0) == server);
  }
  placement.split_above = kSplitNone;
  CHECK(distribute(core.tables(), core.priorities(), placement).is_split[0] == 0);
  // On one node there is nothing to share.
  placement.split_above = 1;
  placement.home.assign(placement.home.size(), 3);
  CHECK(distribute(core.tables(), core.priorities(), placement).is_split[0] == 0);
}

TEST_CASE("split sets: binary interactions cost at most 2.5 messages, ternary ones 4.5") {
  struct Case {
    const char* name;
    void (*build)(ImageBuilder&);
    u32 nodes;  // atom k is at home on node k modulo this
    double most;
  };
  const Case cases[] = {{"pairs", [](ImageBuilder& b) { build_pairs(b, 8); }, 16, 2},
                        {"match", [](ImageBuilder& b) { build_match(b, 4); }, 8, 2.5},
                        {"match, two on a node", [](ImageBuilder& b) { build_match(b, 4); }, 4, 2.5},
                        {"ring", [](ImageBuilder& b) { build_ring(b, 12); }, 12, 2.5},
                        {"both forks", [](ImageBuilder& b) { build_philosophers(b, 16, false); }, 16, 4.5}};
  for (const Case& one : cases) {
    ImageBuilder b;
    one.build(b);
    Placement placement = apart(b.image());
    placement.nodes.resize(one.nodes);
    for (u32& home : placement.home) home %= one.nodes;
    placement.split_above = 1;
    std::uint64_t messages = 0, border = 0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const SimulatedResult result = simulated(b.image(), placement, seed, 2000);
      messages += result.messages();
      border += result.border_steps;
    }
    INFO(one.name << ": " << static_cast<double>(messages) / static_cast<double>(border));
    CHECK(border > 2000);
    CHECK(static_cast<double>(messages) <= one.most * static_cast<double>(border));
  }
}

TEST_CASE("simulated runs with locks are accepted, whatever the network does") {
  for (const int kind : {0, 1, 2}) {
    ImageBuilder b;
    if (kind == 2) build_match(b, 4);
    else build_philosophers(b, 7, kind == 1);
    const Placement placement = split(b.image(), 4);
    RunOptions options;
    options.placement = &placement;
    CHECK((check_runs(b.image(), 70, options) == 0 || kind == 1));
  }
}

TEST_CASE("locks of a lost node stay: the others stop, or go on with what does not need them") {
  ImageBuilder b;
  build_philosophers(b, 9, false);
  const Placement placement = split(b.image(), 3);
  RunOptions options;
  options.placement = &placement;
  int goes_on = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const RunOutput stopped = output_of(b.image(), seed, 100000, "crash 2 30ms, lose 10%", OnLoss::Stop, options);
    CHECK(stopped.result.end == End::Interrupted);
    CHECK(stopped.result.exit_code == 1);
    CHECK(stopped.err.find("error[R0030]: lost `2`") == 0);
    (void)check(b.image(), stopped);
    // Philosophers whose forks are at home on one of the other nodes go on, unless one of them was locked.
    const RunOutput went_on = output_of(b.image(), seed, 3000, "crash 2 30ms, lose 10%", OnLoss::GoOn, options);
    CHECK((went_on.result.end == End::Limit || went_on.result.end == End::Interrupted));
    CHECK(went_on.err.find("[R0030]: lost `2`") != std::string::npos);
    (void)check(b.image(), went_on);
    goes_on += went_on.result.end == End::Limit ? 1 : 0;
  }
  CHECK(goes_on != 0);
}

TEST_CASE("nodes count the candidates that they coordinate, and no others") {
  // All interactions of a broadcast: each core lists those of the initial state.
  Scattered model(
      [](ImageBuilder& b) {
        b.atom_type({.name = "A",
                     .ports = {{.name = "go"}},
                     .places = {"S", "T"},
                     .initial = {"S"},
                     .transitions = {{"go", {"S"}, {"T"}}}});
        b.connector_type({.name = "All", .params = {{"p", 0}, {"q", 0}}, .define = "p' q"});
        for (const char* name : {"a", "b", "c", "d"}) b.atom(name, "A");
        b.connector("ab", "All", {"a.go", "b.go"});
        b.connector("cd", "All", {"c.go", "d.go"});
      },
      kSplitAbove, CoreOptions{.progress = MaximalProgress::Off});
  REQUIRE(model.core->candidate_count() == 4);
  std::size_t counted = 0;
  for (u32 self = 0; self < 4; ++self) {
    Node node(model.image(), CoreOptions{.progress = MaximalProgress::Off}, model.distribution, self);
    REQUIRE(node.start(model.core->snapshot()));
    for (u64 k = 0; k < node.core().candidate_count(); ++k) {
      const InteractionId interaction = node.core().position(k).interaction;
      CHECK(model.distribution.coordinator_of[interaction] == self);
    }
    counted += node.core().candidate_count();
  }
  CHECK(counted == 4);
}

namespace {

// The same steps at one node, in parts and as a whole where that is possible. Returns how many were taken as a whole.
int check_whole(const Image& image, const Placement& placement, int steps) {
  Core core(image);
  REQUIRE(core.initialize());
  const Distribution distribution = distribute(core.tables(), core.priorities(), placement);
  Node in_parts(image, {}, distribution, 0), as_whole(image, {}, distribution, 0);
  REQUIRE(in_parts.start(core.snapshot()));
  REQUIRE(as_whole.start(core.snapshot()));
  std::vector<u32> atoms, same_atoms;
  int whole = 0;
  for (int step = 1; step <= steps && in_parts.core().candidate_count() != 0; ++step) {
    REQUIRE(as_whole.core().candidate_count() == in_parts.core().candidate_count());
    const u64 k = static_cast<u64>(step) * 7 % in_parts.core().candidate_count();
    const EnabledSet::Position at = in_parts.core().position(k);
    const auto take_in_parts = [&](Node& node, std::vector<u32>& taken) {
      node.begin(at, static_cast<u64>(step), taken);
      while (node.work_count() != 0) node.run(0);
    };
    take_in_parts(in_parts, atoms);
    if (as_whole.is_whole(at.interaction)) {
      as_whole.take_whole(at, static_cast<u64>(step));
      as_whole.note_landed(at.interaction, static_cast<u64>(step), same_atoms);
      CHECK(as_whole.work_count() == 0);
      ++whole;
    } else {
      take_in_parts(as_whole, same_atoms);
    }
    CHECK(same_atoms == atoms);
    CHECK(as_whole.landed() == in_parts.landed());
    const PartialState& partial = *in_parts.core().partial().state();
    const PartialState& same = *as_whole.core().partial().state();
    CHECK(as_whole.is_stopped() == in_parts.is_stopped());
    CHECK(same.fault.code == partial.fault.code);
    CHECK(same.fault.atom == partial.fault.atom);
    CHECK(same.fault_step == partial.fault_step);
    // Behind a fault the other atoms of a step in parts still act, as those of other nodes do.
    if (as_whole.is_stopped()) break;
    CHECK(as_whole.outbox().size() == in_parts.outbox().size());
    State state = core.snapshot(), same_state = core.snapshot();
    SavedTime time, same_time;
    in_parts.save(state, time);
    as_whole.save(same_state, same_time);
    CHECK((same_state == state));
    for (u32 atom = 0; atom < image.atoms.size; ++atom) CHECK(as_whole.history(atom) == in_parts.history(atom));
  }
  return whole;
}

}  // namespace

TEST_CASE("a step of atoms at home on one node is the same as a whole and in parts") {
  // One pair has its halves on two nodes; its steps and only they are in parts.
  ImageBuilder pairs;
  build_pairs(pairs, 8);
  Placement placement;
  placement.nodes = {"1", "2"};
  placement.home = {0, 0, 0, 0, 0, 1, 1, 1};
  const int whole = check_whole(pairs.image(), placement, 200);
  CHECK(whole > 100);
  CHECK(whole < 200);
  for (const bool deadlocks : {false, true}) {
    ImageBuilder table;
    build_philosophers(table, 5, deadlocks);
    placement.home.assign(table.image().atoms.size, 0);
    CHECK(check_whole(table.image(), placement, 200) > 5);
  }
  ImageBuilder faulty;
  faulty.atom_type({.name = "A",
                    .data = {"x"},
                    .ports = {{.name = "go"}},
                    .places = {"S"},
                    .initial = {"S"},
                    .transitions = {{"go", {"S"}, {"S"}, nullptr, [](Cell* self, Cell*, const u32*) {
                                       return ++self[0].i < 3 ? 1 : 2;
                                     }}}});
  faulty.connector_type({.name = "Two", .params = {{"p", 0}, {"q", 0}}, .define = "p q"});
  for (const char* name : {"a", "b"}) faulty.atom(name, "A");
  faulty.connector("ab", "Two", {"a.go", "b.go"});
  placement.home.assign(2, 0);
  CHECK(check_whole(faulty.image(), placement, 10) == 3);
}

TEST_CASE("the same seed gives the same simulated run") {
  ImageBuilder b;
  build_philosophers(b, 6, false);
  const char* const faults = "lose 20%, double 20%, cut 1-2 5ms..50ms";
  const RunOutput one = output_of(b.image(), 5, 300, faults, OnLoss::Stop),
                  two = output_of(b.image(), 5, 300, faults, OnLoss::Stop);
  CHECK(one.trace == two.trace);
  CHECK(one.out == two.out);
  CHECK(output_of(b.image(), 6, 300, faults, OnLoss::Stop).trace != one.trace);
}

TEST_CASE("simulated runs are accepted, whatever the network does") {
  for (const bool deadlocks : {false, true}) {
    ImageBuilder b;
    build_philosophers(b, 5, deadlocks);
    CHECK((check_runs(b.image(), 40, {}) == 0 || deadlocks));
  }
}

TEST_CASE("when a node is lost the others stop, or go on with what does not need it") {
  ImageBuilder b;
  build_pairs(b, 12);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const RunOutput stopped = output_of(b.image(), seed, 100000, "crash 2 30ms", OnLoss::Stop);
    CHECK(stopped.result.end == End::Interrupted);
    CHECK(stopped.result.exit_code == 1);
    CHECK(stopped.err.find("error[R0030]: lost `2`") == 0);
    (void)check(b.image(), stopped);
    const RunOutput went_on = output_of(b.image(), seed, 3000, "crash 2 30ms", OnLoss::GoOn);
    CHECK(went_on.result.end == End::Limit);
    CHECK(went_on.result.exit_code == 0);
    CHECK(went_on.err.find("warning[R0030]: lost `2`") == 0);
    (void)check(b.image(), went_on);
  }
}

TEST_CASE("a fault ends a simulated run at the step where a sequential one meets it") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    ImageBuilder b;
    b.atom_type({.name = "Worker",
                 .data = {"n"},
                 .ports = {{.name = "go"}},
                 .places = {"S"},
                 .initial = {"S"},
                 .transitions = {{"go", {"S"}, {"S"}, nullptr, [](Cell* self, Cell*, const u32*) {
                                    return ++self[0].i == 5 ? fault_status(0, FaultKind::DivisionByZero) : 1;
                                  }}}});
    b.connector_type({.name = "Two", .params = {{"p", 0}, {"q", 0}}, .define = "p q"});
    for (const char* name : {"v", "w", "x"}) b.atom(name, "Worker");
    b.connector("vw", "Two", {"v.go", "w.go"});
    b.connector("wx", "Two", {"w.go", "x.go"});
    const RunOutput run = output_of(b.image(), seed, 1000, "lose 10%", OnLoss::Stop);
    CHECK(run.result.end == End::Fault);
    CHECK(run.err.find("R0005") != std::string::npos);
    CHECK(check(b.image(), run).end == End::Fault);
  }
}

// -- Placements by counts --

namespace {

// The part of the counted steps whose components are at home on several nodes, in [0, 1]; 0 if nothing was counted.
double border_part(const Tables& tables, const std::vector<u64>& counts, const Placement& placement) {
  u64 all = 0, border = 0;
  std::vector<u32> ports;
  for (const InteractionId interaction : bip::IdRange<InteractionId>(counts.size())) {
    ports_of_interaction(tables, tables.interactions[interaction], ports);
    const u32 first = placement.home[tables.port_atom[ports.front()]];
    all += counts[interaction.value];
    if (std::any_of(ports.begin(), ports.end(),
                    [&](u32 port) { return placement.home[tables.port_atom[port]] != first; }))
      border += counts[interaction.value];
  }
  return all == 0 ? 0 : static_cast<double>(border) / static_cast<double>(all);
}

}  // namespace

TEST_CASE("atoms without a home go where the steps of several nodes are fewest") {
  ImageBuilder b;
  build_ring(b, 12);
  const Image& image = b.image();
  const Tables tables = link(image, MaximalProgress::On);
  const PriorityTables rules = link_priorities(tables);
  const auto placed = [&](const std::vector<u64>& counts, std::vector<u32> home, u32 nodes) {
    Placement placement;
    for (u32 node = 0; node < nodes; ++node) placement.nodes.push_back(std::to_string(node + 1));
    placement.home = std::move(home);
    place_free_atoms(tables, rules, counts, placement);
    return placement;
  };
  const std::vector<u32> free(12, kNone);
  // A ring in two pieces: two interactions.
  const std::vector<u64> alike(12, 10);
  CHECK(border_part(tables, alike, placed({}, free, 2)) == Approx(2.0 / 12));
  // Pairs that a breadth-first order would cut: 11 and 0, 1 and 2, and so on.
  std::vector<u64> pairs;
  for (int k = 0; k < 12; ++k) pairs.push_back(k % 2 == 1 ? 1000 : 1);
  const Placement apart_in_pairs = placed(pairs, free, 4);
  CHECK(border_part(tables, pairs, apart_in_pairs) < 0.001);
  for (const u32 home : apart_in_pairs.home)
    CHECK(std::count(apart_in_pairs.home.begin(), apart_in_pairs.home.end(), home) <= 4);
  CHECK(placed(pairs, free, 4).home == apart_in_pairs.home);
  // Homes that are given stay.
  std::vector<u32> some(12, kNone);
  some[0] = 1;
  some[6] = 0;
  const Placement around = placed(alike, some, 2);
  CHECK(around.home[0] == 1);
  CHECK(around.home[6] == 0);
  CHECK(border_part(tables, alike, around) == Approx(2.0 / 12));
}

TEST_CASE("a ring without homes comes into arcs, one for each node") {
  ImageBuilder b;
  build_ring(b, 64);
  const Tables tables = link(b.image(), MaximalProgress::On);
  const PriorityTables rules = link_priorities(tables);
  Placement placement;
  for (u32 node = 0; node < 8; ++node) placement.nodes.push_back(std::to_string(node + 1));
  placement.home.assign(64, kNone);
  const std::vector<u64> alike(tables.interactions.size(), 10);
  place_free_atoms(tables, rules, alike, placement);
  CHECK(border_part(tables, alike, placement) == Approx(8.0 / 64));
  for (u32 node = 0; node < 8; ++node) CHECK(std::count(placement.home.begin(), placement.home.end(), node) <= 9);
  // Pieces around homes that are given.
  placement.home.assign(64, kNone);
  for (u32 node = 0; node < 8; ++node) placement.home[8 * node] = node;
  place_free_atoms(tables, rules, alike, placement);
  CHECK(border_part(tables, alike, placement) == Approx(8.0 / 64));
  for (u32 node = 0; node < 8; ++node) CHECK(placement.home[8 * node] == node);
}

TEST_CASE("no node stays empty while there are atoms without a home") {
  struct Example {
    u32 atoms, nodes;
    std::vector<std::pair<u32, u32>> given;  // atom, node
    std::size_t least;                       // atoms of each node
    double border;
  };
  // The part of border steps is the smallest with so many on each node: a ring in n arcs has n of them.
  for (const Example& example :
       {Example{3, 2, {}, 1, 2.0 / 3}, Example{4, 4, {}, 1, 1}, Example{5, 4, {}, 1, 0.8}, Example{8, 4, {}, 1, 0.5},
        Example{12, 8, {}, 1, 8.0 / 12}, Example{20, 4, {}, 2, 0.2}, Example{100, 10, {}, 5, 0.1},
        // One node has more than its share: half of what is left for the others.
        Example{12, 3, {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}, {6, 0}, {7, 0}}, 1, 3.0 / 12},
        // Fewer free atoms than empty nodes: where they cost least.
        Example{4, 4, {{0, 0}, {1, 0}}, 0, 0.5}}) {
    ImageBuilder b;
    build_ring(b, static_cast<int>(example.atoms));
    const Tables tables = link(b.image(), MaximalProgress::On);
    Placement placement;
    for (u32 node = 0; node < example.nodes; ++node) placement.nodes.push_back(std::to_string(node + 1));
    placement.home.assign(example.atoms, kNone);
    for (const auto& [atom, node] : example.given) placement.home[atom] = node;
    const std::vector<u64> alike(tables.interactions.size(), 10);
    place_free_atoms(tables, link_priorities(tables), alike, placement);
    CAPTURE(example.atoms, example.nodes);
    for (u32 node = 0; node < example.nodes; ++node)
      CHECK(static_cast<std::size_t>(std::count(placement.home.begin(), placement.home.end(), node)) >= example.least);
    CHECK(border_part(tables, alike, placement) == Approx(example.border));
  }
}

// -- Losses --

TEST_CASE("an interaction without lost nodes is whole, whatever else its conflict set has") {
  for (const u32 split_above : {1u, kSplitNone}) {
    const Scattered match([](ImageBuilder& b) { build_match(b, 3); }, split_above);
    const Core& core = *match.core;
    const Distribution& distribution = match.distribution;
    // A server; all is one set.
    std::vector<bool> is_lost(6, false);
    is_lost[5] = true;
    const Survivors survivors(core, distribution, is_lost);
    std::size_t whole = 0;
    for (const InteractionId interaction : distribution.coordinator_of.ids()) {
      const bool is_coordinator_lost = distribution.coordinator_of[interaction] == 5;
      const bool meets_lost = interaction.value % 3 == 2;
      CHECK(survivors.is_whole(interaction) == (!is_coordinator_lost && !meets_lost));
      whole += survivors.is_whole(interaction) ? 1 : 0;
    }
    CHECK(whole == 6);
    for (u32 atom = 0; atom < 5; ++atom) CHECK_FALSE(survivors.waits(atom, 0));
    // Who has no other partner waits.
    is_lost.assign(6, true);
    is_lost[0] = false;
    CHECK(Survivors(core, distribution, is_lost).waits(0, 0));
  }
}

TEST_CASE("the report of a silent node names what is at home there and the partners of that") {
  const Scattered match([](ImageBuilder& b) { build_match(b, 3); }, kSplitNone);
  const Core& core = *match.core;
  const u32 coordinator = match.distribution.coordinator_of[InteractionId(0u)];
  // A server that coordinates nothing: its three clients may wait, the other servers do not.
  REQUIRE(coordinator != 5);
  const auto path = [&core](u32 atom) { return core.image().atoms[atom].path(); };
  CHECK(silence_story(core, match.distribution, 5) ==
        "  at home there: " + path(5) + "\n  may wait for it: " + path(0) + ", " + path(1) + ", " + path(2) + "\n");
  // The coordinator of all.
  const std::string all = silence_story(core, match.distribution, coordinator);
  for (u32 atom = 0; atom < 6; ++atom) CHECK(all.find(path(atom)) != std::string::npos);
}
