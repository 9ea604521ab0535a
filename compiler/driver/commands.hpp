// The commands. Each prints its results and returns the exit code.
#pragma once
#include <string>

#include "compiler/driver/options.hpp"

namespace bip::driver {

[[nodiscard]] int command_check(const CheckArguments& arguments);
[[nodiscard]] int command_run(const RunArguments& arguments);
/// Folders for the hosts of a run on several nodes.
[[nodiscard]] int command_deploy(const DeployArguments& arguments);
/// One node of such a run; the first one runs the launcher as well.
[[nodiscard]] int command_node(const NodeArguments& arguments);
/// Deadlock-free, a deadlock with its steps, or unknown: 0, 3, 4.
[[nodiscard]] int command_verify(const VerifyArguments& arguments);
/// All reachable states: 0, 1 run-time errors, 3 deadlocks, 4 a limit came first.
[[nodiscard]] int command_explore(const ExploreArguments& arguments);
/// Estimates from many runs: 0, 1 if a run ended with an error.
[[nodiscard]] int command_simulate(const SimulateArguments& arguments);
/// Until the person quits or the input ends.
[[nodiscard]] int command_step(const StepArguments& arguments);
[[nodiscard]] int command_view(const ViewArguments& arguments);
[[nodiscard]] int command_trace(const TraceArguments& arguments);
/// The debug adapter, until its client disconnects.
[[nodiscard]] int command_dap();
/// Until a client shuts it down or its input ends.
[[nodiscard]] int command_serve(const ServeArguments& arguments);
[[nodiscard]] int command_build(const BuildArguments& arguments);
[[nodiscard]] int command_emit(const EmitArguments& arguments);
/// A picture of the system (DOT), or the system as JSON.
[[nodiscard]] int command_graph(const GraphArguments& arguments);
/// Promela or PNML.
[[nodiscard]] int command_export(const ExportArguments& arguments);
[[nodiscard]] int command_replay(const ReplayArguments& arguments);
[[nodiscard]] int command_fmt(const FmtArguments& arguments);
/// Robot module descriptions (.gen) to BIP.
[[nodiscard]] int command_genom(const GenomArguments& arguments);
[[nodiscard]] int command_rules(const GenomArguments& arguments);
/// The bridge to ROS 2, until a signal comes.
[[nodiscard]] int command_ros1(const BridgeArguments& arguments);
[[nodiscard]] int command_ros2(const Ros2Arguments& arguments);
[[nodiscard]] int command_migrate(const MigrateArguments& arguments);
/// `code` empty: the list of codes.
[[nodiscard]] int command_explain(const std::string& code, ColorChoice color);
[[nodiscard]] int command_version(const VersionArguments& arguments);
/// The published tools' call: checks, or writes C++ if an output folder is given.
[[nodiscard]] int command_published(const PublishedArguments& arguments);

}  // namespace bip::driver
