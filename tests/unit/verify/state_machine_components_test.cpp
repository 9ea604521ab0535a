// State-machine components: found where two of their modes are marked, refused where a step puts a second token.
#include <catch2/catch.hpp>

#include "compiler/verify/invariants/state_machine_components.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;
using test::lock_and_users;

}  // namespace

TEST_CASE("state-machine components: two users in the lock exclude each other") {
  const HandMadeNet made(lock_and_users());
  StateMachineComponentFinder finder(made.net, made.reachable);
  const std::vector<std::uint8_t> candidate = made.marking({"lock@TAKEN", "u@IN", "v@IN"});
  const std::vector<TokenInvariant> found = finder.find(candidate, kComponentBatch, {});
  REQUIRE(found.size() == 1);
  CHECK(found[0].kind == InvariantKind::OneToken);
  CHECK(found[0].modes == made.modes({"lock@FREE", "u@IN", "v@IN"}));
  CHECK_FALSE(is_satisfied(found[0], candidate));
  CHECK(is_satisfied(found[0], made.marking({"lock@TAKEN", "u@IN", "v@OUT"})));
}

TEST_CASE("state-machine components: a reachable candidate gives none") {
  const HandMadeNet made(lock_and_users());
  StateMachineComponentFinder finder(made.net, made.reachable);
  CHECK(finder.find(made.marking({"lock@TAKEN", "u@IN", "v@OUT"}), kComponentBatch, {}).empty());
  CHECK(finder.find(made.marking({"lock@FREE", "u@OUT", "v@OUT"}), kComponentBatch, {}).empty());
}

TEST_CASE("state-machine components: no more than were asked for, none without time") {
  const HandMadeNet made(lock_and_users());
  StateMachineComponentFinder finder(made.net, made.reachable);
  const std::vector<std::uint8_t> candidate = made.marking({"lock@TAKEN", "u@IN", "v@IN"});
  CHECK(finder.find(candidate, 0, {}).empty());
  CHECK(finder.find(candidate, kComponentBatch, within_seconds(0)).empty());
}

TEST_CASE("state-machine components: a step that puts a token more refuses the set") {
  const HandMadeNet made(lock_and_users("on other from FREE to FREE", "connector Two copy(u.enter, lock.other)"));
  StateMachineComponentFinder finder(made.net, made.reachable);
  CHECK(finder.find(made.marking({"lock@TAKEN", "u@IN", "v@IN"}), kComponentBatch, {}).empty());
  PlaceInvariantChecker checker(made.net, made.reachable);
  CHECK_FALSE(checker.is_state_machine_component(made.modes({"lock@FREE", "u@IN", "v@IN"})));
  CHECK(checker.is_state_machine_component(made.modes({"lock@FREE", "lock@TAKEN"})));
}

}  // namespace bip::verify
