// Binary traces (`--trace-format=binary`): which interaction was fired in each step, a byte or two each, and a digest
// of the last state. Everything else follows from the model, so `bipc replay --recorded` shows such a run in any other
// format, and checks it.
//
// "BIPTRC1\n", then numbers as LEB128: flags (1: maximal progress, 2: policy * 2 ..., 8: engine * 8 ...), seed, length
// of the name and the root's name; a step is 1 + (interaction * 2 + (1 if a rank among the interaction's candidates
// follows)); the end is 0, how it ended, the number of steps, digest (8 bytes; 0: none).
#pragma once
#include <string>
#include <string_view>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"

namespace bip::rt {

struct RecordedBegin {
  std::string name;
  std::uint64_t seed = 0;
  Policy policy = Policy::Uniform;
  Engine engine = Engine::Sequential;
  bool maximal_progress = true;
};
struct RecordedEnd {
  End how = End::Limit;
  std::uint64_t steps = 0, digest = 0;
};

void append_recorded_begin(std::string& out, const RecordedBegin& begin);
void append_recorded_step(std::string& out, EnabledSet::Position at);
void append_recorded_end(std::string& out, const Core& core, End how, std::uint64_t steps);
/// Of markings and data; strings by their text, NaN without payload, objects of C++ types left out. Never 0.
[[nodiscard]] std::uint64_t digest_of(const Core& core);

class RecordedReader {
 public:
  /// The bytes must stay. False: not such a trace, or cut off in its first lines.
  [[nodiscard]] bool open(std::string_view bytes, RecordedBegin& begin);
  enum class Next : std::uint8_t { Step, End, Cut };
  Next next(EnabledSet::Position& at, RecordedEnd& end);

 private:
  bool number(std::uint64_t& value);
  std::string_view bytes_;
  std::size_t at_ = 0;
};

}  // namespace bip::rt
