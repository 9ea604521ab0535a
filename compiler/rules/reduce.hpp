// Reduces modules to what rules depend on: the services that rules name, which run and end at any time, and posters
// that are written or not. The reduction simulates the modules as far as rules observe them, in less time: its periods
// and limits are one or two ticks.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/constraints.hpp"
#include "compiler/genom/generate_package.hpp"
#include "compiler/genom/module.hpp"

namespace bip::rules {

struct Reduced {
  std::vector<genom::Module> modules;    // "m0", … with services "s0", … and posters "p0", …
  genom::Constraints constraints;        // the same rows, about those
  std::vector<genom::ServiceRef> names;  // by row: the subject
};
/// How the level of the reduced modules is generated: time is abstracted.
[[nodiscard]] genom::GenerateOptions reduced_options(const Reduced& reduced, const std::string& package);
[[nodiscard]] Reduced reduce(const std::vector<genom::Module>& modules, const genom::Constraints& constraints);

}  // namespace bip::rules
