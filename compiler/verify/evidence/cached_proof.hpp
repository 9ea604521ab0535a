// A proof in terms that outlive the run: components by their place in the system, modes by their rows, state bits by
// what they are of; and its text form, which the proof cache stores. Nothing in it is trusted: all rows are candidates,
// and each user checks them first.
//
// A text names components by path (below the compound that it is about) and by the hash of their modes, so it can be
// read for another system: rows about components that are absent or different are left out.
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
#include "compiler/verify/invariants/token_invariant.hpp"

namespace bip::verify {

/// How the verdict was reached. The order is that of the words in the text form.
enum class ProofMethod : std::uint8_t {
  None,
  Invariants,  // of the structure
  PortUses,    // invariants over modes that distinguish port uses
  Induction,   // invariants, and lemmas over the transition system
  Steps        // a counterexample
};
/// Which modes an invariant is about: of the net that distinguishes port uses (port_uses.hpp), or of the plain one.
enum class PortUseModes : std::uint8_t { Merged, Distinguished };

struct CachedTerm {
  u32 atom = 0, mode = 0;  // mode: row of the atom's class
  std::int64_t weight = 1;
  friend auto operator<=>(const CachedTerm&, const CachedTerm&) = default;
};
struct CachedInvariant {
  InvariantKind kind = InvariantKind::Trap;
  PortUseModes modes = PortUseModes::Merged;
  std::int64_t total = 1;
  std::vector<CachedTerm> terms;
  friend auto operator<=>(const CachedInvariant&, const CachedInvariant&) = default;
};
/// A bit of the transition system's state.
struct CachedLiteral {
  u32 atom = 0;
  bool is_place = false, value = false;
  u32 row = 0, position = 0;
  friend auto operator<=>(const CachedLiteral&, const CachedLiteral&) = default;
};
using CachedLemma = std::vector<CachedLiteral>;
/// Weights of places and ints; the total is that of the initial state.
using CachedEquation = std::vector<AffineEquation::Term>;

struct CachedProof {
  ProofMethod method = ProofMethod::None;
  std::vector<CachedInvariant> invariants;  // in the order of finding
  std::vector<CachedEquation> equations;
  bool uses_bounds = false;  // that follow from the equations: they are shown anew
  std::vector<CachedLemma> lemmas;
  std::vector<std::uint64_t> choices;  // Steps
  friend bool operator==(const CachedProof&, const CachedProof&) = default;
};

/// Converts an invariant of `net`; `modes` says which net that is.
[[nodiscard]] CachedInvariant cached_invariant(const Net& net, const TokenInvariant& invariant, PortUseModes modes);
/// Converts a cube (ic3.hpp) of the transition system.
[[nodiscard]] CachedLemma cached_lemma(const TransitionSystem& machine, const std::vector<u32>& cube);
/// Returns the invariants about such modes that `net` has, in its numbers. They are well formed, not checked.
[[nodiscard]] std::vector<TokenInvariant> invariants_of(const CachedProof& proof, const Net& net, PortUseModes modes);
/// Returns the equations without their totals.
[[nodiscard]] std::vector<AffineEquation> equations_of(const CachedProof& proof);
/// Returns the lemmas that the transition system has bits for, as sorted cubes.
[[nodiscard]] std::vector<std::vector<u32>> lemmas_of(const CachedProof& proof, const TransitionSystem& machine);

/// A component as a text names it.
struct AtomName {
  std::string path, content;
};
using NameOfAtom = std::function<AtomName(u32 atom)>;
/// Returns the row of the component; nothing if there is none, or its modes are others.
using AtomOfName = std::function<std::optional<u32>(const AtomName& name)>;

/// Returns the text form. Cost: linear in its length.
[[nodiscard]] std::string print_cached_proof(const CachedProof& proof, const NameOfAtom& name_of);
/// Reads the text form. Returns nothing if it is none; leaves out rows about unknown components. The text may be
/// damaged or forged: numbers are bounded so that no sum of them overflows.
[[nodiscard]] std::optional<CachedProof> parse_cached_proof(std::string_view text, const AtomOfName& atom_of);

}  // namespace bip::verify
