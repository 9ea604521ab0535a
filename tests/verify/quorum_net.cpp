// See quorum_net.hpp.
#include "tests/verify/quorum_net.hpp"

#include <iterator>

#include "tests/verify/small_net.hpp"
#include "tools/gen/random.hpp"

namespace bip::verify::test {

namespace {

// A guard of a connector between a candidate and a voter; most let a voter answer a candidate once.
const char* const kGuards[] = {
    "v.a < c.id",  "v.a < c.id", "v.a <= c.id", "v.a == 0", "v.a == 0 && v.b < c.id", "v.a == c.id && v.b == 0",
    "v.b != c.id", "true"};
const char* const kTransfers[] = {"v.a = c.id;",
                                  "v.a = c.id;",
                                  "v.a = c.id; if (v.b > c.best) then c.best = v.b; fi",
                                  "v.a = c.id; v.b = c.id;",
                                  "v.b = c.id;",
                                  "v.a = c.id; c.best = v.b;",
                                  "v.b = c.best; v.a = c.id;"};

}  // namespace

QuorumNet quorum_net(std::uint64_t seed) {
  gen::Prng random(seed);
  const std::uint64_t voters = 2 + random.below(4), candidates = 1 + random.below(2);
  const std::uint64_t least = 1 + random.below(voters);
  const bool is_petri = random.percent(15);
  QuorumNet net;
  std::string& text = net.text;
  text =
      "package p\n  port type Ask(int id, int best)\n  port type Vote(int a, int b)\n"
      "  connector type One(Vote v)\n    define v\n  end\n"
      "  connector type Two(Vote v, Vote w)\n    define v w\n    on v w provided (v.a > w.a) down { w.a = v.a; }\n  "
      "end\n";
  const std::uint64_t kinds = 1 + random.below(2);
  for (std::uint64_t k = 0; k < kinds; ++k) {
    text += "  connector type Poll" + number(k) + "(Ask c, Vote v)\n    define c" + (random.percent(15) ? "'" : "") +
            " v\n    on c v provided (" + kGuards[random.below(std::size(kGuards))] + ") down { " +
            kTransfers[random.below(std::size(kTransfers))] + " }\n  end\n";
  }
  // A voter may leave, and come back.
  text += "  atom type Voter()\n    data int a = 0, b = 0\n    export port Vote p(a, b), q(a, b)\n    place IN, OUT" +
          std::string(is_petri ? ", SEEN" : "") + "\n    initial to IN" + (is_petri ? ", SEEN" : "") +
          "\n    on p from IN to IN\n    on q from IN to " + (random.percent(50) ? "OUT" : "IN") +
          (random.percent(20) ? " do { b = (b + 1) % 3; }" : "") + "\n";
  if (random.percent(30)) text += "    on q from OUT to IN\n";
  if (random.percent(20)) text += "    internal from OUT to IN provided (b == 1) do { b = 2; }\n";
  text += "  end\n";
  text +=
      "  atom type Candidate(int number, int least)\n    data int id = number, best = 0, votes = 0\n"
      "    export port Ask p(id, best), q(id, best)\n    place ASKS, COUNTS, WON\n    initial to ASKS\n"
      "    on p from ASKS to ASKS provided (votes < least - 1) do { votes = votes + 1; }\n";
  const bool has_second_round = random.percent(50);
  text += std::string("    on p from ASKS to ") + (has_second_round ? "COUNTS" : "WON") +
          " provided (votes == least - 1) do { votes = 0; }\n"
          "    on q from COUNTS to COUNTS provided (votes < least - 1) do { votes = votes + 1; }\n"
          "    on q from COUNTS to WON provided (votes == least - 1)\n";
  if (random.percent(20)) text += "    on p from WON to ASKS do { votes = 0; }\n";
  // Wins without so many votes.
  if (random.percent(15)) text += "    on q from ASKS to WON provided (votes > 0 && best == 1)\n";
  text += "  end\n  compound type Root()\n    component Voter v[" + number(voters) + "]\n";
  text += "    for i in 0.." + number(candidates) + " component Candidate c[i](i + 1, " + number(least) + ")\n";
  const auto port = [&] { return random.percent(50) ? std::string(".p") : std::string(".q"); };
  const std::string each = "    for i in 0.." + number(candidates) + " { for k in 0.." + number(voters) + " {\n";
  for (std::uint64_t k = 0; k < 2; ++k) {
    const std::string asked = k == 0 ? ".p" : ".q";
    text += each + "      connector Poll" + number(k % kinds) + " poll" + number(k) + "[i * " + number(voters) +
            " + k](c[i]" + asked + ", v[k]" + port() + ")\n    } }\n";
  }
  if (random.percent(30)) text += "    for k in 0.." + number(voters) + " connector One alone[k](v[k]" + port() + ")\n";
  if (random.percent(25)) {
    // All pairs, in both orders.
    text += "    for k in 0.." + number(voters) + " {\n      for d in 1.." + number(voters) +
            " connector Two pair[k * " + number(voters) + " + d](v[k].q, v[(k + d) % " + number(voters) +
            "].q)\n    }\n";
  }
  if (random.percent(20)) text += "    connector all(c[0].q, v[*].q)\n      define [c[0].q' v[*].q]\n";
  // One that is not like the others.
  if (random.percent(10)) text += "    connector One first(v[0].q)\n";
  text += "  end\nend\n";

  const std::string last = "c[" + number(candidates - 1) + "]";
  const std::string values[] = {last + ".best", "c[0].best"};
  net.properties.push_back("never c[0]@WON");
  net.properties.push_back("never " + last + "@WON && " + last + ".best == " + number(random.below(3)));
  net.properties.push_back("always " + values[random.below(2)] + " <= " + number(random.below(3)));
  net.properties.push_back("never " + last + "@WON && v[0].a == 0");
  net.properties.push_back("never v[0].a == " + number(random.below(3)) + " && v[1].b == " + number(random.below(3)));
  net.properties.push_back("never can " + last + ".p && v[1]@OUT");
  if (candidates > 1) {
    net.properties.push_back("never c[0]@WON && c[1]@WON");
    net.properties.push_back("never c[0]@WON && c[1]@WON && c[0].best != c[1].best");
    net.properties.push_back("never c[0]@WON && c[1]@WON && c[1].best == 0");
    net.properties.push_back("never c[0].votes + c[1].votes > " + number(least + random.below(2)));
  }
  return net;
}

}  // namespace bip::verify::test
