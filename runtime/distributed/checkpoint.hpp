// A checkpoint of a distributed run: a state of the whole model between two steps, when nothing is at work, as bytes. A
// run that goes on from it may place the components elsewhere.
//
// Linear in the model. Whatever bytes come, reading ends with a state of this model or a problem.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "runtime/core/state/state.hpp"

namespace bip::rt {

struct Checkpoint {
  u64 steps = 0;  // before it
  State state;
  std::vector<u32> history;  // by atom: NextMove::history
};

/// Returns the path of an atom's variable that C++ made, `atom.variable`: its models have no checkpoints. Empty: none.
[[nodiscard]] std::string object_without_checkpoint(const Image& image);

/// Of images without time and without such variables.
[[nodiscard]] std::string print_checkpoint(const Tables& tables, const Checkpoint& checkpoint);
/// Returns what is wrong with the bytes; empty: nothing. The checkpoint's state has the image's sizes before and after.
[[nodiscard]] std::string read_checkpoint(const Tables& tables, std::string_view bytes, Checkpoint& checkpoint);

}  // namespace bip::rt
