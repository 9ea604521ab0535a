// The system as a sequential AIG: bits for what stable states are made of, inputs for the choice of a step, and the
// next value of each bit. Exact for places, bool, int and string; what floats and C++ do is any value (`imprecisions`).
//
// An atom has one bit a place (exactly one of them if it is an automaton) and, a variable, as many as its range needs.
// A step is an interaction of a connector or an internal port; connectors without guards have one step, the
// largest interaction, as a function of the state; of the others all interactions are enumerated, up to a limit.
// Maximal progress, priorities and internal transitions are part of it, and so are the faults that end a run.
#pragma once
#include <string>
#include <utility>

#include "compiler/verify/solver/cancellation.hpp"
#include "compiler/verify/symbolic/aig.hpp"
#include "compiler/verify/invariants/intervals.hpp"
#include "compiler/verify/symbolic/symbolic_code.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::verify {

struct StateBit {
  Signal now = kFalse, next = kFalse;
  std::int8_t initial = -1;  // 0, 1; -1: not known
  bool is_place = false;
  bool is_alone = false;  // a place of an automaton: exactly one of these is 1
  std::uint32_t atom = 0;
  std::uint32_t row = 0;       // place or variable of the type
  std::uint32_t position = 0;  // which bit of the variable
};
struct SystemStep {
  rt::InteractionId interaction;                        // of the core's candidate order
  Signal chosen = kFalse;                               // an input
  Signal possible = kFalse;                             // it is a candidate, and no priority hides it
  Signal fine = kFalse;                                 // possible, and it ends in no fault
  std::vector<std::pair<std::uint32_t, Signal>> parts;  // port instances, and when they take part
};
/// As many internal transitions of an atom in a row are followed; a state after more is `lost`.
inline constexpr std::uint32_t kMaxInternals = 24;

struct TransitionSystem {
  Aig aig;
  std::vector<StateBit> bits;
  std::vector<SystemStep> steps;
  std::vector<std::vector<std::uint32_t>> exactly_one;  // rows of bits
  std::vector<Range> ranges;                            // by variable among all
  std::vector<Signal> in_range;  // invariants: a variable is in its range; no internal transition can be taken
  Signal next_in_range = kTrue;  // it holds after every step, if the ranges are right
  Signal state_fault = kFalse;   // the run has ended with a fault in this state
  Signal ended = kFalse;         // no candidate, in a state without fault
  Signal stuck = kFalse;         // the same, and not each atom is final
  Signal error = kFalse;         // a fault in the state or in the chosen step
  Signal lost = kFalse;          // more internal transitions in a row than are followed
  std::vector<Word> words;       // by variable among the atoms': its value now; empty: not followed
  std::vector<std::vector<Signal>> marks;  // by atom, by place
  std::vector<std::uint8_t> is_automaton;  // by atom: always exactly one place is marked
  std::vector<Signal> port_is_on;          // by port instance
  std::vector<Signal> connector_can;  // by connector: it has a candidate that nothing hides (none if it exports a port)
  bool starts_with_fault = false;
  std::string unsupported;  // not empty: why there is no transition system
  bool is_stopped = false;  // the time was over before it was complete: of no use
  std::set<Imprecision> imprecisions;
};

/// `system` and `image` are of one compilation. Code of the image is not called. A circuit that takes more than
/// `megabytes` is unsupported, and one that is not complete when the time is over is stopped.
[[nodiscard]] TransitionSystem build_transition_system(const System& system, const rt::Image& image,
                                                       std::size_t megabytes = 2048,
                                                       const CancellationToken& cancellation = {});

}  // namespace bip::verify
