// Resolves the names of a .rules file to services, posters and parameters of modules, and translates each rule to
// constraints on the functional level.
#pragma once
#include "compiler/diag/diagnostics.hpp"
#include "compiler/rules/rules.hpp"

namespace bip::rules {

/// One rule may become several constraints; `rule` of each is its row in the file. Nothing if there are errors.
struct Checked {
  genom::Constraints constraints;
  std::vector<std::size_t> rule;
};
[[nodiscard]] std::optional<Checked> check_rules(const SourceMap& sources, const RuleFile& file,
                                                 const std::vector<genom::Module>& modules, Diagnostics& diags);

}  // namespace bip::rules
