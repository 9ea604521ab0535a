// Following a binary trace: is it a run of the model? The core takes the recorded steps one by one; each must be a
// candidate where it is taken, and the end must be the recorded one, down to the digest of the last state. What engine
// made the trace, sequential, threaded or batch, makes no difference: this is what all of them promise.
#pragma once
#include <string>
#include <string_view>

#include "bip/run.hpp"
#include "runtime/trace/recorded.hpp"

namespace bip::rt {

struct Followed {
  bool is_trace = true;    // false: the bytes are none, or of another root
  std::string problem;     // empty: the model can do all of it
  std::string candidates;  // what could be taken instead of the step that cannot
  std::uint64_t steps = 0;
  End end = End::Limit;
  RecordedBegin begin;
};

/// Returns why the bytes are no trace of the model, by their head; empty: they are one. Needs no code of the image.
[[nodiscard]] std::string recorded_problem(const Image& image, std::string_view bytes);

/// After the end was read: returns what stands behind it, which no writer puts there; empty: nothing.
[[nodiscard]] std::string junk_problem(const RecordedReader& reader);

/// Writes the run as `options` say (silent, format, resume_path where the run went on; trace_path unused); seed, policy
/// and progress are the trace's. C++ functions of the model are called again.
[[nodiscard]] Followed follow(const Image& image, std::string_view bytes, RunOptions options, std::FILE* out);

}  // namespace bip::rt
