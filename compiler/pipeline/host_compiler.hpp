// The C++ compiler of the host, for `bipc build`.
#pragma once
#include <dirent.h>

#include <optional>
#include <memory>
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "runtime/engine/interrupt.hpp"

namespace bip::pipeline {

/// $CXX (may hold arguments, e.g. "ccache g++"), else the first of c++, g++, clang++ on PATH; as an argument vector.
/// Empty if there is none; `tried` says what was looked for.
[[nodiscard]] std::vector<std::string> find_host_compiler(std::string& tried);

/// Returns the path of the program that a command of this name starts; empty if there is none on PATH.
[[nodiscard]] std::string find_program(const std::string& name);

/// Runs a program with its output on our standard error, or in the file `output`, beside which its temporary files lie
/// then. The exit code; 128 + signal if a signal ended it; a Failure if it could not be started. SIGINT, SIGTERM and
/// SIGHUP end the program with all that it started, and not us, so that the caller can tidy up.
[[nodiscard]] Result<int> run_program(const std::vector<std::string>& command, const std::string& output = {});

/// The signal that came while a program ran, or 0. A command that was asked to end so ends by this signal.
[[nodiscard]] int signal_during_program();

/// Where the runtime is: `include`, `core`, `engine`, `trace` below `directory`, and the library made by our own build
/// (empty: compile the sources). Looked for beside the bipc program: in a build tree and in an installation.
struct RuntimeLocation {
  std::string directory;
  std::string library;
  std::string serve_library;  // what programs link that serve a model; empty: it is not there
  std::vector<std::string> tried;
};
[[nodiscard]] RuntimeLocation find_runtime();
/// A directory that disappears with the object. A signal that asks the process to end while it is there is kept for
/// signal_during_program(), so the directory is removed then, too. Files in it are removed without memory being
/// allocated.
class TemporaryDirectory {
 public:
  [[nodiscard]] static Result<TemporaryDirectory> make();
  TemporaryDirectory(TemporaryDirectory&& other) noexcept
      : signals_(std::move(other.signals_)), path_(std::move(other.path_)), entries_(std::move(other.entries_)) {
    other.path_.clear();
  }
  TemporaryDirectory& operator=(TemporaryDirectory&&) = delete;
  ~TemporaryDirectory();
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  explicit TemporaryDirectory(std::unique_ptr<rt::EndingSignals> signals) : signals_(std::move(signals)) {}
  std::unique_ptr<rt::EndingSignals> signals_;
  std::string path_;
  std::unique_ptr<DIR, int (*)(DIR*)> entries_{nullptr, ::closedir};
};

}  // namespace bip::pipeline
