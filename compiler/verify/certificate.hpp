// The evidence of a proof as text (compiler/docs/certificate.md): modes by class, components, invariants; or, after an
// exhaustive search, how many states there are.
#pragma once
#include <string>

#include "compiler/verify/prove.hpp"

namespace bip::verify {

[[nodiscard]] std::string certificate(const Net& net, const Proof& proof, const std::string& root_name);
[[nodiscard]] std::string exhaustive_certificate(const System& system, const std::string& root_name, std::uint64_t states);

/// "exactly one of fork[0]@FREE, phil[0]@EATS"
[[nodiscard]] std::string invariant_text(const Net& net, const TokenInvariant& invariant);

}  // namespace bip::verify
