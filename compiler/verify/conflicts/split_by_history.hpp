// Atoms whose places tell which interaction brought them there: a history variable (Abadi, Lamport: The existence of
// refinement mappings, 1991) written into the places, so that the analyses of nets see it.
//
// The history of an atom is the last connector that moved it through a port which several connectors bind. A place p
// becomes a place for each history that p can have, and such a port becomes a port for each connector. Split are
// automata all of whose shared ports are bound by rendezvous of atoms at the top; other atoms stay as they are. The
// rows of atoms and connectors stay, too. Cost: places times connectors of each atom, within limits.
#pragma once
#include <compare>
#include <set>
#include <vector>

#include "compiler/system/system.hpp"
#include "compiler/verify/conflicts/history_move.hpp"

namespace bip::verify {

/// How an atom was split: what its new places and ports were.
struct SplitAtom {
  struct Place {
    std::uint32_t place = 0, history = HistoryMove::kNoHistory;
    friend auto operator<=>(const Place&, const Place&) = default;
  };
  struct Port {
    std::uint32_t port = 0, connector = HistoryMove::kNoHistory;  // kNoHistory: it is not shared
  };
  std::vector<Place> places;  // empty: the atom is not split
  std::vector<Port> ports;
};

struct SplitSystem {
  System system;
  std::vector<SplitAtom> atoms;
};

/// Which connectors may move an atom through each of its ports, and whether its history can be told.
struct SharedPorts {
  static constexpr std::size_t kMostPlaces = 256, kMostTransitions = 4096, kMostInAll = 400'000;  // of split atoms

  explicit SharedPorts(const System& system);
  [[nodiscard]] bool is_shared(std::uint32_t atom, std::uint32_t port) const {
    return connectors[atom][port].size() > 1;
  }

  std::vector<std::vector<std::vector<std::uint32_t>>> connectors;  // by atom and port
  std::vector<std::uint8_t> is_splittable;                          // by atom
};

/// Returns the system with histories in its places. Moves that are `excluded` are left out.
[[nodiscard]] SplitSystem split_by_history(const System& system, const SharedPorts& shared,
                                           const std::set<HistoryMove>& excluded);

}  // namespace bip::verify
