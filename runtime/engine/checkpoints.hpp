// Checkpoints of a distributed run as files: when the next one is due, writing it, going on from one.
#pragma once
#include <array>
#include <csignal>
#include <string>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/distributed/checkpoint.hpp"

namespace bip::rt {

/// While it lives SIGUSR1 asks for a checkpoint.
class CheckpointSignal {
 public:
  CheckpointSignal();
  ~CheckpointSignal();
  CheckpointSignal(const CheckpointSignal&) = delete;
  CheckpointSignal& operator=(const CheckpointSignal&) = delete;

 private:
  struct sigaction before_ {};
};

class Checkpoints {
 public:
  /// `resumed`: the steps before this run.
  Checkpoints(const RunOptions& options, u64 resumed)
      : options_(options), resumed_(resumed), due_(options.checkpoint_every) {}
  [[nodiscard]] bool is_on() const { return !options_.checkpoint_path.empty(); }
  /// When the next one is due, in ns since the run began; without an interval never.
  [[nodiscard]] i64 due() const;
  /// Is one due or asked for? Then it is not due any more.
  [[nodiscard]] bool take_due(i64 now);
  /// Writes it in place of the one before. A problem is reported on standard error.
  void write(const Core& core, Checkpoint checkpoint);
  [[nodiscard]] u64 count() const { return count_; }
  /// Of the last one: steps, with those before this run.
  [[nodiscard]] u64 steps() const { return steps_; }

 private:
  const RunOptions& options_;
  u64 resumed_ = 0, steps_ = 0, count_ = 0;
  i64 due_ = 0;
};

/// Brings an initialized core to the state of the file. Returns what is wrong; empty: nothing.
[[nodiscard]] std::string resume(Core& core, const std::string& path, Checkpoint& checkpoint);

}  // namespace bip::rt
