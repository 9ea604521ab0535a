// Proofs that are kept: the same system finds all of its proof again, a changed one what is the same, and nothing is
// believed.
#include "compiler/verify/evidence/proof_cache.hpp"

#include <catch2/catch.hpp>

#include <atomic>
#include <limits>
#include <thread>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/portfolio/portfolio.hpp"
#include "compiler/verify/invariants/houdini.hpp"
#include "tests/unit/base/scratch_folder.hpp"
#include "tests/verify/tampering.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;
using verify::Outcome;
using verify::StorePolicy;

// Philosophers at tables, the last one of each right-handed, and a lamp beside them.
std::string dinner(const std::string& root, const std::string& lamp_places, const std::string& lamp_moves) {
  return R"(package dinner
  port type Signal()
  connector type One(Signal a)
    define a
  end
  connector type Two(Signal a, Signal b)
    define a b
  end
  connector type Three(Signal a, Signal b, Signal c)
    define a b c
  end
  atom type Fork()
    export port Signal take(), put()
    place FREE, USED
    initial to FREE
    on take from FREE to USED
    on put from USED to FREE
  end
  atom type Philosopher(bool right_first)
    export port Signal take_left(), take_right(), put()
    place THINKS, HAS_LEFT, HAS_RIGHT, EATS
    initial to THINKS
    on take_left from THINKS to HAS_LEFT provided (!right_first)
    on take_right from HAS_LEFT to EATS
    on take_right from THINKS to HAS_RIGHT provided (right_first)
    on take_left from HAS_RIGHT to EATS
    on put from EATS to THINKS
  end
  compound type Table(int n)
    component Fork fork[n]()
    for i in 0..n component Philosopher phil[i](i == n - 1)
    for i in 0..n connector Two left[i](phil[i].take_left, fork[i].take)
    for i in 0..n connector Two right[i](phil[i].take_right, fork[(i + 1) % n].take)
    for i in 0..n connector Three put[i](phil[i].put, fork[i].put, fork[(i + 1) % n].put)
  end
  atom type Lamp()
    export port Signal light(), dark()
    place )" +
         lamp_places + R"(
    initial to DARK
)" + lamp_moves +
         R"(
  end
)" + root +
         R"(
end
)";
}
const std::string kRoot =
    "  compound type Root()\n    component Table left(4), right(4)\n    component Lamp lamp()\n  end\n";
const std::string kOther = "  compound type Root()\n    component Lamp lamp()\n    component Table corner(4)\n  end\n";
const std::string kMoves = "    on light from DARK to LIT\n    on dark from LIT to DARK\n";

// A counter that stays even, which only induction sees.
const char* const kEven = R"(package even
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Counter()
    data int n = 0
    data int m = 0
    export port Signal more(), less(), odd()
    place S
    initial to S
    on more from S to S provided (n < 1000000000) do { n = n + 2; m = 3 * m + 1; }
    on less from S to S provided (n > 0) do { n = n - 2; m = m - 1; }
    on odd from S to S provided (n == 7)
  end
  compound type Root()
    component Counter c()
    connector One more(c.more), less(c.less), odd(c.odd)
  end
end
)";

// A door that counts who is inside.
const char* const kDoor = R"(package door
  port type Signal()
  connector type Two(Signal a, Signal b)
    define a b
  end
  atom type Door()
    data int n = 0
    export port Signal enter(), leave()
    place S
    initial to S
    on enter from S to S do { n = n + 1; }
    on leave from S to S provided (n != 77) do { n = n - 1; }
  end
  atom type User()
    export port Signal enter(), leave()
    place OUT, IN
    initial to OUT
    on enter from OUT to IN
    on leave from IN to OUT
  end
  compound type Root()
    component Door d()
    component User u[3]()
    for i in 0..3 connector Two enter[i](u[i].enter, d.enter), leave[i](u[i].leave, d.leave)
  end
end
)";

struct Answered {
  verify::Decision decision;
  verify::ReuseCounts counts;
};
const std::vector<verify::Cube>& lemmas_of(const Answered& answered) {
  return std::get<verify::InductiveProof>(answered.decision.evidence).lemmas;
}
Answered ask(const std::string& text, const std::string& folder, const std::string& property = "",
             StorePolicy policy = StorePolicy::All) {
  const gen::Compiled c = gen::compile_texts({text});
  REQUIRE(c.problem.empty());
  const interp::Interpreter interpreter(*c.lowered);
  verify::Question question;
  if (!property.empty()) {
    question.what = verify::QuestionKind::State;
    Result<verify::Property> parsed = verify::parse_property(property, *c.system);
    REQUIRE(parsed);
    question.property = std::move(*parsed);
  }
  ContentCache cache(ContentKind::Proof, folder, std::uint64_t{1} << 30);
  verify::ProofCache memory(cache, "unit", policy);
  verify::Portfolio portfolio(
      *c.system, c.lowered->image, verify::StateAccess::Searchable, [] { return true; },
      [](const char*, std::uint64_t, const char*) {});
  portfolio.use_cache(&memory);
  verify::PortfolioLimits limits;
  limits.cancellation = verify::within_seconds(20);
  limits.may_search = false;
  Answered result{portfolio.decide(question, limits), {}};
  result.counts = memory.counts;
  return result;
}

}  // namespace

TEST_CASE("the same system finds all of its proof again, once") {
  const testing::ScratchFolder folder;
  const std::string text = dinner(kRoot, "DARK, LIT", kMoves);
  const Answered first = ask(text, folder.path());
  CHECK(first.decision.outcome == Outcome::Holds);
  CHECK(first.decision.invariants().size() >= 8);
  CHECK(first.counts.recalled == 0);
  // The system, where its root's last proof is, and one table: both are the same.
  CHECK(first.counts.stored == 3);
  const Answered second = ask(text, folder.path());
  CHECK(second.decision.outcome == Outcome::Holds);
  CHECK(second.counts.is_whole);
  CHECK(second.counts.invariants == first.decision.invariants().size());
  CHECK(second.decision.invariants() == first.decision.invariants());
  CHECK(second.decision.candidates() == 0);
  CHECK(second.counts.stored == 0);
}

TEST_CASE("what is found at once is not kept, unless all is wanted") {
  const testing::ScratchFolder folder;
  CHECK(ask(dinner(kRoot, "DARK, LIT", kMoves), folder.path(), "", StorePolicy::Expensive).counts.stored == 0);
  CHECK(folder.files().empty());
}

TEST_CASE("one component has changed: the rest is used again") {
  const testing::ScratchFolder folder;
  const Answered first = ask(dinner(kRoot, "DARK, LIT", kMoves), folder.path());
  const Answered second =
      ask(dinner(kRoot, "DARK, DIM, LIT",
                 "    on light from DARK to DIM\n    on dark from DIM to LIT\n    on dark from LIT to DARK\n"),
          folder.path());
  CHECK(second.decision.outcome == Outcome::Holds);
  CHECK_FALSE(second.counts.is_whole);
  CHECK(second.counts.invariants == first.decision.invariants().size());
  CHECK(second.decision.candidates() == 0);
  // And both are known now.
  CHECK(ask(dinner(kRoot, "DARK, LIT", kMoves), folder.path()).counts.is_whole);
}

TEST_CASE("a compound is known wherever it stands") {
  const testing::ScratchFolder folder;
  const Answered first = ask(dinner(kRoot, "DARK, LIT", kMoves), folder.path());
  const Answered second = ask(dinner(kOther, "DARK, LIT", kMoves), folder.path());
  CHECK_FALSE(second.counts.is_whole);
  // Where the last root of that name is, which has no corner, and the table.
  CHECK(second.counts.files == 2);
  CHECK(2 * second.counts.invariants == first.decision.invariants().size());
  CHECK(second.decision.candidates() == 0);
  CHECK(second.decision.outcome == Outcome::Holds);
}

TEST_CASE("what held and does not any more is left out") {
  const testing::ScratchFolder folder;
  std::string text = dinner(kRoot, "DARK, LIT", kMoves);
  CHECK(ask(text, folder.path()).decision.outcome == Outcome::Holds);
  // Everybody is left-handed now: the deadlock is there, whatever is known.
  text.replace(text.find("phil[i](i == n - 1)"), 19, "phil[i](i == n + 1)");
  CHECK(ask(text, folder.path()).decision.outcome != Outcome::Holds);
}

TEST_CASE("lemmas come back, are checked, and those of another model go") {
  const testing::ScratchFolder folder;
  const std::string property = "never c.n == 7";
  const Answered first = ask(kEven, folder.path(), property);
  REQUIRE(first.decision.outcome == Outcome::Holds);
  REQUIRE(std::holds_alternative<verify::InductiveProof>(first.decision.evidence));
  REQUIRE(!lemmas_of(first).empty());
  const Answered second = ask(kEven, folder.path(), property);
  CHECK(second.counts.is_whole);
  CHECK(second.counts.lemmas == lemmas_of(first).size());
  CHECK(lemmas_of(second) == lemmas_of(first));
  CHECK(second.decision.frames == 0);
  // n grows by one: the network is the same, the lemmas are none.
  std::string odd = kEven;
  odd.replace(odd.find("n = n + 2"), 9, "n = n + 1");
  const Answered third = ask(odd, folder.path(), property);
  CHECK(third.counts.is_whole);
  CHECK(third.counts.lemmas < lemmas_of(first).size());
  CHECK(third.decision.outcome == Outcome::Violated);
  // And the way to it is taken again.
  const Answered fourth = ask(odd, folder.path(), property);
  CHECK(fourth.counts.has_counterexample);
  CHECK(fourth.decision.counterexample()->choices == third.decision.counterexample()->choices);
  CHECK(ask(kEven, folder.path(), property).decision.outcome == Outcome::Holds);
}

TEST_CASE("equations come back, are checked, and those of another model go") {
  const testing::ScratchFolder folder;
  const std::string property = "never u[0]@IN && d.n == 0";
  const Answered first = ask(kDoor, folder.path(), property);
  REQUIRE(first.decision.outcome == Outcome::Holds);
  REQUIRE(first.decision.facts.affine.equations.size() == 1);
  const Answered second = ask(kDoor, folder.path(), property);
  CHECK(second.counts.is_whole);
  CHECK(second.counts.equations == 1);
  CHECK(second.decision.outcome == Outcome::Holds);
  CHECK(second.decision.facts.affine.equations[0].terms == first.decision.facts.affine.equations[0].terms);
  CHECK(second.decision.facts.affine.equations[0].total == first.decision.facts.affine.equations[0].total);
  // Who leaves counts twice: the network is the same, the equation is none.
  std::string twice = kDoor;
  twice.replace(twice.find("n = n - 1"), 9, "n = n - 2");
  const Answered third = ask(twice, folder.path(), property);
  CHECK(third.counts.is_whole);
  CHECK(third.counts.equations == 0);
  CHECK(third.decision.outcome == Outcome::Violated);
}

TEST_CASE("forged equations are not believed") {
  const gen::Compiled c = gen::compile_texts({kDoor});
  REQUIRE(c.problem.empty());
  const verify::Net net = verify::build_net(*c.system);
  const verify::u32 door = 0, user = 1, in = 1;
  using Terms = verify::CachedEquation;
  const std::vector<Terms> forged = {{{door, 0, false, 1}},                        // n is always 0
                                     {{user, in, true, 1}},                        // nobody is ever inside
                                     {{door, 0, false, 1}, {user, in, true, -1}},  // n is who is inside, of one user
                                     {{door, 0, false, 0}, {user, in, true, 1}},   // a weight of 0
                                     {{door, 7, false, 1}},                        // no such int
                                     {{door, 0, false, 1}, {door, 0, false, -1}, {user, in, true, 1}},  // n twice
                                     {{user, 0, true, 1}},  // the first place of an automaton
                                     {{door, 0, false, std::numeric_limits<std::int32_t>::min()}}};
  for (const Terms& terms : forged) {
    const testing::ScratchFolder folder;
    ContentCache cache(ContentKind::Proof, folder.path(), std::uint64_t{1} << 30);
    verify::ProofCache memory(cache, "unit", StorePolicy::All);
    const std::string property = "never u[0]@IN";
    const std::string question = "state " + property;
    (void)memory.recall(net, question);
    verify::CachedProof proof;
    proof.method = verify::ProofMethod::Induction;
    proof.equations = {terms};
    memory.store(net, question, proof);
    const Answered asked = ask(kDoor, folder.path(), property);
    CHECK(asked.counts.is_whole);
    CHECK(asked.counts.equations == 0);
    CHECK(asked.decision.outcome == Outcome::Violated);
  }
}

TEST_CASE("of candidates for lemmas the largest part is taken that no step leaves") {
  const gen::Compiled c = gen::compile_texts({kEven});
  REQUIRE(c.problem.empty());
  const verify::TransitionSystem machine = verify::build_transition_system(*c.system, c.lowered->image);
  std::optional<verify::u32> low_n, low_m;
  for (verify::u32 row = 0; row < machine.bits.size(); ++row) {
    const verify::StateBit& bit = machine.bits[row];
    if (!bit.is_place && bit.position == 0) (bit.row == 0 ? low_n : low_m) = row;
  }
  REQUIRE(low_n);
  REQUIRE(low_m);
  verify::Ic3Problem problem;
  problem.system = &machine;
  problem.bad = machine.bits[*low_n].now;
  problem.cancellation = verify::within_seconds(20);
  // Never odd: true of n, not of m. Never even: not so at first.
  const verify::InductiveLemmas found =
      verify::houdini(problem, {{2 * *low_m + 1}, {2 * *low_n + 1}, {2 * *low_n}, {}});
  CHECK(found.lemmas == std::vector<verify::Cube>{{2 * *low_n + 1}});
  CHECK(found.is_enough);
  problem.bad = machine.bits[*low_m].now;
  CHECK_FALSE(verify::houdini(problem, {{2 * *low_n + 1}}).is_enough);
}

TEST_CASE("files that are damaged or forged change no verdict") {
  const std::string free = dinner(kRoot, "DARK, LIT", kMoves);
  std::string dead = free;
  dead.replace(dead.find("phil[i](i == n - 1)"), 19, "phil[i](i == n + 1)");
  const testing::ScratchFolder folder;
  std::string foreign;
  std::size_t used = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    (void)ask(free, folder.path());
    if (seed % 3 == 0) verify::test::damage(folder.path(), seed);
    else foreign = verify::test::forge(folder.path(), foreign, seed);
    const Answered again = ask(free, folder.path());
    CHECK(again.decision.outcome == Outcome::Holds);
    used += again.counts.invariants;
    CHECK(ask(dead, folder.path()).decision.outcome != Outcome::Holds);
  }
  CHECK(used > 0);
}

TEST_CASE("a forged proof that would exclude the deadlock is not believed") {
  std::string dead = dinner(kRoot, "DARK, LIT", kMoves);
  dead.replace(dead.find("phil[i](i == n - 1)"), 19, "phil[i](i == n + 1)");
  const gen::Compiled c = gen::compile_texts({dead});
  REQUIRE(c.problem.empty());
  const verify::Net net = verify::build_net(*c.system);
  for (const auto kind : {verify::InvariantKind::Trap, verify::InvariantKind::OneToken, verify::InvariantKind::Sum}) {
    const testing::ScratchFolder folder;
    ContentCache cache(ContentKind::Proof, folder.path(), std::uint64_t{1} << 30);
    verify::ProofCache memory(cache, "unit", StorePolicy::All);
    CHECK(memory.recall(net, "deadlock").invariants.empty());
    // Each component is always as it was at first; so no philosopher ever holds one fork.
    verify::CachedProof forged;
    forged.method = verify::ProofMethod::Invariants;
    for (verify::u32 atom = 0; atom + 1 < net.mode_base.size(); ++atom)
      forged.invariants.push_back({kind, verify::PortUseModes::Merged, 1, {{atom, net.class_at(atom).initial[0], 1}}});
    memory.store(net, "deadlock", forged);
    CHECK(memory.counts.stored >= 2);
    const Answered asked = ask(dead, folder.path());
    CHECK(asked.counts.is_whole);
    CHECK(asked.counts.recalled == forged.invariants.size());
    CHECK(asked.counts.invariants == 0);
    CHECK(asked.decision.outcome != Outcome::Holds);
  }
}

TEST_CASE("texts of all kinds are read without harm") {
  const auto none = [](const verify::AtomName&) -> std::optional<verify::u32> { return std::nullopt; };
  const auto any = [](const verify::AtomName&) -> std::optional<verify::u32> { return 0; };
  const std::string head = "bipc kept proof 1\nway plain\natom 00 a b\n";
  CHECK_FALSE(verify::parse_cached_proof("", any));
  CHECK_FALSE(verify::parse_cached_proof("bipc kept proof 2\n", any));
  CHECK_FALSE(verify::parse_cached_proof(head + "trap 0 1 0 0 1", any));
  CHECK_FALSE(verify::parse_cached_proof(head + "trap 0 1 0 0 x\n", any));
  CHECK_FALSE(verify::parse_cached_proof(head + "trap 0 1 0 99999999999 1\n", any));
  CHECK_FALSE(verify::parse_cached_proof(head + "sum 0 1 0 0 999999999999\n", any));
  CHECK_FALSE(verify::parse_cached_proof(head + "nonsense\n", any));
  const auto known = verify::parse_cached_proof(head + "trap 0 1 0 3 1\nnever 0 1 2 3 1\n", any);
  REQUIRE(known);
  CHECK(known->invariants.size() == 1);
  CHECK(known->lemmas.size() == 1);
  // Rows of unknown components, and of numbers that no component has.
  const auto unknown = verify::parse_cached_proof(head + "trap 0 1 0 3 1\nnever 0 1 2 3 1\n", none);
  REQUIRE(unknown);
  CHECK(unknown->invariants.empty());
  CHECK(unknown->lemmas.empty());
  CHECK(verify::parse_cached_proof(head + "trap 0 1 7 3 1\n", any)->invariants.empty());
}

TEST_CASE("several processes share a folder") {
  const testing::ScratchFolder folder;
  const std::string text = dinner(kRoot, "DARK, LIT", kMoves);
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  const gen::Compiled c = gen::compile_texts({text});
  REQUIRE(c.problem.empty());
  for (int k = 0; k < 4; ++k) {
    threads.emplace_back([&] {
      for (int round = 0; round < 5; ++round) {
        ContentCache cache(ContentKind::Proof, folder.path(), 20000);
        verify::ProofCache memory(cache, "unit", StorePolicy::All);
        verify::Portfolio portfolio(
            *c.system, c.lowered->image, verify::StateAccess::Undetermined, [] { return false; },
            [](const char*, std::uint64_t, const char*) {});
        portfolio.use_cache(&memory);
        verify::PortfolioLimits limits;
        limits.cancellation = verify::within_seconds(100);
        limits.may_search = false;
        if (portfolio.decide({}, limits).outcome != Outcome::Holds || memory.broken_files() != 0) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
}
