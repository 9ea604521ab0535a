// See log.hpp.
#include "compiler/base/log.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>

namespace bip {

namespace {

constexpr std::array kLogAreaNames = {
#define BIP_LOG_AREA(name, text) std::string_view(text),
    BIP_LOG_AREAS(BIP_LOG_AREA)
#undef BIP_LOG_AREA
};
using LogLevels = std::array<int, kLogAreaNames.size()>;

// Empty: the list was read into `levels`.
std::string read_log_levels(std::string_view list, LogLevels& levels) {
  while (!list.empty()) {
    const std::string_view item = list.substr(0, list.find(','));
    list.remove_prefix(std::min(list.size(), item.size() + 1));
    const std::string_view area = item.substr(0, item.find(':'));
    const std::string_view level = area.size() == item.size() ? "1" : item.substr(area.size() + 1);
    const auto found = std::find(kLogAreaNames.begin(), kLogAreaNames.end(), area);
    if (found == kLogAreaNames.end())
      return fmt::format("no area `{}`; there are {}", area, fmt::join(kLogAreaNames, ", "));
    if (level.size() != 1 || level[0] < '0' || level[0] > '9')
      return fmt::format("`{}` is no level from 0 to 9", level);
    levels[static_cast<std::size_t>(found - kLogAreaNames.begin())] = level[0] - '0';
  }
  return {};
}

LogLevels& log_levels() {
  static LogLevels levels = [] {
    LogLevels from_environment{};
    const char* const list = std::getenv("BIPC_LOG");
    if (list == nullptr) return from_environment;
    const std::string problem = read_log_levels(list, from_environment);
    if (!problem.empty()) std::fprintf(stderr, "BIPC_LOG: %s\n", problem.c_str());
    return from_environment;
  }();
  return levels;
}

}  // namespace

int log_level(LogArea area) { return log_levels()[static_cast<std::size_t>(area)]; }

std::string set_log_levels(std::string_view list) {
  LogLevels levels = log_levels();
  std::string problem = read_log_levels(list, levels);
  if (problem.empty() && !kHasLog) problem = "this build has no log lines: configure it with -DBIPC_LOG=ON";
  if (problem.empty()) log_levels() = levels;
  return problem;
}

void write_log(LogArea area, const std::string& line) {
  const std::string_view name = kLogAreaNames[static_cast<std::size_t>(area)];
  std::fprintf(stderr, "[%.*s] %s\n", static_cast<int>(name.size()), name.data(), line.c_str());
}

}  // namespace bip
