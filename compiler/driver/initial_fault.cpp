// See initial_fault.hpp. Small and seen once: the interpreter, whatever back end the model has.
#include "compiler/driver/initial_fault.hpp"

#include <algorithm>
#include <memory>

#include "bip/assert.hpp"
#include "compiler/interp/interp.hpp"
#include "compiler/lower/lower.hpp"
#include "runtime/core/core.hpp"

namespace bip::driver {

namespace {

// Without code only internal transitions can end an initialization.
bool may_fault(const System& system) {
  return system.code.exprs.size() != 0 ||
         std::any_of(system.atom_types.begin(), system.atom_types.end(), [](const AtomType& type) {
           return std::any_of(type.transitions.begin(), type.transitions.end(),
                              [](const Transition& t) { return t.port == Transition::kInternal; });
         });
}

}  // namespace

std::string initial_fault(const System& system) {
  BIP_ASSERT(system.code.functions.empty(), "{} functions of C++", system.code.functions.size());
  if (!may_fault(system)) return {};
  const std::unique_ptr<lower::LoweredSystem> lowered = lower::lower(system, "initial");
  const interp::Interpreter interpreter(*lowered);
  rt::Core core(lowered->image);
  return core.initialize() ? std::string() : std::string(core.fault().what);
}

}  // namespace bip::driver
