// Ctrl-C cancels the question of the command line instead of ending the process: the facts known by then are reported.
#pragma once
#include <optional>

#include "compiler/verify/solver/cancellation.hpp"
#include "runtime/engine/interrupt.hpp"

namespace bip::driver {

/// Cancels its own source when SIGINT, SIGTERM or SIGHUP arrives, for as long as it lives; then restores the handler
/// that was there before. At most one lives at a time in a process: signals belong to the process, questions do not.
class InterruptCancellation {
 public:
  InterruptCancellation();
  ~InterruptCancellation();
  InterruptCancellation(const InterruptCancellation&) = delete;
  InterruptCancellation& operator=(const InterruptCancellation&) = delete;

  /// Returns a token that Ctrl-C cancels, without deadline. It must not outlive this object.
  [[nodiscard]] verify::CancellationToken token() const { return verify::CancellationToken(source_); }

 private:
  verify::CancellationSource source_;
  std::optional<rt::EndingSignals> signals_;
};

}  // namespace bip::driver
