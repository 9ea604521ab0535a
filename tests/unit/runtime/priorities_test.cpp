// Priorities: hiding, chains through what is not enabled, wildcards, guards.
#include <catch2/catch.hpp>

#include "tests/unit/runtime/helpers.hpp"

using namespace bip::rt;
using namespace bip::rt::testing;

namespace {

// `count` atoms a0, a1 … each with a connector k0, k1 …; those in `off` offer nothing until poked by t_i.
struct Singles {
  ImageBuilder b;
  Singles(int count, const std::vector<int>& off) {
    b.atom_type(
        {.name = "T",
         .params = {"ready"},
         .data = {"x"},
         .ports = {{.name = "p", .vars = {}}, {.name = "t", .vars = {}}},
         .places = {"S"},
         .initial = {"S"},
         .transitions = {{"p", {"S"}, {"S"}, [](Cell* self, Cell*, const u32*) { return self[1].i != 0 ? 1 : 0; }},
                         {"t",
                          {"S"},
                          {"S"},
                          nullptr,
                          [](Cell* self, Cell*, const u32*) {
                            self[1].i = 1 - self[1].i;
                            return 1;
                          }}},
         .initial_action = [](Cell* self, Cell*, const u32*) {
           self[1].i = self[0].i;
           return 1;
         }});
    b.connector_type(
        {.name = "One", .params = {{"p", 0}}, .define = "p", .clauses = {}, .data = {}, .exported_data = {}});
    for (int i = 0; i < count; ++i) {
      const std::string n = std::to_string(i);
      b.atom("a" + n, "T", {std::count(off.begin(), off.end(), i) == 0 ? 1 : 0});
      b.connector("k" + n, "One", {"a" + n + ".p"});
    }
    const u32 other = b.compound("ROOT.other", 0);
    for (int i = 0; i < count; ++i)
      b.connector("t" + std::to_string(i), "One", {"a" + std::to_string(i) + ".t"}, {}, other);
  }
  static Strings only_k(Core& core) {
    Strings out;
    for (const std::string& text : candidates(core)) {
      if (text[0] == 'k') out.push_back(text.substr(0, text.find(':')));
    }
    return out;
  }
  static void poke(Core& core, const std::string& atom) {
    for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
      if (text_of(core, core.candidate(k)).find(atom + ".t") == std::string::npos) continue;
      REQUIRE(core.fire(k));
      return;
    }
    FAIL("no " << atom << ".t");
  }
};

}  // namespace

TEST_CASE("an enabled higher one hides") {
  Singles s(2, {});
  s.b.priority("r", {.connector = "k0", .params = {}}, {.connector = "k1", .params = {}});
  Core core(s.b.image());
  REQUIRE(core.initialize());
  CHECK(Singles::only_k(core) == Strings{"k1"});
  Singles::poke(core, "a1");
  CHECK(Singles::only_k(core) == Strings{"k0"});
  Singles::poke(core, "a1");
  CHECK(Singles::only_k(core) == Strings{"k1"});
}

TEST_CASE("a chain hides through one that is not enabled") {
  Singles s(3, {1});
  s.b.priority("r1", {.connector = "k0", .params = {"p"}}, {.connector = "k1", .params = {"p"}});
  s.b.priority("r2", {.connector = "k1", .params = {"p"}}, {.connector = "k2", .params = {"p"}});
  Core core(s.b.image());
  REQUIRE(core.initialize());
  CHECK(Singles::only_k(core) == Strings{"k2"});
  Singles::poke(core, "a2");
  CHECK(Singles::only_k(core) == Strings{"k0"});
}

TEST_CASE("the wildcard is everything of the compound that is not on the other side") {
  Singles s(3, {});
  s.b.priority("r", {.connector = "k1", .params = {}}, {.connector = "", .params = {}});
  Core core(s.b.image());
  REQUIRE(core.initialize());
  CHECK(Singles::only_k(core) == Strings{"k0", "k2"});
  Singles::poke(core, "a0");
  Singles::poke(core, "a2");
  // The t connectors belong to another compound.
  CHECK(Singles::only_k(core) == Strings{"k1"});
}

TEST_CASE("guards of rules are read again when their atom moved") {
  Singles s(3, {2});
  s.b.priority("r", {.connector = "k0", .params = {}}, {.connector = "k1", .params = {}},
               [](Cell*, Cell* all, const u32* bind) { return all[bind[0]].i != 0 ? 1 : 0; }, {"a2.x"});
  Core core(s.b.image());
  REQUIRE(core.initialize());
  CHECK(Singles::only_k(core) == Strings{"k0", "k1"});
  Singles::poke(core, "a2");
  CHECK(Singles::only_k(core) == Strings{"k1", "k2"});
}

// k1 hides all others, too many to be followed at once; k3 hides k2 and k5 hides k4, the latter while x of a6 holds.
TEST_CASE("what is followed at once and what is marked hide alike") {
  constexpr int kCount = 40;
  Singles s(kCount, {1, 4, 9});
  s.b.priority("wide", {.connector = "", .params = {}}, {.connector = "k1", .params = {}});
  s.b.priority("narrow", {.connector = "k2", .params = {}}, {.connector = "k3", .params = {}});
  s.b.priority("guarded", {.connector = "k4", .params = {}}, {.connector = "k5", .params = {}},
               [](Cell*, Cell* all, const u32* bind) { return all[bind[0]].i != 0 ? 1 : 0; }, {"a6.x"});
  Core core(s.b.image());
  REQUIRE(core.initialize());
  CHECK(core.priorities().is_followed[1_i] == 0);
  CHECK(core.priorities().is_followed[3_i] == 1);
  std::vector<bool> ready(kCount, true);
  for (const std::size_t off : {1u, 4u, 9u}) ready[off] = false;
  const auto expected = [&] {
    Strings shown;
    for (std::size_t i = 0; i < ready.size(); ++i) {
      const bool is_hidden =
          (i != 1 && ready[1]) || (i == 2 && ready[3]) || (i == 4 && ready[6] && (ready[5] || ready[1]));
      if (ready[i] && !is_hidden) shown.push_back("k" + std::to_string(i));
    }
    return shown;
  };
  Prng prng(11);
  for (int step = 0; step < 300; ++step) {
    REQUIRE(Singles::only_k(core) == expected());
    const std::size_t atom = step % 7 == 0 ? 1 : prng.below(step % 3 == 0 ? kCount : 8);
    Singles::poke(core, "a" + std::to_string(atom));
    ready[atom] = !ready[atom];
    if (step % 50 == 49) REQUIRE(core.restore(core.snapshot()));
  }
}

TEST_CASE("interactions of one connector") {
  ImageBuilder b;
  b.atom_type(always_ready("T"));
  for (const char* name : {"a", "c", "d"}) b.atom(name, "T");
  const Fn never = [](Cell*, Cell*, const u32*) { return 0; };
  b.connector_type({.name = "B",
                    .params = {{"p", 0}, {"q", 0}, {"r", 0}},
                    .define = "p' q r",
                    .clauses = {{.params = {"p", "q", "r"}, .guard = never}},
                    .data = {},
                    .exported_data = {}});
  b.connector("brd", "B", {"a.p", "c.p", "d.p"});
  b.connector("brd2", "B", {"a.p", "c.p", "d.p"});
  b.priority("r", {.connector = "brd", .params = {"p", "q"}}, {.connector = "brd", .params = {"p", "r"}});
  Core core(b.image());
  REQUIRE(core.initialize());
  CHECK(candidates(core) == Strings{"brd: a.p d.p", "brd2: a.p c.p", "brd2: a.p d.p"});
  REQUIRE(core.fire(core.candidate(0)));
  CHECK(candidates(core) == Strings{"brd: a.p d.p", "brd2: a.p c.p", "brd2: a.p d.p"});
}

TEST_CASE("a broadcast under a rule that names an interaction follows its receivers") {
  ImageBuilder b;
  b.atom_type({.name = "T",
               .params = {},
               .data = {},
               .ports = {{.name = "p", .vars = {}}},
               .places = {"A", "B"},
               .initial = {"A"},
               .transitions = {{"p", {"A"}, {"B"}}}});
  b.atom_type(always_ready("S"));
  b.atom("s", "S");
  b.atom("r", "T");
  b.atom("o", "S");
  b.connector_type(
      {.name = "B", .params = {{"s", 0}, {"r", 0}}, .define = "s' r", .clauses = {}, .data = {}, .exported_data = {}});
  b.connector_type(
      {.name = "One", .params = {{"p", 0}}, .define = "p", .clauses = {}, .data = {}, .exported_data = {}});
  b.connector("brd", "B", {"s.p", "r.p"});
  b.connector("k", "One", {"o.p"});
  // Only with the receiver is the broadcast above k.
  b.priority("r", {.connector = "k", .params = {}}, {.connector = "brd", .params = {"s", "r"}});
  Core core(b.image());
  REQUIRE(core.initialize());
  CHECK(candidates(core) == Strings{"brd: s.p r.p"});
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(candidates(core) == Strings{"brd: s.p", "k: o.p"});
}

TEST_CASE("a cycle that closes at run time is a fault") {
  Singles s(3, {2});
  const Fn on = [](Cell*, Cell* all, const u32* bind) { return all[bind[0]].i != 0 ? 1 : 0; };
  s.b.priority("r1", {.connector = "k0", .params = {}}, {.connector = "k1", .params = {}});
  s.b.priority("r2", {.connector = "k1", .params = {}}, {.connector = "k0", .params = {}}, on, {"a2.x"});
  Core core(s.b.image());
  REQUIRE(core.initialize());
  CHECK(Singles::only_k(core) == Strings{"k1"});
  const State good = core.snapshot();
  for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
    if (text_of(core, core.candidate(k)) != "t2: a2.t") continue;
    CHECK(!core.fire(k));
    break;
  }
  CHECK(core.fault().code == FaultCode::PriorityCycle);
  CHECK(core.fault().what == "priorities close a cycle: `r1`, `r2` in `ROOT`");
  REQUIRE(core.restore(good));
  CHECK(Singles::only_k(core) == Strings{"k1"});
}
