// A node of a run on several hosts, but the first one: waits until the launcher knocks and welcomes it, then lives as
// any node does (node_process.hpp).
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "bip/assert.hpp"
#include "bip/run.hpp"
#include "runtime/distributed/codec.hpp"
#include "runtime/distributed/deployment.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/engine/node_process.hpp"
#include "runtime/engine/policies.hpp"
#include "runtime/engine/waker.hpp"

namespace bip::rt {

namespace {

constexpr int kWakeUp = 500;  // ms between looks whether a signal came
// Bytes of frames that come before the node is welcome. Of more it keeps the last ones; the others are sent again.
constexpr std::size_t kMostEarly = std::size_t{1} << 20;

void tell_of_node(const Deployment& deployment, const std::string& text) {
  std::fprintf(stderr, "bipc: node `%s`: %s\n", deployment.names[deployment.self].c_str(), text.c_str());
  std::fflush(stderr);
}

u64 draw_number() {
  std::random_device device;
  return (u64{device()} << 32 | device()) >> 1;
}

// Frames of the run that came before the node takes part in it: of others who were welcome sooner, and what follows the
// welcome itself. Dropped, they would be sent again when their confirmation is missed.
class EarlyFrames {
 public:
  void add(Arrival arrival) {
    if (bytes_ + arrival.bytes.size() > kMostEarly) frames_.clear(), bytes_ = 0;
    bytes_ += arrival.bytes.size();
    if (bytes_ <= kMostEarly) frames_.push_back(std::move(arrival));
  }
  /// Those of the run; others are of one that is over.
  [[nodiscard]] std::vector<Arrival> take(u64 run) {
    std::erase_if(frames_, [&](const Arrival& frame) { return !Codec::is_of_run(frame.bytes, run); });
    return std::move(frames_);
  }

 private:
  std::vector<Arrival> frames_;
  std::size_t bytes_ = 0;
};

// False: interrupted.
bool await_welcome(const Deployment& deployment, Fabric& fabric, Greeting& welcome, EarlyFrames& early) {
  const Greeting answer{.kind = Greeting::Kind::Answer, .number = draw_number(), .model = deployment.model};
  const u32 launcher = deployment.launcher();
  bool is_refused = false;
  i64 answer_at = 0;
  bool is_welcome = false;
  std::vector<Arrival> arrivals;
  while (!is_interrupted() && !is_welcome) {
    arrivals.clear();
    (void)fabric.wait(kWakeUp, {}, arrivals);
    // A launcher that believes that this node is in its run learns that it is not.
    if (const i64 now = wall_clock(); now >= answer_at) {
      fabric.send(launcher, text_of(answer));
      answer_at = now + i64{kWakeUp} * 1000000;
    }
    for (Arrival& arrival : arrivals) {
      if (!is_greeting(arrival.bytes)) {
        early.add(std::move(arrival));
        continue;
      }
      Greeting greeting;
      if (is_welcome || arrival.from != launcher || !read(arrival.bytes, greeting)) continue;
      const bool is_knock = greeting.kind == Greeting::Kind::Knock || greeting.protocol != kProtocol;
      if (is_knock) fabric.send(launcher, text_of(answer));
      if (greeting.protocol != kProtocol || greeting.model != deployment.model) {
        if (!std::exchange(is_refused, true))
          tell_of_node(deployment, "`" + deployment.names[0] + "` has another model, placement or bipc: deploy again");
        continue;
      }
      if (greeting.kind != Greeting::Kind::Welcome) continue;
      welcome = greeting;
      is_welcome = true;
    }
  }
  return is_welcome;
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
  EarlyFrames early;
  do {
    if (!await_welcome(deployment, **fabric, welcome, early)) return 128 + interrupting_signal();
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
  const NodeSetup setup{image,        how,     distribution, deployment.self,           welcome.number,
                        options.seed, options, output,       early.take(welcome.number)};
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
