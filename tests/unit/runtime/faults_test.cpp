// Each run-time error, with what its message names.
#include <catch2/catch.hpp>

#include <limits>

#include "tests/unit/runtime/helpers.hpp"

using namespace bip::rt;
using namespace bip::rt::testing;

namespace {

// One atom of the type with a connector on its port p; fires until a fault.
std::string fault_of(ImageBuilder& b, const AtomTypeSpec& type, FaultCode expected, CoreOptions options = {}) {
  b.atom_type(type);
  b.connector_type({.name = "One", .params = {{"p", 0}}, .define = "p"});
  b.atom("a", type.name);
  b.connector("k", "One", {"a.p"});
  Core core(b.image(), options);
  bool sound = core.initialize();
  for (int i = 0; i < 5 && sound; ++i) {
    REQUIRE(core.candidate_count() > 0);
    sound = core.fire(std::uint64_t{0});
  }
  CHECK(!sound);
  CHECK(core.fault().code == expected);
  return fault_text(core, 42, 1);
}
const Fn kAlways = [](Cell*, Cell*, const u32*) { return 1; };

}  // namespace

TEST_CASE("R0001 two transitions of a port") {
  ImageBuilder b;
  CHECK(fault_of(b,
                 {.name = "T",
                  .data = {"n"},
                  .ports = {{.name = "p"}},
                  .places = {"A", "B"},
                  .initial = {"A"},
                  .transitions = {{"p", {"A"}, {"B"}}, {"p", {"B"}, {"A"}, kAlways}, {"p", {"B"}, {"B"}, kAlways}}},
                 FaultCode::TwoTransitions) ==
        "error[R0001]: two transitions of port `p` are enabled in `ROOT.a` at `B`   (step 1, seed 42)\n"
        "  --> test.bip:3:5\n"
        "  --> test.bip:4:5\n"
        "  data: n = 0\n");
}

TEST_CASE("R0002 two internal transitions") {
  ImageBuilder b;
  const std::string text = fault_of(b,
                                    {.name = "T",
                                     .ports = {{.name = "p"}},
                                     .places = {"A", "B"},
                                     .initial = {"A"},
                                     .transitions = {{"p", {"A"}, {"B"}}, {"", {"B"}, {"A"}}, {"", {"B"}, {"B"}}}},
                                    FaultCode::TwoInternals);
  CHECK(text.find("error[R0002]: two internal transitions are enabled in `ROOT.a` at `B`") == 0);
}

TEST_CASE("R0003 not 1-safe") {
  ImageBuilder b;
  const std::string text = fault_of(b,
                                    {.name = "T",
                                     .ports = {{.name = "p"}},
                                     .places = {"A", "B"},
                                     .initial = {"A", "B"},
                                     .transitions = {{"p", {"A"}, {"B"}}}},
                                    FaultCode::NotOneSafe);
  CHECK(text.find("error[R0003]: port `p` puts a second token on `B` in `ROOT.a` at `B`") == 0);
}

TEST_CASE("a place in both sets stays marked") {
  ImageBuilder b;
  b.atom_type({.name = "T",
               .ports = {{.name = "p"}},
               .places = {"A", "B"},
               .initial = {"A"},
               .transitions = {{"p", {"A"}, {"A", "B"}}}});
  b.connector_type({.name = "One", .params = {{"p", 0}}, .define = "p"});
  b.atom("a", "T");
  b.connector("k", "One", {"a.p"});
  Core core(b.image());
  REQUIRE(core.initialize());
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(core.is_marked(0, 0));
  CHECK(core.is_marked(0, 1));
}

TEST_CASE("R0004 internal transitions without end") {
  ImageBuilder b;
  const std::string text = fault_of(b,
                                    {.name = "T",
                                     .ports = {{.name = "p"}},
                                     .places = {"A", "B"},
                                     .initial = {"A"},
                                     .transitions = {{"p", {"A"}, {"B"}}, {"", {"B"}, {"B"}}}},
                                    FaultCode::EndlessInternals, {.internal_bound = 1000});
  CHECK(text.find("internal transitions run on without end in `ROOT.a` at `B` (bound 1000)") != std::string::npos);
}

TEST_CASE("R0005 and R0006 from a guard, an action and a transfer") {
  ImageBuilder b;
  const std::int32_t zero = b.fault(FaultKind::DivisionByZero);
  const std::string text =
      fault_of(b,
               {.name = "T",
                .ports = {{.name = "p"}},
                .places = {"A"},
                .initial = {"A"},
                .transitions = {{"p", {"A"}, {"A"}, nullptr, [zero](Cell*, Cell*, const u32*) { return zero; }}}},
               FaultCode::DivisionByZero);
  CHECK(text.find("error[R0005]: division by zero in `ROOT.a` at `A`, port `p`") == 0);
  CHECK(text.find("--> test.bip:77:9") != std::string::npos);

  ImageBuilder c;
  (void)c.fault(FaultKind::DivisionByZero);
  const std::int32_t overflow = c.fault(FaultKind::DivisionOverflow);
  const std::string second =
      fault_of(c,
               {.name = "T",
                .ports = {{.name = "p"}},
                .places = {"A"},
                .initial = {"A"},
                .transitions = {{"p", {"A"}, {"A"}, [overflow](Cell*, Cell*, const u32*) { return overflow; }}}},
               FaultCode::DivisionOverflow);
  CHECK(second.find("error[R0006]: the smallest int divided by -1 in `ROOT.a`") == 0);

  ImageBuilder d;
  const std::int32_t in_down = d.fault(FaultKind::DivisionByZero);
  d.atom_type({.name = "T",
               .data = {"x"},
               .ports = {{.name = "p", .vars = {"x"}}},
               .places = {"A"},
               .initial = {"A"},
               .transitions = {{"p", {"A"}, {"A"}}}});
  d.connector_type({.name = "One",
                    .params = {{"p", 1}},
                    .define = "p",
                    .clauses = {{.params = {"p"}, .down = [in_down](Cell*, Cell*, const u32*) { return in_down; }}}});
  d.atom("a", "T");
  d.connector("k", "One", {"a.p"});
  Core core(d.image());
  REQUIRE(core.initialize());
  const State start = core.snapshot();
  CHECK(!core.fire(std::uint64_t{0}));
  CHECK(core.fault().what == "division by zero in connector `ROOT.k`");
  CHECK(core.fault().data == "p.v = 0");
  REQUIRE(core.restore(start));
  CHECK(core.candidate_count() == 1);
}

TEST_CASE("R0009 too many interactions to enumerate") {
  ImageBuilder b;
  b.atom_type(always_ready("T"));
  ConnectorTypeSpec type{.name = "B"};
  std::vector<std::string> ports;
  for (int i = 0; i < 40; ++i) {
    const std::string n = std::to_string(i);
    b.atom("a" + n, "T");
    type.params.emplace_back("p" + n, 0);
    type.define += "p" + n + "' ";
    ports.push_back("a" + n + ".p");
  }
  b.connector_type(type);
  b.connector("k", "B", ports);
  Core core(b.image(), {.progress = MaximalProgress::Off});
  CHECK(!core.initialize());
  CHECK(core.fault().code == FaultCode::TooManyInteractions);
  CHECK(core.fault().what == "too many interactions to enumerate in connector `ROOT.k` (bound 65536)");
}
