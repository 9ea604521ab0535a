// A proof whose modes tell values from outside apart (port_uses.hpp), in words that certificates have: modes without these values, the
// invariants that hold of such modes, and of the others clauses over places and values.
//
// Of a sum of weights that are all the same, "at least T of these k" is k choose T - 1 clauses; the side of the equation with fewer of
// them is tried first, and both only if that one does not exclude all candidates. Past kMaxClauses there is no evidence.
// Needs a proof that is Free; nothing is claimed that the structure or the solver has not confirmed.
#pragma once
#include <optional>
#include <string>

#include "compiler/verify/prove.hpp"

namespace bip::verify {

struct Evidence {
  static constexpr std::size_t kMaxClauses = 200'000;
  Net net;                         // uses of ports are one again
  Proof proof;                     // its reachable modes and invariants
  std::vector<std::string> rows;   // ranges and lemmas
};

/// `plain`: the net without, `told`: with uses told apart. Nothing: a certificate has no form for it.
[[nodiscard]] std::optional<Evidence> find_evidence(const Net& plain, const Net& told, const Proof& proof, Clock::time_point end);

}  // namespace bip::verify
