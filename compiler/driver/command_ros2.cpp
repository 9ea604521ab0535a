// `bipc ros2`: the bridge between a running `bipc serve` and ROS 2, and the package of message types that a workspace
// of ROS 2 needs for it (compiler/docs/ros2.md).
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
#include "compiler/driver/rule_files.hpp"
#include "compiler/pipeline/exit_codes.hpp"
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

void write_package(Compilation& c, const ros2::Interfaces& interfaces, const std::string& folder) {
  namespace fs = std::filesystem;
  const auto files = ros2::package_files(interfaces);
  for (const auto& [name, text] : files) {
    const fs::path path = fs::path(folder) / name;
    std::error_code ignored;
    fs::create_directories(path.parent_path(), ignored);
    const Result<bool> written = write_file(path.string(), text);
    if (!written) return void(c.diags.report(Diag::kB5004, {}, path.string(), written.error()));
  }
  std::printf("%s: package %s, %zu actions, %zu messages\n", folder.c_str(), interfaces.package.c_str(),
              interfaces.actions.size(), interfaces.own.size());
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
  std::FILE* const to = line.starts_with("warning") ? stderr : stdout;
  std::fprintf(to, "%s\n", line.c_str());
  std::fflush(to);
}

int run_bridge(const ros2::Interfaces& interfaces, const Ros2Arguments& a) {
  ros2::BusPlan plan;
  plan.interface = a.network == "auto" ? "" : a.network;
  if (!domain_of(a.domain, plan.domain)) return usage_error("$ROS_DOMAIN_ID is a number from 0 to 232");
  const Result<const ros2::BusFactory*> factory = load_dds();
  if (!factory) return usage_error(factory.error());
  // Before there are threads, which would take the signals.
  sigset_t ends{};
  sigemptyset(&ends);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&ends, signal);
  if (::pthread_sigmask(SIG_BLOCK, &ends, nullptr) != 0) return usage_error("signals cannot be blocked");
  const int stop = ::signalfd(-1, &ends, SFD_CLOEXEC | SFD_NONBLOCK);
  if (stop < 0) return usage_error("signals cannot be waited for");
  auto bus = (*factory)->open(plan);
  if (!bus) return usage_error("DDS cannot be used: " + bus.error());
  const char* const token = std::getenv("BIPC_TOKEN");
  ros2::Bridge bridge(
      interfaces, **bus,
      {.where = a.serve, .token = token == nullptr ? "" : token, .name_space = a.name_space, .rate = a.rate},
      print_event);
  if (const std::string wrong = bridge.open(); !wrong.empty()) return usage_error("DDS cannot be used: " + wrong);
  print_event("ROS 2 domain " + std::to_string(plan.domain) + ": " + std::to_string(interfaces.actions.size()) +
              " actions, " + std::to_string(interfaces.topics.size()) + " topics");
  bridge.run(stop);
  (void)::close(stop);
  return kOk;
}

}  // namespace

int command_ros2(const Ros2Arguments& a) {
  if (a.serve.empty() && a.interfaces.empty())
    return usage_error("`bipc ros2` needs `--serve` or `--interfaces`", "`bipc ros2 --help`");
  if (!a.level.package.empty() && !ros2::is_package_name(a.level.package))
    return usage_error("`" + a.level.package +
                       "` is no name of a package of ROS 2: small letters, digits, `_` between");
  Compilation c(a.level.compile);
  const auto level = load_level(c, a.level);
  std::optional<ros2::Interfaces> interfaces;
  if (level) {
    check_modules(c, *level, a.modules);
    const std::string package = a.level.package.empty() ? ros2::package_for(level->name) : a.level.package;
    interfaces = ros2::make_interfaces(level->modules, level->constraints, package, a.modules, c.diags);
  }
  if (interfaces && !c.diags.has_errors() && !a.interfaces.empty()) write_package(c, *interfaces, a.interfaces);
  const int code = report(c);
  if (code != kOk || !interfaces || a.serve.empty()) return code;
  return run_bridge(*interfaces, a);
}

}  // namespace bip::driver
