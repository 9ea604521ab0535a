// The C++ classes behind event ports that a system needs: one per event port of an atom type with instances.
#pragma once
#include <vector>

#include "compiler/system/system_ids.hpp"

namespace bip::lower {

struct EventClassUse {
  AtomTypeId type;
  std::uint32_t port = 0;
};
/// By types and ports; the row is that of Image::event_classes. None if no `@cpp(include=…)` could declare a class:
/// such a model gets its events from files and programs.
[[nodiscard]] std::vector<EventClassUse> event_class_uses(const System& system);

}  // namespace bip::lower
