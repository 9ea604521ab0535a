// See deployment_files.hpp.
#include "compiler/driver/deployment_files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include <fmt/format.h>

#include "compiler/base/content_hash.hpp"
#include "compiler/base/read_file.hpp"
#include "compiler/base/visit_files.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/distributed_runs.hpp"
#include "compiler/driver/known_conflicts.hpp"
#include "compiler/emit_cpp/copy_ffi_files.hpp"
#include "compiler/pipeline/ffi_build.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/system/system.hpp"

namespace bip::driver {

namespace {

namespace fs = std::filesystem;

constexpr const char* kNodeFile = "node";
constexpr const char* kKeyFile = "key";
constexpr const char* kLauncherKeyFile = "launcher.key";
constexpr const char* kWhereInstalled = "/opt/bipc";

constexpr const char* kStart = R"sh(#!/bin/sh
# Starts node `{0}`; options are those of `bipc node`.
exec "${{BIPC:-bipc}}" node "$(dirname "$0")" "$@"
)sh";

constexpr const char* kUnit = R"([Unit]
Description=bipc node {0}
Wants=network-online.target
After=network-online.target
# Nodes wait for each other as long as it takes.
StartLimitIntervalSec=0

[Service]
ExecStart={1}/{0}/start
User=bipc
# Where machine code of the model is kept.
CacheDirectory=bipc
Environment=XDG_CACHE_HOME=/var/cache/bipc
Restart=on-failure
RestartSec=2
NoNewPrivileges=yes
PrivateTmp=yes
ProtectSystem=full
ProtectHome=yes

[Install]
WantedBy=multi-user.target
)";

constexpr const char* kReadme = R"(Node `{0}` of {2}, made by `bipc deploy`.

Needed on its host: the packages bipc and bipc-distributed, of the version with which this was made ({3}).
Copy this folder there, so that only the user who runs it can read `key`.

  {0}/start
      runs the node{4}
  bipc-{0}.service
      the same as a unit of systemd, for a folder in {1} and a user `bipc`:
      cp {0}/bipc-{0}.service /etc/systemd/system/ && systemctl enable --now bipc-{0}

It listens at {5}; open that port in the host's firewall. Messages of senders without one of the keys in `node` are dropped.
Nodes start in any order and wait for each other. `{6}` begins the run; its folder has `launcher.key` as well.
After a change of the model or the placement: deploy again, and copy all folders.
)";

constexpr const char* kStartAll = R"sh(#!/bin/sh
# Copies each node's folder to its host and starts it there, over ssh; `{1}` with the options given here (those of
# `bipc node`). TARGET: the folder on the hosts. An interrupt ends the run, a second one all nodes at once.
set -e
cd "$(dirname "$0")"
target=${{TARGET:-bipc-nodes}}
options=
for word; do options="$options '$(printf %s "$word" | sed "s/'/'\\\\''/g")'"; done

# In an archive: addresses of IPv6 need no brackets, and modes stay. The C++ of an earlier deployment goes.
copy() {{
  tar -cf - "$1" |
    ssh "$2" "umask 077 && mkdir -p '$target' && chmod 700 '$target' && rm -rf '$target/$1/{3}' &&
      tar -xpf - -C '$target'"
}}
{0}
# Nobody writes to these pipes. A node ends when what its ssh reads ends: this script or the ssh, or a pipe is closed.
pipes=$(mktemp -d)
mkfifo "$pipes/first" "$pipes/others"
exec 4<>"$pipes/first" 5<>"$pipes/others"
exec 6<"$pipes/first" 7<"$pipes/others"
rm -r "$pipes"
start() {{
  exec ssh "$2" "exec 3<&0; '$target/$1/start'$3 3<&- </dev/null & node=\$!
    {{ read -r end; kill \$node; }} <&3 >/dev/null 2>&1 & reader=\$!
    exec 3<&-; code=0; wait \$node || code=\$?; kill \$reader 2>/dev/null; exit \$code" 4<&- 5<&- 6<&- 7<&-
}}
others=
{4}start {1} {2} "$options" <&6 &
first=$!
exec 6<&- 7<&-

trap 'trap - HUP INT TERM; exec 4<&-' HUP INT TERM
while :; do
  code=0
  wait $first || code=$?
  kill -0 $first 2>/dev/null || break
done
# The others end with the run. Those that do not within five seconds are stopped; at once, if there was no run.
delay=5
case $code in 2|255) delay=0 ;; esac
(sleep $delay; kill $others) 4<&- 5<&- </dev/null >/dev/null 2>&1 &
timer=$!
for other in $others; do wait "$other" || true; done
kill $timer 2>/dev/null || true
exit $code
)sh";

bool is_folder_name(const std::string& name) {
  return !name.empty() && name.front() != '.' && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '.';
  });
}

std::string host_of(const std::string& address) {
  std::string host = address.substr(0, address.rfind(':'));
  if (host.starts_with('[')) host = host.substr(1, host.size() - 2);
  return host;
}

// Sockets listen at numbers; of a host's name only the port is known.
std::string listen_of(const std::string& address) {
  const std::string host = host_of(address);
  const bool is_number =
      host.find_first_not_of("0123456789.") == std::string::npos || host.find(':') != std::string::npos;
  return is_number ? address : "*" + address.substr(address.rfind(':'));
}

// False after a report.
bool note_written(Compilation& c, const fs::path& path, const Result<bool>& written) {
  if (!written) c.diags.report(Diag::kB5004, {}, path.string(), written.error());
  return static_cast<bool>(written);
}

// Only the owner reads it, from its first byte on. What is no regular file, a link to another place above all, gives
// way.
Result<bool> replace_secret(const fs::path& path, const std::string& text) {
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(path, error))) fs::remove(path, error);
  Result<NewFile> file = NewFile::create(path, Readers::OwnerAlone);
  if (!file) return Failure{file.error()};
  if (Result<bool> written = file->write(text); !written) return written;
  return file->commit(Durability::Synced);
}

bool write_secret(Compilation& c, const fs::path& path, const std::string& text) {
  return note_written(c, path, replace_secret(path, text));
}

bool write_text_file(Compilation& c, const fs::path& path, const std::string& text) {
  return note_written(c, path, write_file(path, text));
}

bool write_program(Compilation& c, const fs::path& path, const std::string& text) {
  if (!write_text_file(c, path, text)) return false;
  return note_written(c, path, ::chmod(path.c_str(), 0755) == 0 ? Result<bool>(true) : Failure{std::strerror(errno)});
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

Result<rt::FabricKeys> read_keys(const fs::path& path, const std::string& open) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return Failure{path.string() + ": " + std::strerror(errno)};
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    return Failure{path.string() + ": others can read this key: `chmod 600`, or deploy again"};
  const std::optional<std::string> text = read_file(path);
  if (!text) return Failure{path.string() + " cannot be read"};
  return rt::FabricKeys{open, first_line(*text)};
}

// Everything that all nodes must have alike.
std::string model_hash(const fs::path& folder, const rt::Placement& placement) {
  std::vector<std::string> texts{BIPC_VERSION, read_file(folder / kModelFile).value_or(""),
                                 read_file(folder / kMovesFile).value_or("")};
  std::string homes;
  for (const std::string& name : placement.nodes) homes += name + '\n';
  for (const std::uint32_t home : placement.home) homes += std::to_string(home) + ' ';
  homes += "\nsplit above " + std::to_string(placement.split_above);
  texts.push_back(homes);
  std::error_code error;
  for (const fs::path& path : files_below(folder / kCppFolder, error)) {
    texts.push_back(path.lexically_relative(folder).generic_string());
    texts.push_back(read_file(path).value_or(""));
  }
  return content_hash({texts.begin(), texts.end()});
}

// The model's C++ is where it was copied to, below the node's folder.
Result<bool> move_cpp(FfiFiles& cpp, const fs::path& folder) {
  std::map<std::string, std::string> folders;  // by name
  std::error_code error;
  for (const fs::path& path : files_below(folder / kCppFolder, error)) {
    const std::string name = path.filename().string();
    if (!folders.emplace(name, path.parent_path().lexically_relative(folder).generic_string()).second)
      return Failure{"two C++ files are called `" + name + '`'};
  }
  for (auto* files : {&cpp.includes, &cpp.sources, &cpp.objects}) {
    for (CppFile& file : *files) {
      const std::string name = fs::path(file.name).filename().string();
      // A header of the system stays what it is.
      if (const auto found = folders.find(name); found != folders.end()) file = {found->second, name};
    }
  }
  return true;
}

// Before anything is written. Other folders called `ffi` than ours are not removed.
bool check_deployed_files(Compilation& c, const rt::Placement& placement, const DeployArguments& arguments) {
  std::error_code error;
  for (const std::string& name : placement.nodes) {
    const fs::path folder = fs::path(arguments.output) / name;
    const fs::path cpp = folder / kCppFolder;
    std::vector<std::string> files;
    for (const char* file : {kModelFile, kPlacementFile, kMovesFile, kNodeFile, kKeyFile, kLauncherKeyFile})
      files.push_back(folder / file);
    if (!check_outputs(c, files, {arguments.placement_path}) || !check_replaced_folder(c, cpp)) return false;
    if (fs::exists(cpp, error) && !fs::exists(folder / kNodeFile, error)) {
      c.diags.report(Diag::kB5004, {}, cpp.string(), "it is there already, and `bipc deploy` has not made it");
      return false;
    }
  }
  return true;
}

}  // namespace

bool is_deployable(Compilation& c, const rt::Placement& placement) {
  std::set<std::string> addresses;
  for (std::size_t node = 0; node < placement.nodes.size(); ++node) {
    const std::string& name = placement.nodes[node];
    const std::string& address = placement.addresses[node];
    if (!is_folder_name(name)) {
      c.diags.report(Diag::kB5073, {}, fmt::format("node `{}` cannot be deployed: its folder has its name", name))
          .help("letters, digits, `_` and `.`");
    } else if (address.empty()) {
      c.diags.report(Diag::kB5073, {}, fmt::format("node `{}` has no address", name))
          .help(fmt::format("`node {} host ADDRESS:PORT`", name));
    } else if (!addresses.insert(address).second) {
      c.diags.report(Diag::kB5073, {}, fmt::format("two nodes are at `{}`", address));
    }
  }
  return !c.diags.has_errors();
}

Result<bool> write_deployment(Compilation& c, const rt::Placement& placement, const DeployArguments& arguments,
                              const rt::FabricFactory& fabrics) {
  emit_cpp::CppBuild cpp;
  if (!find_ffi_files(c, cpp)) return false;
  const std::optional<std::string> given = read_file(arguments.placement_path);
  if (!given) return Failure{arguments.placement_path + " cannot be read"};
  // All nodes have the same homes, and not the counts by which these were found.
  const bool is_found = given->find("anywhere") != std::string::npos || given->find("counts") != std::string::npos;
  const std::string place = is_found ? print_placement(c.lowered->image, placement) : *given;

  const std::size_t nodes = placement.nodes.size();
  std::vector<rt::FabricKeys> keys;
  std::string known;
  for (std::size_t peer = 0; peer <= nodes; ++peer) {
    keys.push_back(fabrics.make_keys());
    if (keys.back().open.empty()) return Failure{"no keys can be made: this libzmq has no CURVE"};
    known += peer == nodes ? "launcher " : "key " + placement.nodes[peer] + ' ';
    known += keys.back().open + '\n';
  }

  const fs::path top = arguments.output;
  if (!check_deployed_files(c, placement, arguments)) return false;
  std::string copies, starts, model;
  for (std::size_t node = 0; node < nodes; ++node) {
    const std::string& name = placement.nodes[node];
    const fs::path folder = top / name;
    std::error_code error;
    fs::create_directories(folder, error);
    const std::string about = fmt::format(
        "# Made by `bipc deploy`. Only senders with one of these keys are heard; where the nodes are says {}.\nnode "
        "{}\n",
        kPlacementFile, name);
    // First: it says that the folder is ours, also if what follows cannot be written.
    if (!error && !write_text_file(c, folder / kNodeFile, about + known)) return false;
    fs::remove_all(folder / kCppFolder, error);
    fs::create_directories(folder, error);
    if (error) return note_written(c, folder, Failure{error.message()});
    if (const auto copied = emit_cpp::copy_ffi_files(cpp, folder); !copied) return Failure{copied.error()};
    if (node == 0) {
      if (const Result<bool> moved = move_cpp(c.system->code.cpp, folder); !moved) return moved;
      model = system::print(*c.system);
    }
    const std::string& address = placement.addresses[node];
    const std::string readme =
        fmt::format(kReadme, name, kWhereInstalled, nodes, BIPC_VERSION,
                    node == 0 ? " and the launcher, which prints the steps: see `bipc node --help`" : "",
                    listen_of(address), placement.nodes[0]);
    const std::string unit = fmt::format(kUnit, name, kWhereInstalled);
    const bool is_written = write_text_file(c, folder / kModelFile, model) &&
                            write_text_file(c, folder / kPlacementFile, place) &&
                            write_text_file(c, folder / kMovesFile, print_next_moves(placement.next_moves)) &&
                            write_secret(c, folder / kKeyFile, keys[node].secret + '\n') &&
                            (node != 0 || write_secret(c, folder / kLauncherKeyFile, keys[nodes].secret + '\n')) &&
                            write_program(c, folder / "start", fmt::format(kStart, name)) &&
                            write_text_file(c, folder / ("bipc-" + name + ".service"), unit) &&
                            write_text_file(c, folder / "README", readme);
    if (!is_written) return false;
    const std::string host = host_of(address);
    copies += fmt::format("copy {} {}\n", name, host);
    if (node != 0) starts += fmt::format("start {} {} '' <&7 >&2 &\nothers=\"$others $!\"\n", name, host);
  }
  return write_program(
      c, top / "start",
      fmt::format(kStartAll, copies, placement.nodes[0], host_of(placement.addresses[0]), kCppFolder, starts));
}

Result<rt::Deployment> read_deployment(const std::string& folder, const rt::Placement& placement) {
  const fs::path top = folder;
  const std::optional<std::string> text = read_file(top / kNodeFile);
  if (!text) return Failure{(top / kNodeFile).string() + " cannot be read"};
  rt::Deployment deployment;
  deployment.names = placement.nodes;
  deployment.addresses = placement.addresses;
  deployment.open_keys.assign(placement.nodes.size() + 1, "");
  std::istringstream lines(*text);
  std::string self;
  for (std::string line; std::getline(lines, line);) {
    // Keys may have a `#` in them.
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    std::string what, name, key;
    words >> what >> name >> key;
    const auto node = std::find(placement.nodes.begin(), placement.nodes.end(), name);
    if (what == "node") self = name;
    else if (what == "launcher") deployment.open_keys.back() = name;
    else if (what == "key" && node != placement.nodes.end())
      deployment.open_keys[static_cast<std::size_t>(node - placement.nodes.begin())] = key;
    else return Failure{(top / kNodeFile).string() + ": odd line: " + line};
  }
  const auto own = std::find(placement.nodes.begin(), placement.nodes.end(), self);
  const bool has_all_keys = std::none_of(deployment.open_keys.begin(), deployment.open_keys.end(),
                                         [](const std::string& key) { return key.empty(); });
  if (own == placement.nodes.end() || !has_all_keys)
    return Failure{(top / kNodeFile).string() + " does not fit " + kPlacementFile + ": deploy again"};
  deployment.self = static_cast<std::uint32_t>(own - placement.nodes.begin());
  deployment.listen = listen_of(deployment.addresses[deployment.self]);
  Result<rt::FabricKeys> keys = read_keys(top / kKeyFile, deployment.open_keys[deployment.self]);
  if (!keys) return Failure{keys.error()};
  deployment.keys = *keys;
  if (deployment.self == 0) {
    keys = read_keys(top / kLauncherKeyFile, deployment.open_keys.back());
    if (!keys) return Failure{keys.error()};
    deployment.launcher_keys = *keys;
  }
  deployment.model = model_hash(top, placement);
  return deployment;
}

}  // namespace bip::driver
