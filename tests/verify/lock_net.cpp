// Users and locks: what small_net makes by luck needs an invariant once in a hundred proofs, this nearly always.
#include "tests/verify/small_net.hpp"

#include "tools/gen/random.hpp"

namespace bip::verify::test {

// Two or three users take one to three of two or three locks, one after the other and mostly in one order, and give
// them back at once or singly; some count their rounds modulo two and do every other one without locks.
std::string lock_net(std::uint64_t seed) {
  gen::Prng random(seed);
  const std::size_t users = 2 + random.below(2), locks = 2 + random.below(2);
  std::string types, connectors, components;
  for (std::size_t u = 0; u < users; ++u) {
    std::vector<std::size_t> wanted;
    for (std::size_t lock = 0; lock < locks; ++lock) {
      if (random.percent(70)) wanted.push_back(lock);
    }
    if (wanted.empty()) wanted.push_back(random.below(locks));
    if (random.percent(15)) random.shuffle(wanted);
    const bool counts = random.percent(25), gives_singly = random.percent(40);
    const std::size_t count = wanted.size();
    const std::string me = "u" + number(u);
    types += "  atom type U" + number(u) + "()\n" + (counts ? "    data bool odd = false\n" : "") +
             "    export port Signal rest()";
    for (std::size_t k = 0; k < count; ++k) types += ", take" + number(k) + "(), give" + number(k) + "()";
    types += "\n    place P0";
    const std::size_t places = gives_singly ? 2 * count : count + 1;
    for (std::size_t k = 1; k < places; ++k) types += ", P" + number(k);
    types += "\n    initial to P0\n";
    for (std::size_t k = 0; k < count; ++k) {
      types += "    on take" + number(k) + " from P" + number(k) + " to P" + number(k + 1) +
               (counts && k == 0 ? " provided (!odd)" : "") + "\n";
      connectors += "    connector Two " + me + "take" + number(k) + "(" + me + ".take" + number(k) + ", l" +
                    number(wanted[k]) + ".take)\n";
    }
    const std::string turn = counts ? " do { odd = true; }" : "";
    if (gives_singly) {
      for (std::size_t k = 0; k < count; ++k) {
        const bool is_last = k + 1 == count;
        types += "    on give" + number(k) + " from P" + number(count + k) + " to P" +
                 number(is_last ? 0 : count + k + 1) + (is_last ? turn : "") + "\n";
        connectors += "    connector Two " + me + "give" + number(k) + "(" + me + ".give" + number(k) + ", l" +
                      number(wanted[k]) + ".give)\n";
      }
    } else {
      types += "    on give0 from P" + number(count) + " to P0" + turn + "\n";
      const char* connector[] = {"Two", "Three", "Four"};
      connectors += std::string("    connector ") + connector[count - 1] + " " + me + "give(" + me + ".give0";
      for (std::size_t lock : wanted) connectors += ", l" + number(lock) + ".give";
      connectors += ")\n";
    }
    if (counts) {
      types += "    on rest from P0 to P0 provided (odd) do { odd = false; }\n";
      connectors += "    connector One " + me + "rest(" + me + ".rest)\n";
    }
    types += "  end\n";
    components += "    component U" + number(u) + " " + me + "()\n";
  }
  for (std::size_t lock = 0; lock < locks; ++lock) components += "    component Lock l" + number(lock) + "()\n";
  return "package p\n  port type Signal()\n  connector type One(Signal a)\n    define a\n  end\n  connector type "
         "Two(Signal a, Signal b)\n    define a b\n  end\n"
         "  connector type Three(Signal a, Signal b, Signal c)\n    define a b c\n  end\n  connector type Four(Signal "
         "a, Signal b, Signal c, Signal d)\n    define a b c d\n  end\n"
         "  atom type Lock()\n    export port Signal take(), give()\n    place FREE, TAKEN\n    initial to FREE\n    "
         "on take from FREE to TAKEN\n    on give from TAKEN to FREE\n  end\n" +
         types + "  compound type Root()\n" + components + connectors + "  end\nend\n";
}

}  // namespace bip::verify::test
