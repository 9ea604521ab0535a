// What rules say that cannot go well, and that shows without a proof: recoveries that rules refuse, recoveries that
// call each other, and bounds of freshness that the writer of a poster does not meet.
//
// A recovery is asked for when its rule is violated: then the rule's condition is false, and a service that must
// stop is active. Other rules about the recovery are judged with these facts; what is not decided by them counts as
// unknown.
#pragma once
#include "compiler/rules/check_rules.hpp"

namespace bip::rules {

/// Reports B6111 to B6114, and B6116. Cost: quadratic in the rules with recoveries.
void report_conflicts(const RuleFile& file, const std::vector<genom::Module>& modules, const Checked& checked,
                      std::int64_t tick_us, Diagnostics& diags);

}  // namespace bip::rules
