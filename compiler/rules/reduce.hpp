// What is left of modules if only rules matter: the services that rules name, which run and end as they like, posters
// that are written or not. Everything that the modules can do, as far as rules see it, the reduction can do as well, in
// less time: its periods and limits are one or two ticks.
#pragma once
#include <vector>

#include "compiler/genom/constraints.hpp"
#include "compiler/genom/module.hpp"

namespace bip::rules {

struct Reduced {
  std::vector<genom::Module> modules;    // "m0", … with services "s0", … and posters "p0", …
  genom::Constraints constraints;        // the same rows, about those
  std::vector<genom::ServiceRef> names;  // by row: the subject
};
[[nodiscard]] Reduced reduce(const std::vector<genom::Module>& modules, const genom::Constraints& constraints);

}  // namespace bip::rules
