// Delays the end of the process by a signal while a file is half written, so that the file is removed first.
#pragma once

namespace bip {

/// While an object lives, SIGINT, SIGTERM and SIGHUP end the process only when the last such object is gone, if they
/// would end it at once: signals that are ignored or have a handler of somebody else are left alone. Any thread.
class DelayedSignals {
 public:
  DelayedSignals();
  ~DelayedSignals();
  DelayedSignals(const DelayedSignals&) = delete;
  DelayedSignals& operator=(const DelayedSignals&) = delete;
};

}  // namespace bip
