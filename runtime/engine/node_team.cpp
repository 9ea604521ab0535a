// See node_team.hpp.
#include "runtime/engine/node_team.hpp"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

#include "runtime/engine/interrupt.hpp"

namespace bip::rt {

namespace {

// Unix sockets have short names: a folder deep down is of no use.
std::string folder_for_sockets() {
  const char* given = std::getenv("TMPDIR");
  std::string base = given == nullptr || std::strlen(given) > 60 || *given == '\0' ? "/tmp" : given;
  std::string name = base + "/bipc-nodes-XXXXXX";
  return ::mkdtemp(name.data()) == nullptr ? std::string() : name;
}

std::string socket_of(const std::string& folder, u32 node) { return folder + '/' + std::to_string(node); }

int watch(pid_t process) { return static_cast<int>(::syscall(SYS_pidfd_open, process, 0)); }

}  // namespace

NodeTeam::~NodeTeam() {
  for (Child& child : children_) {
    if (child.process == 0) continue;
    ::kill(child.process, SIGKILL);
    ::waitpid(child.process, nullptr, 0);
    close_file(child);
  }
  if (folder_.empty()) return;
  for (u32 node = 0; node < children_.size(); ++node) ::unlink(socket_of(folder_, node).c_str());
  ::rmdir(folder_.c_str());
}

void NodeTeam::close_file(Child& child) {
  child.process = 0;
  if (child.file < 0) return;
  ::close(child.file);
  files_.erase(std::find(files_.begin(), files_.end(), child.file));
  child.file = -1;
}

std::string NodeTeam::start(u32 nodes, const FabricFactory& fabrics,
                            const std::function<int(u32, const FabricPlan&)>& live) {
  folder_ = folder_for_sockets();
  if (folder_.empty()) return std::string("no folder for sockets can be made: ") + std::strerror(errno);
  plan_.self = nodes;
  std::vector<FabricKeys> keys;
  for (u32 peer = 0; peer <= nodes; ++peer) {
    keys.push_back(fabrics.make_keys());
    if (keys.back().open.empty()) return "no keys can be made: this libzmq has no CURVE";
    plan_.open_keys.push_back(keys.back().open);
    plan_.addresses.push_back(peer == nodes ? std::string() : "ipc://" + socket_of(folder_, peer));
  }
  plan_.keys = keys[nodes];
  for (u32 node = 0; node < nodes; ++node) {
    std::string problem = start_child([&] {
      FabricPlan plan = plan_;
      plan.self = node;
      plan.keys = keys[node];
      return live(node, plan);
    });
    if (!problem.empty()) return problem;
  }
  return {};
}

std::string NodeTeam::start_first(const FabricPlan& plan, const std::function<int()>& live) {
  plan_ = plan;
  return start_child(live);
}

std::string NodeTeam::start_child(const std::function<int()>& live) {
  // What is buffered now would be written by the child as well.
  std::fflush(nullptr);
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process < 0) return std::string("a process cannot be started: ") + std::strerror(errno);
  if (process == 0) {
    // Ends with the launcher; signals of the terminal are for the launcher.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) std::_Exit(1);
    for (const int signal : kEndingSignals) ::signal(signal, SIG_IGN);
    const int code = live();
    std::fflush(stdout);
    std::fflush(stderr);
    std::_Exit(code);
  }
  children_.push_back({process, watch(process)});
  if (children_.back().file >= 0) files_.push_back(children_.back().file);
  return {};
}

std::vector<EndedNode> NodeTeam::take_ended() {
  std::vector<EndedNode> ended;
  for (u32 node = 0; node < children_.size(); ++node) {
    Child& child = children_[node];
    int status = 0;
    if (child.process == 0 || ::waitpid(child.process, &status, WNOHANG) != child.process) continue;
    close_file(child);
    ended.push_back({node, WIFSIGNALED(status) ? "killed by signal " + std::to_string(WTERMSIG(status))
                                               : "exit code " + std::to_string(WEXITSTATUS(status))});
  }
  return ended;
}

// The letter after the name of the program, which may hold blanks and parentheses (proc(5), /proc/PID/stat).
std::string NodeTeam::state_of(u32 node) const {
  const pid_t process = node < children_.size() ? children_[node].process : 0;
  if (process == 0) return "its process has ended";
  const std::string name = "its process " + std::to_string(process);
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  const std::string line{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::size_t end = line.rfind(") ");
  switch (end == std::string::npos || end + 2 >= line.size() ? '?' : line[end + 2]) {
    case 'T': return name + " is stopped";
    case 't': return name + " is stopped by a debugger";
    case 'R': return name + " is running: an action, or a busy machine";
    case 'S': return name + " sleeps: an action that waits";
    case 'D': return name + " waits for a device";
    default: return name + " is there";
  }
}

void NodeTeam::wait_for_all(int ms) {
  while (!files_.empty()) {
    std::vector<pollfd> polled;
    for (const int file : files_) polled.push_back({file, POLLIN, 0});
    if (::poll(polled.data(), polled.size(), ms) <= 0) return;
    (void)take_ended();
  }
}

}  // namespace bip::rt
