// Exit codes of every command, in one place.
#pragma once

namespace bip::pipeline {
inline constexpr int kOk = 0;
inline constexpr int kModelErrors = 1;  // errors in the model, or a run-time error
inline constexpr int kUsage = 2;        // the command line is wrong
inline constexpr int kViolated = 3;     // `verify`: a deadlock is reachable
inline constexpr int kUnknown = 4;      // `verify`: not decided within the limits
}  // namespace bip::pipeline
