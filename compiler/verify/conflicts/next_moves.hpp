// What may move an atom next, as far as modes and invariants tell: what a distributed run needs to know about conflicts
// (runtime/distributed/distribution.hpp).
//
// A fork that philosopher 3 took is put back by philosopher 3. Places do not tell that, but the fork's history does
// (split_by_history.hpp), if invariants exclude that any other neighbour eats then. The proof assumes what it proves:
// moves are left out of the system, and each of them is then shown to be impossible in every state that satisfies the
// invariants of what is left. By induction on the length of runs none of them ever happens. Moves of which that cannot
// be shown are put back, and the proof begins anew; so the result is sound after the last round, and only then. Left
// out at first are the moves by connectors with fewer of the atoms that brought the atom where it is than others have.
// "Knowledge" of this kind for conflicts: S. Bensalem, M. Bozga, J. Quilbeuf, J. Sifakis, Optimized distributed
// implementation of multiparty interactions with restriction, Science of Computer Programming 98 (2015).
//
// Cost: a few rounds of at most one call of the solver for each move left out, and for each invariant; linear passes
// over the net for each invariant.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/system/system_ids.hpp"
#include "compiler/verify/conflicts/history_move.hpp"
#include "compiler/verify/solver/cancellation.hpp"
#include "runtime/distributed/distribution.hpp"

namespace bip::verify {

using rt::NextMove;
/// Whether the question was gone into; if it was not, places tell all that is known.
enum class ConflictQuestion : std::uint8_t { Answered, TooLarge, OutOfTime };
struct NextMoves {
  std::vector<NextMove> moves;        // sorted; all of the atoms of which more is known than places tell
  std::vector<HistoryMove> excluded;  // by invariants, sorted
  std::size_t invariants = 0;         // that they need, at most
  ConflictQuestion question = ConflictQuestion::Answered;
};

inline constexpr std::size_t kMostAtomsOfNextMoves = 20'000;

/// Returns no moves of larger systems, of those whose atoms have too many modes (TooLarge), and after the time.
[[nodiscard]] NextMoves find_next_moves(const System& system, const CancellationToken& cancellation);

}  // namespace bip::verify
