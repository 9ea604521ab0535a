// Finds and runs the host's C++ compiler, finds the runtime's sources, and manages temporary files. POSIX only.
#include "compiler/driver/host_compiler.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

extern char** environ;

namespace bip::driver {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

bool is_program(const std::string& name) {
  if (name.find('/') != std::string::npos) return ::access(name.c_str(), X_OK) == 0;
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (::access(((folder.empty() ? "." : folder) + "/" + name).c_str(), X_OK) == 0) return true;
  }
  return false;
}

// Our parent stays deaf to Ctrl-C while the child runs; the child gets the default back.
class IgnoreInterrupts {
 public:
  IgnoreInterrupts() {
    struct sigaction ignore {};
    ignore.sa_handler = SIG_IGN;
    ::sigaction(SIGINT, &ignore, &before_);
  }
  ~IgnoreInterrupts() { ::sigaction(SIGINT, &before_, nullptr); }
  IgnoreInterrupts(const IgnoreInterrupts&) = delete;
  IgnoreInterrupts& operator=(const IgnoreInterrupts&) = delete;

 private:
  struct sigaction before_ {};
};

}  // namespace

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
  const IgnoreInterrupts quiet;
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&actions);
  if (!output.empty())
    ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  ::posix_spawnattr_init(&attributes);
  sigset_t defaults;
  ::sigemptyset(&defaults);
  ::sigaddset(&defaults, SIGINT);
  ::posix_spawnattr_setsigdefault(&attributes, &defaults);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, arguments.front(), &actions, &attributes, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::posix_spawnattr_destroy(&attributes);
  if (error != 0) return Failure{std::strerror(error)};
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return Failure{std::strerror(errno)};
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::string program_path() {
  std::error_code ignored;
  return fs::read_symlink("/proc/self/exe", ignored).string();
}

RuntimeLocation find_runtime() {
  RuntimeLocation found;
  std::error_code ignored;
  const fs::path folder = fs::path(program_path()).parent_path();
  // In a build tree CMake leaves a link `runtime` to the sources beside the program.
  for (const fs::path& candidate :
       {folder / "runtime", folder.parent_path() / "share/bipc/runtime", folder.parent_path() / "runtime"}) {
    found.tried.push_back(candidate.string());
    if (!fs::exists(candidate / "include/bip/run.hpp", ignored)) continue;
    found.directory = candidate.string();
#ifdef BIPC_PREBUILT_RUNTIME
    for (const fs::path& library : {folder / "libbip_runtime.a", folder.parent_path() / "lib/bipc/libbip_runtime.a"}) {
      if (found.library.empty() && fs::exists(library, ignored)) found.library = library.string();
    }
#endif
    break;
  }
  return found;
}

Result<TemporaryDirectory> TemporaryDirectory::make() {
  std::error_code error;
  std::string name = (fs::temp_directory_path(error) / "bipc-XXXXXX").string();
  if (error || ::mkdtemp(name.data()) == nullptr)
    return Failure{"no temporary directory: " + std::string(std::strerror(errno))};
  return TemporaryDirectory(std::move(name));
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

Result<bool> write_file(const std::string& path, const std::string& text) {
  std::error_code ignored;
  // Through a link, the file it points to is what changes.
  const fs::path target = fs::is_symlink(path, ignored) ? fs::canonical(path, ignored) : fs::path(path);
  const bool is_plain = !fs::exists(target, ignored) || fs::is_regular_file(target, ignored);
  const fs::path written = is_plain ? fs::path(target.string() + ".bipc-new") : target;
  {
    std::ofstream out(written, std::ios::binary);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    out.close();
    if (!out) {
      const std::string reason = std::strerror(errno);
      if (is_plain) fs::remove(written, ignored);
      return Failure{reason};
    }
  }
  if (!is_plain) return true;
  if (const fs::file_status old = fs::status(target, ignored); fs::exists(old))
    fs::permissions(written, old.permissions(), ignored);
  std::error_code error;
  fs::rename(written, target, error);
  if (error) {
    fs::remove(written, ignored);
    return Failure{error.message()};
  }
  return true;
}

}  // namespace bip::driver
