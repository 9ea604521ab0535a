// Proofs by counting as rows of a certificate: `lemma` rows say which local states each component can be in, and that
// each trap has a token; a `bound` row says that the weighted sum is never more than initially.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compiler/system/system.hpp"
#include "compiler/verify/counting/sub_invariant.hpp"

namespace bip::verify {

/// Returns the rows; nothing: a certificate cannot name a value (floats, C++), or weights are too large for the
/// checker. `unread_cells`: of no local state, ascending.
[[nodiscard]] std::optional<std::string> counting_rows(CountedNetBuilder& builder,
                                                       const std::vector<SubInvariant>& proofs, const System& system,
                                                       const std::vector<rt::VariableId>& unread_cells);

}  // namespace bip::verify
