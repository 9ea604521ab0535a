// `bipc deploy` writes folders for the hosts of a run on several nodes, `bipc node` runs one of them.
#include <dlfcn.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/deployment_files.hpp"
#include "compiler/driver/distributed_runs.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/serve/safe_stop.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/fabric_loader.hpp"

namespace bip::driver {
namespace {

int end_unusable(const std::string& problem) {
  print_error_words(fmt::format("error: {}", problem));
  return kUsage;
}

// Options that say how the run goes are the first node's.
bool has_options_of_run(const NodeArguments& a) {
  const rt::RunOptions plain;
  return a.run.has_seed || a.run.limit != plain.limit || a.run.policy != plain.policy || !a.run.trace_path.empty() ||
         a.run.format != plain.format || a.run.on_loss != plain.on_loss || a.run.silent || a.run.show_state ||
         a.run.stats;
}

}  // namespace

int command_deploy(const DeployArguments& arguments) {
  Compilation c(arguments.compile);
  rt::Placement placement;
  const bool ready = compile(c, arguments.file, Stage::Image) &&
                     prepare_deployed(c, arguments.placement_path, {}, placement) && is_deployable(c, placement);
  if (!ready) return report(c);
  const Result<const rt::FabricFactory*> fabrics = load_fabric();
  if (!fabrics) return end_unusable(fabrics.error());
  const Result<bool> written = write_deployment(c, placement, arguments, **fabrics);
  if (const int code = report(c); code != 0) return code;
  if (!written) return end_unusable(written.error());
  for (std::size_t node = 0; node < placement.nodes.size(); ++node)
    print_words(fmt::format("{}/{}: at {}{}", arguments.output, placement.nodes[node], placement.addresses[node],
                            node == 0 ? ", begins the run" : ""));
  return kOk;
}

int command_node(const NodeArguments& arguments) {
  namespace fs = std::filesystem;
  constexpr std::int64_t kLeastSilence = 2000000000;
  if (arguments.run.lost_after < kLeastSilence)
    return end_unusable("--lost-after: at least 2s, for there is a sign a second");
  Compilation c(arguments.compile);
  rt::Placement placement;
  Executor executor;
  const bool ready = compile(c, (fs::path(arguments.folder) / kModelFile).string(), Stage::Image) &&
                     check_outputs(c, {arguments.run.trace_path}) &&
                     prepare_deployed(c, (fs::path(arguments.folder) / kPlacementFile).string(),
                                      (fs::path(arguments.folder) / kMovesFile).string(), placement) &&
                     is_deployable(c, placement) && executor.prepare(c, arguments.backend, arguments.optimisation);
  if (const int code = report(c); code != 0 || !ready) return code;
  Result<rt::Deployment> deployment = read_deployment(arguments.folder, placement);
  if (!deployment) return end_unusable(deployment.error());
  if (!arguments.listen.empty()) deployment->listen = arguments.listen;
  Result<serve::SafeStop> safe_stop =
      serve::find_safe_stop(c.lowered->library, arguments.safe_stop, arguments.stall_after);
  if (!safe_stop) return end_unusable(safe_stop.error());
  deployment->stall = {safe_stop->stall_after, safe_stop->stop, nullptr, safe_stop->name};
  if (c.lowered->library != nullptr)
    deployment->stall.go_on = reinterpret_cast<void (*)(const char*)>(::dlsym(c.lowered->library, "safe_go_on"));
  const Result<const rt::FabricFactory*> fabrics = load_fabric();
  if (!fabrics) return end_unusable(fabrics.error());
  rt::RunOptions options = arguments.run;
  options.engine = rt::Engine::Distributed;
  options.placement = &placement;
  options.deployment = &*deployment;
  options.fabrics = *fabrics;
  if (deployment->self == 0) {
    const int code = rt::run(c.lowered->image, options, stdout, stderr).exit_code;
    if (options.stats) std::fputs(executor.summary().c_str(), stderr);
    return code;
  }
  if (has_options_of_run(arguments))
    return end_unusable("options of the run are those of its first node, `" + placement.nodes.front() + '`');
  return rt::run_node(c.lowered->image, options);
}

}  // namespace bip::driver
