// Proves that a system with clocks has neither deadlock nor time lock, without a zone graph of the whole.
//
// A deadlock (time diverges and there never is a candidate) is a question about modes (time_divergence.hpp), answered
// as for a system without clocks. A time lock needs a component whose invariants stop time. For each such component the
// zone graph of a localization is explored (localization.hpp): the component, and as many neighbours as it takes to see
// that a step is possible whenever time stops. States that the invariants of the untimed system exclude are not entered
// (mode_facts.hpp). Refinement: where a time lock stays open, a neighbour joins that one of the offered ports waits
// for. If the neighbourhood becomes too large, each local state of the component gets a neighbourhood of its own.
//
// Sound but incomplete: failure implies nothing. After L. Astefanoaei, S. Ben Rayana, S. Bensalem, M. Bozga, J. Combaz:
// Compositional Invariant Generation for Timed Systems (2014). Departure: they relate clocks of components by history
// clocks; here components whose clocks must be related are explored together. Cost: that of the neighbourhoods' zone
// graphs, equal neighbourhoods once.
#pragma once
#include <functional>
#include <string>

#include "compiler/verify/property/property.hpp"
#include "compiler/verify/solver/cancellation.hpp"
#include "runtime/explore/zones.hpp"

namespace bip::verify {

/// Lowers a system to an image with code and explores its zones.
using ExplorePart = std::function<rt::PartReport(const System& part, const rt::ExploreOptions& options,
                                                 const rt::PartQuestion& question)>;

struct TimeProof {
  bool is_proved = false;
  std::string reason;                // else: what was missing
  std::uint64_t neighbourhoods = 0;  // components that can hold time up, each with its neighbours
  std::uint64_t largest = 0;         // of them, in components
  std::uint64_t alike = 0;           // components that two of the neighbourhood stand for; 0: it stands for itself
  std::uint64_t explored = 0;        // zone graphs made
  std::uint64_t zones = 0;           // of all of these
  std::uint64_t invariants = 0;      // without time
  std::string rows;                  // of a certificate, if one is wanted and there is nothing that it cannot say
};

struct PartLimits {
  std::size_t members = 6;      // of a neighbourhood
  std::uint64_t zones = 20000;  // of its graph
};

/// Returns why no local system can decide the property; empty: one may.
[[nodiscard]] std::string obstacle_to_local_proof(const System& system, const Property& property);
/// Of the exploration of a local system; refers to the token.
[[nodiscard]] rt::ExploreOptions local_options(std::uint64_t zones, const CancellationToken& cancellation);

/// Proves that there is neither deadlock nor time lock.
[[nodiscard]] TimeProof prove_time(const System& system, const ExplorePart& explore,
                                   const CancellationToken& cancellation, const PartLimits& limits = {});

/// Proves a property of places and data from the components that it speaks of and their neighbours. Properties with
/// `can` depend on the instant and are not proved.
[[nodiscard]] TimeProof prove_state_in_time(const System& system, const Property& property, const ExplorePart& explore,
                                            const CancellationToken& cancellation, const PartLimits& limits = {});

}  // namespace bip::verify
