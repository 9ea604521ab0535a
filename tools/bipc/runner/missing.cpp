// What the runner's commands call and the runner does not have: each says so.
#include <fmt/format.h>

#include "bip/run.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/distributed_runs.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/driver/judge_lesson.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/pipeline/exit_codes.hpp"

namespace bip::driver {

namespace {

constexpr const char* kHelp = "this is the part that runs models; `tools/build bipc` builds the rest";

int missing(const char* command) {
  print_error_words(fmt::format("error: `bipc {}` is not part of this build of bipc\n  = help: {}", command, kHelp));
  return pipeline::kUsage;
}

void report_missing(Compilation& c, const char* what) { c.diags.report(Diag::kB5001, {}, what).help(kHelp); }

}  // namespace

int command_dap() { return missing("dap"); }
int command_deploy(const DeployArguments&) { return missing("deploy"); }
int command_explore(const ExploreArguments&) { return missing("explore"); }
int command_export(const ExportArguments&) { return missing("export"); }
int command_genom(const GenomArguments&) { return missing("genom"); }
int command_graph(const GraphArguments&) { return missing("graph"); }
int command_migrate(const MigrateArguments&) { return missing("migrate"); }
int command_node(const NodeArguments&) { return missing("node"); }
int command_replay(const ReplayArguments&) { return missing("replay"); }
int command_ros1(const BridgeArguments&) { return missing("ros1"); }
int command_ros2(const Ros2Arguments&) { return missing("ros2"); }
int command_rules(const GenomArguments&) { return missing("rules"); }
int command_serve(const ServeArguments&) { return missing("serve"); }
int command_simulate(const SimulateArguments&) { return missing("simulate"); }
int command_step(const StepArguments&) { return missing("step"); }
int command_trace(const TraceArguments&) { return missing("trace"); }
int command_verify(const VerifyArguments&) { return missing("verify"); }
int command_view(const ViewArguments&) { return missing("view"); }
int judge_lesson(const CheckArguments&) { return missing("check --lesson"); }

void emit_stage(Compilation& c, const std::string&, Optimisation) { report_missing(c, "`--emit`"); }

bool prepare_distributed(Compilation& c, const RunArguments& arguments, rt::Placement&) {
  if (!rt::has_nodes(arguments.run.engine) && arguments.placement_path.empty()) return true;
  report_missing(c, "a run on several nodes");
  return false;
}

std::string distribution_text(Compilation& c, const std::string&) {
  report_missing(c, "`--placement`");
  return {};
}
std::string distribution_json(Compilation& c, const std::string&, const std::string&) {
  report_missing(c, "`--placement`");
  return {};
}

}  // namespace bip::driver

namespace bip::rt {

ExploreResult explore(const Image&, const RunOptions&, std::FILE*, std::FILE*) {
  ExploreResult refused;
  refused.complete = false;
  refused.exit_code = driver::missing("run --explore");
  return refused;
}

}  // namespace bip::rt
