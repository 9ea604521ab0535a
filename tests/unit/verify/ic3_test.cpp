// IC3 on systems with known answers: counterexamples of known length, proofs whose lemmas another check accepts.
#include <catch2/catch.hpp>

#include "compiler/verify/invariants/houdini.hpp"
#include "compiler/verify/invariants/inductive_core.hpp"
#include "compiler/verify/symbolic/ic3.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;
using test::lock_and_users;

struct Ic3Case {
  explicit Ic3Case(const std::string& text)
      : made(text), system(build_transition_system(*made.compiled.system, made.compiled.lowered->image)) {
    REQUIRE(system.unsupported.empty());
  }
  [[nodiscard]] Ic3Problem problem(Signal bad) const {
    Ic3Problem result;
    result.system = &system;
    result.bad = bad;
    return result;
  }
  /// Every lemma excludes the initial state, and together they are inductive and exclude the bad states.
  void check_proof(const Ic3Problem& problem, const Ic3Answer& answer) const {
    REQUIRE(answer.end == Ic3End::Safe);
    for (const Cube& lemma : answer.lemmas) {
      CHECK_FALSE(meets_initial(lemma, system));
      CHECK(std::is_sorted(lemma.begin(), lemma.end()));
    }
    const InductiveLemmas again = houdini(problem, answer.lemmas);
    CHECK(again.lemmas == answer.lemmas);
    CHECK(again.is_enough);
  }

  HandMadeNet made;
  TransitionSystem system;
};

std::string counter_to(int limit) {
  return R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Counter()
    data int n = 0
    data bool odd = false
    export port Signal more()
    place S
    initial to S
    on more from S to S provided (n < )" +
         std::to_string(limit) + R"() do { n = n + 1; odd = !odd; }
  end
  compound type Root()
    component Counter c()
    connector One m(c.more)
  end
end
)";
}

}  // namespace

TEST_CASE("IC3: a lock lets one user in, and the lemmas prove it") {
  Ic3Case lock(lock_and_users());
  const Signal both_in = lock.system.aig.make_and(lock.system.marks[1][1], lock.system.marks[2][1]);
  const Ic3Problem problem = lock.problem(both_in);
  const Ic3Answer answer = run_ic3(problem);
  lock.check_proof(problem, answer);
  CHECK(answer.lemmas.size() >= 1);
  CHECK(answer.frames >= 1);
}

TEST_CASE("IC3: a broken lock lets two in, after two steps") {
  Ic3Case broken(lock_and_users("on other from FREE to FREE", "connector Two copy(u.enter, lock.other)"));
  const Signal both_in = broken.system.aig.make_and(broken.system.marks[1][1], broken.system.marks[2][1]);
  const Ic3Answer answer = run_ic3(broken.problem(both_in));
  REQUIRE(answer.end == Ic3End::Reached);
  CHECK(answer.steps.size() == 2);
}

TEST_CASE("IC3: a counterexample is as long as the counter") {
  for (const int limit : {1, 5, 12}) {
    Ic3Case counter(counter_to(limit));
    const Signal at_limit = equal(counter.system.aig, counter.system.words[0], word_of(limit));
    const Ic3Answer answer = run_ic3(counter.problem(at_limit));
    INFO("limit " << limit);
    REQUIRE(answer.end == Ic3End::Reached);
    CHECK(answer.steps.size() == static_cast<std::size_t>(limit));
  }
}

TEST_CASE("IC3: the parity of a counter needs an inductive invariant") {
  Ic3Case counter(counter_to(20));
  const Signal last_bit = counter.system.words[0][0], is_odd = counter.system.words[1][0];
  const Ic3Problem problem = counter.problem(counter.system.aig.make_xor(last_bit, is_odd));
  counter.check_proof(problem, run_ic3(problem));
}

TEST_CASE("IC3: bad initially, never bad, and out of time") {
  Ic3Case lock(lock_and_users());
  const Ic3Answer at_once = run_ic3(lock.problem(lock.system.marks[0][0]));
  CHECK(at_once.end == Ic3End::Reached);
  CHECK(at_once.steps.empty());
  CHECK(run_ic3(lock.problem(kFalse)).end == Ic3End::Safe);
  Ic3Problem late = lock.problem(lock.system.marks[1][1]);
  late.cancellation = within_seconds(0);
  CHECK(run_ic3(late).end == Ic3End::Stopped);
}

TEST_CASE("IC3: invariants are assumed in every frame") {
  Ic3Case broken(lock_and_users("on other from FREE to FREE", "connector Two copy(u.enter, lock.other)"));
  const Signal u_in = broken.system.marks[1][1], v_in = broken.system.marks[2][1];
  Ic3Problem problem = broken.problem(broken.system.aig.make_and(u_in, v_in));
  // Not true here, so that the answer shows that it was used.
  problem.invariants.push_back({negated(u_in), negated(v_in)});
  CHECK(run_ic3(problem).end == Ic3End::Safe);
}

TEST_CASE("Houdini: keeps the largest inductive subset") {
  Ic3Case lock(lock_and_users());
  const auto bit_of_place = [&](u32 atom, u32 place) {
    for (u32 bit = 0; bit < lock.system.bits.size(); ++bit) {
      if (lock.system.bits[bit].atom == atom && lock.system.bits[bit].row == place) return bit;
    }
    return kNoRow;
  };
  const Signal both_in = lock.system.aig.make_and(lock.system.marks[1][1], lock.system.marks[2][1]);
  const u32 free = bit_of_place(0, 0), u_in = bit_of_place(1, 1), v_in = bit_of_place(2, 1);
  const auto cube = [](std::vector<u32> bits) {
    std::vector<u32> result;
    for (u32 bit : bits) result.push_back(cube_literal_of(bit, true));
    std::sort(result.begin(), result.end());
    return result;
  };
  // True and inductive together; false after one step; false initially.
  const std::vector<Cube> good{cube({u_in, v_in}), cube({free, u_in}), cube({free, v_in})};
  std::vector<Cube> candidates = good;
  candidates.insert(candidates.begin() + 1, cube({u_in}));
  candidates.push_back(cube({free}));
  const InductiveLemmas result = houdini(lock.problem(both_in), candidates);
  CHECK(result.lemmas == good);
  CHECK(result.is_enough);
  // Without the lock's lemmas mutual exclusion is not inductive.
  CHECK(houdini(lock.problem(both_in), {good[0]}).lemmas.empty());
}

TEST_CASE("Houdini: candidates of many groups, of which some are refuted") {
  constexpr u32 kUsers = 30;
  std::string text = R"(package p
  port type Signal()
  connector type Two(Signal a, Signal b)
    define a b
  end
  atom type Lock()
    export port Signal take(), give()
    place FREE, TAKEN
    initial to FREE
    on take from FREE to TAKEN
    on give from TAKEN to FREE
  end
  atom type User()
    export port Signal enter(), leave()
    place OUT, IN
    initial to OUT
    on enter from OUT to IN
    on leave from IN to OUT
  end
  compound type Root()
    component Lock lock()
    component User user[30]
    for i in 0..30 connector Two enter[i](user[i].enter, lock.take), leave[i](user[i].leave, lock.give)
  end
end
)";
  Ic3Case lock(text);
  const auto literal_of = [&](u32 atom, u32 place) {
    for (u32 bit = 0; bit < lock.system.bits.size(); ++bit) {
      if (lock.system.bits[bit].atom == atom && lock.system.bits[bit].row == place) return cube_literal_of(bit, true);
    }
    FAIL("no such place");
    return u32{0};
  };
  std::vector<Cube> good, candidates;
  const auto add = [&](Cube cube, bool is_inductive) {
    std::sort(cube.begin(), cube.end());
    if (is_inductive) good.push_back(cube);
    candidates.push_back(std::move(cube));
  };
  for (u32 i = 1; i <= kUsers; ++i) {
    add({literal_of(0, 0), literal_of(i, 1)}, true);
    for (u32 j = i + 1; j <= kUsers; ++j) {
      add({literal_of(i, 1), literal_of(j, 1)}, true);
      // One that enters while the other one is out.
      add({literal_of(i, 1), literal_of(j, 0)}, false);
    }
  }
  const InductiveLemmas result =
      houdini(lock.problem(lock.system.aig.make_and(lock.system.marks[3][1], lock.system.marks[7][1])), candidates);
  CHECK(result.lemmas == good);
  CHECK(result.is_enough);
  CHECK_FALSE(houdini(lock.problem(lock.system.marks[3][1]), candidates).is_enough);
  // One pair less: what it kept apart is not kept apart.
  std::erase(candidates, good[1]);
  CHECK_FALSE(
      houdini(lock.problem(lock.system.aig.make_and(lock.system.marks[1][1], lock.system.marks[2][1])), candidates)
          .is_enough);

  SECTION("inductive core") {
    // Of groups that do alike, the first.
    const Signal bad = lock.system.aig.make_and(lock.system.marks[1][1], lock.system.marks[2][1]);
    const u32 free = literal_of(0, 0);
    std::vector<Cube> pairs, frees;
    for (const Cube& cube : good)
      (std::find(cube.begin(), cube.end(), free) == cube.end() ? pairs : frees).push_back(cube);
    const std::vector<std::vector<Cube>> groups{frees, pairs, frees};
    CHECK(inductive_core(lock.problem(bad), groups) == std::vector<std::size_t>{0, 1});
    // They do not suffice: all of them.
    CHECK(inductive_core(lock.problem(bad), {{frees[5]}, pairs}) == std::vector<std::size_t>{0, 1});
  }
}

}  // namespace bip::verify
