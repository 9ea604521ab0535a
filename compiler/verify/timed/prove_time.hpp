// Neither deadlock nor time lock in a system with clocks, by parts of it: no zone graph of the whole is made.
//
// A deadlock, time passing for ever without a candidate, is a question about modes alone (time_divergence.hpp),
// answered as without time. A time lock needs a component whose invariants hold time up. For each of them: the zones of
// the component and of so many of its neighbours as are needed to see that somebody among them can go on
// (localization.hpp); the others may do anything that does not lead where the invariants of the system without time
// exclude it (mode_facts.hpp). A neighbour is added where the zones leave a time lock open: one that a port waits for.
// If they become too many, each local state of the component that holds time up has neighbours of its own.
//
// Proved is proved; a reason says no more than that this was not enough. After the idea of L. Astefanoaei, S. Ben
// Rayana, S. Bensalem, M. Bozga, J. Combaz: Compositional Invariant Generation for Timed Systems (2014). Where they
// relate components' clocks by history clocks, here those that must be related are looked at together. Cost: that of
// the neighbourhoods, alike ones once.
#pragma once
#include <functional>
#include <string>

#include "compiler/verify/property/property.hpp"
#include "compiler/verify/solver/cancellation.hpp"
#include "runtime/explore/zones.hpp"

namespace bip::verify {

/// Makes a system an image with code and explores it.
using ExplorePart = std::function<rt::PartReport(const System& part, const rt::ExploreOptions& options,
                                                 const rt::PartQuestion& question)>;

struct TimeProof {
  bool is_proved = false;
  std::string reason;                // else: what was missing
  std::uint64_t neighbourhoods = 0;  // components that can hold time up, each with its neighbours
  std::uint64_t largest = 0;         // of them, in components
  std::uint64_t explored = 0;        // zone graphs made
  std::uint64_t zones = 0;           // of all of these
  std::uint64_t invariants = 0;      // without time
};

struct PartLimits {
  std::size_t members = 6;      // of a neighbourhood
  std::uint64_t zones = 20000;  // of its graph
};

/// Neither deadlock nor time lock.
[[nodiscard]] TimeProof prove_time(const System& system, const ExplorePart& explore,
                                   const CancellationToken& cancellation, const PartLimits& limits = {});

/// A property of places and data, from the components that it speaks of and neighbours. `can` is about instants: that
/// is left to the whole.
[[nodiscard]] TimeProof prove_state_in_time(const System& system, const Property& property, const ExplorePart& explore,
                                            const CancellationToken& cancellation, const PartLimits& limits = {});

}  // namespace bip::verify
