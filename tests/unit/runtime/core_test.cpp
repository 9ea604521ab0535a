// Enabled and fire on small systems, one idea a test.
#include <catch2/catch.hpp>

#include "tests/unit/runtime/helpers.hpp"

using namespace bip::rt;
using namespace bip::rt::testing;

namespace {

// One token: `go` leaves A for B, `back` returns.
AtomTypeSpec toggle(const std::string& name) {
  return {.name = name,
          .ports = {{.name = "go", .vars = {}}, {.name = "back", .vars = {}}},
          .places = {"A", "B"},
          .initial = {"A"},
          .transitions = {{"go", {"A"}, {"B"}}, {"back", {"B"}, {"A"}}}};
}
// Holds x = its parameter, offers it on p; r receives.
AtomTypeSpec cell(const std::string& name) {
  return {.name = name,
          .params = {"start"},
          .data = {"x"},
          .ports = {{.name = "p", .vars = {"x"}}},
          .places = {"S"},
          .initial = {"S"},
          .transitions = {{"p", {"S"}, {"S"}}},
          .initial_action = [](Cell* self, Cell*, const u32*) {
            self[1].i = self[0].i;
            return 1;
          }};
}
ConnectorTypeSpec plain(const std::string& name, const std::string& define, const std::vector<std::string>& params) {
  ConnectorTypeSpec spec{.name = name, .params = {}, .define = define, .clauses = {}, .data = {}, .exported_data = {}};
  for (const std::string& param : params) spec.params.emplace_back(param, 0);
  return spec;
}

}  // namespace

TEST_CASE("a rendezvous needs everybody") {
  ImageBuilder b;
  b.atom_type(toggle("T"));
  b.atom("a", "T");
  b.atom("c", "T");
  b.connector_type(plain("R", "p q", {"p", "q"}));
  b.connector("go", "R", {"a.go", "c.go"});
  b.connector("mix", "R", {"a.go", "c.back"});
  b.connector("back", "R", {"a.back", "c.back"});
  Core core(b.image());
  REQUIRE(core.initialize());
  CHECK(candidates(core) == Strings{"go: a.go c.go"});
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(candidates(core) == Strings{"back: a.back c.back"});
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(candidates(core) == Strings{"go: a.go c.go"});
}

TEST_CASE("a broadcast takes all that are ready") {
  ImageBuilder b;
  b.atom_type(toggle("T"));
  for (const char* name : {"s", "r1", "r2"}) b.atom(name, "T");
  b.connector_type(plain("B", "p' q r", {"p", "q", "r"}));
  b.connector_type(plain("One", "p", {"p"}));
  b.connector("all", "B", {"s.go", "r1.go", "r2.go"});
  b.connector("r1b", "One", {"r1.back"});
  b.connector("sb", "One", {"s.back"});
  Core core(b.image());
  REQUIRE(core.initialize());
  CHECK(candidates(core) == Strings{"all: s.go r1.go r2.go"});
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(candidates(core) == Strings{"r1b: r1.back", "sb: s.back"});
  REQUIRE(core.fire(std::uint64_t{1}));
  CHECK(candidates(core) == Strings{"all: s.go", "r1b: r1.back"});
  REQUIRE(core.fire(std::uint64_t{1}));
  CHECK(candidates(core) == Strings{"all: s.go r1.go"});
}

TEST_CASE("groups in groups") {
  ImageBuilder b;
  b.atom_type(toggle("T"));
  for (const char* name : {"a", "c", "d"}) b.atom(name, "T");
  b.connector_type(plain("G", "p' (q r)", {"p", "q", "r"}));
  b.connector_type(plain("H", "(p q)' r", {"p", "q", "r"}));
  b.connector_type(plain("One", "p", {"p"}));
  b.connector("g", "G", {"a.go", "c.go", "d.go"});
  b.connector("h", "H", {"a.go", "c.go", "d.go"});
  b.connector("move", "One", {"d.go"});
  Core core(b.image());
  REQUIRE(core.initialize());
  CHECK(candidates(core) == Strings{"g: a.go c.go d.go", "h: a.go c.go d.go", "move: d.go"});
  REQUIRE(core.fire(std::uint64_t{2}));
  CHECK(candidates(core) == Strings{"g: a.go", "h: a.go c.go"});
}

TEST_CASE("without maximal progress every interaction is a candidate") {
  ImageBuilder b;
  b.atom_type(always_ready("T"));
  for (const char* name : {"a", "c", "d"}) b.atom(name, "T");
  b.connector_type(plain("B", "p' q r", {"p", "q", "r"}));
  b.connector("all", "B", {"a.p", "c.p", "d.p"});
  Core core(b.image(), {.progress = MaximalProgress::Off});
  REQUIRE(core.initialize());
  CHECK(candidates(core) == Strings{"all: a.p c.p d.p", "all: a.p c.p", "all: a.p d.p", "all: a.p"});
}

TEST_CASE("guards choose among subsets") {
  ImageBuilder b;
  b.atom_type(always_ready("T"));
  for (const char* name : {"a", "c", "d"}) b.atom(name, "T");
  ConnectorTypeSpec type = plain("B", "p' q r", {"p", "q", "r"});
  const Fn never = [](Cell*, Cell*, const u32*) { return 0; };
  type.clauses = {{.params = {"p", "q", "r"}, .guard = never}, {.params = {"p"}, .guard = never}};
  b.connector_type(type);
  b.connector("brd", "B", {"a.p", "c.p", "d.p"});
  Core core(b.image());
  REQUIRE(core.initialize());
  CHECK(candidates(core) == Strings{"brd: a.p c.p", "brd: a.p d.p"});
}

TEST_CASE("a guard over data is looked at again when the data moved") {
  ImageBuilder b;
  AtomTypeSpec counter = cell("C");
  counter.ports.push_back({.name = "inc", .vars = {}});
  counter.transitions.push_back({"inc", {"S"}, {"S"}, nullptr, [](Cell* self, Cell*, const u32*) {
                                   ++self[1].i;
                                   return 1;
                                 }});
  b.atom_type(counter);
  b.atom("a", "C", {1});
  b.atom("c", "C", {2});
  ConnectorTypeSpec type{
      .name = "Eq", .params = {{"l", 1}, {"r", 1}}, .define = "l r", .clauses = {}, .data = {}, .exported_data = {}};
  type.clauses = {{.params = {"l", "r"},
                   .guard = [](Cell*, Cell* all, const u32* bind) { return all[bind[0]].i == all[bind[1]].i ? 1 : 0; },
                   .down =
                       [](Cell*, Cell* all, const u32* bind) {
                         all[bind[0]].i = 7;
                         return 1;
                       }}};
  b.connector_type(type);
  b.connector_type(plain("One", "p", {"p"}));
  b.connector("eq", "Eq", {"a.p", "c.p"});
  b.connector("inc", "One", {"a.inc"});
  Core core(b.image());
  REQUIRE(core.initialize());
  CHECK(candidates(core) == Strings{"inc: a.inc"});
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(candidates(core) == Strings{"eq: a.p c.p", "inc: a.inc"});
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(core.cell(b.variable("a.x")).i == 7);
  CHECK(candidates(core) == Strings{"inc: a.inc"});
}

TEST_CASE("up and down through a hierarchy") {
  ImageBuilder b;
  b.atom_type(cell("C"));
  b.atom("a", "C", {5});
  b.atom("c", "C", {3});
  b.atom("d", "C", {9});
  ConnectorTypeSpec least{.name = "Min",
                          .params = {{"p", 1}, {"q", 1}},
                          .define = "p q",
                          .clauses = {},
                          .data = {"z"},
                          .exports = true,
                          .exported_data = {"z"}};
  least.clauses = {{.params = {"p", "q"},
                    .guard = nullptr,
                    .up =
                        [](Cell* self, Cell* all, const u32* bind) {
                          self[0].i = std::min(all[bind[0]].i, all[bind[1]].i);
                          return 1;
                        },
                    .down =
                        [](Cell* self, Cell* all, const u32* bind) {
                          all[bind[0]].i = self[0].i;
                          all[bind[1]].i = self[0].i;
                          return 1;
                        }}};
  b.connector_type(least);
  ConnectorTypeSpec top{
      .name = "Top", .params = {{"l", 1}, {"r", 1}}, .define = "l r", .clauses = {}, .data = {}, .exported_data = {}};
  top.clauses = {{.params = {"l", "r"},
                  .guard = [](Cell*, Cell* all, const u32* bind) { return all[bind[0]].i < all[bind[1]].i ? 1 : 0; },
                  .down =
                      [](Cell*, Cell* all, const u32* bind) {
                        all[bind[1]].i = all[bind[0]].i + 10;
                        all[bind[0]].i = 100;
                        return 1;
                      }}};
  b.connector_type(top);
  b.connector("min", "Min", {"a.p", "c.p"});
  b.connector("top", "Top", {"min", "d.p"});
  Core core(b.image());
  REQUIRE(core.initialize());
  REQUIRE(candidates(core) == Strings{"top: a.p c.p d.p"});
  std::vector<Participant> direct;
  core.direct_participants(core.candidate(0), direct);
  REQUIRE(direct.size() == 2);
  CHECK(direct[0].connector == 0);
  CHECK(core.cell(b.image().connectors[0].variable(0)).i == 3);
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(core.cell(b.variable("a.x")).i == 100);
  CHECK(core.cell(b.variable("c.x")).i == 100);
  CHECK(core.cell(b.variable("d.x")).i == 13);
  CHECK(candidates(core).empty());
}

TEST_CASE("through a compound's exported port only the maximal interactions are seen") {
  const Fn small_only = [](Cell* self, Cell* all, const u32* bind) {
    (void)self;
    return all[bind[0]].i == 1 ? 1 : 0;
  };
  for (const bool maximal : {false, true}) {
    ImageBuilder b;
    b.atom_type(always_ready("T"));
    for (const char* name : {"a", "c", "d"}) b.atom(name, "T");
    ConnectorTypeSpec inner = plain("In", "p' q", {"p", "q"});
    inner.exports = true;
    inner.data = {"n"};
    inner.exported_data = {"n"};
    const auto set = [](int n) {
      return [n](Cell* self, Cell*, const u32*) {
        self[0].i = n;
        return 1;
      };
    };
    inner.clauses = {{.params = {"p", "q"}, .up = set(2)}, {.params = {"p"}, .up = set(1)}};
    b.connector_type(inner);
    ConnectorTypeSpec outer{
        .name = "Out", .params = {{"i", 1}, {"r", 0}}, .define = "i r", .clauses = {}, .data = {}, .exported_data = {}};
    outer.clauses = {{.params = {"i", "r"}, .guard = small_only}};
    b.connector_type(outer);
    b.connector("in", "In", {"a.p", "c.p"});
    b.connector("out", "Out", {maximal ? "in!" : "in", "d.p"});
    Core core(b.image());
    REQUIRE(core.initialize());
    CHECK(candidates(core) == (maximal ? Strings{} : Strings{"out: a.p d.p"}));
  }
}

TEST_CASE("internal ports are candidates of their own, after the connectors") {
  ImageBuilder b;
  AtomTypeSpec type = toggle("T");
  type.ports.push_back({.name = "think", .vars = {}, .exported = false});
  type.transitions.push_back({"think", {"A"}, {"B"}});
  b.atom_type(type);
  b.atom("a", "T");
  b.connector_type(plain("One", "p", {"p"}));
  b.connector("k", "One", {"a.go"});
  Core core(b.image());
  REQUIRE(core.initialize());
  CHECK(candidates(core) == Strings{"k: a.go", "a.think"});
  REQUIRE(core.fire(std::uint64_t{1}));
  CHECK(candidates(core).empty());
}

TEST_CASE("internal transitions have absolute precedence") {
  ImageBuilder b;
  AtomTypeSpec type = toggle("T");
  type.data = {"n"};
  type.transitions = {{"go", {"A"}, {"B"}},
                      {"",
                       {"B"},
                       {"B"},
                       [](Cell* self, Cell*, const u32*) { return self[0].i < 5 ? 1 : 0; },
                       [](Cell* self, Cell*, const u32*) {
                         ++self[0].i;
                         return 1;
                       }},
                      {"", {"B"}, {"A"}, [](Cell* self, Cell*, const u32*) { return self[0].i == 5 ? 1 : 0; }}};
  b.atom_type(type);
  b.atom("a", "T");
  b.connector_type(plain("One", "p", {"p"}));
  b.connector("k", "One", {"a.go"});
  Core core(b.image());
  REQUIRE(core.initialize());
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(core.is_marked(0, 0));
  CHECK(core.cell(b.variable("a.n")).i == 5);
  CHECK(candidates(core) == Strings{"k: a.go"});
}

TEST_CASE("Petri nets: several tokens") {
  ImageBuilder b;
  AtomTypeSpec type{
      .name = "N",
      .params = {},
      .data = {},
      .ports = {{.name = "fork", .vars = {}},
                {.name = "l", .vars = {}},
                {.name = "r", .vars = {}},
                {.name = "join", .vars = {}}},
      .places = {"S", "L1", "R1", "L2", "R2"},
      .initial = {"S"},
      .transitions = {
          {"fork", {"S"}, {"L1", "R1"}}, {"l", {"L1"}, {"L2"}}, {"r", {"R1"}, {"R2"}}, {"join", {"L2", "R2"}, {"S"}}}};
  b.atom_type(type);
  b.atom("n", "N");
  b.connector_type(plain("One", "p", {"p"}));
  for (const char* port : {"fork", "l", "r", "join"}) b.connector(port, "One", {std::string("n.") + port});
  Core core(b.image());
  REQUIRE(core.initialize());
  CHECK(candidates(core) == Strings{"fork: n.fork"});
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(candidates(core) == Strings{"l: n.l", "r: n.r"});
  REQUIRE(core.fire(std::uint64_t{1}));
  CHECK(candidates(core) == Strings{"l: n.l"});
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(candidates(core) == Strings{"join: n.join"});
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(candidates(core) == Strings{"fork: n.fork"});
}

TEST_CASE("a trigger with 1000 synchrons, with and without guards") {
  for (const bool guarded : {false, true}) {
    ImageBuilder b;
    b.atom_type(toggle("T"));
    b.atom_type(always_ready("S"));
    b.atom("s", "S");
    ConnectorTypeSpec type = plain("B", "s'", {"s"});
    std::vector<std::string> ports{"s.p"};
    b.connector_type(plain("One", "p", {"p"}));
    for (int i = 0; i < 1000; ++i) {
      const std::string name = "r" + std::to_string(i);
      b.atom(name, "T");
      type.params.emplace_back(name, 0);
      type.define += " " + name;
      ports.push_back(name + ".go");
    }
    if (guarded) type.clauses = {{.params = {"s"}, .guard = [](Cell*, Cell*, const u32*) { return 0; }}};
    b.connector_type(type);
    b.connector("all", "B", ports);
    b.connector("one", "One", {"r7.back"});
    Core core(b.image());
    REQUIRE(core.initialize());
    REQUIRE(core.candidate_count() == 1);
    std::vector<Participant> who;
    core.participants(core.candidate(0), who);
    CHECK(who.size() == 1001);
    REQUIRE(core.fire(std::uint64_t{0}));
    // Guarded: alone the trigger may not fire.
    CHECK(core.candidate_count() == (guarded ? 1 : 2));
    REQUIRE(core.fire(core.candidate_count() - 1));
    CHECK(candidates(core)[0] == "all: s.p r7.go");
  }
}

TEST_CASE("snapshot and restore") {
  ImageBuilder b;
  b.atom_type(toggle("T"));
  b.atom_type(cell("C"));
  b.atom("a", "T");
  b.atom("c", "T");
  b.atom("x", "C", {4});
  b.connector_type(plain("One", "p", {"p"}));
  for (const char* port : {"a.go", "a.back", "c.go", "c.back"})
    b.connector(std::string("k_") + port[0] + "_" + (port + 2), "One", {port});
  Core core(b.image());
  REQUIRE(core.initialize());
  const State start = core.snapshot();
  const Strings first = candidates(core);
  REQUIRE(core.fire(std::uint64_t{0}));
  const State next = core.snapshot();
  const Strings second = candidates(core);
  CHECK(first != second);
  CHECK(!(start == next));
  REQUIRE(core.restore(start));
  CHECK(candidates(core) == first);
  REQUIRE(core.restore(next));
  CHECK(candidates(core) == second);
  CHECK(core.snapshot() == next);
  // Into a core that never ran.
  Core fresh(b.image());
  REQUIRE(fresh.restore(next));
  CHECK(candidates(fresh) == second);
}
