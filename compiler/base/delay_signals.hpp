// Delays the end of the process by a signal while a file is half written, so that the file is removed first.
#pragma once

namespace bip {

/// While an object lives, SIGINT, SIGTERM and SIGHUP do not end the process at once, but when the last object is
/// destroyed. A signal that is ignored or that has another handler is not changed. Objects may live in any thread.
class DelayedSignals {
 public:
  DelayedSignals();
  ~DelayedSignals();
  DelayedSignals(const DelayedSignals&) = delete;
  DelayedSignals& operator=(const DelayedSignals&) = delete;
};

}  // namespace bip
