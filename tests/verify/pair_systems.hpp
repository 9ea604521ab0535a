// Random systems of a few processes that are alike, with clocks in ns and small constants, beside one component that
// they share: what is proved by pairs (compiler/verify/timed/prove_pairs.hpp), and its certificates.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "runtime/include/bip/prng.hpp"

namespace bip::verify::test {

/// Writes a row of processes that differ in a number, and a variable that may hold one.
class PairSystemWriter {
 public:
  explicit PairSystemWriter(std::uint64_t seed) : random_(seed * 2654435761u + 3) {}

  /// `size` processes.
  std::string model(std::uint64_t size) {
    std::string text =
        "package t\n  port type S()\n  port type N(int n)\n  connector type One(S a)\n    define a\n  end\n"
        "  connector type Two(S a, S b)\n    define a b\n  end\n"
        "  connector type Put(N a, N b)\n    define a b\n    on a b down { b.n = a.n; }\n  end\n"
        "  connector type Same(N a, N b)\n    define a b\n    on a b provided (a.n == b.n)\n  end\n"
        "  connector type Other(N a, N b)\n    define a b\n    on a b provided (a.n != b.n)\n  end\n";
    text +=
        "  atom type Process(int me)\n    clock x unit nanosecond\n    data int n = me\n"
        "    export port S p(), q(), r(), all()\n    export port N put(n), see(n)\n";
    text += body("x", {"p", "q", "r", "all", "put", "see"}, false);
    text +=
        "  atom type Middle()\n    clock y unit nanosecond\n    data int n = 0\n    export port S p(), q(), all()\n"
        "    export port N put(n), see(n)\n";
    text += body("y", {"p", "q", "all", "put", "see"}, true);
    text += "  compound type Row(int n)\n    for i in 0..n component Process a[i](i + 1)\n    component Middle m()\n";
    text += "    for i in 0..n {\n      connector One r[i](a[i].r)\n";
    const char* const ports[] = {"p", "q"};
    const std::uint64_t count = 1 + below(3);
    for (std::uint64_t k = 0; k < count; ++k)
      text += std::string("      connector Two c") + std::to_string(k) + "[i](a[i]." + ports[below(2)] + ", m." +
              ports[below(2)] + ")\n";
    if (below(3) != 0) text += "      connector Put w[i](a[i].put, m.put)\n";
    const std::uint64_t sees = below(4);
    if (sees != 0)
      text += std::string("      connector ") + (sees == 3 ? "Other" : "Same") + " s[i](a[i].see, m.see)\n";
    text += "    }\n";
    if (below(3) == 0) text += "    connector all(m.all, a[*].all)\n      define [m.all, a[*].all]\n";
    return text + "  end\n  compound type Root()\n    component Row row(" + std::to_string(size) + ")\n  end\nend\n";
  }

  /// Of the first two processes and the middle; after `model`.
  [[nodiscard]] std::string property() {
    std::string text = "never row.a[0]@S" + std::to_string(below(places_[0]));
    if (below(4) != 0) text += " && row.a[1]@S" + std::to_string(below(places_[0]));
    if (below(4) == 0) text += " && row.m@S" + std::to_string(below(places_[1]));
    return text;
  }

  /// The same of any processes; after `model`.
  [[nodiscard]] std::string counted_property() {
    const std::string at = "row.a[i]@S" + std::to_string(below(places_[0]));
    if (below(3) == 0) return "never row.m@S" + std::to_string(below(places_[1])) + " && exists i in row.a: " + at;
    const std::string of = below(4) == 0 ? at + " || row.a[i]@S" + std::to_string(below(places_[0])) : at;
    return (below(2) == 0 ? "always at most 1 i in row.a: " : "never exists i in row.a: ") + of;
  }

 private:
  std::uint64_t below(std::uint64_t n) { return random_.below(n); }

  std::string body(const std::string& clock, const std::vector<std::string>& ports, bool is_middle) {
    const std::uint64_t places = is_middle ? 1 + below(2) : 2 + below(2);
    places_[is_middle ? 1 : 0] = places;
    std::string text = "    place S0";
    for (std::uint64_t k = 1; k < places; ++k) text += ", S" + std::to_string(k);
    text += "\n    initial to S0\n";
    for (const std::string& port : ports) {
      for (std::uint64_t place = 0; place < places; ++place) {
        if (below(2) != 0 && place != 0) continue;
        text += "    on " + port + " from S" + std::to_string(place) + " to S" + std::to_string(below(places));
        std::string guard;
        if (below(3) == 0) guard = clock + (below(2) == 0 ? " >= " : " <= ") + std::to_string(1 + below(3));
        if (is_middle && below(3) == 0) guard += (guard.empty() ? "" : " && ") + std::string("n == 0");
        if (!guard.empty()) text += " provided (" + guard + ")";
        std::string action;
        if (below(3) != 0) action += " " + clock + " = 0;";
        if (is_middle && port != "put" && below(4) == 0) action += " n = 0;";
        if (!action.empty()) text += " do {" + action + " }";
        text += "\n";
      }
    }
    const char* const rules[] = {"* < r", "r < *", "p < q"};
    if (!is_middle && below(4) == 0) text += std::string("    priority first ") + rules[below(3)] + "\n";
    if (below(3) != 0)
      text += "    invariant soon at S" + std::to_string(below(places)) + " provided (" + clock +
              " <= " + std::to_string(2 + below(2)) + ")\n";
    return text + "  end\n";
  }

  rt::Prng random_;
  std::uint64_t places_[2] = {1, 1};
};

}  // namespace bip::verify::test
