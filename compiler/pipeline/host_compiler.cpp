// Finds and runs the host's C++ compiler, finds the runtime's sources, and manages temporary files. POSIX only.
#include "compiler/pipeline/host_compiler.hpp"

#include "compiler/pipeline/parts.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <new>
#include <sstream>

#include "runtime/engine/interrupt.hpp"

extern char** environ;

namespace bip::pipeline {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

bool is_program(const std::string& name) { return !find_program(name).empty(); }

// The process group of the program that runs, for the handler of signals, and what the handler was called with.
std::atomic<pid_t> running_group{0};
std::atomic<int> forwarded_signal{0};
extern "C" void bip_forward_signal(int signal) {
  forwarded_signal.store(signal);
  if (const pid_t group = running_group.load(); group != 0) ::kill(-group, signal);
}

// Blocks the ending signals of this thread while it lives: between the start of a program and the note of its number.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t ending;
    ::sigemptyset(&ending);
    for (const int signal : rt::kEndingSignals) ::sigaddset(&ending, signal);
    ::pthread_sigmask(SIG_BLOCK, &ending, &before_);
  }
  ~BlockedSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;
  [[nodiscard]] const sigset_t& before() const { return before_; }

 private:
  sigset_t before_{};
};

// The environment of a program whose temporary files belong beside `output`, in a folder that is removed: a compiler
// that a signal ends between the making of such a file and the note of it leaves it there.
std::vector<std::string> environment_beside(const std::string& output) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (output.empty() || std::strncmp(*variable, "TMPDIR=", 7) != 0) variables.emplace_back(*variable);
  }
  if (!output.empty()) variables.push_back("TMPDIR=" + fs::path(output).parent_path().string());
  return variables;
}

// Starts the program in a process group of its own. Returns the error's number.
int start_program(const std::vector<std::string>& command, const std::string& output, pid_t& child) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  std::vector<std::string> environment = environment_beside(output);
  std::vector<char*> variables;
  for (std::string& variable : environment) variables.push_back(variable.data());
  variables.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&actions);
  if (!output.empty())
    ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  ::posix_spawnattr_init(&attributes);
  sigset_t defaults;
  ::sigemptyset(&defaults);
  for (const int signal : rt::kEndingSignals) ::sigaddset(&defaults, signal);
  ::posix_spawnattr_setsigdefault(&attributes, &defaults);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  const BlockedSignals blocked;
  ::posix_spawnattr_setsigmask(&attributes, &blocked.before());
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
  const int error =
      ::posix_spawnp(&child, arguments.front(), &actions, &attributes, arguments.data(), variables.data());
  if (error == 0) running_group.store(child);
  ::posix_spawn_file_actions_destroy(&actions);
  ::posix_spawnattr_destroy(&attributes);
  return error;
}

// Ends the group of a program if this process ends while the program runs, also by SIGKILL: a process of its own waits
// for the end of a connection whose other end this process alone holds open. Without a connection or a process there is
// no such guard.
class GroupGuard {
 public:
  explicit GroupGuard(pid_t group) {
    // Sockets: writing to a pipe would end this process if the guard is gone.
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return;
    guard_ = ::fork();
    if (guard_ == 0) guard(ends[0], group);
    ::close(ends[0]);
    if (guard_ > 0) open_end_ = ends[1];
    else ::close(ends[1]);
  }
  ~GroupGuard() {
    if (open_end_ < 0) return;
    constexpr char kDone = 0;
    // If this fails, the guard signals a group that is no longer there.
    (void)::send(open_end_, &kDone, 1, MSG_NOSIGNAL);
    ::close(open_end_);
    while (::waitpid(guard_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  GroupGuard(const GroupGuard&) = delete;
  GroupGuard& operator=(const GroupGuard&) = delete;

 private:
  // After fork: only functions that are safe in signal handlers.
  [[noreturn]] static void guard(int end, pid_t group) {
    // The child must not keep other files open: their readers wait for their end.
    if (end > 0) ::close_range(0, static_cast<unsigned>(end) - 1, 0);
    ::close_range(static_cast<unsigned>(end) + 1, ~0u, 0);
    char done = 0;
    ssize_t size = 0;
    while ((size = ::read(end, &done, 1)) < 0 && errno == EINTR) {
    }
    if (size == 0) ::kill(-group, SIGTERM);
    ::_exit(0);
  }

  pid_t guard_ = -1;
  int open_end_ = -1;
};

}  // namespace

std::string find_program(const std::string& name) {
  if (name.find('/') != std::string::npos) return ::access(name.c_str(), X_OK) == 0 ? name : std::string();
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    std::string file = (folder.empty() ? "." : folder) + "/" + name;
    if (::access(file.c_str(), X_OK) == 0) return file;
  }
  return {};
}

std::vector<std::string> find_host_compiler(std::string& tried) {
  const char* cxx = std::getenv("CXX");
  if (cxx != nullptr && *cxx != '\0') {
    tried = std::string("`") + cxx + "` of $CXX";
    std::vector<std::string> command = words_of(cxx);
    if (!command.empty() && is_program(command.front())) return command;
    return {};
  }
  tried = "`c++`, `g++`, `clang++`";
  for (const char* name : {"c++", "g++", "clang++"}) {
    if (is_program(name)) return {name};
  }
  return {};
}

Result<int> run_program(const std::vector<std::string>& command, const std::string& output) {
  const rt::EndingSignals forwarded(bip_forward_signal);
  pid_t child = 0;
  if (const int error = start_program(command, output, child); error != 0) return Failure{std::strerror(error)};
  const GroupGuard guard(child);
  int status = 0;
  int error = 0;
  while (::waitpid(child, &status, 0) < 0 && error == 0) error = errno == EINTR ? 0 : errno;
  running_group.store(0);
  if (error != 0) return Failure{std::strerror(error)};
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

int signal_during_program() { return forwarded_signal.load(); }

RuntimeLocation find_runtime() {
  RuntimeLocation found;
  std::error_code ignored;
  // In a build tree CMake leaves a link `runtime` to the sources beside the program.
  for (const fs::path& candidate : places_of_part("runtime")) {
    found.tried.push_back(candidate.string());
    if (!fs::exists(candidate / "include/bip/run.hpp", ignored)) continue;
    found.directory = candidate.string();
    for (const fs::path& library : places_of_part(BIPC_PREBUILT_RUNTIME)) {
      std::error_code unknown;
      // Where the file system cannot say whether it exists, the builds that link it look again.
      if (found.library.empty() && (fs::exists(library, unknown) || unknown)) found.library = library.string();
    }
    for (const fs::path& library : places_of_part(BIPC_PREBUILT_SERVE)) {
      std::error_code unknown;
      if (found.serve_library.empty() && (fs::exists(library, unknown) || unknown))
        found.serve_library = library.string();
    }
    break;
  }
  return found;
}

Result<TemporaryDirectory> TemporaryDirectory::make() {
  std::error_code error;
  std::string name = (fs::temp_directory_path(error) / "bipc-XXXXXX").string();
  TemporaryDirectory made(std::make_unique<rt::EndingSignals>(bip_forward_signal));
  if (error || ::mkdtemp(name.data()) == nullptr)
    return Failure{"no temporary directory: " + std::string(std::strerror(errno))};
  made.path_ = std::move(name);
  made.entries_.reset(::opendir(made.path_.c_str()));
  if (made.entries_ == nullptr) return Failure{"no temporary directory: " + std::string(std::strerror(errno))};
  return made;
}

TemporaryDirectory::~TemporaryDirectory() {
  if (path_.empty()) return;
  if (entries_ != nullptr) {
    ::rewinddir(entries_.get());
    while (const dirent* entry = ::readdir(entries_.get())) (void)::unlinkat(::dirfd(entries_.get()), entry->d_name, 0);
  }
  if (::rmdir(path_.c_str()) == 0) return;
  try {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  } catch (const std::bad_alloc&) {
    // What lies in folders of its own stays.
  }
}

}  // namespace bip::pipeline
