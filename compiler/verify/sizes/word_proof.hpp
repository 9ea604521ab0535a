// Deadlock-freedom for all sizes, by traps over words.
//
// A state of size n is a word: letter i has the modes of the elements i of all sized arrays. A trap of size n is such a
// word too, of sets of modes. An interaction of a loop touches a window of letters, so whether a word of sets is a
// trap, and whether no step is possible in a word of modes, are read letter by letter with a bounded memory: both are
// finite automata. The search here runs over all words of modes in which no step is possible for sure, together with
// the set of all traps that the word does not meet (a subset construction). If at the end of every such word, however
// long, some trap is left that is marked initially, no reachable state of any size is a deadlock. So all traps of all
// sizes take part, and none is guessed. Where traps do not suffice, sets whose count never grows, or never shrinks,
// take part in the same way.
//
// Source: J. Esparza, M. Raskin, C. Welzel, Regular Model Checking Upside-Down: An Invariant-Based Approach, 2022.
// Cost: exponential in the modes of one letter and in the connectors between neighbours; bounded by limits.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "compiler/verify/net/modes.hpp"
#include "compiler/verify/sizes/sized_compound.hpp"
#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

struct WordAtom {
  const ModeClass* modes = nullptr;
  std::vector<std::uint8_t> is_final;  // by mode
};
struct WordPort {
  std::uint32_t atom = 0;  // Single: row of WordProblem::singles; else of a zone
  std::uint32_t port = 0;  // row of ModeClass::moves
  ElementPlace place = ElementPlace::Single;
  std::int64_t offset = 0;   // FromStart, FromEnd, AtLoop
  bool is_optional = false;  // Every: any number of the elements takes part
};
/// An interaction, or one at each position i of a loop, low <= i < n - high.
struct WordEvent {
  std::vector<WordPort> ports;
  bool is_loop = false;
  std::int64_t low = 0, high = 0;
  bool is_sure = true;  // enabled whenever its ports are
};
/// The loops' offsets and bounds are within the margin, as describe_sizes promises.
struct WordProblem {
  std::int64_t margin = 1;
  std::vector<WordAtom> singles;
  std::vector<std::vector<WordAtom>> zones;  // by zone (2 * margin + 1 of them), by sized array
  std::vector<WordEvent> events;
};
/// What a set of modes promises of a reachable word: it has one of them (Trap); at most, or at least, as many as the
/// initial one.
enum class SetPromise : std::uint8_t { Trap, AtMost, AtLeast };
/// A row of an automaton that reads sets of modes: first of the components outside of the arrays, then letter by
/// letter. The middle zone comes any number of times, at least once. It ends in states without rows, after the last
/// zone.
struct WordSetRow {
  bool is_first = false;  // the set of the components outside of the arrays; `from` and `zone` say nothing
  SetPromise promise = SetPromise::Trap;
  std::uint32_t from = 0, to = 0;
  std::size_t zone = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> modes;  // by atom of the letter
};
enum class WordEvidence : std::uint8_t { None, Sets };
struct WordAnswer {
  enum class Outcome : std::uint8_t { Proved, Candidate, TooLarge } outcome = Outcome::TooLarge;
  std::size_t nodes = 0;               // of the subset construction
  std::vector<std::uint32_t> singles;  // Candidate: modes in which no step is possible and every trap holds
  std::vector<std::vector<std::uint32_t>> letters;  // by position, by sized array
  std::string reason;                               // TooLarge
  std::vector<WordSetRow> sets;  // Proved, and wanted: each word without a step breaks the promise of a word of these
};

/// Decides all sizes from 2 * margin + 1 on.
[[nodiscard]] WordAnswer prove_words(const WordProblem& problem, const CancellationToken& cancellation,
                                     WordEvidence evidence = WordEvidence::None);

}  // namespace bip::verify
