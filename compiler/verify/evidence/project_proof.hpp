// Projects a proof over modes that distinguish port uses (port_uses.hpp) onto modes that a certificate can name: modes
// without the values that connectors give, the invariants that hold of such modes, and of the others lemmas and
// equations about places and values.
//
// Requires a proof that is Free. A projection exists only if values distinguish the modes of one place wherever these
// have different weights, and if it needs at most kMaxWords words. Nothing is claimed that structure has not confirmed.
// Cost: the modes, and a check by structure for each invariant.
#pragma once
#include <optional>
#include <string>

#include "compiler/verify/portfolio/prove_by_invariants.hpp"

namespace bip::verify {

struct ProjectedProof {
  static constexpr std::size_t kMaxWords = 1'000'000;
  Net net;                        // port uses are not distinguished
  Proof proof;                    // reachable modes and invariants of that net
  std::vector<std::string> rows;  // lemmas and equations, one row of the certificate each
};

/// Projects `proof`, which is about `distinguishing`, to the modes of `plain`, the net of the same system without port
/// uses. Returns nothing if a certificate has no form for it.
[[nodiscard]] std::optional<ProjectedProof> project_proof(const Net& plain, const Net& distinguishing,
                                                          const Proof& proof);

}  // namespace bip::verify
