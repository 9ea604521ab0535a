// Several .rules files as one (`extends`), and groups of services replaced by their services.
#pragma once
#include "compiler/diag/diagnostics.hpp"
#include "compiler/rules/rules.hpp"

namespace bip::rules {

/// Puts what `base` says before what `file` says. The side file is that of `base` if `file` names none; the package
/// is that of `file`.
void extend(RuleFile& file, RuleFile base);

/// Replaces names of groups by their services, in all rules. Reports groups with the name of an earlier one.
void expand_groups(RuleFile& file, Diagnostics& diags);

}  // namespace bip::rules
