#include "compiler/base/log.hpp"

#include <catch2/catch.hpp>

namespace bip {

TEST_CASE("log areas are turned on by a list, in builds that have log lines") {
  const std::string problem = set_log_levels("ic3:2,traps");
  CHECK(problem.empty() == kHasLog);
  CHECK(log_level(LogArea::Ic3) == (kHasLog ? 2 : 0));
  CHECK(log_level(LogArea::Traps) == (kHasLog ? 1 : 0));
  CHECK(set_log_levels("ic3:0,traps:0").empty() == kHasLog);
}

TEST_CASE("a list of log areas with a mistake changes nothing") {
  CHECK(set_log_levels("ic3:1,ic4:1").find("no area `ic4`; there are affine, components") == 0);
  CHECK(set_log_levels("ic3:many") == "`many` is no level from 0 to 9");
  CHECK(log_level(LogArea::Ic3) == 0);
}

}  // namespace bip
