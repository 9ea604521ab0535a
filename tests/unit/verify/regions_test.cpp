// Regions of values: how ranges are divided, what components can be in alone and together, the linear program over all
// of them, and locks whose proofs need all three.
#include <catch2/catch.hpp>

#include <algorithm>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/regions/explore_alone.hpp"
#include "compiler/verify/regions/joint_explorer.hpp"
#include "compiler/verify/regions/refute_bad_states.hpp"
#include "tools/gen/compiled.hpp"

namespace bip::verify {

namespace {

// Peterson's filter lock without the way of looking at all others: who is overtaken passes. GUARD, ENTERED as they are
// in the lock: of `LAST` levels.
const char* const kLock = R"(package p
  port type Signal()
  port type See(int me, int level)
  port type Last(int level, int last)
  connector type One(Signal a) define a end
  connector type Enter(See process, Last level)
    define process level
    on process level provided (process.level == level.level) down { level.last = ENTERED; }
  end
  connector type Overtaken(See process, Last level)
    define process level
    on process level provided (GUARD)
  end
  atom type Process(int me, int top)
    data int self = me, level = 0
    export port Signal ask(), leave()
    export port See enter(self, level), overtaken(self, level)
    place OUTSIDE, ENTERS, LOOKS, PASSES, CRITICAL
    initial to OUTSIDE
    on ask from OUTSIDE to ENTERS do { level = 1; }
    on enter from ENTERS to LOOKS
    on overtaken from LOOKS to PASSES
    internal from PASSES to ENTERS provided (level < top) do { level = level + 1; }
    internal from PASSES to CRITICAL provided (level == top)
    on leave from CRITICAL to OUTSIDE do { level = 0; }
  end
  atom type Level(int number)
    data int level = number, last = -1
    export port Last enter(level, last), overtaken(level, last)
    place L
    initial to L
    on enter from L to L
    on overtaken from L to L
  end
  compound type Root()
    for i in 0..4 component Process process[i](i, LEVELS)
    for k in 0..LEVELS component Level level[k](k + 1)
    for i in 0..4 {
      connector One ask[i](process[i].ask), leave[i](process[i].leave)
      for k in 0..LEVELS {
        connector Enter enter[i * 4 + k](process[i].enter, level[k].enter)
        connector Overtaken overtaken[i * 4 + k](process[i].overtaken, level[k].overtaken)
      }
    }
  end
end
)";
constexpr const char* kGuard = "process.level == level.level && level.last != process.me";

struct Lock {
  gen::Compiled compiled;
  RegionNet net;

  Lock(const std::string& levels, const std::string& guard, const std::string& entered) {
    std::string text = kLock;
    for (const auto& [word, by] : {std::pair{std::string("LEVELS"), levels}, {"GUARD", guard}, {"ENTERED", entered}}) {
      for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at))
        text.replace(at, word.size(), by);
    }
    compiled = gen::compile_texts({text});
    REQUIRE(compiled.problem.empty());
    REQUIRE(is_plain_rendezvous(*compiled.system));
    net = build_region_net(*compiled.system, compiled.lowered->image);
  }
  [[nodiscard]] RegionSearch ask(const std::string& text) const {
    if (text.empty()) return refute_bad_states(net, nullptr, {});
    const Result<Property> property = parse_property(text, *compiled.system);
    REQUIRE(property);
    return refute_bad_states(net, &*property, {});
  }
};

// So many components that each need one of the first `holes` components: state k of the former implies state i of the
// k-th of the latter.
ExclusionProgram pigeons(u32 count, u32 holes) {
  ExclusionProgram program;
  std::vector<u32> pigeon, hole;
  for (u32 k = 0; k < count; ++k) pigeon.push_back(program.add_component(holes));
  for (u32 k = 0; k < holes; ++k) hole.push_back(program.add_component(count + 1));
  for (u32 i = 0; i < count; ++i) {
    for (u32 k = 0; k < holes; ++k) program.add({{pigeon[i] + k}, {hole[k] + i}});
  }
  return program;
}

}  // namespace

TEST_CASE("regions: constants divide a range") {
  CHECK(divide({0, 9}, {}) == std::vector<Range>{{0, 9}});
  CHECK(divide({0, 9}, {-3, 0, 4, 5, 9, 12}) == std::vector<Range>{{0, 0}, {1, 3}, {4, 4}, {5, 5}, {6, 8}, {9, 9}});
  CHECK(divide({3, 3}, {3}) == std::vector<Range>{{3, 3}});
  CHECK(divide(kAnyInt, {7}) == std::vector<Range>{{kAnyInt.low, 6}, {7, 7}, {8, kAnyInt.high}});
}

TEST_CASE("regions: the remainder of a range within one turn is a range") {
  CHECK(IntervalDomain::apply(Op::Mod, {12, 14}, {10, 10}) == Range{2, 4});
  CHECK(IntervalDomain::apply(Op::Mod, {8, 12}, {10, 10}) == Range{0, 9});
  CHECK(IntervalDomain::apply(Op::Mod, {10, 10}, {10, 10}) == Range{0, 0});
  CHECK(IntervalDomain::apply(Op::Mod, {-2, -1}, {10, 10}) == Range{-2, 0});
}

TEST_CASE("regions: variables that are compared or moved are of one class, with the constants that they meet") {
  const Lock lock("3", kGuard, "process.me");
  const System& system = *lock.compiled.system;
  const ValueClasses& values = lock.net.values;
  const auto class_of = [&](const std::string& type, const std::string& name) {
    for (std::size_t row = 0; row < system.atom_types.size(); ++row) {
      const AtomType& each = system.atom_types[AtomTypeId(row)];
      for (std::size_t k = 0; k < each.variables.size() && each.name == type; ++k) {
        if (each.variables[k].name == name) return values.class_of[row][k];
      }
    }
    FAIL(type << '.' << name);
    return 0u;
  };
  CHECK(class_of("Process", "level") == class_of("Level", "level"));
  CHECK(class_of("Process", "self") == class_of("Level", "last"));
  CHECK(class_of("Process", "level") != class_of("Level", "last"));
  const RegionConstants constants = constants_of(lock.net, {0, 4});
  CHECK(constants[class_of("Process", "level")] == std::vector<std::int64_t>{0, 1, 3});
  CHECK(constants[class_of("Level", "last")] == std::vector<std::int64_t>{-1, 0});
}

TEST_CASE("regions: a component alone, and with others") {
  const Lock lock("3", kGuard, "process.me");
  std::vector<u32> all;
  for (u32 atom = 0; atom < 7; ++atom) all.push_back(atom);
  const RegionConstants constants = constants_of(lock.net, all);
  std::vector<std::vector<std::uint8_t>> follows;
  for (const AtomType& type : lock.compiled.system->atom_types)
    follows.emplace_back(type.variables.size(), std::uint8_t{1});
  const auto of_type = [&](u32 atom) {
    return follows[lock.compiled.system->atoms[AtomId(std::size_t{atom})].type.value];
  };
  // Outside, critical, and at each of three levels before and behind `enter`.
  const std::optional<LocalSpace> process = explore_alone(lock.net, 0, constants, of_type(0), 100, {});
  REQUIRE(process);
  CHECK(process->size() == 8);
  // -1, and four processes.
  const std::optional<LocalSpace> level = explore_alone(lock.net, 4, constants, of_type(4), 100, {});
  REQUIRE(level);
  CHECK(level->size() == 5);
  CHECK_FALSE(explore_alone(lock.net, 0, constants, of_type(0), 3, {}));
  CHECK_FALSE(explore_alone(lock.net, 0, constants, of_type(0), 100, within_seconds(0)));

  // While the process waits at level 1 and nobody came after it, it is the last one; outside it may be.
  JointExplorer joint(lock.net, follows);
  REQUIRE(joint.explore({0, 4}, 1000, {}));
  const AtomType& type = lock.net.type_of(0);
  const auto place = static_cast<u32>(std::find(type.places.begin(), type.places.end(), "LOOKS") - type.places.begin());
  u32 waits_unknown = 0, waits = 0;
  for (const JointExplorer::Tuple& tuple : joint.reached()) {
    const LocalSpace &own = joint.spaces()[0], &other = joint.spaces()[1];
    if (!own.is_marked(tuple[0], place) || own.range(tuple[0], 3) != Range{1, 1}) continue;
    ++waits;
    waits_unknown += other.range(tuple[1], 2) == Range{-1, -1} ? 1 : 0;
  }
  CHECK(waits == 2);
  CHECK(waits_unknown == 0);
  CHECK_FALSE(joint.explore({0, 4}, 3, {}));
  CHECK_FALSE(joint.explore({0, 1, 4}, 1000, within_seconds(0)));
  // What was explored before leaves nothing behind.
  REQUIRE(joint.explore({0, 4}, 1000, {}));
  const std::size_t count = joint.reached().size();
  REQUIRE(joint.explore({0, 1, 4}, 10'000, {}));
  REQUIRE(joint.explore({0, 4}, 1000, {}));
  CHECK(joint.reached().size() == count);
}

TEST_CASE("regions: more components than places for them is refuted, as many is not") {
  for (const u32 holes : {1u, 2u, 5u, 30u}) {
    std::optional<ExclusionProgram::Proof> proof = pigeons(holes + 1, holes).refute({});
    REQUIRE(proof);
    CHECK(proof->least > 0);
    CHECK(proof->used.size() == holes * (holes + 1));
    CHECK_FALSE(pigeons(holes, holes).refute({}));
  }
  CHECK_FALSE(pigeons(6, 5).refute(within_seconds(0)));
  // Unlike ones: one hole less for the first, and one that nobody can have.
  ExclusionProgram program = pigeons(5, 5);
  program.forbid(4);
  CHECK_FALSE(program.refute({}));
  for (u32 k = 0; k < 5; ++k) program.forbid(5 * k + 3);
  CHECK(program.refute({}));
}

TEST_CASE("regions: a component without a state is refuted, by implications of nothing, too") {
  ExclusionProgram program;
  (void)program.add_component(2);
  (void)program.add_component(2);
  program.add({{0}, {2}});
  program.add({{1}, {3}});
  CHECK_FALSE(program.refute({}));
  program.forbid(2);
  program.forbid(3);
  const std::optional<ExclusionProgram::Proof> proof = program.refute({});
  REQUIRE(proof);
  CHECK(proof->used.empty());
}

TEST_CASE("regions: why states are impossible, in the order in which it is found out") {
  ExclusionProgram program;
  (void)program.add_component(3);
  (void)program.add_component(2);
  program.forbid(3, 7);
  program.forbid(3, 8);
  program.add({{0, 1}, {3}, 9});
  program.add({{4}, {0, 1}, 10});
  // The second component's only state that is left implies states of the first that need the other one.
  const std::optional<ExclusionProgram::Proof> proof = program.refute({});
  REQUIRE(proof);
  CHECK(proof->used.empty());
  REQUIRE(program.forbidden().size() == 3);
  CHECK(program.forbidden()[0].states == std::vector<u32>{3});
  CHECK(program.forbidden()[0].source == 7);
  CHECK(program.forbidden()[0].others.empty());
  CHECK(program.forbidden()[1].states == std::vector<u32>{0, 1});
  CHECK(program.forbidden()[1].source == 9);
  CHECK(program.forbidden()[1].others == std::vector<u32>{3});
  CHECK(program.forbidden()[2].states == std::vector<u32>{4});
  CHECK(program.forbidden()[2].others == std::vector<u32>{0, 1});
}

TEST_CASE("regions: rows of a certificate") {
  const Lock lock("3", kGuard, "process.me");
  const auto count = [](const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
  };
  for (const Writing writing : {Writing::Anything, Writing::Followed}) {
    const RegionNet net = build_region_net(*lock.compiled.system, lock.compiled.lowered->image, writing);
    const RegionSearch found = refute_bad_states(net, nullptr, {}, RegionRows::Yes);
    REQUIRE(found.proof);
    const std::string& rows = found.proof->rows;
    // Four processes wait at three levels each; each of the two other kinds of places is left at once.
    CHECK(count(rows, "@LOOKS&ROOT.process[2].level=1*1 ROOT.level[0]@L&ROOT.level[0].last=2*-1\n") == 1);
    CHECK(count(rows, "*-1") == 12);
    CHECK(count(rows, "unless ROOT.leave[1] ROOT.process[1]@CRITICAL") == 1);
    CHECK(count(rows, "lemma ROOT.process[3].self=3\n") == 1);
    // Whatever is written to it: then nothing is known of it.
    CHECK(count(rows, "lemma ROOT.level[1].last=-1..3\n") == (writing == Writing::Followed ? 1 : 0));
    const Result<Property> exclusion =
        parse_property("never process[0]@CRITICAL && process[1]@CRITICAL", *lock.compiled.system);
    REQUIRE(exclusion);
    CHECK_FALSE(refute_bad_states(net, &*exclusion, {}, RegionRows::Yes).proof);
    const Result<Property> range = parse_property("always process[2].level <= 3", *lock.compiled.system);
    REQUIRE(range);
    const RegionSearch local = refute_bad_states(net, &*range, {}, RegionRows::Yes);
    REQUIRE(local.proof);
    CHECK(count(local.proof->rows, "unless") == 0);
    CHECK(count(local.proof->rows, "lemma ROOT.process[2].level=0..3\n") == 1);
    CHECK(count(local.proof->rows, "lemma ROOT.process[0].self=0\n") == (writing == Writing::Followed ? 1 : 0));
  }
}

TEST_CASE("regions: rows about steps of ports alone, and what they lead to") {
  const gen::Compiled c = gen::compile_texts({R"(package p
  port type Signal()
  port type Number(int n)
  connector type Pass(Number a, Number b) define a b on a b provided (a.n < b.n) end
  atom type Turns(int me)
    data int n = me
    export port Number give(n), take(n)
    port Signal tick()
    place AWAY, READY
    initial to AWAY
    on tick from AWAY to READY
    on give from READY to AWAY
    on take from READY to AWAY
  end
  compound type Root()
    component Turns a(1), b(2)
    connector Pass pass(a.give, b.take)
  end
end
)"});
  REQUIRE(c.problem.empty());
  const RegionNet net = build_region_net(*c.system, c.lowered->image, Writing::Anything);
  const RegionSearch found = refute_bad_states(net, nullptr, {}, RegionRows::Yes);
  REQUIRE(found.proof);
  // `a` has no state: away it takes its own step, and ready it needs that `b` is away, which takes one, too.
  CHECK(found.proof->rows ==
        "lemma ROOT.a@AWAY ROOT.a@READY\nlemma ROOT.a.n=1\nlemma ROOT.b@AWAY ROOT.b@READY\nlemma ROOT.b.n=2\n"
        "unless ROOT.pass ROOT.a@READY*1 ROOT.b@AWAY*-1\nunless ROOT.a.tick ROOT.a@AWAY*1\n"
        "unless ROOT.b.tick ROOT.b@AWAY*1\n");
}

TEST_CASE("regions: locks by levels, and locks that are none") {
  const std::string exclusion = "never process[0]@CRITICAL && process[1]@CRITICAL";
  // Overtaken is overtaken: with as many levels as processes but one, one is critical.
  const Lock lock("3", kGuard, "process.me");
  CHECK(lock.ask(exclusion).proof);
  const RegionSearch deadlock = lock.ask("");
  REQUIRE(deadlock.proof);
  CHECK(deadlock.proof->explored == 0);
  // A level less lets two pass, a level more is one for each: all wait.
  const Lock low("2", kGuard, "process.me"), high("4", kGuard, "process.me");
  CHECK_FALSE(low.ask(exclusion).proof);
  CHECK(high.ask(exclusion).proof);
  const RegionSearch all_wait = high.ask("");
  CHECK_FALSE(all_wait.proof);
  CHECK(all_wait.is_complete);
  CHECK(lock.ask("always process[2].level <= 3 && level[1].last >= -1").proof);
  CHECK_FALSE(lock.ask("always level[1].last > -1").proof);
  CHECK(lock.ask("never process[0]@LOOKS && process[0].level == 1 && level[0].last == -1").proof);
  // Everybody passes: nobody waits, and nothing is excluded.
  CHECK_FALSE(Lock("3", "process.level == level.level", "process.me").ask(exclusion).proof);
  CHECK(Lock("3", "process.level == level.level", "process.me").ask("").proof);
  // All of them are said to be process 0.
  CHECK_FALSE(Lock("3", kGuard, "0 * process.me").ask("never process[1]@CRITICAL && process[2]@CRITICAL").proof);
  // A float may be beyond all ints.
  CHECK_FALSE(lock.ask("never 2147483647 < 3000000000.0 && process[0].level >= 0").proof);
  // An end of the time is no answer.
  const Result<Property> property = parse_property(exclusion, *lock.compiled.system);
  REQUIRE(property);
  const RegionSearch none = refute_bad_states(lock.net, &*property, within_seconds(0));
  CHECK_FALSE(none.proof);
  CHECK_FALSE(none.is_complete);
}

}  // namespace bip::verify
