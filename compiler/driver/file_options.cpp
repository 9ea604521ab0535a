// See file_options.hpp.
#include "compiler/driver/file_options.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <vector>

#include "runtime/engine/file_conflict.hpp"

namespace bip::driver {

namespace {

constexpr FileOption kFileOptions[] = {
    {"check", "FILE", FileRole::Source},
    {"check", "--placement", FileRole::Input},
    {"run", "FILE", FileRole::Source},
    {"run", "--trace", FileRole::Output},
    {"run", "--placement", FileRole::Input},
    // A run that goes on from a checkpoint may write its own ones in the same place.
    {"run", "--checkpoint-file", FileRole::Updated},
    {"run", "--resume", FileRole::Input},
    {"run", "--events", FileRole::Input},
    {"run", "--record", FileRole::Output},
    {"run", "--replay", FileRole::Input},
    {"run", "--profile-json", FileRole::Output},
    {"verify", "FILE", FileRole::Source},
    {"verify", "--properties", FileRole::Input},
    {"verify", "--certificate", FileRole::Output},
    {"verify", "--trace", FileRole::Output},
    {"explore", "FILE", FileRole::Source},
    {"explore", "--trace", FileRole::Output},
    {"simulate", "FILE", FileRole::Source},
    {"simulate", "--csv", FileRole::Output},
    {"step", "FILE", FileRole::Source},
    {"step", "--trace", FileRole::Input},
    {"step", "--events", FileRole::Input},
    {"view", "FILE", FileRole::Source},
    {"view", "--output", FileRole::Output},
    {"view", "--certificate", FileRole::Input},
    {"view", "--trace", FileRole::Input},
    {"view", "--events", FileRole::Input},
    {"view", "--open", FileRole::Other},
    {"trace", "MODEL", FileRole::Source},
    {"trace", "TRACE", FileRole::Input},
    {"trace", "--output", FileRole::Output},
    {"trace", "--events", FileRole::Input},
    {"trace", "--component", FileRole::Other},
    {"trace", "--interaction", FileRole::Other},
    {"serve", "FILE", FileRole::Source},
    {"serve", "--socket", FileRole::Other},
    {"serve", "--trace", FileRole::Output},
    {"deploy", "FILE", FileRole::Source},
    {"deploy", "--placement", FileRole::Input},
    {"deploy", "--output", FileRole::Folder},
    {"node", "DIR", FileRole::Folder},
    {"node", "--trace", FileRole::Output},
    {"build", "FILE", FileRole::Source},
    {"build", "--output", FileRole::Output},
    {"emit", "FILE", FileRole::Source},
    {"emit", "--output", FileRole::Folder},
    {"graph", "FILE", FileRole::Source},
    {"graph", "--output", FileRole::Output},
    {"graph", "--yields", FileRole::Input},
    {"graph", "--open", FileRole::Other},
    {"export", "FILE", FileRole::Source},
    {"export", "--output", FileRole::Output},
    {"replay", "FILE", FileRole::Source},
    {"replay", "--published", FileRole::Input},
    {"replay", "--recorded", FileRole::Input},
    {"replay", "--resume", FileRole::Input},
    {"fmt", "FILE", FileRole::Source},
    {"migrate", "FILE", FileRole::Source},
    {"migrate", "--output", FileRole::Output},
    {"genom", "FILE", FileRole::Source},
    {"genom", "--output", FileRole::Output},
    {"genom", "--yields", FileRole::Input},
    {"genom", "--codels", FileRole::Input},
    {"rules", "FILE", FileRole::Source},
    {"rules", "--output", FileRole::Output},
    {"rules", "--yields", FileRole::Input},
    {"rules", "--codels", FileRole::Input},
    {"ros1", "FILE", FileRole::Source},
    {"ros1", "--interfaces", FileRole::Folder},
    {"ros1", "--yields", FileRole::Input},
    {"ros2", "FILE", FileRole::Source},
    {"ros2", "--interfaces", FileRole::Folder},
    {"ros2", "--yields", FileRole::Input},
};

constexpr std::string_view kFileTypes[] = {"PATH", "FILE", "DIR", "TRACE", "PAGE", "CERT", "EXE"};
constexpr std::string_view kFilePositionals[] = {"FILE", "MODEL", "TRACE", "DIR"};
// Of every command that has them: where packages are, and the cache.
constexpr std::string_view kCommonFolders[] = {"-I", "--cache"};

bool is_written(FileRole role) { return role == FileRole::Output || role == FileRole::Updated; }

std::string shown(const FileOption& row) { return std::string_view(row.option) == "--output" ? "-o" : row.option; }

}  // namespace

std::span<const FileOption> file_options() { return kFileOptions; }

bool names_file(const CLI::Option& option) {
  const auto is_in = [](const std::string& word, const auto& words) {
    return std::find(std::begin(words), std::end(words), word) != std::end(words);
  };
  if (std::any_of(std::begin(kCommonFolders), std::end(kCommonFolders),
                  [&](std::string_view name) { return option.check_name(std::string(name)); }))
    return false;
  return option.get_positional() ? is_in(option.get_name(true), kFilePositionals)
                                 : is_in(option.get_type_name(), kFileTypes);
}

std::string nameless_file(const CLI::App& command) {
  for (const FileOption& row : kFileOptions) {
    if (command.get_name() != row.command || row.role == FileRole::Other) continue;
    const CLI::Option* option = command.get_option_no_throw(row.option);
    if (option == nullptr) continue;
    const std::vector<std::string>& paths = option->results();
    if (std::find(paths.begin(), paths.end(), "") != paths.end()) return shown(row);
  }
  return {};
}

std::string file_conflict(const CLI::App& command) {
  std::vector<rt::NamedFile> files;
  for (const FileOption& row : kFileOptions) {
    if (command.get_name() != row.command || !(is_written(row.role) || row.role == FileRole::Input)) continue;
    const CLI::Option* option = command.get_option_no_throw(row.option);
    if (option == nullptr) continue;
    const rt::FileUse use = row.role == FileRole::Input    ? rt::FileUse::Input
                            : row.role == FileRole::Output ? rt::FileUse::Output
                                                           : rt::FileUse::Updated;
    for (const std::string& path : option->results())
      if (!path.empty() && path != "-") files.push_back({shown(row), path, use});
  }
  return rt::file_conflict(files);
}

}  // namespace bip::driver
