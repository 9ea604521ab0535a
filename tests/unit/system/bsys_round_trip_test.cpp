// .bsys round trips: every table comes back, broken text is refused at its place, deep code costs no stack.
#include <catch2/catch.hpp>

#include "compiler/system/bsys.hpp"
#include "compiler/system/bsys_text.hpp"
#include "tests/unit/system/bsys_sample.hpp"

using namespace bip;

namespace {

std::string error_of(const std::string& text) {
  const Result<System> result = system::parse_bsys(text);
  return result ? "accepted" : result.error();
}
/// `text` with the first `what` replaced.
std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), with);
}

}  // namespace

TEST_CASE("the sample is sound") {
  for (const std::string& problem : system::validate(test::make_sample_system())) FAIL_CHECK(problem);
}

TEST_CASE("print, parse, print gives the same text") {
  const System sample = test::make_sample_system();
  const std::string text = system::print(sample);
  CAPTURE(text);
  const Result<System> again = system::parse_bsys(text);
  if (!again) FAIL(again.error());
  CHECK(system::print(*again) == text);
  CHECK(system::validate(*again).empty());
}

TEST_CASE("tables come back as they were") {
  const System a = test::make_sample_system();
  const Result<System> parsed = system::parse_bsys(system::print(a));
  REQUIRE(parsed);
  const System& b = *parsed;
  CHECK(b.files == a.files);
  CHECK(b.code.strings == a.code.strings);
  CHECK(b.port_types[PortTypeId(1u)].variables[1].name == "w");
  CHECK(b.port_types[PortTypeId(2u)].name == "?3");
  CHECK(b.atom_types[AtomTypeId(0u)].variables[1].exported);
  CHECK(b.atom_types[AtomTypeId(0u)].variables[0].is_param);
  CHECK(b.atom_types[AtomTypeId(0u)].transitions[1].port == Transition::kInternal);
  CHECK(b.atom_types[AtomTypeId(0u)].transitions[0].loc == Loc{0, 17, 3});
  CHECK(b.connector_types[ConnectorTypeId(0u)].params[2].first_bind == 3);
  CHECK(b.connector_types[ConnectorTypeId(0u)].define[1].children == std::vector<std::uint32_t>{2, 3, 4});
  CHECK(b.connector_types[ConnectorTypeId(0u)].define[2].trigger);
  CHECK(b.atoms[AtomId(1u)].args == a.atoms[AtomId(1u)].args);
  CHECK(b.connectors[ConnectorId(2u)].ports[0].maximal_only);
  CHECK(b.connectors[ConnectorId(0u)].data == a.connectors[ConnectorId(0u)].data);
  CHECK(b.connectors[ConnectorId(0u)].bound);
  CHECK(b.choices == a.choices);
  CHECK(b.connectors[ConnectorId(5u)].ports == a.connectors[ConnectorId(5u)].ports);
  CHECK(b.atom_types[AtomTypeId(0u)].priorities[1].low == AtomPriority::kAnyPort);
  CHECK(b.atom_types[AtomTypeId(0u)].invariants[1].places == std::vector<std::uint32_t>{0, 2});
  CHECK(b.atom_types[AtomTypeId(1u)].merged[0].ports == std::vector<std::uint32_t>{1, 2});
  CHECK(b.priorities[PriorityId(0u)].low == a.priorities[PriorityId(0u)].low);
  CHECK(b.priorities[PriorityId(2u)].low.any_connector);
}

TEST_CASE("what the text must not say, and where it says it") {
  const std::string text = system::print(test::make_sample_system());
  CHECK(error_of("") == "1:1: expected `(bsys 1)`");
  CHECK(error_of("(bsys 2)") == "1:1: the first row is `(bsys 1)`");
  CHECK(error_of("(bsys 1)\n(bsys 1)") == "2:1: no row begins with this word");
  CHECK(error_of("(bsys 1)") == "1:1: there is no root compound");
  CHECK(error_of("(bsys 1)\n  (file 0 \"a") == "2:11: string does not end on its line");
  CHECK(error_of("(bsys 1))") == "1:9: `)` without `(`");
  CHECK(error_of("(bsys 1)\n(compound 1 ROOT T)") == "2:11: this row's number is 0");
  CHECK(error_of("(bsys 1) ; a comment\n(compound 0 ROOT T)") == "accepted");
  CHECK(error_of(replaced(text, "0:Worker", "0:Walker")).find("the name after `:`") != std::string::npos);
  CHECK(error_of(replaced(text, "0:Worker", "0")) == "accepted");
  CHECK(error_of(replaced(text, "0:Worker", "9:Worker")).find("out of range") != std::string::npos);
  CHECK(error_of(replaced(text, "(args -5)", "(args 5000000000)")).find("expected a constant") != std::string::npos);
  CHECK(error_of(replaced(text, "(args -5)", "(args 5.0)")).find("an argument has not its parameter's type") !=
        std::string::npos);
  CHECK(error_of(replaced(text, " bound", "")).find("`bound` is wrong") != std::string::npos);
  CHECK(error_of(replaced(text, "(params 0:a 3)", "(params 0:a)")).find("no interaction") != std::string::npos);
  CHECK(error_of(replaced(text, "(lt ", "(below ")).find("no operator has this name") != std::string::npos);
  CHECK(error_of(replaced(text, "(set 1:x", "(set 0:n")).find("read-only") != std::string::npos);
}

TEST_CASE("nesting is limited, not the stack") {
  const auto nested = [](std::size_t depth) {
    std::string text =
        "(bsys 1)\n(compound 0 ROOT T)\n(atom-type 0 A (place 0 p) (initial 0) (transition 0 (from 0) (to 0) (guard ";
    for (std::size_t k = 0; k < depth; ++k) text += "(not ";
    text += "true" + std::string(depth, ')');
    return text + ")))\n";
  };
  const Result<System> deep = system::parse_bsys(nested(system::text::kMaxCodeDepth));
  if (!deep) FAIL(deep.error());
  CHECK(system::parse_bsys(system::print(*deep)));
  CHECK(error_of(nested(system::text::kMaxCodeDepth + 1)).find("nested too deep") != std::string::npos);
  CHECK(error_of(nested(1'000'000)).find("nested deeper than") != std::string::npos);
}

TEST_CASE("a wide text costs linear time") {
  std::string text = "(bsys 1)\n(compound 0 ROOT T)\n(atom-type 0 A (place 0 p) (initial 0))\n";
  for (int k = 0; k < 100'000; ++k)
    text += "(atom " + std::to_string(k) + " ROOT.a[" + std::to_string(k) + "] 0:A (in 0:ROOT))\n";
  Result<System> wide = system::parse_bsys(text);
  REQUIRE(wide);
  CHECK(wide->atoms.size() == 100'000);
  CHECK(system::parse_bsys(system::print(*wide)));
}
