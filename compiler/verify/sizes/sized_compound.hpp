// A compound type with a size n, for every n at once: which arrays have n elements, and which elements each connector
// joins. Read from the type model, never from an instance.
//
// Positions of an array have *zones*: the first `margin` ones and the last `margin` ones, each by itself, and all
// others. From n = 2 * margin + 1 on, elements of one zone have equal arguments.
#pragma once
#include <string>
#include <vector>

#include "compiler/model/model.hpp"
#include "compiler/verify/sizes/size_value.hpp"

namespace bip::verify {

enum class ElementPlace : std::uint8_t {
  Single,     // no element of a sized array: of an array of fixed size `offset` is the element
  FromStart,  // element `offset`
  FromEnd,    // element n - 1 - offset
  AtLoop,     // element (i + offset) mod n of the connector's loop
  Every       // all elements
};
struct SizedPort {
  std::uint32_t family = 0, port = 0;  // rows of the compound type's components, of the atom type's ports
  ElementPlace place = ElementPlace::Single;
  std::int64_t offset = 0;
};
struct SizedConnector {
  std::uint32_t family = 0;  // row of the compound type's connectors
  ConnectorTypeId type;
  std::vector<SizedPort> ports;  // as written
  bool is_loop = false;          // one for each i, low <= i < n - high
  std::int64_t low = 0, high = 0;
};
enum class ArrayKind : std::uint8_t { None, Fixed, Sized };
struct SizedFamily {
  std::string name;
  AtomTypeId type;
  ArrayKind kind = ArrayKind::None;
  std::int64_t count = 1;  // Fixed
};
/// "ROOT.station[2]"
[[nodiscard]] std::string element_path(const SizedFamily& family, std::int64_t element);
struct SizedCompound {
  std::int64_t margin = 1;
  std::vector<SizedFamily> families;
  std::vector<SizedConnector> connectors;

  /// From here on the zones are complete.
  [[nodiscard]] std::int64_t least_size() const { return 2 * margin + 1; }
};

/// Returns the description with the least margin that suffices, or why there is none. Requires a type with one
/// parameter, an int.
[[nodiscard]] Result<SizedCompound> describe_sizes(const Model& model, const CompoundType& type);

}  // namespace bip::verify
