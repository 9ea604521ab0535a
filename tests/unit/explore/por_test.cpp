// Partial-order reduction where its effect is known: philosophers who each take the left fork first.
#include <catch2/catch.hpp>

#include <string>

#include "compiler/interp/interp.hpp"
#include "runtime/explore/explore.hpp"
#include "tools/gen/compiled.hpp"

namespace {

// The last one may be left-handed: then there is no deadlock.
std::string philosophers(int n, bool has_left_handed) {
  const std::string count = std::to_string(n);
  std::string text = R"(package table
  port type P()
  connector type Two(P a, P b)
    define a b
  end
  connector type Three(P a, P b, P c)
    define a b c
  end
  atom type Fork()
    export port P take(), put()
    place FREE, USED
    initial to FREE
    on take from FREE to USED
    on put from USED to FREE
  end
  atom type Philosopher()
    export port P first(), second(), put()
    place THINKS, WAITS, EATS
    initial to THINKS
    on first from THINKS to WAITS
    on second from WAITS to EATS
    on put from EATS to THINKS
  end
  compound type Root()
    component Fork fork[)" +
                     count + "]()\n    component Philosopher phil[" + count + "]()\n";
  for (int i = 0; i < n; ++i) {
    const bool swaps = has_left_handed && i + 1 == n;
    const std::string me = "phil[" + std::to_string(i) + "]", left = "fork[" + std::to_string(i) + "]",
                      right = "fork[" + std::to_string((i + 1) % n) + "]";
    text +=
        "    connector Two l" + std::to_string(i) + '(' + me + (swaps ? ".second, " : ".first, ") + left + ".take)\n";
    text +=
        "    connector Two r" + std::to_string(i) + '(' + me + (swaps ? ".first, " : ".second, ") + right + ".take)\n";
    text += "    connector Three p" + std::to_string(i) + '(' + me + ".put, " + left + ".put, " + right + ".put)\n";
  }
  return text + "  end\nend\n";
}

bip::rt::ExploreReport explore(const std::string& text, bip::rt::StateReduction reduction) {
  const bip::gen::Compiled c = bip::gen::compile_texts({text});
  REQUIRE(c.problem.empty());
  const bip::interp::Interpreter interpreter(*c.lowered);
  return bip::rt::explore_states(c.lowered->image, {.reduction = reduction, .limit = 2000000});
}

}  // namespace

TEST_CASE("stubborn sets keep the philosophers' deadlock and visit few states") {
  for (int n = 2; n <= 8; ++n) {
    INFO("philosophers " << n);
    const bip::rt::ExploreReport all = explore(philosophers(n, false), bip::rt::StateReduction::None);
    const bip::rt::ExploreReport few = explore(philosophers(n, false), bip::rt::StateReduction::Por);
    CHECK(all.deadlocks == 1);
    CHECK(few.deadlocks == 1);
    CHECK(few.states <= all.states);
    CHECK(explore(philosophers(n, true), bip::rt::StateReduction::Por).deadlocks == 0);
  }
}

// Exponential in the number of philosophers without the reduction: (1 + sqrt 2)^40 is 2 * 10^15.
TEST_CASE("stubborn sets make forty philosophers small") {
  for (const bool has_left_handed : {false, true}) {
    const bip::rt::ExploreReport found = explore(philosophers(40, has_left_handed), bip::rt::StateReduction::Por);
    CHECK(found.end == bip::rt::ExploreEnd::Complete);
    CHECK(found.deadlocks == (has_left_handed ? 0 : 1));
    CHECK(found.states < 40 * 40 * 4);
    WARN("40 philosophers: " << found.states << " states");
  }
}
