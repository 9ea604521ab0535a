// The batch engine: epochs of compiled steps, a part of the system a thread (core/batch.hpp), in turn with compiled
// steps of the whole system. For large systems whose steps are short; with one seed and number of threads the run is
// always the same.
//
// A binary trace needs the interactions alone. For text a second core follows what was fired, epoch by epoch: slow, and
// a proof that the order is a sequential one.
#pragma once
#include <memory>

#include "bip/run.hpp"
#include "runtime/core/programs/batch_plan.hpp"
#include "runtime/core/core.hpp"
#include "runtime/core/programs/team.hpp"
#include "runtime/engine/output.hpp"
#include "runtime/engine/scheduler.hpp"

namespace bip::rt {

class BatchEngine {
 public:
  /// Of an initialized core whose scheduler was started. Linear in the image.
  BatchEngine(Core& core, Scheduler& scheduler, const RunOptions& options, Output& output);
  /// False: the system has steps without compiled code, another policy is wanted, or it does not come apart; nothing
  /// else may be used.
  [[nodiscard]] bool is_on() const { return plan_.parts > 1; }
  /// Takes up to `limit` steps, `number` being the next one's; returns how many.
  u64 advance(u64 number, u64 limit, bool& sound);

  [[nodiscard]] u32 parts() const { return plan_.parts; }
  [[nodiscard]] std::size_t shared() const { return plan_.shared.size(); }
  [[nodiscard]] u64 beside() const { return beside_; }

 private:
  void tell(const std::vector<InteractionId>& interactions);

  Core& core_;
  Scheduler& scheduler_;
  const RunOptions& options_;
  Output& output_;
  BatchPlan plan_;
  std::unique_ptr<Team> team_;
  std::unique_ptr<Core> follower_;
  u64 told_ = 0;
  u64 beside_ = 0;  // steps taken in epochs
};

}  // namespace bip::rt
