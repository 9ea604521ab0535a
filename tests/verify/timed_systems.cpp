// See timed_systems.hpp. Two or three atoms of types of their own, each with one or two clocks: guards with bounds, all
// urgencies, invariants, data that guards of transitions and connectors read and connectors write, limits that are
// data, `resume`; rendezvous, broadcasts, internal ports, rules.
#include "tests/verify/timed_systems.hpp"

#include <vector>

#include "runtime/include/bip/prng.hpp"

namespace bip::rt::testing {

namespace {

class TimedSystemWriter {
 public:
  TimedSystemWriter(std::uint64_t seed, std::uint64_t more) : random_(seed * 2654435761u + 1), more_(more) {}

  std::string write() {
    text_ =
        "package t\n  port type P(int v)\n  connector type One(P a)\n    define a\n  end\n  connector type Two(P a, P "
        "b)\n    define a b\n  end\n"
        "  connector type Sync(P a, P b)\n    define a b resume sync\n  end\n  connector type Cast(P a, P b)\n    "
        "define a' b\n  end\n"
        "  connector type Most(P a, P b)\n    define a b\n    on a b provided (a.v <= b.v && 2 > b.v)\n  end\n"
        "  connector type Pass(P a, P b)\n    define a b\n    on a b down { b.v = a.v; }\n  end\n";
    const std::uint64_t atoms = 2 + below(2) + more_;
    for (std::uint64_t k = 0; k < atoms; ++k) write_atom(k);
    text_ += "  compound type Root()\n";
    for (std::uint64_t k = 0; k < atoms; ++k) text_ += "    component A" + number(k) + " a" + number(k) + "()\n";
    std::vector<std::string> connectors;
    const auto add = [&](const std::string& line) {
      connectors.push_back("c" + number(connectors.size()));
      text_ += "    connector " + line.substr(0, line.find(' ')) + ' ' + connectors.back() +
               line.substr(line.find(' ') + 1) + '\n';
    };
    for (std::uint64_t k = 0; k < atoms; ++k) {
      if (below(2) == 0) add("One (a" + number(k) + ".p)");
      static const char* const kinds[] = {"Two", "Two", "Sync", "Cast", "Cast", "Most", "Most", "Pass"};
      add(std::string(kinds[below(8)]) + " (a" + number(k) + "." + (below(2) == 0 ? "p" : "q") + ", a" +
          number((k + 1) % atoms) + "." + (below(2) == 0 ? "p" : "q") + ")");
    }
    if (below(3) == 0) text_ += "    priority r " + connectors[0] + ":* < " + connectors[1] + ":*\n";
    return text_ + "  end\nend\n";
  }

 private:
  std::uint64_t below(std::uint64_t n) { return random_.below(n); }
  static std::string number(std::uint64_t n) { return std::to_string(n); }
  std::string constant() { return number(below(static_cast<std::uint64_t>(kMostConstant) + 1)); }

  std::string bound() {
    static const char* const operators[] = {" <= ", " >= ", " == ", " < ", " > "};
    const std::string clock = below(2) == 0 && has_second_ ? "y" : "x";
    if (below(6) == 0) return clock + " >= n";
    return clock + operators[below(5)] + constant();
  }
  std::string guard() {
    if (below(4) == 0) return "";
    std::string text = bound();
    if (below(3) == 0) text += " && " + bound();
    if (below(3) == 0) text += below(2) == 0 ? " && n < 2" : " && n == 1";
    return " provided (" + text + ")";
  }
  std::string action() {
    if (below(4) == 0) return "";
    std::string text = " do {";
    if (below(3) != 0) text += " x = " + (below(3) == 0 ? constant() : "0") + ";";
    if (has_second_ && below(2) == 0) text += " y = 0;";
    if (below(3) == 0) text += " n = (n + 1) % 3;";
    return text + " }";
  }

  void write_atom(std::uint64_t k) {
    has_second_ = below(3) == 0;
    const std::uint64_t places = 1 + below(3);
    text_ += "  atom type A" + number(k) + "()\n    clock x" + (has_second_ ? std::string(", y") : "") +
             " unit nanosecond\n    data int n = " + number(below(3)) + "\n";
    text_ += "    export port P p(n), q(n)\n    port P i(n)\n    place S0";
    for (std::uint64_t place = 1; place < places; ++place) text_ += ", S" + number(place);
    text_ += "\n    initial to S0" + std::string(below(4) == 0 ? " resume (x >= " + constant() + ")" : "") + "\n";
    std::string body;
    static const char* const urgencies[] = {"", "", " lazy", " delayable", " eager"};
    static const char* const ports[] = {"p", "p", "q", "i"};
    const std::uint64_t count = 2 + below(4);
    for (std::uint64_t t = 0; t < count; ++t) {
      const char* port = t == 0 ? "p" : t == 1 ? "q" : ports[below(4)];
      body += std::string("    on ") + port + " from S" + number(below(places)) + " to S" + number(below(places)) +
              guard() + urgencies[below(5)] + action();
      if (below(5) == 0) body += " resume (" + bound() + ")";
      body += '\n';
    }
    text_ += body;
    if (below(5) == 0) text_ += "    priority r p < q\n";
    if (below(2) == 0)
      text_ += "    invariant v at S" + number(below(places)) + " provided (x <= " + number(1 + below(4)) + ")\n";
    text_ += "  end\n";
  }

  Prng random_;
  std::uint64_t more_;
  bool has_second_ = false;
  std::string text_;
};

}  // namespace

std::string random_timed_system(std::uint64_t seed, std::uint64_t more) {
  return TimedSystemWriter(seed, more).write();
}

}  // namespace bip::rt::testing
