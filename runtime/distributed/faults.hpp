// What goes wrong in a simulated network: the text of --faults, as data.
//
//   cut 1-2 3s..5s     nothing passes between the two nodes in that time
//   crash 3 5s         the node is gone from then on
//   slow 2 x10         the node, and all that it sends and receives, takes so many times as long
//   lose 5%            of the frames are lost
//   double 5%          of the frames arrive twice
// Parts are separated by commas. Time is that of the simulation, with the units of models.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "bip/result.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/core/time/interval.hpp"

namespace bip::rt {

struct NetworkFaults {
  struct Cut {
    u32 a = 0, b = 0;
    i64 from = 0, until = 0;  // ns
  };
  struct Crash {
    u32 node = 0;
    i64 at = 0;
  };
  std::vector<Cut> cuts;
  std::vector<Crash> crashes;
  std::vector<u32> slowness;  // by node; 1: as the others. Empty: all are 1
  u32 lost_percent = 0, doubled_percent = 0;
  [[nodiscard]] i64 slowness_of(u32 node) const { return slowness.empty() ? 1 : slowness[node]; }
};

/// Reads the text; `nodes` are their names. No text: no faults. The error says what is wrong with the text.
[[nodiscard]] Result<NetworkFaults> read_faults(std::string_view text, const std::vector<std::string>& nodes);

}  // namespace bip::rt
