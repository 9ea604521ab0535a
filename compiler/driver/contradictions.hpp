// Can the rules be met? A service that they never let in is reported (B6110) with a set of rules that is enough for it
// and that no rule can be taken from.
//
// QuestionKind of a reduction (compiler/rules/reduce.hpp) of the modules, once for each service that rules are about,
// and for what is found once more for each rule. Time is left out: a limit may be reached or not. Out of time: nothing
// is said.
#pragma once
#include "compiler/driver/pipeline.hpp"
#include "compiler/rules/check.hpp"

namespace bip::driver {

void report_contradictions(Compilation& c, const rules::RuleFile& file, const std::vector<genom::Module>& modules,
                           const rules::Checked& checked, double seconds);

}  // namespace bip::driver
