// See level_net.hpp.
#include "tests/verify/level_net.hpp"

#include <iterator>

#include "tests/verify/small_net.hpp"
#include "tools/gen/random.hpp"

namespace bip::verify::test {

LevelNet level_net(std::uint64_t seed) {
  gen::Prng random(seed);
  // The first of each is the filter lock's.
  const auto one_of = [&](auto... texts) {
    const char* const all[] = {texts...};
    return std::string(random.percent(75) ? all[0] : all[random.below(std::size(all))]);
  };
  const std::uint64_t processes = 2 + random.below(2);
  const std::uint64_t levels = random.percent(80) ? processes - 1 : 1 + random.below(processes);
  const std::string n = number(processes), last = number(levels);
  const std::string entered = one_of("process.me", "process.me", "process.next", "level.last + 1", "process.me - 1");
  LevelNet net;
  net.text =
      "package p\n  port type Signal()\n  port type See(int me, int level, int next)\n"
      "  port type Show(int me, int level)\n  port type Last(int level, int last)\n"
      "  connector type One(Signal a)\n    define a\n  end\n"
      "  connector type Enter(See process, Last level)\n    define process level\n    on process level provided (" +
      one_of("process.level == level.level", "process.level >= level.level", "true") +
      ") down { level.last = " + entered + "; " + one_of("", "process.level = level.level;", "process.next = 0;") +
      " }\n  end\n  connector type Overtaken(See process, Last level)\n    define process level\n"
      "    on process level provided (" +
      one_of("process.level == level.level && level.last != process.me", "level.last != process.me",
             "process.level == level.level", "process.level == level.level && level.last > process.me") +
      ")\n  end\n  connector type Look(See process, Show other)\n    define process other\n"
      "    on process other provided (" +
      one_of("other.me == process.next && other.level < process.level", "other.me == process.next",
             "other.level < process.level", "other.me == process.next && other.level <= process.level",
             "!(other.me != process.next || other.level >= process.level)") +
      ")\n  end\n"
      "  atom type Process(int me, int n)\n    data int self = me, level = 0, next = (me + 1) % n\n"
      "    export port Signal ask(), leave()\n"
      "    export port See enter(self, level, next), overtaken(self, level, next), look(self, level, next)\n"
      "    export port Show show(self, level)\n    place OUTSIDE, ENTERS, LOOKS, PASSES, CRITICAL\n"
      "    initial to OUTSIDE\n    on ask from OUTSIDE to ENTERS do { level = 1; }\n"
      "    on enter from ENTERS to LOOKS do { next = (self + 1) % n; }\n"
      "    on look from LOOKS to LOOKS do { next = " +
      one_of("(next + 1) % n", "(next + 1) % n", "(next + 2) % n", "self - next") +
      "; }\n    on overtaken from LOOKS to PASSES\n    internal from LOOKS to PASSES provided (next == self)\n"
      "    internal from PASSES to ENTERS provided (level < " +
      last +
      ") do { level = level + 1; next = (self + 1) % n; }\n    internal from PASSES to CRITICAL provided (level >= " +
      last + ") do { next = (self + 1) % n; }\n    on leave from CRITICAL to OUTSIDE do { level = 0; }\n" +
      (random.percent(10) ? "" : "    on show from OUTSIDE to OUTSIDE\n") +
      "    on show from ENTERS to ENTERS\n    on show from LOOKS to LOOKS\n    on show from CRITICAL to CRITICAL\n  "
      "end\n"
      "  atom type Level(int number)\n    data int level = number, last = " +
      one_of("-1", "0") +
      "\n    export port Last enter(level, last), overtaken(level, last)\n    place L\n    initial to L\n"
      "    on enter from L to L\n    on overtaken from L to L\n  end\n"
      "  compound type Root()\n    for i in 0.." +
      n + " component Process process[i](i, " + n + ")\n    for k in 1.." + number(levels + 1) +
      " component Level level[k - 1](k)\n    for i in 0.." + n + " {\n" +
      (random.percent(90) ? "      connector One ask[i](process[i].ask)\n" : "") +
      "      connector One leave[i](process[i].leave)\n      for k in 1.." + number(levels + 1) +
      " {\n        connector Enter enter[i * " + n +
      " + k](process[i].enter, level[k - 1].enter)\n        connector "
      "Overtaken overtaken[i * " +
      n + " + k](process[i].overtaken, level[k - 1].overtaken)\n      }\n      for k in 1.." + n +
      " connector Look look[i * " + n + " + k](process[i].look, process[(i + k) % " + n +
      "].show)\n    }\n  end\nend\n";
  const std::string top = "level[" + number(levels - 1) + "]";
  net.properties = {"never process[0]@CRITICAL && process[1]@CRITICAL",
                    "never process[" + number(processes - 1) + "]@CRITICAL && process[0]@CRITICAL",
                    "never process[0]@CRITICAL && " + top + ".last == -1",
                    "never process[0]@CRITICAL && process[1]@LOOKS",
                    "never process[0]@CRITICAL && process[1]@LOOKS && " + top + ".last == 0",
                    "always " + top + ".last < " + number(processes - random.below(2)),
                    "always process[0].next >= 0 && process[0].level <= " + number(levels),
                    "never process[0]@LOOKS && process[0].next == 0",
                    "never process[1]@LOOKS && process[1].level == process[0].level && " + top +
                        ".last == 1 && can process[0].leave"};
  return net;
}

}  // namespace bip::verify::test
