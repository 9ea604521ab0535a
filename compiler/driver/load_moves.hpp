// Loads a recorded run into a debugging session: a trace (JSON lines, binary, the published engine's text), as `run`,
// `explore`, `verify` and `step` write them, or a record (`run --record`).
#pragma once
#include <optional>
#include <string>

#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "runtime/debug/session.hpp"

namespace bip::driver {

enum class RecordedRun : std::uint8_t { JsonTrace, BinaryTrace, PublishedTrace, EventRecord };

/// A file that was read, and what it says about how the run was made.
struct RunFileText {
  std::string path, text;
  RecordedRun kind = RecordedRun::JsonTrace;
  rt::Record record;  // EventRecord
};

/// Reads the file and its head; `options` get the seed, the policy and what else the run was made with. Nothing: a
/// diagnostic says why.
[[nodiscard]] std::optional<RunFileText> read_run(Compilation& c, const std::string& path, rt::SessionOptions& options);

/// Appends the moves to a session in its initial state, made with these options. False: a diagnostic says where the
/// model cannot follow.
[[nodiscard]] bool load_moves(Compilation& c, const RunFileText& run, rt::DebugSession& session);

}  // namespace bip::driver
