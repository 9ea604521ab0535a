// What a proof found, in terms that outlive the run: components by their place in the system, modes by their rows, bits
// by what they are of. Its text form is what is kept on disk. Nothing in it is trusted: all are candidates, and whoever
// takes one checks it first.
//
// A text speaks of components by path (below the compound that it is about) and by the hash of their modes, so it can
// be read for another system: what speaks of components that are not there, or are others, is left out.
#pragma once
#include <compare>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/verify/invariants/affine_invariants.hpp"
#include "compiler/verify/symbolic/transition_system.hpp"
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/invariants/traps.hpp"

namespace bip::verify {

/// Which engine had the answer.
enum class ProofMethod : std::uint8_t {
  None,
  Plain,      // invariants of the structure
  Told,       // invariants, values from outside told apart
  Induction,  // invariants and lemmas over the machine
  Steps       // a way to a bad state
};

struct CachedTerm {
  u32 atom = 0, mode = 0;  // mode: row of the atom's class
  std::int64_t weight = 1;
  friend auto operator<=>(const CachedTerm&, const CachedTerm&) = default;
};
struct CachedInvariant {
  InvariantKind kind = InvariantKind::Trap;
  bool is_told = false;  // modes are those of the net with uses told apart
  std::int64_t total = 1;
  std::vector<CachedTerm> terms;
  friend auto operator<=>(const CachedInvariant&, const CachedInvariant&) = default;
};
/// A bit of the machine.
struct CachedLiteral {
  u32 atom = 0;
  bool is_place = false, value = false;
  u32 row = 0, position = 0;
  friend auto operator<=>(const CachedLiteral&, const CachedLiteral&) = default;
};
using CachedLemma = std::vector<CachedLiteral>;
/// Weights of places and ints; what they add up to is the system's.
using CachedEquation = std::vector<AffineEquation::Term>;

struct CachedProof {
  ProofMethod way = ProofMethod::None;
  std::vector<CachedInvariant> invariants;  // in the order of finding
  std::vector<CachedEquation> equations;
  bool uses_bounds = false;  // that follow from the equations: they are shown anew
  std::vector<CachedLemma> lemmas;
  std::vector<std::uint64_t> choices;  // Steps
  friend bool operator==(const CachedProof&, const CachedProof&) = default;
};

[[nodiscard]] CachedInvariant kept(const Net& net, const TokenInvariant& invariant, bool is_told);
[[nodiscard]] CachedLemma kept(const TransitionSystem& machine, const std::vector<u32>& cube);
/// Those that speak of modes that the net has, in its numbers; `is_told` says which are meant.
[[nodiscard]] std::vector<TokenInvariant> invariants_of(const CachedProof& proof, const Net& net, bool is_told);
[[nodiscard]] std::vector<AffineEquation> equations_of(const CachedProof& proof);
/// As cubes of the machine, sorted; those that it has bits for.
[[nodiscard]] std::vector<std::vector<u32>> lemmas_of(const CachedProof& proof, const TransitionSystem& machine);

/// A component as texts name it.
struct AtomName {
  std::string path, content;
};
using NameOfAtom = std::function<AtomName(u32 atom)>;
/// Nothing: there is none, or its modes are others.
using AtomOfName = std::function<std::optional<u32>(const AtomName& name)>;

[[nodiscard]] std::string print_cached_proof(const CachedProof& proof, const NameOfAtom& name_of);
/// Nothing: it is no such text. Left out: rows that speak of unknown components.
[[nodiscard]] std::optional<CachedProof> parse_cached_proof(std::string_view text, const AtomOfName& atom_of);

}  // namespace bip::verify
