// The AIGER text of a transition system: latches by initial value, numbering, symbols.
#include "compiler/verify/symbolic/aiger.hpp"

#include <catch2/catch.hpp>

#include <sstream>

#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

const char* const kSwitch = R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Switch()
    export port Signal flip()
    place OFF, ON
    initial to OFF
    on flip from OFF to ON
  end
  compound type Root()
    component Switch s()
    connector One f(s.flip)
  end
end
)";

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace

TEST_CASE("aiger: a latch of 1 is negated, one without an initial value is its own reset") {
  const test::HandMadeNet made(kSwitch);
  TransitionSystem system = build_transition_system(*made.compiled.system, made.compiled.lowered->image);
  REQUIRE(system.bits.size() == 2);
  REQUIRE(system.bits[0].initial == 1);
  REQUIRE(system.bits[1].initial == 0);
  // One input (the step), then two latches. The output is the place OFF, whose latch is negated.
  std::vector<std::string> lines = lines_of(aiger_text(system, system.bits[0].now, *made.compiled.system));
  const std::string sizes = lines[0].substr(lines[0].find(' '));
  CHECK(lines[0].rfind("aag ", 0) == 0);
  CHECK(sizes.find(" 1 2 1 ") != std::string::npos);
  CHECK(lines[1] == "2");
  CHECK(lines[2].rfind("4 ", 0) == 0);
  CHECK(std::count(lines[2].begin(), lines[2].end(), ' ') == 1);
  CHECK(lines[4] == "5");
  CHECK(lines[lines.size() - 3] == "l0 not ROOT.s@OFF");
  CHECK(lines[lines.size() - 2] == "l1 ROOT.s@ON");
  CHECK(lines.back() == "o0 bad");

  system.bits[1].initial = -1;
  lines = lines_of(aiger_text(system, system.bits[0].now, *made.compiled.system));
  CHECK(lines[3].rfind("6 ", 0) == 0);
  CHECK(lines[3].substr(lines[3].rfind(' ')) == " 6");
}

TEST_CASE("aiger: gates come after their operands, the larger one first") {
  const test::HandMadeNet made(test::lock_and_users());
  TransitionSystem system = build_transition_system(*made.compiled.system, made.compiled.lowered->image);
  const std::vector<std::string> lines = lines_of(aiger_text(system, system.stuck, *made.compiled.system));
  std::istringstream head(lines[0].substr(4));
  std::size_t variables = 0, inputs = 0, latches = 0, outputs = 0, gates = 0;
  head >> variables >> inputs >> latches >> outputs >> gates;
  REQUIRE(gates > 5);
  CHECK(variables == inputs + latches + gates);
  CHECK(latches == system.bits.size());
  const std::size_t first_gate = 1 + inputs + latches + outputs;
  for (std::size_t k = 0; k < gates; ++k) {
    std::istringstream row(lines[first_gate + k]);
    std::size_t gate = 0, left = 0, right = 0;
    row >> gate >> left >> right;
    CHECK(gate == 2 * (inputs + latches + k + 1));
    CHECK(left < gate);
    CHECK(right <= left);
  }
}

}  // namespace bip::verify
