// One small change of a certificate's text, of the kinds that a wrong prover could make: a clause lost, weakened or
// strengthened, a number off by one, two rows with each other's words.
#pragma once
#include <string>

#include "tools/gen/random.hpp"

namespace bip::verify::test {

/// The text with one to three changes; what is claimed and the forms of rows stay. May be the same text, by chance.
[[nodiscard]] std::string mutate(const std::string& certificate, gen::Prng& random);

}  // namespace bip::verify::test
