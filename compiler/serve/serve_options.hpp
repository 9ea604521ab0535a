// The options of a served model: one table for `bipc serve` and for programs of `bipc build --serve`.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bip/run.hpp"

namespace bip::serve {

/// How a model is served.
struct ServeSettings {
  std::uint64_t seed = 0;
  rt::Policy policy = rt::Policy::Uniform;
  bool asap = false;
  bool paused = false;
  double speed = 1;
  int real_time_priority = 0;     // 0: as usual
  std::int64_t stall_after = -1;  // ns; -1: a second if there is a safe-stop function, 0: the watchdog is off
  std::int64_t late_after = -1;   // ns; -1: kLateByDefault, in the log alone; 0: late steps are not reported
  std::int64_t silent_after = 0;  // ns; 0: clients may be silent
  std::string safe_stop;          // empty: `safe_stop` if the model's C++ has it
  std::string trace_path;         // empty: none
  rt::TraceFormat trace_format = rt::TraceFormat::Json;
  std::string socket;  // empty: standard input, unless has_port
  bool has_port = false;
  std::uint16_t port = 0;
  std::int64_t close_after = 10'000'000'000, idle_after = 60'000'000'000;  // ns; see ServerOptions
};

struct ServeOption {
  std::string name;   // "--seed"
  std::string value;  // how the help writes its value, "N"; empty: a flag
  std::string help;   // empty: for tests, and not shown
  /// Takes the value (of a flag: an empty text). Returns an empty text, or what is wrong with it.
  std::string (*read)(const std::string& text, ServeSettings& settings);
};

/// All of them, in the order of the help.
[[nodiscard]] const std::vector<ServeOption>& serve_options();

}  // namespace bip::serve
