// What nodes say to each other. `n` counts how often an atom took part: an offer is of one n, a step takes that one,
// and whatever is about an earlier one comes too late and changes nothing.
#pragma once
#include <string>
#include <variant>
#include <vector>

#include "runtime/core/fire/partial.hpp"
#include "runtime/core/time/interval.hpp"

namespace bip::rt {

/// Of frames and greetings: programs of other versions do not understand each other.
inline constexpr u64 kProtocol = 7;

/// The instant of models with time, and its number among the steps: smaller than those of the steps that are taken
/// there, larger than those before. Who hears of it passes to it.
struct Moment {
  i64 instant = 0;
  u64 step = 0;
};
/// From an atom's home to its coordinator: it is at rest, and can do this.
struct Offer {
  u32 atom = kNone;
  u64 n = 0;
  AtomOffer offer;
  std::vector<u64> cells;  // the bits of Distribution::cells
  Moment moment = {};
  u32 set = kNone;  // of an atom of ConflictSets::by_situation: that of the interactions that can take it now
};
/// A part of a step: what one atom does.
struct Part {
  u32 atom = kNone;
  u64 n = 0;
  u32 transition = kNone;  // row of Tables::transitions
  u32 order = 0;           // in the step
  std::vector<u64> cells;  // as the connector's `down` left them
};
/// From a coordinator to a home: the parts of a step that are at home there.
struct Begin {
  u64 step = 0;
  std::vector<Part> parts;
  InteractionId interaction{0u};
  Moment moment = {};
};
/// An attempt to begin an interaction of a split set, from the node that has locked all so far to the home of the next
/// atom. It carries the offers of what it holds.
struct Lock {
  InteractionId interaction{0u};
  u32 own = 0;  // of what it holds: so many were offered to the coordinator, which gets them back
  std::vector<Offer> held;
};
/// From the node at which an attempt ended: these atoms, at home there or given by that coordinator, are offered there
/// again.
struct Release {
  InteractionId interaction{0u};
  bool is_refused = false;  // the interaction was not possible
  bool is_watched = false;  // all that it needs was there: it may be possible when one of these atoms has changed
  std::vector<u32> atoms;
};
/// From a home to a coordinator: an atom for which the interaction was refused has changed.
struct Wake {
  InteractionId interaction{0u};
};
/// To all other nodes: this step ended in a run-time error; begin nothing more.
struct Stop {
  u64 step = 0;
};
/// Between a node and the launcher of a run whose nodes are processes; the numbers and texts are those of the kind.
struct Control {
  enum class Kind : std::uint8_t {
    // To a node.
    Credit,  // begin so many steps more
    Recall,  // give back what credit is not needed
    Count,   // round
    Lost,    // node
    Halt,    // begin nothing more
    Pause,   // begin nothing until GoOn
    Tell,    // say your state, and Told
    GoOn,
    Limit,    // say how far time may pass, and Limited
    Plan,     // an instant: plan your steps up to it, and say Planned
    Instant,  // the instant to which time passes, and its number among the steps
    Finish,   // say your last state, then wait. A second one: how the run ended, steps
    Written,  // all steps up to this one are written
    Beat,     // to a node: say where your clock is. To the launcher: clock, steps, credit that is not spent
    // To the launcher.
    Ready,
    Idle,     // sent, received, clock, steps, Credits that came
    Want,     // it could begin a step, and has no credit
    Counted,  // round, sent, received, 1 if idle, Credits that came
    Return,   // credit
    Begun,    // step, interaction, where the texts have the number of the step, the home of each part; texts. Of a run
              // whose steps are followed: step, interaction, the candidate's rank, 0, homes; empty texts
    Took,     // step; of each of the steps that it took as a whole one after the other, which share this number:
              // interaction, numbers as of Begun, lengths of its texts; the texts of all
    Fired,    // the same of a run whose steps are followed, or of which only the interactions are written: step, how
              // many; their interactions (fired_interactions.hpp)
    Landed,   // steps of which a part has ended
    Fault,    // step, order, code, atom, connector, port, and two places in files; texts
    Atom,     // a state: atom, place, marks, history, 1 if an attempt holds it; its variables, and with time its clocks
    Told,
    Limited,  // the last instant, the next change
    Planned,  // the earliest instant
    Finished  // what it counted
  };
  Kind kind = Kind::Credit;
  std::vector<u64> numbers;
  std::vector<std::string> texts;
};
inline constexpr Control::Kind kLastControl = Control::Kind::Finished;
using Message = std::variant<Offer, Begin, Stop, Control, Lock, Release, Wake>;

struct Outgoing {
  u32 to = 0;
  Message message;
};

/// Calls `take` with each row of variables that is carried (Offer::cells, Part::cells).
template <class Take>
void visit_cells(const Lock& lock, Take take) {
  for (const Offer& offer : lock.held) take(offer.cells);
}
template <class Take>
void visit_cells(const Message& message, Take take) {
  if (const auto* const offer = std::get_if<Offer>(&message)) take(offer->cells);
  if (const auto* const lock = std::get_if<Lock>(&message)) visit_cells(*lock, take);
  if (const auto* const begin = std::get_if<Begin>(&message)) {
    for (const Part& part : begin->parts) take(part.cells);
  }
}
template <class Take>
void visit_cells(const std::vector<Message>& messages, Take take) {
  for (const Message& message : messages) visit_cells(message, take);
}

}  // namespace bip::rt
