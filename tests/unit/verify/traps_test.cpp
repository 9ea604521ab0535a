// Traps of a lock with two users: found from candidates, checked by structure, not found where there is none.
#include <catch2/catch.hpp>

#include "compiler/verify/invariants/token_invariant_checker.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;
using test::lock_and_users;

}  // namespace

TEST_CASE("traps: the lock is free or held by a user") {
  const HandMadeNet made(lock_and_users());
  TrapFinder finder(made.net, made.reachable);
  const std::vector<TokenInvariant> found = finder.find(made.marking({"lock@TAKEN", "u@OUT", "v@OUT"}));
  REQUIRE(found.size() == 1);
  CHECK(found[0].modes == made.modes({"lock@FREE", "u@IN", "v@IN"}));
  // Each step keeps its number of tokens.
  CHECK(found[0].kind == InvariantKind::OneToken);
}

TEST_CASE("traps: a candidate that no trap excludes gives none") {
  const HandMadeNet made(lock_and_users());
  TrapFinder finder(made.net, made.reachable);
  // Impossible, but by the number of tokens alone.
  CHECK(finder.find(made.marking({"lock@FREE", "u@IN", "v@OUT"})).empty());
  // Reachable.
  CHECK(finder.find(made.marking({"lock@TAKEN", "u@IN", "v@OUT"})).empty());
  CHECK(finder.find(made.marking({"lock@FREE", "u@OUT", "v@OUT"})).empty());
}

TEST_CASE("traps: one whose number of tokens grows is a trap and no component") {
  const HandMadeNet made(lock_and_users("on other from FREE to FREE", "connector Two copy(u.enter, lock.other)"));
  TrapFinder finder(made.net, made.reachable);
  const std::vector<TokenInvariant> found = finder.find(made.marking({"lock@TAKEN", "u@OUT", "v@OUT"}));
  REQUIRE(found.size() == 1);
  CHECK(found[0].modes == made.modes({"lock@FREE", "u@IN", "v@IN"}));
  CHECK(found[0].kind == InvariantKind::Trap);
}

TEST_CASE("traps: a step that empties the set, as one of its moves or with another user") {
  for (const char* const connector : {"connector One lose(lock.other)", "connector Two lose(v.leave, lock.other)"}) {
    const HandMadeNet made(lock_and_users("on other from FREE to TAKEN", connector));
    TrapFinder finder(made.net, made.reachable);
    INFO(connector);
    CHECK_FALSE(finder.holds(made.modes({"lock@FREE", "u@IN", "v@IN"})));
    CHECK(finder.find(made.marking({"lock@TAKEN", "u@OUT", "v@OUT"})).empty());
  }
}

TEST_CASE("traps: what does not hold initially is refused, and so is half of a trap") {
  const HandMadeNet made(lock_and_users());
  TrapFinder finder(made.net, made.reachable);
  CHECK(finder.holds(made.modes({"lock@FREE", "u@IN", "v@IN"})));
  CHECK(finder.holds(made.modes({"lock@FREE", "lock@TAKEN"})));
  CHECK_FALSE(finder.holds(made.modes({"lock@FREE", "u@IN"})));
  CHECK_FALSE(finder.holds(made.modes({"lock@TAKEN", "u@IN"})));
  CHECK_FALSE(finder.holds({}));
}

TEST_CASE("traps: of a trigger group any set may take part") {
  // With a broadcast from the lock a user may stay where it is: the lock alone leaves the set.
  const std::string broadcast = R"(
  end
  connector type Cast(Signal a, Signal b)
    define a' b
)";
  std::string text = lock_and_users("on other from FREE to TAKEN", "connector Cast c(lock.other, u.enter)");
  text.insert(text.find("\n  end\n  atom type Lock"), broadcast);
  const HandMadeNet made(text);
  TrapFinder finder(made.net, made.reachable);
  CHECK_FALSE(finder.holds(made.modes({"lock@FREE", "u@IN", "v@IN"})));
  // The user as the trigger, which puts a token into the set whenever the group fires.
  text.replace(text.find("c(lock.other, u.enter)"), 22, "c(u.enter, lock.other)");
  const HandMadeNet other(text);
  TrapFinder other_finder(other.net, other.reachable);
  CHECK(other_finder.holds(other.modes({"lock@FREE", "u@IN", "v@IN"})));
  CHECK_FALSE(TokenInvariantChecker(other.net, other.reachable)
                  .holds({InvariantKind::OneToken, other.modes({"lock@FREE", "u@IN", "v@IN"})}));
}

}  // namespace bip::verify
