// Steps of several threads at once, in epochs: the atoms are cut into parts; in an epoch each thread takes compiled
// steps among its own part's atoms, and nothing else; then one thread alone takes the steps that concern two parts.
// Steps of different parts share no atom, no counter and no interaction, so all of part 0's, then all of part 1's, ...,
// then the shared ones is a run.
//
// Parts are grown breadth first along connectors, so that few are shared: of a ring two cuts. An interaction is
// *shared* if a step of it changes what an interaction that spans two parts depends on. Linear in the image.
#pragma once
#include <vector>

#include "runtime/core/link/priorities.hpp"
#include "bip/prng.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

inline constexpr std::uint8_t kMostParts = 64;

struct BatchPlan {
  u32 parts = 0;                                  // 0: too much is shared
  IndexVector<InteractionId, std::uint8_t> part;  // whose list it is in
  IndexVector<InteractionId, std::uint8_t> is_shared;
  std::vector<InteractionId> shared;
  std::vector<u32> size;       // by part: interactions
  u64 least_epoch = 1u << 16;  // steps: an epoch's two meetings of the threads cost as much as some hundred
  u64 perturb = 0;             // tests: the parts of an epoch begin late, by this seed
};
/// any_share: also if most of it is shared, for tests.
[[nodiscard]] BatchPlan plan_batch(const Tables& tables, const PriorityTables& rules, u32 parts,
                                   bool any_share = false);

/// Cuts the atoms, in breadth-first order along interactions, into `parts` pieces of equal size. Linear.
[[nodiscard]] std::vector<std::uint8_t> parts_of_atoms(const RowsByInteraction& atoms_of_interaction,
                                                       const InteractionsBy& interactions_of_atom, u32 atoms,
                                                       u32 parts);

/// One thread's share of an epoch.
struct BatchPart {
  Prng prng;
  std::vector<u32> members;  // interactions as plain numbers, for compiled steps change them
  std::vector<u32> scratch;
  std::vector<InteractionId> fired;  // if the run is recorded, in their order
  u32 count = 0;                     // of members
  u64 draws = 0, steps = 0;          // to make, and made
};

}  // namespace bip::rt
