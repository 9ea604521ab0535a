// See small_net.hpp.
#include "tests/verify/small_net.hpp"

#include "tools/gen/random.hpp"

namespace bip::verify::test {

// Atoms of up to four places, connectors of two or three with and without triggers, one level of hierarchy.
std::string small_net(std::uint64_t seed) {
  gen::Prng random(seed);
  gen::Prng ends(seed ^ 0x656e6473u);
  const auto below = [&](std::uint64_t n) { return random.below(n); };
  const std::uint64_t types = 2 + below(2), atoms = 2 + below(4);
  std::string text = "package p\n  port type Signal()\n";
  text += "  connector type Two(Signal a, Signal b)\n    define a b\n  end\n";
  text += "  connector type Cast(Signal a, Signal b, Signal c)\n    define a' b c\n  end\n";
  text += "  connector type Both(Signal a, Signal b)\n    define a' b'\n  end\n";
  text += "  connector type Inner(Signal a, Signal b)\n    export port Signal e()\n    define a' b\n  end\n";
  text += "  connector type Nested(Signal a, Signal b, Signal c)\n    define (a b)' c\n  end\n";
  for (std::uint64_t t = 0; t < types; ++t) {
    const std::uint64_t places = 2 + below(3);
    text += "  atom type A" + number(t) + "()\n    export port Signal p(), q(), r()\n    place P0";
    for (std::uint64_t k = 1; k < places; ++k) text += ", P" + number(k);
    text += "\n    initial to P0\n";
    // Of half of all seeds: what is a deadlock then depends on where the atoms are.
    for (std::uint64_t k = 0; k < places && seed % 2 == 0; ++k) {
      if (ends.percent(60)) text += "    final P" + number(k) + "\n";
    }
    for (const char* port : {"p", "q", "r"}) {
      // One transition a port and place at most.
      for (std::uint64_t k = 0; k < places; ++k) {
        if (below(10) < 5)
          text += std::string("    on ") + port + " from P" + number(k) + " to P" + number(below(places)) + "\n";
      }
      text += std::string("    on ") + port + " from P0 to P" + number(below(places)) + " provided (false)\n";
    }
    text += "  end\n";
  }
  text += "  compound type Root()\n";
  for (std::uint64_t a = 0; a < atoms; ++a)
    text += "    component A" + number(below(types)) + " a" + number(a) + "()\n";
  const char* ports[] = {"p", "q", "r"};
  const auto distinct = [&](std::uint64_t count, std::uint64_t first) {
    std::string list;
    for (std::uint64_t k = 0; k < count; ++k)
      list += (k != 0 ? ", a" : "a") + number((first + k) % atoms) + "." + ports[below(3)];
    return list;
  };
  for (std::uint64_t k = 0; k < 3 + below(5); ++k) {
    const std::uint64_t first = below(atoms);
    const std::string c = "c" + number(k);
    switch (below(atoms >= 3 ? 5 : 2)) {
      case 0: text += "    connector Two " + c + "(" + distinct(2, first) + ")\n"; break;
      case 1: text += "    connector Both " + c + "(" + distinct(2, first) + ")\n"; break;
      case 2: text += "    connector Cast " + c + "(" + distinct(3, first) + ")\n"; break;
      case 3: text += "    connector Nested " + c + "(" + distinct(3, first) + ")\n"; break;
      default:
        text += "    connector Inner i" + number(k) + "(" + distinct(2, first) + ")\n";
        text += "    connector Two " + c + "(i" + number(k) + ".e, " + distinct(1, first + 2) + ")\n";
    }
  }
  return text + "  end\nend\n";
}

}  // namespace bip::verify::test
