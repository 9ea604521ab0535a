// A system of plain rendezvous, prepared for exploration by regions: ranges, kinds of values, and who is joined to
// whom.
#pragma once
#include <optional>
#include <vector>

#include "compiler/verify/invariants/interval_domain.hpp"
#include "compiler/verify/regions/value_classes.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::verify {

/// By class of values its constants, sorted, each once.
using RegionConstants = std::vector<std::vector<std::int64_t>>;

/// What connectors write to a component when it is explored by itself: what the other components may have them write,
/// or any values. The latter proves less, but what holds then holds whatever connectors do.
enum class Writing : std::uint8_t { Followed, Anything };

struct RegionNet {
  const System* system = nullptr;
  Writing writing = Writing::Followed;
  std::vector<Range> ranges;        // by variable of the image, in all reachable states
  std::vector<u32> first_cell;      // by atom
  std::vector<u32> first_own;       // by connector: of its own data
  std::vector<u32> first_own_step;  // by atom: number of the step of its port 0 alone, from the number of connectors on
  ValueClasses values;
  std::vector<RegionConstants> constants;           // by atom: what its code and its fixed data say
  std::vector<std::vector<u32>> connectors;         // by atom
  std::vector<std::vector<std::uint8_t>> assigned;  // by connector type: bound variables that it may write
  std::vector<std::vector<std::vector<u32>>>
      written;                           // by atom type and port: what some connector may write, ascending
  std::vector<std::vector<bool>> reads;  // by connector type: bound variables that its code reads

  [[nodiscard]] const AtomType& type_of(u32 atom) const {
    return system->atom_types[system->atoms[AtomId(std::size_t{atom})].type];
  }
  [[nodiscard]] const Connector& connector(u32 row) const { return system->connectors[ConnectorId(std::size_t{row})]; }
  [[nodiscard]] const ConnectorType& type_of(const Connector& row) const { return system->connector_types[row.type]; }
  [[nodiscard]] const Range& range(u32 atom, u32 variable) const { return ranges[first_cell[atom] + variable]; }
  [[nodiscard]] bool is_fixed(u32 atom, u32 variable) const {
    return range(atom, variable).low == range(atom, variable).high;
  }
};

/// Is each connector a rendezvous of at most 64 ports of different atoms, each with variables that differ? Linear.
[[nodiscard]] bool is_plain_rendezvous(const System& system);
/// Requires is_plain_rendezvous(), no C++ and no time. Cost: that of find_ranges(), and linear in the system.
[[nodiscard]] RegionNet build_region_net(const System& system, const rt::Image& image,
                                         Writing writing = Writing::Followed);
/// The constants of these atoms together.
[[nodiscard]] RegionConstants constants_of(const RegionNet& net, const std::vector<u32>& atoms);

}  // namespace bip::verify
