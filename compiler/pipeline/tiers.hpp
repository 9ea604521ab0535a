// Tiered execution: a run begins interpreted at once and continues with machine code when that is ready.
//
// A thread waits a little, because most runs are short and need no compiler; then it loads the JIT, compiles everything
// at -O2 with compiled steps (or finds it in the cache) and notifies the engine. The trace does not depend on when that
// happens.
#pragma once
#include <condition_variable>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "compiler/pipeline/jit_loader.hpp"
#include "compiler/lower/lower.hpp"
#include "runtime/engine/code_replacement.hpp"

namespace bip::pipeline {

class Tiers {
 public:
  /// `lowered` has code already and must outlive this; no other code may change it. options.goes_on is ours.
  Tiers(lower::LoweredSystem& lowered, jit::JitOptions options, unsigned patience_ms);
  /// Ends the compilation after the module at hand. After the run.
  ~Tiers();
  Tiers(const Tiers&) = delete;
  Tiers& operator=(const Tiers&) = delete;

  /// For RunOptions.
  [[nodiscard]] rt::NewCode& new_code() { return new_code_; }
  /// After the run: what became of it, a line.
  [[nodiscard]] std::string summary();

 private:
  void work(unsigned patience_ms);
  void end();
  std::vector<rt::Code> install();

  lower::LoweredSystem& lowered_;
  jit::JitOptions options_;
  rt::NewCode new_code_;
  jit::MadeCode made_;
  JitCode code_;
  std::string problem_;
  double seconds_ = 0;
  bool is_installed_ = false;
  std::mutex mutex_;
  std::condition_variable stop_;
  bool is_stopped_ = false;
  std::thread thread_;  // last: it starts when all else is there
};

/// What a compilation made, for --stats; `when` stands before its seconds.
[[nodiscard]] std::string text_of(const jit::MadeCode& made, std::string_view begin, std::string_view when,
                                  double seconds);

}  // namespace bip::pipeline
