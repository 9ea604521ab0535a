// The protocol as a model and as a program are one: what happens to each atom in simulated runs, whatever the network
// does, is a run of models/protocol/offer_begin.bip, which is proved.
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

// One atom's protocol, as the model tells it.
class Protocol {
 public:
  explicit Protocol(const rt::Image& image) : core_(image) {
    REQUIRE(core_.initialize());
    // The initial state is offered, and known to all.
    take("offer");
    take("hear_offer");
  }
  void take(rt::NodeEvent::Kind kind) {
    switch (kind) {
      case rt::NodeEvent::Kind::Begun: take("decide"); return take("begin");
      case rt::NodeEvent::Kind::Taken: return take("hear_begin");
      case rt::NodeEvent::Kind::Rested: return take("work");
      case rt::NodeEvent::Kind::Offered: return take("offer");
      case rt::NodeEvent::Kind::Received: return take("hear_offer");
    }
  }
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  void take(std::string_view name) {
    if (!problem_.empty()) return;
    for (std::uint64_t k = 0; k < core_.candidate_count(); ++k) {
      const std::string path = core_.image().connectors[core_.candidate(k).connector].path();
      if (path != "ROOT." + std::string(name)) continue;
      problem_ = core_.fire(k) ? "" : "a fault in " + path;
      return;
    }
    problem_ = std::string(name) + " is no step there";
  }

  rt::Core core_;
  std::string problem_;
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
  rt::NetworkFaults faults;
  REQUIRE(rt::read_faults(text, placement.nodes, faults).empty());
  std::vector<std::unique_ptr<Protocol>> protocols;
  for (u32 atom = 0; atom < model.image().atoms.size; ++atom)
    protocols.push_back(std::make_unique<Protocol>(protocol.image()));
  Followed result;
  std::uint64_t events = 0;
  const rt::SimulatedResult run =
      rt::run_simulated(core, distribution, faults, options, seed, output, 0, [&](rt::NodeEvent event) {
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
