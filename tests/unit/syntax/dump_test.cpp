// The dump, as goldens rely on it.
#include <catch2/catch.hpp>

#include "tests/unit/parse/parsed.hpp"

using namespace bip;
using test::Parsed;

TEST_CASE("a node a line with its range") {
  Parsed p(
      "package p\n  port type P(int d)\n  atom type N()\n    place A\n    initial to A do { x = 1 + 2 * 3; }\n  "
      "end\nend\n");
  CHECK(syntax::dump(*p.syntax, p.sources) ==
        "Package @1:1-8:1 p\n"
        "  PortType @2:3-2:21 P(int d)\n"
        "  AtomType @3:3-6:6 N()\n"
        "    Place @4:11-4:12 A\n"
        "    Initial @5:5-5:39 (A)\n"
        "      Do @5:21-5:39\n"
        "        Assign @5:23-5:36 x = (1 + (2 * 3))\n");
}
