// A monitor that counts its clients by an int: proofs need equations between data and places.
#include "tests/verify/small_net.hpp"

#include "tools/gen/random.hpp"

namespace bip::verify::test {

// Clients come and go, the monitor counts them, by its own actions or by transfers; others are let in alone, while
// nobody is counted. Now and then a step counts wrongly, twice, by a variable, in a second int, only by some way
// through an `if`, or a guard asks something else; then the sum is another one, or none. A last look after each leaving
// may set the count anew.
std::string counter_net(std::uint64_t seed) {
  gen::Prng random(seed);
  const std::size_t clients = 2 + random.below(3);
  const bool carries = random.percent(40), looks = random.percent(40);
  const std::string up =
      random.pick<std::string>({"n = n + 1;", "n = n + 1;", "n = n + 2;", "n = n + step;", "n = n + 1; m = m + 1;",
                                "m = n; n = m + 1;", "if (flag) then n = n + 1; else n = n + 1; m = m + 0; fi"});
  const std::string down =
      random.pick<std::string>({"n = n - 1;", "n = n - 1;", "n = n - 2;", "n = n - step;", "n = n - 1; m = m - 1;",
                                "flag = !flag; n = n - 1;", "if (flag) then n = n - 1; else n = n - 2; n = n + 1; fi"});
  const std::string may_leave = random.pick<std::string>({"n > 0", "n > 0", "n != 0", "n >= step", "true"});
  const std::string is_empty = random.pick<std::string>({"n == 0", "n == 0", "n <= 0", "n < 1"});
  const std::string type = carries ? "Number" : "Signal", value = carries ? "(n)" : "()",
                    one = carries ? "(one)" : "()";
  std::string text =
      "package p\n  port type Signal()\n  port type Number(int v)\n  connector type Two(Signal a, Signal b)\n    "
      "define a b\n  end\n";
  for (const bool adds : {true, false}) {
    text += std::string("  connector type ") + (adds ? "Add" : "Take") +
            "(Number a, Number b)\n    define a b\n    on a b down { a.v = a.v " + (adds ? "+ " : "- ") +
            random.pick<std::string>({"1", "1", "b.v", "(2 - 1)"}) + "; }\n  end\n";
  }
  text += "  atom type Monitor()\n    data int n = 0\n    data int m = " + number(random.below(3)) +
          "\n    data int step = 1\n    data bool flag = false\n    export port " + type + " enter" + value +
          ", leave" + value + "\n    export port Signal close(), open()\n    place OPEN, CLOSED" +
          (looks ? ", LOOKS" : "") + "\n    initial to OPEN\n" + "    on enter from OPEN to OPEN" +
          (random.percent(30) ? " provided (n < " + number(clients) + ")" : "") + " do { " + (carries ? "m = m;" : up) +
          " }\n" + "    on leave from OPEN to " + (looks ? "LOOKS" : "OPEN") + " provided (" + may_leave + ") do { " +
          (carries ? "m = m;" : down) + " }\n";
  if (looks) {
    text +=
        "    internal from LOOKS to OPEN provided (n != 0)\n    internal from LOOKS to OPEN provided (n == 0) do { " +
        random.pick<std::string>({"n = 0;", "m = 0;", "n = n;", "n = m;"}) + " }\n";
  }
  text += "    on close from OPEN to CLOSED provided (" + is_empty + ")" +
          random.pick<std::string>({"", " do { n = 0; }", " do { m = 0; }"}) + "\n    on open from CLOSED to OPEN" +
          random.pick<std::string>({"", "", " do { n = 0; }"}) + "\n  end\n";
  text += "  atom type Client()\n    data int one = 1\n    export port " + type + " start" + one + ", stop" + one +
          "\n    place AWAY, HERE\n    initial to AWAY\n    on start from AWAY to HERE\n    on stop from HERE to "
          "AWAY\n  end\n"
          "  atom type Guest()\n    export port Signal start(), stop()\n    place AWAY, HERE\n    initial to AWAY\n    "
          "on start from AWAY to HERE\n    on stop from HERE to AWAY\n  end\n";
  const std::string enters = carries ? "Add" : "Two", leaves = carries ? "Take" : "Two", count = number(clients);
  return text + "  compound type Root()\n    component Monitor mon()\n    component Client c[" + count +
         "]()\n    component Guest g[2]()\n    for i in 0.." + count + " connector " + enters +
         " enter[i](mon.enter, c[i].start)\n    for i in 0.." + count + " connector " + leaves +
         " leave[i](mon.leave, c[i].stop)\n" +
         "    for i in 0..2 connector Two close[i](mon.close, g[i].start)\n    for i in 0..2 connector Two "
         "open[i](mon.open, g[i].stop)\n  end\nend\n";
}

}  // namespace bip::verify::test
