// The evidence of a proof as text (compiler/docs/certificate.md): modes by class, components, invariants, ranges,
// lemmas; or, after an exhaustive search, how many states there are.
#pragma once
#include <optional>
#include <string>

#include "compiler/verify/portfolio/portfolio.hpp"
#include "runtime/explore/zones.hpp"

namespace bip::verify {

/// Writes the certificate of a decision that Holds, made by `portfolio` about `system`. Deterministic: rows in the
/// order of the system and of finding. Cost: linear in the evidence.
[[nodiscard]] std::string certificate(const Portfolio& portfolio, const Question& question, const Decision& decision,
                                      const System& system, const std::string& root_name);

/// Returns the first rows of a certificate: its version, the root and the claim.
[[nodiscard]] std::string certificate_head(const Question& question, const System& system,
                                           const std::string& root_name);

/// Returns the rows of modes, reachable modes and invariants, if there is a proof, of equations and of ranges.
[[nodiscard]] std::string invariant_rows(const Net& net, const Proof* proof, const AffineInvariants& affine,
                                         const TransitionSystem& machine, const System& system);
/// Returns the rows of modes, reachable modes and invariants.
[[nodiscard]] std::string structure_rows(const Net& net, const Proof& proof);
/// Returns "ROOT.a@EATS", "!ROOT.a.n:3".
[[nodiscard]] std::string literal_text(const StateBit& bit, bool value, const System& system);

/// Returns the certificate of a property of runs that holds under that fairness (fairness.hpp): the rows of all
/// reachable states. Nothing: the property is too long.
[[nodiscard]] std::optional<std::string> certificate_of_runs(const Formula& formula, const Fairness& fairness,
                                                             const std::string& rows, const System& system,
                                                             const std::string& root_name);

/// Returns the certificate of a property of branching time that holds: the rows of all reachable states. Nothing: as
/// above.
[[nodiscard]] std::optional<std::string> certificate_of_branches(const BranchingFormula& formula,
                                                                 const std::string& rows, const System& system,
                                                                 const std::string& root_name);

/// Returns the certificate of a response that holds in the zone graph of `report`, of which `rows` are the rows, with
/// those of its observer. Nothing: as above.
[[nodiscard]] std::optional<std::string> certificate_of_response(const Formula& formula, const rt::ZoneReport& report,
                                                                 const std::string& rows, const System& system,
                                                                 const std::string& root_name);

/// Returns "exactly one of fork[0]@FREE, phil[0]@EATS"
[[nodiscard]] std::string invariant_text(const Net& net, const TokenInvariant& invariant);
/// Returns "a@P and b.x in 4..7"
[[nodiscard]] std::string cube_text(const TransitionSystem& machine, const System& system, const Cube& cube);

}  // namespace bip::verify
