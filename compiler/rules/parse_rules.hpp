// Parses .rules text to rows. A rule with a syntax error is reported and skipped; the next one begins after its
// semicolon.
#pragma once
#include "compiler/diag/diagnostics.hpp"
#include "compiler/rules/rules.hpp"

namespace bip::rules {

[[nodiscard]] RuleFile parse_rules(const SourceMap& sources, FileId file, Diagnostics& diags);

}  // namespace bip::rules
