// Clerks who remember a number that somebody gave them, and serve only whom it means: proofs need to know what values
// come from outside.
#include "tests/verify/small_net.hpp"

#include "tools/gen/random.hpp"

namespace bip::verify::test {

// One or two clerks, two to four desks and users with numbers of their own. Users go round asking and being served by
// desks; a clerk takes an order and calls the desk that is meant. Now and then a guard compares differently, a clerk
// changes what it was told, forgets it, or a number means nobody.
std::string value_net(std::uint64_t seed) {
  gen::Prng random(seed);
  const std::size_t clerks = 1 + random.below(2), desks = 2 + random.below(2), users = 2 + random.below(3);
  const bool keeps = random.percent(30), has_idle = random.percent(40), forgets = random.percent(25),
             swaps = random.percent(20);
  const char* compare[] = {"==", "==", "==", "!=", "<=", ">"};
  const char* change[] = {
      "", "", "", "", " do { order = order + 1; }", " do { order = 1 - order; }", " do { order = 0; }"};
  std::string text =
      "package p\n  port type Signal()\n  port type Number(int v)\n  connector type One(Signal a)\n    define a\n  "
      "end\n"
      "  connector type Two(Signal a, Signal b)\n    define a b\n  end\n"
      "  connector type Give(Number giver, Number taker)\n    define giver taker\n    on giver taker down { taker.v = "
      "giver.v" +
      std::string(random.percent(15) ? " + 1" : "") + "; }\n  end\n" +
      "  connector type Call(Number a, Number b)\n    define a b\n    on a b provided (a.v " +
      compare[random.below(6)] + " b.v)\n  end\n" +
      "  connector type Swap(Number a, Number b)\n    define a b\n    on a b down { if (a.v > b.v) then a.v = b.v; "
      "else b.v = a.v; fi }\n  end\n";
  text += "  atom type Clerk()\n    data int order = " + number(random.below(2)) +
          "\n    export port Number take(order), call(order), swap(order)\n    export port Signal idle()\n" +
          "    place FREE, BUSY\n    initial to FREE\n    on take from FREE to BUSY" + change[random.below(7)] +
          "\n    on call from BUSY to FREE" + change[random.below(7)] + "\n" +
          (keeps ? "    on take from BUSY to BUSY\n" : "") +
          (has_idle ? "    on idle from FREE to FREE provided (order == 0)\n" : "    on idle from FREE to FREE\n") +
          "    on swap from BUSY to BUSY\n" + (forgets ? "    on idle from BUSY to FREE provided (order > 1)\n" : "") +
          "  end\n";
  text +=
      "  atom type Desk(int n)\n    data int id = n\n    export port Number call(id)\n    export port Signal serve(), "
      "done()\n    place FREE, READY, WORKS\n    initial to FREE\n"
      "    on call from FREE to READY\n    on serve from READY to WORKS\n    on done from WORKS to FREE\n  end\n";
  text +=
      "  atom type User(int n)\n    data int desk = n\n    export port Number ask(desk)\n    export port Signal "
      "serve(), done()\n    place HOME, WAITS, SITS\n    initial to HOME\n"
      "    on ask from HOME to WAITS\n    on serve from WAITS to SITS\n    on done from SITS to HOME\n  end\n";
  std::string components, connectors;
  for (std::size_t c = 0; c < clerks; ++c) components += "    component Clerk c" + number(c) + "()\n";
  for (std::size_t d = 0; d < desks; ++d) components += "    component Desk d" + number(d) + "(" + number(d) + ")\n";
  for (std::size_t u = 0; u < users; ++u) {
    const std::size_t desk = u % desks, wanted = random.percent(10) ? desks : desk;
    components += "    component User u" + number(u) + "(" + number(wanted) + ")\n";
    for (std::size_t c = 0; c < clerks; ++c) {
      if (c == 0 || random.percent(60))
        connectors +=
            "    connector Give ask" + number(u) + number(c) + "(u" + number(u) + ".ask, c" + number(c) + ".take)\n";
    }
    connectors += "    connector Two serve" + number(u) + "(u" + number(u) + ".serve, d" + number(desk) + ".serve)\n";
    connectors += "    connector Two done" + number(u) + "(u" + number(u) + ".done, d" + number(desk) + ".done)\n";
  }
  for (std::size_t c = 0; c < clerks; ++c) {
    for (std::size_t d = 0; d < desks; ++d) {
      if (random.percent(95))
        connectors +=
            "    connector Call call" + number(c) + number(d) + "(c" + number(c) + ".call, d" + number(d) + ".call)\n";
    }
    if (has_idle || forgets) connectors += "    connector One idle" + number(c) + "(c" + number(c) + ".idle)\n";
  }
  if (clerks == 2 && swaps) connectors += "    connector Swap swap(c0.swap, c1.swap)\n";
  return text + "  compound type Root()\n" + components + connectors + "  end\nend\n";
}

}  // namespace bip::verify::test
