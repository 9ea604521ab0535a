// Cycles of a compound's priorities, against a search over all interactions of all its connectors.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "tests/unit/system/instantiated.hpp"

namespace {

using bip::test::Instantiated;

using Ports = std::set<int>;
struct Interaction {
  int connector = 0;
  Ports ports;
};
struct Side {
  bool any_connector = false;
  bool any_interaction = false;
  int connector = 0;
  Ports ports;
};
struct Rule {
  Side low, high;
  bool has_guard = false;
};

bool contains(const Ports& big, const Ports& small) {
  return std::includes(big.begin(), big.end(), small.begin(), small.end());
}

bool is_low(const Rule& r, const Interaction& x);
bool is_high(const Rule& r, const Interaction& x) {
  if (r.high.any_connector) return !is_low(r, x);
  return r.high.connector == x.connector && (r.high.any_interaction || contains(x.ports, r.high.ports));
}
bool is_low(const Rule& r, const Interaction& x) {
  if (r.low.any_connector) return !is_high(r, x);
  return r.low.connector == x.connector && (r.low.any_interaction || contains(r.low.ports, x.ports));
}

struct World {
  std::mt19937 random;
  // Three connectors, all ports of their own: a rendezvous, a trigger with two synchrons, two triggers.
  std::vector<Interaction> interactions = {{0, {0, 1}},    {1, {0}}, {1, {0, 1}}, {1, {0, 2}},
                                           {1, {0, 1, 2}}, {2, {0}}, {2, {1}},    {2, {0, 1}}};
  std::vector<Rule> rules{};

  Side side() {
    Side s;
    const auto kind = random() % 6;
    s.any_connector = kind == 0;
    const Interaction& x = interactions[random() % interactions.size()];
    s.connector = x.connector;
    s.any_interaction = kind == 1;
    if (kind > 1) s.ports = x.ports;
    return s;
  }
  void make() {
    const auto n = 1 + random() % 4;
    while (rules.size() < n) {
      Rule r{side(), side(), random() % 5 == 0};
      if (!r.low.any_connector || !r.high.any_connector) rules.push_back(r);
    }
  }
  static std::string text(const Side& s) {
    if (s.any_connector) return "*:*";
    std::string out = "k" + std::to_string(s.connector) + ":";
    if (s.any_interaction) return out + "*";
    for (const int p : s.ports) out += (out.back() == ':' ? "a" : ", a") + std::to_string(s.connector * 3 + p) + ".p";
    return out;
  }
  [[nodiscard]] std::string text() const {
    std::string out = R"(package t
port type P()
connector type K0(P a, P b) define a b end
connector type K1(P a, P b, P c) define a' b c end
connector type K2(P a, P b) define a' b' end
atom type A()
  export data int v = 0
  export port P p()
  place S
  initial to S
  on p from S to S do { v = v + 1; }
end
compound type R()
component A a0(), a1(), a3(), a4(), a5(), a6(), a7()
connector K0 k0(a0.p, a1.p)
connector K1 k1(a3.p, a4.p, a5.p)
connector K2 k2(a6.p, a7.p)
)";
    for (std::size_t i = 0; i < rules.size(); ++i) {
      out += "priority r" + std::to_string(i) + " " + text(rules[i].low) + " < " + text(rules[i].high) +
             (rules[i].has_guard ? " provided (a0.v == 1)\n" : "\n");
    }
    return out + "end\nend\n";
  }
  // Rules of one connector by name whose low side holds all of the high one.
  [[nodiscard]] bool is_against_progress() const {
    return std::any_of(rules.begin(), rules.end(), [](const Rule& r) {
      const bool by_name =
          !r.low.any_connector && !r.high.any_connector && !r.low.any_interaction && !r.high.any_interaction;
      return by_name && r.low.connector == r.high.connector && contains(r.low.ports, r.high.ports);
    });
  }
  // Reachability over "loses against", by repeated squaring of a small relation.
  [[nodiscard]] bool has_cycle() const {
    const std::size_t n = interactions.size();
    std::vector<std::vector<bool>> below(n, std::vector<bool>(n));
    for (const Rule& r : rules) {
      for (std::size_t x = 0; x < n; ++x) {
        for (std::size_t y = 0; y < n; ++y)
          below[x][y] = below[x][y] || (!r.has_guard && is_low(r, interactions[x]) && is_high(r, interactions[y]));
      }
    }
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t x = 0; x < n; ++x) {
        for (std::size_t y = 0; y < n; ++y) below[x][y] = below[x][y] || (below[x][k] && below[k][y]);
      }
    }
    for (std::size_t x = 0; x < n; ++x) {
      if (below[x][x]) return true;
    }
    return false;
  }
};

TEST_CASE("cycles of random priorities, against all interactions") {
  int cycles = 0;
  int orders = 0;
  for (std::uint32_t seed = 0; seed < 1500; ++seed) {
    World world{std::mt19937(seed)};
    world.make();
    const Instantiated made(world.text());
    const std::string codes = made.codes();
    INFO("seed " << seed << "\n" << world.text() << codes);
    REQUIRE((codes.find("B3007") != std::string::npos) == world.is_against_progress());
    if (world.is_against_progress()) continue;
    REQUIRE((codes.find("B3006") != std::string::npos) == world.has_cycle());
    REQUIRE(made.system.has_value() == !world.has_cycle());
    (world.has_cycle() ? cycles : orders) += 1;
  }
  REQUIRE(cycles > 100);
  REQUIRE(orders > 100);
}

TEST_CASE("a chain of priorities as long as one likes") {
  constexpr int kRules = 20000;
  std::string text = "compound type R() component A a[" + std::to_string(kRules + 1) + "](0)\n";
  for (int i = 0; i <= kRules; ++i)
    text += "connector One c" + std::to_string(i) + "(a[" + std::to_string(i) + "].p)\n";
  for (int i = 0; i < kRules; ++i)
    text += "priority r" + std::to_string(i) + " c" + std::to_string(i) + ":* < c" + std::to_string(i + 1) + ":*\n";
  const Instantiated open(bip::test::with_types(text + "end"));
  REQUIRE(open.codes().empty());
  const Instantiated closed(
      bip::test::with_types(text + "priority back c" + std::to_string(kRules) + ":* < c0:*\nend"));
  REQUIRE(closed.codes() == "B3006");
}

}  // namespace
