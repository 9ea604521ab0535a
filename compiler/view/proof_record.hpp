// A certificate (compiler/docs/certificate.md) as the page reads it: its claim, its method, and each invariant with the
// components, places and values that it speaks of.
//
// {"claim": text, "method": text, "left_out": rows that are not in it,
//  "rows": [[kind, total, [[weight, [[atom, [place] or null, [[variable, value]], is negated]]]]]]}
// With time also "locations": states with zones (zone_record.hpp).
// kind: trap, one-token, sum, equation, lemma, domain (the component is always in one of these modes).
// A term is a case: literals that all hold; an equation may also have a variable as a term, with value null.
#pragma once
#include <string_view>

#include <nlohmann/json.hpp>

#include "compiler/base/result.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::view {

/// Reads the certificate, or says why it is none of this system. Linear in the text; at most kMostInvariants rows.
[[nodiscard]] Result<nlohmann::ordered_json> record_proof(const System& system, std::string_view certificate);

inline constexpr std::size_t kMostInvariants = 20000;

}  // namespace bip::view
