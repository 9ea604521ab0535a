// What `bipc explore --json` prints.
#pragma once
#include <string>

#include "compiler/driver/options.hpp"
#include "runtime/explore/counterexample.hpp"
#include "runtime/explore/explore.hpp"

namespace bip::driver {

/// The runs that a visit shows, as text for people; empty if it has none or does not know them.
struct ShownRuns {
  rt::CounterexampleText deadlock, error;
};

/// The result of a visit on one line, with its end.
[[nodiscard]] std::string exploration_json(const ExploreArguments& arguments, const rt::Image& image,
                                           const rt::ExploreReport& found, const ShownRuns& runs);

}  // namespace bip::driver
