// A few runs before a proof is tried, of models whose states cannot be searched because C++ has a state of its own: a
// deadlock or a run-time error that a run meets is one, whatever that C++ does.
#pragma once
#include <optional>
#include <string>

#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "runtime/include/bip/run.hpp"

namespace bip::driver {

struct FirstRuns {
  std::optional<std::string> found;  // the shortest run that ends as wanted, as `bipc run` prints it
  std::string crash;  // "signal SIGSEGV … in the model's C++, `f()` …   (seed 3)", if a run ends the process so
};
/// Does a run, as `bipc run` prints it, end in a time lock?
[[nodiscard]] bool is_time_lock(const std::string& run);
/// Makes a few random runs; those wanted end in a deadlock (with time, or a time lock) or a fault. Finds nothing if no
/// run does within its steps, or the model's C++ cannot be had. The runs are made in a process of their own, for at
/// most `seconds` after its C++ is compiled; what they write and read is dropped, but for the last of the standard
/// error if one crashes. Requires an image; the compilation is as before.
[[nodiscard]] FirstRuns make_first_runs(Compilation& c, Backend backend, rt::End wanted, unsigned seconds);

}  // namespace bip::driver
