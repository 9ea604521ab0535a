// Shared by `bipc rules` and `bipc ros2`: a .rules file with the modules that it names.
#pragma once
#include <optional>
#include <vector>

#include "compiler/driver/options.hpp"
#include "compiler/genom/translate.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/rules/check_rules.hpp"

namespace bip::driver {

struct RuleLevel {
  rules::RuleFile file;
  genom::TranslateOptions options;
  std::vector<genom::Module> modules;
  rules::Checked checked;
};

/// Parsed and checked; nothing if there are errors. `types`: are those of GenoM 3 components read?
[[nodiscard]] std::optional<RuleLevel> load_rules(Compilation& c, const GenomArguments& arguments,
                                                  genom::Types types = genom::Types::Skipped);

}  // namespace bip::driver
