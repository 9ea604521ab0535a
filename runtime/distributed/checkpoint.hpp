// A checkpoint of a distributed run: a state of the whole model between two steps, when nothing is at work, as bytes;
// with time its instant and the clocks. A run that goes on from it may place the components elsewhere.
//
// Linear in the model. Whatever bytes come, reading ends with a state of this model or a problem.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "runtime/distributed/node.hpp"

namespace bip::rt {

struct Checkpoint {
  u64 steps = 0;  // before it
  State state;
  std::vector<u32> history;  // by atom: NextMove::history
  SavedTime time = {};       // of the state, as nodes say it; State::time is made of it when it is read
};

/// Returns the path of an atom's variable that C++ made, `atom.variable`: its models have no checkpoints. Empty: none.
[[nodiscard]] std::string object_without_checkpoint(const Image& image);

/// Of images without such variables. The state is one of the core's image. An action that runs beside the others
/// (`@async`) has not run yet, whatever time has passed since it began: it runs when its budget ends. So it is a part
/// of the state: which transition, and until when.
[[nodiscard]] std::string print_checkpoint(const Core& core, const Checkpoint& checkpoint);
/// Returns what is wrong with the bytes; empty: nothing. The checkpoint's state is one of the core before and after.
[[nodiscard]] std::string read_checkpoint(const Core& core, std::string_view bytes, Checkpoint& checkpoint);

}  // namespace bip::rt
