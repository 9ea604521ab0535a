// A proof whose modes tell values from outside apart (port_uses.hpp), in words that certificates have: modes without
// these values, the invariants that hold of such modes, and of the others lemmas and equations about places and values.
//
// Values must tell modes of one place apart where they do not weigh the same; else there is no evidence, nor is there
// past kMaxWords. Needs a proof that is Free; nothing is claimed that the structure or the solver has not confirmed.
#pragma once
#include <optional>
#include <string>

#include "compiler/verify/portfolio/prove_by_invariants.hpp"

namespace bip::verify {

struct Evidence {
  static constexpr std::size_t kMaxWords = 1'000'000;
  Net net;                        // uses of ports are one again
  Proof proof;                    // its reachable modes and invariants
  std::vector<std::string> rows;  // lemmas and equations
};

/// `plain`: the net without, `told`: with uses told apart. Nothing: a certificate has no form for it.
[[nodiscard]] std::optional<Evidence> find_evidence(const Net& plain, const Net& told, const Proof& proof);

}  // namespace bip::verify
