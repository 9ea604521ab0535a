// See open_eager.hpp.
#include "runtime/core/time/open_eager.hpp"

#include <vector>

#include "bip/image_time.hpp"

namespace bip::rt {

// The bound may be another participant's. A type without an atom changes nothing.
OpenEager find_open_eager(const Image& image) {
  std::vector<bool> is_used(image.atom_types.size);
  for (const Atom& atom : image.atoms) is_used[atom.type] = true;
  OpenEager found;
  bool is_async = false;
  for (u32 number = 0; number < image.atom_types.size; ++number) {
    const AtomType& type = image.atom_types[number];
    for (u32 row = 0; is_used[number] && type.time != nullptr && row < type.transitions.size; ++row) {
      const TransitionTime& transition = type.time->transitions[row];
      if (found.eager == nullptr && transition.urgency == Urgency::Eager) found.eager = &type.transitions[row];
      is_async |= transition.async.present;
      for (const Bound& bound : transition.when.bounds) {
        // `x < 5` of a clock begins to hold when the clock is set: no open bound, for clocks do not run backwards.
        const bool is_open = bound.op == BoundOp::Gt || (bound.op == BoundOp::Lt && bound.minus != kNone);
        if (is_open && found.open_bound == nullptr) found.open_bound = &type.transitions[row];
      }
    }
  }
  return found.eager != nullptr && found.open_bound != nullptr && !is_async ? found : OpenEager{};
}

bool may_open_eagerly(const Image& image) { return find_open_eager(image).eager != nullptr; }

}  // namespace bip::rt
