// See next_moves.hpp.
#include "compiler/verify/conflicts/next_moves.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "compiler/verify/conflicts/split_by_history.hpp"
#include "compiler/verify/invariants/place_invariants.hpp"
#include "compiler/verify/invariants/state_machine_components.hpp"
#include "compiler/verify/invariants/traps.hpp"
#include "compiler/verify/net/net_encoding.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr double kConflictComponentSeconds = 0.5;

using AtomRows = std::vector<u32>;  // sorted

std::vector<AtomRows> atoms_of_connectors(const System& system) {
  std::vector<AtomRows> atoms;
  for (const Connector& connector : system.connectors) {
    atoms.emplace_back();
    for (const PortRef& ref : connector.ports) {
      if (ref.kind == PortRef::Kind::Atom) atoms.back().push_back(ref.atom.value);
    }
    std::sort(atoms.back().begin(), atoms.back().end());
  }
  return atoms;
}

// Moves that are likely to be impossible: others have more of the atoms that brought this one where it is.
std::set<HistoryMove> unlikely_moves(const System& system, const SharedPorts& shared,
                                     const std::vector<SplitAtom>& split) {
  const std::vector<AtomRows> atoms = atoms_of_connectors(system);
  BIP_ASSERT(split.size() == system.atoms.size() && shared.connectors.size() == system.atoms.size(),
             "{} of {} atoms may be split", split.size(), system.atoms.size());
  std::set<HistoryMove> moves;
  for (u32 atom = 0; atom < split.size(); ++atom) {
    const AtomType& type = system.atom_types[system.atoms[AtomId(std::size_t{atom})].type];
    for (const SplitAtom::Place& at : split[atom].places) {
      if (at.history == HistoryMove::kNoHistory) continue;
      BIP_ASSERT(at.history < atoms.size(), "connector {} of {} brought atom {} there", at.history, atoms.size(), atom);
      std::vector<std::pair<std::size_t, u32>> uses;  // how many atoms they have in common, and the connector
      std::size_t most = 0;
      for (const Transition& t : type.transitions) {
        if (t.port == Transition::kInternal || t.from[0] != at.place) continue;
        for (const u32 connector : shared.connectors[atom][t.port]) {
          AtomRows common;
          std::set_intersection(atoms[at.history].begin(), atoms[at.history].end(), atoms[connector].begin(),
                                atoms[connector].end(), std::back_inserter(common));
          most = std::max(most, common.size());
          if (shared.is_shared(atom, t.port)) uses.emplace_back(common.size(), connector);
        }
      }
      for (const auto& [common, connector] : uses) {
        if (common < most) moves.insert({atom, at.place, at.history, connector});
      }
    }
  }
  return moves;
}

// One round: the net without the moves, and what invariants of it say.
class NextMoveProof {
 public:
  NextMoveProof(const System& original, const SplitSystem& split, const Net& net, const CancellationToken& cancellation)
      : original_(original),
        split_(split),
        net_(net),
        cancellation_(cancellation),
        reachable_(spread(net)),
        encoding_(net, reachable_, Encoded::Nothing),
        traps_(net, reachable_),
        sums_(net, reachable_, cancellation),
        one_tokens_(net, reachable_) {}

  // Can no state that satisfies the invariants have the atom there, and what else the connector needs at its places?
  bool excludes(const HistoryMove& move) {
    BIP_ASSERT(assumed_.empty() && move.connector < original_.connectors.size(),
               "{} assumptions are left, and connector {} is asked about", assumed_.size(), move.connector);
    if (!add_condition(move.atom, [&](u32 place) {
          const SplitAtom::Place& at = split_.atoms[move.atom].places[place];
          return at.place == move.place && at.history == move.history;
        }))
      return true;
    const std::size_t first = assumed_.size() - 1;
    for (const PortRef& ref : original_.connectors[ConnectorId(std::size_t{move.connector})].ports) {
      if (ref.atom.value != move.atom && !add_port(ref.atom.value, ref.port)) {
        assumed_.resize(first);
        return true;
      }
    }
    const std::vector<Lit> assumed(assumed_.begin() + static_cast<std::ptrdiff_t>(first), assumed_.end());
    assumed_.resize(first);
    while (true) {
      for (const Lit literal : assumed) encoding_.assume(literal);
      const Answer answer = encoding_.solve(cancellation_);
      if (answer != Answer::Satisfiable) return answer == Answer::Unsatisfiable;
      const std::vector<std::uint8_t> marked = encoding_.marked();
      std::size_t added = add_all(traps_.find(marked));
      if (added == 0) added = add_all(sums_.find(marked));
      if (added == 0 && !sums_.satisfies_all())
        added = add_all(one_tokens_.find(marked, kComponentBatch, cancellation_.within(kConflictComponentSeconds)));
      if (added == 0) return false;
    }
  }

  [[nodiscard]] std::size_t invariants() const { return invariants_; }
  [[nodiscard]] const ModeReachability& reachable() const { return reachable_; }

 private:
  static ModeReachability spread(const Net& net) {
    ModeReachability reachable(net, Direction::Forward, nullptr);
    for (u32 atom = 0; atom + 1 < net.mode_base.size(); ++atom) {
      for (const u32 mode : net.class_at(atom).initial) reachable.turn_on(net.mode_base[atom] + mode);
    }
    reachable.run();
    return reachable;
  }

  std::size_t add_all(const std::vector<TokenInvariant>& found) {
    std::size_t added = 0;
    for (const TokenInvariant& invariant : found) added += encoding_.add(invariant) ? 1 : 0;
    invariants_ += added;
    return added;
  }

  // The atom is at such a place (of the split system). False: it never is.
  template <class IsPlace>
  bool add_condition(u32 atom, IsPlace is_place) {
    BIP_ASSERT(atom + 1 < net_.mode_base.size(), "atom {} of {}", atom, net_.mode_base.size() - 1);
    const Lit condition = encoding_.new_switch();
    std::vector<Lit> clause{-condition};
    for (u32 mode = net_.mode_base[atom]; mode < net_.mode_base[atom + 1]; ++mode) {
      const std::vector<u32>& places = net_.class_at(atom).modes[mode - net_.mode_base[atom]].places;
      if (reachable_.is_on(mode) && std::any_of(places.begin(), places.end(), is_place))
        clause.push_back(encoding_.literal(mode));
    }
    if (clause.size() == 1) return false;
    encoding_.add_clause(clause);
    assumed_.push_back(condition);
    return true;
  }

  // As places alone tell: moves that were left out may be among those.
  bool add_port(u32 atom, u32 port) {
    const auto [known, is_new] = of_port_.try_emplace({atom, port}, 0);
    if (is_new) {
      const AtomType& type = original_.atom_types[original_.atoms[AtomId(std::size_t{atom})].type];
      const std::vector<SplitAtom::Place>& places = split_.atoms[atom].places;
      const bool is_ever = add_condition(atom, [&](u32 place) {
        const u32 at = places.empty() ? place : places[place].place;
        return std::any_of(type.transitions.begin(), type.transitions.end(), [&](const Transition& t) {
          return t.port == port && std::find(t.from.begin(), t.from.end(), at) != t.from.end();
        });
      });
      if (is_ever) {
        known->second = assumed_.back();
        assumed_.pop_back();
      }
    }
    if (known->second == 0) return false;
    assumed_.push_back(known->second);
    return true;
  }

  const System& original_;
  const SplitSystem& split_;
  const Net& net_;
  const CancellationToken& cancellation_;
  ModeReachability reachable_;
  Encoding encoding_;
  TrapFinder traps_;
  PlaceInvariantFinder sums_;
  StateMachineComponentFinder one_tokens_;
  std::map<std::pair<u32, u32>, Lit> of_port_;  // 0: never
  std::vector<Lit> assumed_;                    // scratch
  std::size_t invariants_ = 0;
};

bool waits_for_events(const AtomType& type) {
  return std::any_of(type.ports.begin(), type.ports.end(), [](const Port& port) { return port.external; });
}

// What the modes of the atom offer; nothing if places tell as much.
std::vector<NextMove> moves_of_atom(const System& original, const SplitSystem& split, const Net& net,
                                    const ModeReachability& reachable, u32 atom) {
  const AtomType& type = original.atom_types[original.atoms[AtomId(std::size_t{atom})].type];
  if (!type.is_automaton() || waits_for_events(type)) return {};
  const SplitAtom& as = split.atoms[atom];
  std::vector<NextMove> moves;
  std::map<std::pair<u32, u32>, std::set<u32>> ports_of_mode;  // by place and mode
  const u32 base = net.mode_base[atom], first_leaf = net.graph.port_base[atom];
  for (u32 leaf = first_leaf; leaf < net.graph.port_base[atom + 1]; ++leaf) {
    if (!reachable.in_context(leaf)) continue;
    for (const Move& move : net.moves(leaf)) {
      if (!reachable.is_on(base + move.from)) continue;
      const u32 place = net.class_at(atom).modes[move.from].places[0];
      const u32 port = leaf - first_leaf;
      BIP_ASSERT(as.places.empty() || (place < as.places.size() && port < as.ports.size()),
                 "place {} of {} and port {} of {} of a split atom", place, as.places.size(), port, as.ports.size());
      if (as.places.empty()) {
        moves.push_back({atom, place, rt::kNone, move.from, port, rt::kNone});
      } else {
        const SplitAtom::Place& at = as.places[place];
        moves.push_back({atom, at.place, at.history, move.from, as.ports[port].port, as.ports[port].connector});
      }
      ports_of_mode[{moves.back().place, move.from}].insert(moves.back().port);
    }
  }
  std::sort(moves.begin(), moves.end());
  moves.erase(std::unique(moves.begin(), moves.end()), moves.end());
  if (!as.places.empty()) return moves;
  std::vector<std::set<u32>> by_place(type.places.size());
  for (const Transition& t : type.transitions) {
    if (t.port != Transition::kInternal) by_place[t.from[0]].insert(t.port);
  }
  // A place whose ports are one says all.
  const bool tells_more = std::any_of(ports_of_mode.begin(), ports_of_mode.end(), [&](const auto& row) {
    return row.second.size() != by_place[row.first.first].size();
  });
  return tells_more ? moves : std::vector<NextMove>();
}

}  // namespace

NextMoves find_next_moves(const System& system, const CancellationToken& cancellation) {
  NextMoves result;
  result.question = ConflictQuestion::TooLarge;
  if (system.atoms.size() > kMostAtomsOfNextMoves) return result;
  const SharedPorts shared(system);
  std::set<HistoryMove> excluded;
  bool is_first = true;
  while (!cancellation.is_over()) {
    SplitSystem split = split_by_history(system, shared, excluded);
    if (is_first) {
      is_first = false;
      excluded = unlikely_moves(system, shared, split.atoms);
      if (!excluded.empty()) split = split_by_history(system, shared, excluded);
    }
    const Net net = build_net(split.system);
    if (net.too_large_atom != kNoRow) return result;
    NextMoveProof proof(system, split, net, cancellation);
    const std::size_t before = excluded.size();
    std::erase_if(excluded, [&](const HistoryMove& move) { return !proof.excludes(move); });
    if (excluded.size() != before) continue;
    result.question = ConflictQuestion::Answered;
    result.excluded.assign(excluded.begin(), excluded.end());
    result.invariants = proof.invariants();
    for (u32 atom = 0; atom < system.atoms.size(); ++atom) {
      std::vector<NextMove> moves = moves_of_atom(system, split, net, proof.reachable(), atom);
      result.moves.insert(result.moves.end(), moves.begin(), moves.end());
    }
    return result;
  }
  result.question = ConflictQuestion::OutOfTime;
  return result;
}

}  // namespace bip::verify
