// Properties of runs by neighbourhoods: what is found to be finite, fairness that is sure, runs that end, and code that
// may end in an error.
#include <catch2/catch.hpp>

#include <string>

#include "compiler/verify/liveness/faultless_code.hpp"
#include "compiler/verify/liveness/neighbourhood_runs.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

// Who waits goes in once somebody else has come after it. DONE: what a process does then.
const char* const kRoomOfLast = R"(package p
  port type Signal()
  port type Id(int me)
  port type Last(int last)
  connector type One(Signal a) define a end
  connector type Come(Id process, Last room)
    define process room
    on process room down { room.last = process.me; }
  end
  connector type Pass(Id process, Last room)
    define process room
    on process room provided (GUARD)
  end
  atom type Process(int number)
    data int me = number, share = 1
    export port Id come(me), pass(me)
    export port Signal leave()
    place AWAY, WAITS, INSIDE
    initial to AWAY
    on come from AWAY to WAITS
    on pass from WAITS to INSIDE do { DONE }
    on leave from INSIDE to AWAY
  end
  atom type Room()
    data int last = -1
    export port Last come(last), pass(last)
    place R
    initial to R
    on come from R to R
    on pass from R to R
  end
  compound type Root()
    for i in 0..4 component Process process[i](i)
    component Room room()
    for i in 0..4 {
      connector One leave[i](process[i].leave)
      connector Come come[i](process[i].come, room.come)
      connector Pass pass[i](process[i].pass, room.pass)
    }
  end
end)";
const char* const kGoesIn = "process[0]@WAITS leads to process[0]@INSIDE";

// One key, and who takes it twice in a row while another one waits.
const char* const kOneKey = R"(package p
  port type Signal()
  connector type One(Signal a) define a end
  connector type Two(Signal a, Signal b) define a b end
  atom type Process()
    export port Signal ask(), take(), give()
    place AWAY, WAITS, INSIDE
    initial to AWAY
    on ask from AWAY to WAITS
    on take from WAITS to INSIDE
    on give from INSIDE to AWAY
  end
  atom type Key()
    export port Signal take(), give()
    place HANGS, TAKEN
    initial to HANGS
    on take from HANGS to TAKEN
    on give from TAKEN to HANGS
  end
  compound type Root()
    for i in 0..2 component Process process[i]()
    component Key key()
    for i in 0..2 {
      connector One ask[i](process[i].ask)
      connector Two take[i](process[i].take, key.take), give[i](process[i].give, key.give)
    }
  end
end)";

// Both end where they are.
const char* const kMeetOnce = R"(package p
  port type Signal()
  connector type Two(Signal a, Signal b) define a b end
  atom type Half()
    export port Signal meet()
    place BEFORE, AFTER
    initial to BEFORE
    final AFTER
    on meet from BEFORE to AFTER
  end
  compound type Root()
    component Half a(), b()
    connector Two meet(a.meet, b.meet)
  end
end)";

std::string room_text(const std::string& guard, const std::string& done) {
  std::string text = kRoomOfLast;
  text.replace(text.find("GUARD"), 5, guard);
  return text.replace(text.find("DONE"), 4, done);
}

NeighbourhoodProof prove_around(const HandMadeNet& net, const char* property, const char* fairness, bool never_ends) {
  const System& system = *net.compiled.system;
  Result<ParsedProperty> parsed = PropertyReader(system).read(property);
  REQUIRE(parsed);
  REQUIRE(has_neighbourhoods(system, net.compiled.lowered->image));
  NeighbourhoodOptions options;
  options.fairness = *read_fairness(fairness, system);
  options.never_ends = [&] { return never_ends; };
  return prove_by_neighbourhoods(parsed->formula, system, net.compiled.lowered->image, options);
}

}  // namespace

TEST_CASE("neighbourhoods: who waits goes in, because the others come to rest") {
  const HandMadeNet net(room_text("room.last != process.me", ""));
  const NeighbourhoodProof proof = prove_around(net, kGoesIn, "weak", true);
  CHECK(proof.is_proved);
  CHECK(proof.cases == 1);
  CHECK(proof.neighbours == 1);
  CHECK(proof.needs_endless_runs);
  CHECK_FALSE(proof.may_have_errors);
  // Another process beside the room cannot stay anywhere.
  const NeighbourhoodProof by_two = prove_around(net, kGoesIn, "weak", false);
  CHECK(by_two.is_proved);
  CHECK(by_two.neighbours == 2);
  CHECK_FALSE(by_two.needs_endless_runs);
  CHECK(prove_around(net, kGoesIn, "strong", true).is_proved);
  CHECK(prove_around(net, kGoesIn, "weak:atoms", true).is_proved);
  CHECK(prove_around(net, "always eventually happens pass[2]", "weak", true).is_proved);
  // Of the named ones alone, as it is process 0 that must go on once others have come to rest.
  CHECK(prove_around(net, kGoesIn, "weak:pass[0]", true).is_proved);
  CHECK(prove_around(net, kGoesIn, "weak:process[0].pass", true).is_proved);
  CHECK(prove_around(net, kGoesIn, "strong:process[0]", true).is_proved);
  CHECK_FALSE(prove_around(net, kGoesIn, "weak:pass[1],strong:process[1].come", true).is_proved);
}

TEST_CASE("neighbourhoods: what fairness leaves open is not proved") {
  const HandMadeNet net(room_text("room.last != process.me", ""));
  CHECK_FALSE(prove_around(net, kGoesIn, "none", true).is_proved);
  CHECK_FALSE(
      prove_around(net, "process[0]@WAITS leads to process[1]@WAITS && process[0]@WAITS", "weak", true).is_proved);
  // Two processes and no room for both.
  const HandMadeNet closed(room_text("room.last == process.me", ""));
  CHECK_FALSE(prove_around(closed, kGoesIn, "weak", true).is_proved);
  const HandMadeNet key(kOneKey);
  CHECK_FALSE(prove_around(key, kGoesIn, "weak", true).is_proved);
  CHECK(prove_around(key, kGoesIn, "strong", true).is_proved);
}

TEST_CASE("neighbourhoods: a step that may end in an error is not due") {
  // The divisor is 1, but assigned before; a parameter would do.
  const HandMadeNet variable(room_text("room.last != process.me", "share = 12 / share;"));
  CHECK_FALSE(prove_around(variable, kGoesIn, "weak", true).is_proved);
  const HandMadeNet constant(room_text("room.last != process.me", "share = share / 12;"));
  CHECK(prove_around(constant, kGoesIn, "weak", true).is_proved);
}

TEST_CASE("neighbourhoods: the last state of a run repeats") {
  const HandMadeNet net(kMeetOnce);
  CHECK(prove_around(net, "eventually a@AFTER && b@AFTER", "weak", false).is_proved);
  CHECK_FALSE(prove_around(net, "eventually a@AFTER && b@AFTER", "none", false).is_proved);
  CHECK_FALSE(prove_around(net, "always eventually happens meet", "weak", false).is_proved);
  CHECK_FALSE(prove_around(net, "always eventually a@BEFORE", "weak", false).is_proved);
}

TEST_CASE("neighbourhoods: code without errors") {
  const auto is_faultless = [](const std::string& transitions) {
    const std::string text =
        "package p\n  use std.chance\n  port type Signal()\n  connector type One(Signal a) define a end\n"
        "  atom type A(int n, float f)\n    data int x = 0\n    export port Signal go()\n    place S, T\n"
        "    initial to S\n" +
        transitions +
        "  end\n  compound type Root()\n    component A a(3, 0.5)\n"
        "    connector One go(a.go)\n  end\nend\n";
    const HandMadeNet net(text);
    const RegionNet regions = build_region_net(*net.compiled.system, net.compiled.lowered->image);
    return find_faultless_code(regions).has_all();
  };
  CHECK(is_faultless("    on go from S to S do { x = (x + 1) % n; }\n"));
  CHECK_FALSE(is_faultless("    on go from S to S do { x = x % (n - 3); }\n"));
  CHECK(is_faultless(
      "    on go from S to S provided (x < n) do { x = x + 1; }\n    on go from S to T provided (x == n)\n"));
  CHECK_FALSE(is_faultless(
      "    on go from S to S provided (x <= n) do { x = x + 1; }\n    on go from S to T provided (x == n)\n"));
  CHECK(is_faultless("    on go from S to T\n    internal from T to S\n"));
  CHECK(is_faultless("    on go from S to S do { x = uniform(n, n + 2) + uniform(-1, n); }\n"));
  CHECK(is_faultless("    on go from S to S do { if (flip(0.25)) then x = table(x, 1.0, n, 2.5); fi }\n"));
  CHECK_FALSE(is_faultless("    on go from S to S do { x = uniform(n + 1, n); }\n"));
  CHECK_FALSE(is_faultless("    on go from S to S do { x = uniform(0, x); }\n"));
  CHECK_FALSE(is_faultless("    on go from S to S do { if (flip(f)) then x = 1; fi }\n"));
  CHECK_FALSE(is_faultless("    on go from S to S do { x = table(1, f, 2, 1.0); }\n"));
  CHECK_FALSE(is_faultless("    on go from S to S do { x = 3 % uniform(0, 3); }\n"));
  CHECK(is_faultless("    on go from S to S do { x = 3 % (n + 1) + uniform(0, 3); }\n"));
  CHECK_FALSE(
      is_faultless("    internal from S to T provided (x != 0)\n    internal from T to S\n    on go from S to S\n"));
}

}  // namespace bip::verify
