// Place invariants of a store of two units, whose only invariant is known: store + users + 2 * machine = 2.
#include <catch2/catch.hpp>

#include "compiler/verify/invariants/place_invariants.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;
using test::lock_and_users;
using test::store_of_two;

std::string text_of(const TokenInvariant& invariant, const Net& net) {
  std::string text = std::to_string(invariant.total) + " =";
  for (std::size_t k = 0; k < invariant.modes.size(); ++k)
    text += ' ' + std::to_string(weight_of(invariant, k)) + '*' + net.mode_name(invariant.modes[k]);
  return text;
}
const char* const kStoreInvariant = "2 = 2*store@N2 1*store@N1 1*u@HAS 1*v@HAS 2*machine@HAS";

}  // namespace

TEST_CASE("place invariants: weights are found from a candidate that breaks them") {
  const HandMadeNet made(store_of_two());
  PlaceInvariantFinder finder(made.net, made.reachable, {});
  const std::vector<std::uint8_t> candidate = made.marking({"store@N2", "u@HAS", "v@IDLE", "machine@IDLE"});
  const std::vector<TokenInvariant> found = finder.find(candidate);
  REQUIRE(found.size() == 1);
  CHECK(text_of(found[0], made.net) == kStoreInvariant);
  CHECK_FALSE(finder.satisfies_all());
  CHECK_FALSE(is_satisfied(found[0], candidate));
  CHECK(is_satisfied(found[0], made.marking({"store@N0", "u@IDLE", "v@IDLE", "machine@HAS"})));
  // Not twice.
  CHECK(finder.find(candidate).empty());
}

TEST_CASE("place invariants: a reachable candidate satisfies the marking equation") {
  const HandMadeNet made(store_of_two());
  PlaceInvariantFinder finder(made.net, made.reachable, {});
  CHECK(finder.find(made.marking({"store@N1", "u@IDLE", "v@HAS", "machine@IDLE"})).empty());
  CHECK(finder.satisfies_all());
}

TEST_CASE("place invariants: all small ones at once") {
  const HandMadeNet made(store_of_two());
  PlaceInvariantFinder finder(made.net, made.reachable, {});
  const std::vector<TokenInvariant> found = finder.find_small();
  REQUIRE(found.size() == 1);
  CHECK(text_of(found[0], made.net) == kStoreInvariant);
  CHECK(finder.find(made.marking({"store@N2", "u@HAS", "v@IDLE", "machine@IDLE"})).empty());
}

TEST_CASE("place invariants: none where a step changes every sum") {
  const HandMadeNet made(lock_and_users("on other from FREE to FREE", "connector Two copy(u.enter, lock.other)"));
  PlaceInvariantFinder finder(made.net, made.reachable, {});
  // u enters with and without the lock, so it weighs nothing, and then neither does the lock.
  CHECK(finder.find_small().empty());
}

TEST_CASE("place invariants: the checker refuses wrong weights and totals") {
  const HandMadeNet made(store_of_two());
  PlaceInvariantChecker checker(made.net, made.reachable);
  PlaceInvariantFinder finder(made.net, made.reachable, {});
  const TokenInvariant invariant = finder.find_small().at(0);
  CHECK(checker.holds(invariant));
  TokenInvariant other_total = invariant;
  other_total.total = 3;
  CHECK_FALSE(checker.holds(other_total));
  for (std::size_t k = 0; k < invariant.modes.size(); ++k) {
    TokenInvariant other_weight = invariant;
    ++other_weight.weights[k];
    // The sum is made to fit initially, so that only steps can refuse it.
    if (made.net.mode_name(invariant.modes[k]) == "store@N2") ++other_weight.total;
    INFO("weight " << k);
    CHECK_FALSE(checker.holds(other_weight));
  }
  CHECK(checker.holds(invariant));
}

}  // namespace bip::verify
