// Decides whether rules over robot modules can be met. A service that they never admit is reported (B6110) with a
// minimal set of rules that excludes it.
//
// Each service that rules are about is one question about the reduction (compiler/rules/reduce.hpp) of the modules, and
// each service that is never admitted one more question per rule. Time is abstracted: a limit may be reached or not. If
// the time limit is reached, nothing is reported.
//
// Then each promise is a question about the same reduction: it holds, is reported as not kept (B6160) or as not decided
// (B6161).
#pragma once
#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/rules/check_rules.hpp"

namespace bip::driver {

void report_contradictions(Compilation& c, const rules::RuleFile& file, const std::vector<genom::Module>& modules,
                           const rules::Checked& checked, double seconds);

}  // namespace bip::driver
