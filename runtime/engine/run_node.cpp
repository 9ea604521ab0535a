// A node of a run on several hosts, but the first one: waits until the launcher knocks and welcomes it, then lives as
// any node does (node_process.hpp).
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>

#include "bip/assert.hpp"
#include "bip/run.hpp"
#include "runtime/distributed/deployment.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/engine/node_process.hpp"
#include "runtime/engine/policies.hpp"
#include "runtime/engine/waker.hpp"

namespace bip::rt {

namespace {

constexpr int kWakeUp = 500;  // ms between looks whether a signal came

void tell_of_node(const Deployment& deployment, const std::string& text) {
  std::fprintf(stderr, "bipc: node `%s`: %s\n", deployment.names[deployment.self].c_str(), text.c_str());
  std::fflush(stderr);
}

u64 draw_number() {
  std::random_device device;
  return (u64{device()} << 32 | device()) >> 1;
}

// False: interrupted.
bool await_welcome(const Deployment& deployment, Fabric& fabric, Greeting& welcome) {
  const Greeting answer{.kind = Greeting::Kind::Answer, .number = draw_number(), .model = deployment.model};
  const u32 launcher = deployment.launcher();
  bool is_refused = false;
  i64 answer_at = 0;
  std::vector<Arrival> arrivals;
  while (!is_interrupted()) {
    arrivals.clear();
    (void)fabric.wait(kWakeUp, {}, arrivals);
    // A launcher that believes that this node is in its run learns that it is not.
    if (const i64 now = wall_clock(); now >= answer_at) {
      fabric.send(launcher, text_of(answer));
      answer_at = now + i64{kWakeUp} * 1000000;
    }
    for (const Arrival& arrival : arrivals) {
      Greeting greeting;
      if (arrival.from != launcher || !read(arrival.bytes, greeting)) continue;
      const bool is_knock = greeting.kind == Greeting::Kind::Knock || greeting.protocol != kProtocol;
      if (is_knock) fabric.send(launcher, text_of(answer));
      if (greeting.protocol != kProtocol || greeting.model != deployment.model) {
        if (!std::exchange(is_refused, true))
          tell_of_node(deployment, "`" + deployment.names[0] + "` has another model, placement or bipc: deploy again");
        continue;
      }
      if (greeting.kind != Greeting::Kind::Welcome) continue;
      welcome = greeting;
      return true;
    }
  }
  return false;
}

// What the launcher says of the run, as options.
bool options_of(const Greeting& welcome, RunOptions& options) {
  if (welcome.policy >= policies().size() || welcome.format >= trace_formats().size()) return false;
  options.seed = welcome.seed;
  options.has_seed = true;
  options.policy = static_cast<Policy>(welcome.policy);
  options.format = static_cast<TraceFormat>(welcome.format);
  options.silent = welcome.is_silent;
  options.trace_path = welcome.is_traced ? "/dev/null" : "";
  options.on_loss = welcome.goes_on ? OnLoss::GoOn : OnLoss::Stop;
  options.maximal_progress = welcome.has_maximal_progress;
  options.asap = welcome.is_asap;
  return true;
}

std::string end_text(u64 end, u64 steps) {
  static constexpr const char* kEnds[] = {"the limit", "a deadlock", "a run-time error", "an interruption or a loss",
                                          "a final state"};
  if (end >= std::size(kEnds)) return "the run has ended";
  return std::string("the run ended at ") + kEnds[end] + " after " + std::to_string(steps) +
         (steps == 1 ? " step" : " steps");
}

}  // namespace

int run_node(const Image& image, const RunOptions& given) {
  const Deployment& deployment = *given.deployment;
  const InterruptGuard guard;
  const Result<std::unique_ptr<Fabric>> fabric = given.fabrics->open(node_plan(deployment));
  if (!fabric) {
    tell_of_node(deployment, "cannot listen at " + deployment.listen + ": " + fabric.error());
    return 1;
  }
  tell_of_node(deployment, "listens at " + deployment.listen + ", waits for `" + deployment.names[0] + '`');
  Greeting welcome;
  RunOptions options = given;
  do {
    if (!await_welcome(deployment, **fabric, welcome)) return 128 + interrupting_signal();
  } while (!options_of(welcome, options));
  tell_of_node(deployment, "the run begins");

  RunFile trace(options.trace_path, stderr);
  if (!trace.open()) return 1;
  Output output(options, options.seed, stdout, trace, image);
  const CoreOptions how{.progress = options.maximal_progress ? MaximalProgress::On : MaximalProgress::Off};
  Core core(image, how);
  if (image.ffi != nullptr) std::srand(static_cast<unsigned>(options.seed));
  core.seed_draws(options.seed);
  // The launcher meets a fault of the initial state as well, and begins no run.
  if (!core.initialize()) return 1;
  const Distribution distribution = distribute(core.tables(), core.priorities(), *options.placement);
  const NodeSetup setup{image, how, distribution, deployment.self, welcome.number, options.seed, options, output};
  NodeProcess process(setup, **fabric);
  if (!process.run(core.snapshot())) {
    tell_of_node(deployment, process.why());
    return is_interrupted() ? 128 + interrupting_signal() : 1;
  }
  tell_of_node(deployment, end_text(process.told_end(), process.told_steps()));
  const bool is_good =
      process.told_end() != static_cast<u64>(End::Fault) && process.told_end() != static_cast<u64>(End::Interrupted);
  return is_good ? 0 : 1;
}

}  // namespace bip::rt
