// What a certificate that lists reached states says, read once more (neither by the prover's code nor by certcheck's),
// and whether it suffices: the first state is among those it tells, every step that the engine knows stays among them,
// and none is bad.
#pragma once
#include "tests/verify/clauses.hpp"

namespace bip::verify::test {

/// TooLarge: more than `limit` states, none at all, or atoms that are no automata.
[[nodiscard]] Worth listed_worth(const std::string& text, const System& system, const rt::Image& image,
                                 const SearchGoal& goal, std::size_t limit);

}  // namespace bip::verify::test
