// See initial_fault.hpp. Small and seen once: the interpreter, whatever back end the model has.
#include "compiler/library/initial_fault.hpp"

#include <memory>

#include "bip/assert.hpp"
#include "compiler/pipeline/error_sources.hpp"
#include "compiler/interp/interp.hpp"
#include "compiler/lower/lower.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/portfolio/search_bad_state.hpp"

namespace bip::library {

std::string initial_fault(const System& system) {
  BIP_ASSERT(system.code.functions.empty(), "{} functions of C++", system.code.functions.size());
  if (!system::is_timed(system) && !pipeline::can_end_in_error(system)) return {};
  const std::unique_ptr<lower::LoweredSystem> lowered = lower::lower(system, "initial");
  const interp::Interpreter interpreter(*lowered);
  return verify::fault_of(lowered->image, {});
}

}  // namespace bip::library
