// Decides whether a reduction may be used; models that it cannot treat soundly are refused with the reason.
#include "runtime/explore/explore.hpp"
#include "runtime/explore/shapes.hpp"
#include "runtime/explore/symmetry.hpp"

namespace bip::rt {

std::string reduction_problem(const Image& image, const ExploreOptions& options) {
  if (options.reduction == StateReduction::None) return {};
  if (has_time(image)) return "the model has time, on whose passing all components agree";
  if (image.ffi != nullptr) return "the model calls C++, and what a function remembers belongs to no component";
  if (image.priorities.size != 0)
    return "the model has priorities between interactions, which compare components that share no interaction";
  const Core core(image, {.progress = options.progress});
  if (options.reduction == StateReduction::Por) {
    // A step would then depend on guards of connectors that it shares no atom with.
    const bool may_fault = !shapes_of(core, options.progress).watched.items.empty();
    return may_fault ? "a guard of a connector may end in a run-time error, which depends on the order of steps" : "";
  }
  const Locals locals(core, options.unread_cells);
  if (Symmetry(image, locals, options.symmetry).is_trivial())
    return "no two members of an array are interchangeable: same arguments, and connectors that stay the same when the "
           "two change places";
  return {};
}

std::vector<std::vector<std::vector<u32>>> interchangeable_members(const Image& image, const SymmetryLimits& limits) {
  if (image.ffi != nullptr) return {};
  const Core core(image);
  return Symmetry(image, Locals(core), limits).members();
}

}  // namespace bip::rt
