// `bipc ros2` and `bipc ros1`: the bridge between a running `bipc serve` and ROS, and the package of message types that
// a workspace of ROS needs for it (compiler/docs/ros2.md, ros1.md).
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string_view>

#include "compiler/base/write_file.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/dds_loader.hpp"
#include "compiler/driver/genom_files.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/driver/ros1_loader.hpp"
#include "compiler/driver/rule_files.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/ros1/action_bus.hpp"
#include "compiler/ros1/types.hpp"
#include "compiler/ros2/bridge.hpp"
#include "compiler/ros2/interfaces.hpp"

namespace bip::driver {
namespace {

struct LoadedLevel {
  std::vector<genom::Module> modules;
  genom::Constraints constraints;
  std::string name;  // of the rules, or of the first module
};

std::optional<LoadedLevel> load_level(Compilation& c, const GenomArguments& a) {
  if (std::filesystem::path(a.files.front()).extension() == ".rules") {
    auto level = load_rules(c, a, genom::Types::Read);
    if (!level) return std::nullopt;
    return LoadedLevel{std::move(level->modules), std::move(level->checked.constraints), level->file.package.text};
  }
  genom::TranslateOptions options = translate_options(a, a.files, "");
  options.types = genom::Types::Read;
  auto modules = load_modules(c, a.files, a.side_file, options);
  if (!modules) return std::nullopt;
  std::string name = modules->front().name.text;
  return LoadedLevel{std::move(*modules), {}, std::move(name)};
}

void check_modules(Compilation& c, const LoadedLevel& level, const std::vector<std::string>& wanted) {
  std::vector<std::string> known;
  for (const genom::Module& m : level.modules) known.push_back(m.name.text);
  for (const std::string& name : wanted) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    auto d = c.diags.report(Diag::kB6131, {}, name);
    for (const std::string& similar : similar_names(name, known)) d.help("there is `" + similar + "`");
  }
}

using PackageFiles = std::vector<std::pair<std::string, std::string>>;
void write_package(Compilation& c, const ros2::Interfaces& interfaces, const PackageFiles& files,
                   const std::string& folder) {
  namespace fs = std::filesystem;
  for (const auto& [name, text] : files) {
    const fs::path path = fs::path(folder) / name;
    std::error_code ignored;
    fs::create_directories(path.parent_path(), ignored);
    const Result<bool> written = write_file(path.string(), text);
    if (!written) return void(c.diags.report(Diag::kB5004, {}, path.string(), written.error()));
  }
  print_words(fmt::format("{}: package {}, {} actions, {} messages", folder, interfaces.package,
                          interfaces.actions.size(), interfaces.own.size()));
}

// As ROS 2 says it, else 0.
bool domain_of(std::int64_t given, std::uint32_t& domain) {
  domain = static_cast<std::uint32_t>(std::max<std::int64_t>(given, 0));
  const char* const text = std::getenv("ROS_DOMAIN_ID");
  if (given >= 0 || text == nullptr || *text == '\0') return true;
  const std::string_view digits = text;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), domain);
  return read.ec == std::errc() && read.ptr == digits.data() + digits.size() && domain <= 232;
}

void print_event(const std::string& line) {
  if (line.starts_with("warning")) return print_error_words(line);
  print_words(line);
  std::fflush(stdout);
}

// Signals end the bridge: a descriptor that can be read then; negative: none. Before there are threads, which would
// take the signals.
int wait_for_signals() {
  sigset_t ends{};
  sigemptyset(&ends);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&ends, signal);
  if (::pthread_sigmask(SIG_BLOCK, &ends, nullptr) != 0) return -1;
  return ::signalfd(-1, &ends, SFD_CLOEXEC | SFD_NONBLOCK);
}

// `network`: "DDS", "ROS 1"; `where`: of it.
int run_bridge(const ros2::Interfaces& interfaces, const BridgeArguments& a, ros2::Bus& bus, int stop,
               const std::string& network, const std::string& where) {
  const char* const token = std::getenv("BIPC_TOKEN");
  ros2::Bridge bridge(
      interfaces, bus,
      {.where = a.serve, .token = token == nullptr ? "" : token, .name_space = a.name_space, .rate = a.rate},
      print_event);
  if (const std::string wrong = bridge.open(); !wrong.empty())
    return usage_error(network + " cannot be used: " + wrong);
  print_event(where + ": " + std::to_string(interfaces.actions.size()) + " actions, " +
              std::to_string(interfaces.topics.size()) + " topics");
  bridge.run(stop);
  (void)::close(stop);
  return kOk;
}

int run_ros2(const ros2::Interfaces& interfaces, const Ros2Arguments& a) {
  ros2::BusPlan plan;
  plan.interface = a.network == "auto" ? "" : a.network;
  if (!domain_of(a.domain, plan.domain)) return usage_error("$ROS_DOMAIN_ID is a number from 0 to 232");
  const Result<const ros2::BusFactory*> factory = load_dds();
  if (!factory) return usage_error(factory.error());
  const int stop = wait_for_signals();
  if (stop < 0) return usage_error("signals cannot be waited for");
  auto bus = (*factory)->open(plan);
  if (!bus) return usage_error("DDS cannot be used: " + bus.error());
  return run_bridge(interfaces, a.bridge, **bus, stop, "DDS", "ROS 2 domain " + std::to_string(plan.domain));
}

int run_ros1(const ros2::Interfaces& interfaces, const BridgeArguments& a) {
  const Result<const ros1::TopicBusFactory*> factory = load_ros1();
  if (!factory) return usage_error(factory.error());
  const int stop = wait_for_signals();
  if (stop < 0) return usage_error("signals cannot be waited for");
  auto topics = (*factory)->open("bipc_" + interfaces.package);
  if (!topics) return usage_error("ROS 1 cannot be used: " + topics.error());
  ros1::ActionBus bus(interfaces, std::move(*topics));
  return run_bridge(interfaces, a, bus, stop, "ROS 1", "ROS 1 package " + interfaces.package);
}

/// The interfaces, with the package written if one is asked for. Nothing: `code` is what to end with.
std::optional<ros2::Interfaces> prepare(const BridgeArguments& a, const std::string& command,
                                        PackageFiles (&files_of)(const ros2::Interfaces&), int& code) {
  if (a.serve.empty() && a.interfaces.empty()) {
    code = usage_error("`bipc " + command + "` needs `--serve` or `--interfaces`", "`bipc " + command + " --help`");
    return std::nullopt;
  }
  if (!a.level.package.empty() && !ros2::is_package_name(a.level.package)) {
    code = usage_error("`" + a.level.package + "` is no name of a package of ROS: small letters, digits, `_` between");
    return std::nullopt;
  }
  Compilation c(a.level.compile);
  const auto level = load_level(c, a.level);
  std::optional<ros2::Interfaces> interfaces;
  if (level) {
    check_modules(c, *level, a.modules);
    const std::string package = a.level.package.empty() ? ros2::package_for(level->name) : a.level.package;
    interfaces = ros2::make_interfaces(level->modules, level->constraints, package, a.modules, c.diags);
  }
  if (interfaces && !c.diags.has_errors() && !a.interfaces.empty())
    write_package(c, *interfaces, files_of(*interfaces), a.interfaces);
  code = report(c);
  if (code != kOk) interfaces.reset();
  return interfaces;
}

}  // namespace

int command_ros1(const BridgeArguments& a) {
  int code = kOk;
  const auto interfaces = prepare(a, "ros1", ros1::package_files, code);
  return !interfaces || a.serve.empty() ? code : run_ros1(*interfaces, a);
}

int command_ros2(const Ros2Arguments& a) {
  int code = kOk;
  const auto interfaces = prepare(a.bridge, "ros2", ros2::package_files, code);
  return !interfaces || a.bridge.serve.empty() ? code : run_ros2(*interfaces, a);
}

}  // namespace bip::driver
