// Searches of maximal interactions by ranges of values against those by descent and against all interactions listed one
// by one: random trees of connectors with guards, and trees whose search would be exponential by descent.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <set>
#include <string>

#include "compiler/interp/interp.hpp"
#include "runtime/core/core.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;
using Ports = std::vector<std::pair<rt::u32, rt::u32>>;

// What the core offers: of each candidate who takes part, in canonical order.
std::vector<Ports> offers(rt::Core& core) {
  std::vector<Ports> all;
  std::vector<rt::Participant> parts;
  for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
    parts.clear();
    core.participants(core.candidate(k), parts);
    Ports ports;
    for (const rt::Participant& part : parts) ports.emplace_back(part.atom, part.port);
    all.push_back(ports);
  }
  return all;
}

// Those that no other one contains.
std::set<Ports> maximal(const std::vector<Ports>& all) {
  std::set<Ports> kept;
  for (Ports ports : all) {
    std::sort(ports.begin(), ports.end());
    const bool below = std::any_of(all.begin(), all.end(), [&](Ports other) {
      std::sort(other.begin(), other.end());
      return other != ports && std::includes(other.begin(), other.end(), ports.begin(), ports.end());
    });
    if (!below) kept.insert(ports);
  }
  return kept;
}

// A tree of connectors, each with a type of its own, over atoms whose values change as they fire.
class RandomTree {
 public:
  explicit RandomTree(unsigned seed) : random_(seed) {
    std::vector<std::string> level;
    const int leaves = pick(3, 7);
    for (int i = 0; i < leaves; ++i) level.push_back("a" + std::to_string(i) + ".p");
    for (int i = 0; i < leaves; ++i)
      parts_ += "    component A a" + std::to_string(i) + "(" + std::to_string(pick(-3, 4)) + ", " +
                std::to_string(pick(2, 7)) + ")\n";
    while (level.size() > 1) {
      std::vector<std::string> above;
      for (std::size_t i = 0; i < level.size();) {
        const std::size_t count = std::min<std::size_t>(level.size() - i, static_cast<std::size_t>(pick(2, 3)));
        above.push_back(count < 2 ? level[i]
                                  : connector({level.begin() + static_cast<std::ptrdiff_t>(i),
                                               level.begin() + static_cast<std::ptrdiff_t>(i + count)},
                                              count == level.size()));
        i += count;
      }
      level = std::move(above);
    }
  }

  [[nodiscard]] std::string text() const {
    return "package tree\n"
           "  port type P(int v, float f)\n"
           "  atom type A(int start, int modulus)\n    data int v = start\n    data float f = start * 0.5\n    export "
           "port P p(v, f)\n"
           "    place S, T\n    initial to S\n"
           "    on p from S to T do { v = (v * 3 + 1) % 7 - 2; f = f + 0.25; }\n    on p from T to S provided (modulus "
           "!= 3) do { v = modulus - v; }\n  end\n" +
           types_ + "  compound type Root()\n" + parts_ + "  end\nend\n";
  }

 private:
  int pick(int from, int to) { return from + static_cast<int>(random_() % static_cast<unsigned>(to - from + 1)); }
  std::string number(int from, int to) {
    const int n = pick(from, to);
    return n < 0 ? "(0 - " + std::to_string(-n) + ")" : std::to_string(n);
  }
  std::string value(char p) {
    const std::string v = std::string(1, p) + ".v";
    switch (pick(0, 7)) {
      case 0: return "(0 - " + v + ")";
      case 1: return "(" + v + " * " + number(-2, 3) + ")";
      case 2: return pick(0, 3) == 0 ? "(" + v + " * 65536 * 65536)" : v;
      default: return v;
    }
  }
  std::string guard(const std::string& members) {
    static const char* const kSigns[] = {"<", "<=", ">", ">=", "==", "!="};
    std::string left = value(members[0]);
    for (std::size_t i = 1; i < members.size(); ++i)
      left += std::string(pick(0, 2) == 0 ? " - " : " + ") + value(members[i]);
    std::string all = left + " " + kSigns[pick(0, 5)] + " " + number(-4, 12);
    if (pick(0, 4) == 0) all = "!(" + all + ")";
    if (pick(0, 3) == 0)
      all = "(" + all + (pick(0, 1) == 0 ? ") && " : ") || ") + std::string(1, members[0]) + ".f " +
            kSigns[pick(0, 5)] + " 1.5";
    return all;
  }
  std::string connector(const std::vector<std::string>& below, bool is_root) {
    struct Form {
      const char* define;
      std::vector<std::string> interactions;
    };
    static const std::vector<Form> kTwo{
        {"a' b'", {"ab", "a", "b"}}, {"a' b", {"ab", "a"}}, {"a b'", {"ab", "b"}}, {"a b", {"ab"}}};
    static const std::vector<Form> kThree{{"a' b' c'", {"abc", "ab", "ac", "bc", "a", "b", "c"}},
                                          {"a' b c", {"abc", "ab", "ac", "a"}},
                                          {"(a b)' c'", {"abc", "ab", "c"}},
                                          {"(a' b)' c", {"abc", "ab", "ac", "a"}}};
    const std::vector<Form>& forms = below.size() == 2 ? kTwo : kThree;
    // Triggers mostly: there is little to search without.
    const Form& form =
        forms[pick(0, 2) != 0 ? 0 : static_cast<std::size_t>(pick(0, static_cast<int>(forms.size()) - 1))];
    const std::string name = "K" + std::to_string(count_++);
    types_ += "  connector type " + name + "(P a, P b" + (below.size() == 3 ? ", P c" : "") +
              ")\n    data int v\n    data float f\n";
    if (!is_root) types_ += "    @SuppressWarning(missinginteraction)\n    export port P up_port(v, f)\n";
    types_ += std::string("    define ") + form.define + "\n";
    for (const std::string& members : form.interactions) {
      const bool guarded = pick(0, 3) == 0 || is_root;
      if (pick(0, 9) == 0 && !is_root) continue;
      types_ += "    on";
      for (const char p : members) types_ += std::string(" ") + p;
      if (guarded) types_ += " provided (" + guard(members) + ")";
      if (!is_root) {
        types_ += " up { v = " + value(members[0]) + "; f = " + members[0] + ".f;";
        for (std::size_t i = 1; i < members.size(); ++i) {
          const std::string next = value(members[i]);
          if (pick(0, 3) == 0) types_ += " if (" + next + " > v) then v = " + next + "; fi";
          else types_ += " v = v + " + next + "; f = f " + (pick(0, 1) == 0 ? "-" : "*") + " " + members[i] + ".f;";
        }
        types_ += " }";
      }
      types_ += "\n";
    }
    types_ += "  end\n";
    const std::string instance = "k" + std::to_string(count_);
    parts_ += "    connector " + name + " " + instance + "(";
    for (std::size_t i = 0; i < below.size(); ++i) parts_ += (i == 0 ? "" : ", ") + below[i];
    parts_ += ")\n";
    return instance + ".up_port";
  }

  std::mt19937 random_;
  int count_ = 0;
  std::string types_, parts_;
};

struct Compared {
  std::uint64_t states = 0, offered = 0, looks = 0;
};

void compare(const std::string& text, unsigned seed, Compared& compared) {
  const gen::Compiled c = gen::compile_texts({text});
  INFO(text);
  REQUIRE(c.problem == "");
  const interp::Interpreter interpreter(*c.lowered);
  const rt::Image& image = c.lowered->image;
  rt::Core by_descent(image, {.descent_bound = 1u << 30}), by_ranges(image, {.descent_bound = 0}),
      all(image, {.progress = rt::MaximalProgress::Off});
  std::mt19937 random(seed);
  REQUIRE(by_descent.initialize());
  REQUIRE(by_ranges.initialize());
  REQUIRE(all.initialize());
  for (int step = 0; step < 12; ++step) {
    const std::vector<Ports> expected = offers(by_descent);
    ++compared.states;
    compared.offered += expected.size();
    REQUIRE(offers(by_ranges) == expected);
    REQUIRE(maximal(offers(all)) == maximal(expected));
    if (expected.empty()) break;
    REQUIRE(by_descent.fire(random() % expected.size()));
    REQUIRE(by_ranges.restore(by_descent.snapshot()));
    REQUIRE(all.restore(by_descent.snapshot()));
  }
  compared.looks += by_ranges.search().work().range_looks;
}

// n lamps in a binary tree of triggers whose `up` adds, a guard at the root; watts are 1, 2, 3, 4, 1, …
std::string lamps(const std::string& sign) {
  return "package lights\n"
         "  port type Power(int watt)\n"
         "  connector type Both(Power a, Power b)\n    data int watt\n    export port Power top(watt)\n    define a' "
         "b'\n"
         "    on a b up { watt = a.watt + b.watt; }\n    on a up { watt = a.watt; }\n    on b up { watt = b.watt; }\n  "
         "end\n"
         "  connector type Mains(Power p, Power limit)\n    define p limit\n    on p limit provided (p.watt " +
         sign +
         " limit.watt)\n  end\n"
         "  atom type Lamp(int start)\n    data int watt = start\n    export port Power shine(watt)\n    place ON\n    "
         "initial to ON\n"
         "    on shine from ON to ON\n  end\n"
         "  compound type Street(int n, int limit)\n"
         "    for i in 0..n component Lamp lamp[i](i % 4 + 1)\n    component Lamp meter(limit)\n"
         "    for i in 0..n / 2 - 1 connector Both node[i](node[2 * i + 1].top, node[2 * i + 2].top)\n"
         "    for i in n / 2 - 1..n - 1 connector Both node[i](lamp[2 * i + 2 - n].shine, lamp[2 * i + 3 - n].shine)\n"
         "    connector Mains mains(node[0].top, meter.shine)\n  end\n";
}

struct Searched {
  std::uint64_t offered = 0;
  rt::SearchWork work;
};
Searched search_lamps(const std::string& sign, int limit) {
  const std::string root =
      "  compound type Root()\n    component Street street(32, " + std::to_string(limit) + ")\n  end\nend\n";
  const gen::Compiled c = gen::compile_texts({lamps(sign) + root});
  REQUIRE(c.problem == "");
  const interp::Interpreter interpreter(*c.lowered);
  rt::Core core(c.lowered->image);
  REQUIRE(core.initialize());
  return {core.candidate_count(), core.search().work()};
}

}  // namespace

TEST_CASE("searches by ranges find what the others find") {
  Compared compared;
  const char* const wanted = std::getenv("BIP_SEARCH_RUNS");
  const unsigned runs = wanted == nullptr ? 150 : static_cast<unsigned>(std::strtoul(wanted, nullptr, 10));
  for (unsigned seed = 1; seed <= runs; ++seed) compare(RandomTree(seed).text(), seed, compared);
  CHECK(compared.states > 500);
  CHECK(compared.offered > compared.states);
  CHECK(compared.looks > 1000);
}

TEST_CASE("what no interaction can reach takes one look") {
  const Searched found = search_lamps(">=", 90);
  CHECK(found.offered == 0);
  CHECK(found.work.range_looks == 1);
  CHECK(found.work.configurations < 100);
}

TEST_CASE("what few interactions meet is found among four thousand million") {
  // At most 3 watt: one lamp of 3, or one of 1 and one of 2, or three of 1; eight lamps of each.
  CHECK(search_lamps("<=", 3).offered == 8 + 8 * 8 + 56);
  // At most 80 of 80: all.
  CHECK(search_lamps("<=", 80).offered == 1);
  // 77 of 80: without 3, 2 and 1, or 1, 1 and 1.
  const Searched found = search_lamps("==", 77);
  CHECK(found.offered == 8 + 8 * 8 + 56);
  CHECK(found.work.range_looks < 20000);
}

TEST_CASE("a search that is recalled offers what a new one finds") {
  std::uint64_t recalled = 0, searches = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const gen::Compiled c = gen::compile_texts({RandomTree(seed).text()});
    REQUIRE(c.problem == "");
    const interp::Interpreter interpreter(*c.lowered);
    rt::Core core(c.lowered->image);
    REQUIRE(core.initialize());
    const auto start = core.snapshot();
    std::mt19937 random(seed);
    // Twice the same walk: the second time most inputs are known.
    for (int walk = 0; walk < 2; ++walk) {
      random.seed(seed);
      REQUIRE(core.restore(start));
      for (int step = 0; step < 6; ++step) {
        rt::Core fresh(c.lowered->image);
        REQUIRE(fresh.initialize());
        REQUIRE(fresh.restore(core.snapshot()));
        const std::vector<Ports> expected = offers(fresh);
        INFO("seed " << seed << ", walk " << walk << ", step " << step);
        REQUIRE(offers(core) == expected);
        if (expected.empty()) break;
        REQUIRE(core.fire(random() % expected.size()));
      }
    }
    recalled += core.search().work().recalled;
    searches += core.search().work().searches;
  }
  CHECK(recalled > 100);
  CHECK(searches > 100);
}

TEST_CASE("a search whose inputs do not change is made once") {
  const std::string root = "  compound type Root()\n    component Street street(16, 37)\n  end\nend\n";
  const gen::Compiled c = gen::compile_texts({lamps("<=") + root});
  REQUIRE(c.problem == "");
  const interp::Interpreter interpreter(*c.lowered);
  rt::Core core(c.lowered->image);
  REQUIRE(core.initialize());
  for (int step = 0; step < 50; ++step) REQUIRE(core.fire(0));
  CHECK(core.search().work().searches == 1);
  CHECK(core.search().work().recalled == 50);
}
