// A few runs before a proof is tried, of models whose states cannot be searched because C++ has a state of its own: a
// deadlock or a run-time error that a run meets is one, whatever that C++ does.
#pragma once
#include <optional>
#include <string>

#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "runtime/include/bip/run.hpp"

namespace bip::driver {

/// The shortest of a few random runs that end so (Deadlock, Fault), as `bipc run` prints it; nothing if none does
/// within its steps, the model's C++ cannot be had, or it ends the process. The runs are made in a process of their
/// own, for at most `seconds` after its C++ is compiled; what they write and read is dropped. Requires an image; the
/// compilation is as before.
[[nodiscard]] std::optional<std::string> run_to_end(Compilation& c, Backend backend, rt::End end, unsigned seconds);

}  // namespace bip::driver
