// Random systems with time against an oracle that knows nothing of heaps, intervals and ports: it keeps the instant at
// which each clock was zero, looks at whole nanoseconds one by one, and says of every step whether the language allows
// it. Runs end by themselves too: a deadlock and a time lock are checked the same way.
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "compiler/pipeline/pipeline.hpp"
#include "compiler/interp/interp.hpp"
#include "runtime/include/bip/prng.hpp"
#include "runtime/engine/timed_scheduler.hpp"

using namespace bip;

namespace {

constexpr std::int64_t kFar = 60;  // longer than any bound: beyond it nothing changes

enum Urgent { Lazy, Delayable, Eager };
struct Arc {
  int from, to, low, high;  // high < 0: none
  Urgent urgency;
  bool zeroes;
};
/// One clock; arcs[p] are port p's, at most one a place.
struct TransitionSystem {
  std::vector<std::vector<Arc>> arcs;
  int limit[2];  // at each place; < 0: none
  // run
  int place = 0;
  std::int64_t zero = 0;

  [[nodiscard]] const Arc* arc(int port) const {
    for (const Arc& a : arcs[static_cast<std::size_t>(port)]) {
      if (a.from == place) return &a;
    }
    return nullptr;
  }
  [[nodiscard]] bool is_enabled(int port, std::int64_t t) const {
    const Arc* a = arc(port);
    return a != nullptr && t - zero >= a->low && (a->high < 0 || t - zero <= a->high);
  }
  /// May time go on from t to t + 1?
  [[nodiscard]] bool lets_pass(std::int64_t t) const { return limit[place] < 0 || t + 1 - zero <= limit[place]; }
};
struct Joint {
  std::vector<std::pair<int, int>> ends;  // machine, port
};
struct Plant {
  std::vector<TransitionSystem> machines;
  std::vector<Joint> joints;

  [[nodiscard]] bool is_enabled(const Joint& j, std::int64_t t) const {
    for (const auto& [m, p] : j.ends) {
      if (!machines[static_cast<std::size_t>(m)].is_enabled(p, t)) return false;
    }
    return true;
  }
  /// Why time may not go on from t to t + 1.
  [[nodiscard]] std::string blocked(std::int64_t t) const {
    for (const TransitionSystem& m : machines) {
      if (!m.lets_pass(t)) return "an invariant";
    }
    for (const Joint& j : joints) {
      if (!is_enabled(j, t)) continue;
      int urgency = Lazy;
      for (const auto& [m, p] : j.ends)
        urgency = std::max<int>(urgency, machines[static_cast<std::size_t>(m)].arc(p)->urgency);
      if (urgency == Eager) return "an eager step";
      if (urgency == Delayable && !is_enabled(j, t + 1)) return "a delayable step";
    }
    return {};
  }
  /// From t on, is there an instant at which a step is possible, before time is blocked?
  [[nodiscard]] std::optional<std::int64_t> first_step(std::int64_t t) const {
    for (std::int64_t at = t; at < t + kFar; ++at) {
      for (const Joint& j : joints) {
        if (is_enabled(j, at)) return at;
      }
      if (!blocked(at).empty()) return std::nullopt;
    }
    return std::nullopt;
  }
  [[nodiscard]] std::string source() const {
    std::string out = "package m\n  port type S()\n";
    out += "  connector type C1(S a)\n    define a\n  end\n  connector type C2(S a, S b)\n    define a b\n  end\n";
    std::string parts;
    for (std::size_t m = 0; m < machines.size(); ++m) {
      out += fmt::format(
          "  @SuppressWarning(nondeterminism)\n  atom type M{}()\n    clock x unit nanosecond\n    export port S p0(), "
          "p1()\n    place A, B\n    initial to A\n",
          m);
      for (std::size_t p = 0; p < machines[m].arcs.size(); ++p) {
        for (const Arc& a : machines[m].arcs[p]) {
          static constexpr const char* kWords[] = {"", " delayable", " eager"};
          const std::string high = a.high < 0 ? "" : fmt::format(" && x <= {}", a.high);
          out += fmt::format("    on p{} from {} to {} provided (x >= {}{}){} do {{ {} }}\n", p, "AB"[a.from],
                             "AB"[a.to], a.low, high, kWords[a.urgency], a.zeroes ? "x = 0;" : "");
        }
      }
      for (int place = 0; place < 2; ++place) {
        if (machines[m].limit[place] >= 0)
          out +=
              fmt::format("    invariant i{} at {} provided (x <= {})\n", place, "AB"[place], machines[m].limit[place]);
      }
      out += "  end\n";
      parts += fmt::format("    component M{} m{}()\n", m, m);
    }
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const auto& ends = joints[j].ends;
      parts += fmt::format("    connector C{} c{}(m{}.p{}", ends.size(), j, ends[0].first, ends[0].second);
      if (ends.size() == 2) parts += fmt::format(", m{}.p{}", ends[1].first, ends[1].second);
      parts += ")\n";
    }
    return out + "  compound type R()\n" + parts + "  end\nend\n";
  }
};

Plant random_plant(rt::Prng& random) {
  const auto below = [&](int n) { return static_cast<int>(random.below(static_cast<std::uint64_t>(n))); };
  Plant plant;
  plant.machines.resize(static_cast<std::size_t>(2 + below(2)));
  for (TransitionSystem& m : plant.machines) {
    m.arcs.resize(2);
    for (auto& arcs : m.arcs) {
      for (int place = 0; place < 2; ++place) {
        if (below(5) == 0) continue;
        const int low = below(12);
        arcs.push_back(
            {place, below(2), low, below(3) == 0 ? -1 : low + below(10), static_cast<Urgent>(below(3)), below(3) != 0});
      }
    }
    for (int& limit : m.limit) limit = below(3) != 0 ? -1 : 8 + below(20);
  }
  const int count = 2 + below(3);
  for (int j = 0; j < count; ++j) {
    const int machines = static_cast<int>(plant.machines.size());
    const int a = below(machines);
    Joint joint{{{a, below(2)}}};
    if (below(3) != 0) joint.ends.push_back({(a + 1 + below(machines - 1)) % machines, below(2)});
    plant.joints.push_back(joint);
  }
  return plant;
}

struct Totals {
  int steps = 0, deadlocks = 0, time_locks = 0, waited = 0;
};

/// Runs it and checks every step; empty, or what is wrong.
std::string check(Plant plant, std::uint64_t seed, bool asap, Totals& totals) {
  pipeline::Compilation c(pipeline::CompileOptions{});
  c.open_texts["m.bip"] = plant.source();
  if (!pipeline::compile(c, "m.bip", pipeline::Stage::Image)) return "it does not compile";
  const interp::Interpreter interpreter(*c.lowered);
  rt::Core core(c.lowered->image);
  rt::TimedScheduler scheduler(rt::Policy::Uniform, asap, seed);
  rt::EventFeed feed(core);
  if (!core.initialize()) return core.fault().what;
  scheduler.start(core);
  std::int64_t now = 0;
  for (int k = 0; k < 40; ++k) {
    const std::optional<std::int64_t> first = plant.first_step(now);
    const rt::Due due = scheduler.wait(core, feed);
    const std::string fault = core.fault().what;
    if (due != rt::Due::Step) {
      if (first) return fmt::format("it ends at {} although a step is possible at {}: {}", now, *first, fault);
      std::int64_t end = now;
      while (end < now + kFar && plant.blocked(end).empty()) ++end;
      const bool is_lock = end < now + kFar;
      if (is_lock != (due == rt::Due::Fault))
        return fmt::format("deadlock and time lock are confused at {}: {}", now, fault);
      if (is_lock && (core.fault().code != rt::FaultCode::TimeLock || core.now() != end))
        return fmt::format("time lock at {} instead of {}: {}", core.now(), end, fault);
      ++(is_lock ? totals.time_locks : totals.deadlocks);
      return {};
    }
    const std::int64_t at = core.now();
    ++totals.steps;
    totals.waited += at > now ? 1 : 0;
    if (at < now) return "time runs backwards";
    if (asap && (!first || at != *first))
      return fmt::format("a step at {}, and one was possible at {}", at, first.value_or(-1));
    // Far waits end up after everything that changes.
    for (std::int64_t t = now; t < at && t < now + kFar; ++t) {
      if (const std::string why = plant.blocked(t); !why.empty())
        return fmt::format("time passes {} although {} holds it", t, why);
    }
    const std::size_t taken = core.candidate(scheduler.choice()).connector;
    const Joint& joint = plant.joints[taken];
    if (!plant.is_enabled(joint, at)) return fmt::format("c{} is taken at {} and is not possible then", taken, at);
    for (const auto& [m, p] : joint.ends) {
      TransitionSystem& machine = plant.machines[static_cast<std::size_t>(m)];
      const Arc arc = *machine.arc(p);
      machine.place = arc.to;
      if (arc.zeroes) machine.zero = at;
    }
    if (!core.time().take(scheduler.choice())) return core.fault().what;
    now = at;
  }
  return {};
}

}  // namespace

TEST_CASE("the language allows every timed step, and every end") {
  Totals totals;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    rt::Prng random(seed);
    const Plant plant = random_plant(random);
    for (const bool asap : {false, true}) {
      const std::string wrong = check(plant, seed, asap, totals);
      if (!wrong.empty()) FAIL("seed " << seed << (asap ? " asap: " : ": ") << wrong << "\n" << plant.source());
    }
  }
  // Every kind of end occurs, and most steps wait.
  CHECK(totals.steps > 2000);
  CHECK(totals.waited > 500);
  CHECK(totals.deadlocks > 20);
  CHECK(totals.time_locks > 20);
}

TEST_CASE("a snapshot holds the time") {
  pipeline::Compilation c(pipeline::CompileOptions{});
  c.open_texts["m.bip"] =
      "package m\n  port type S()\n  connector type C(S a)\n    define a\n  end\n  atom type A()\n    clock x, y unit "
      "nanosecond\n    data int n = 0\n"
      "    export port S p()\n    place P\n    initial to P do { y' = 0.5; }\n    on p from P to P provided (x >= 3 && "
      "x <= 90 && y >= 2) do { x = 0; n = n + 1; } resume (x >= n)\n"
      "  end\n  compound type R()\n    component A a(), b()\n    connector C ca(a.p), cb(b.p)\n  end\nend\n";
  REQUIRE(pipeline::compile(c, "m.bip", pipeline::Stage::Image));
  const interp::Interpreter interpreter(*c.lowered);
  rt::Core core(c.lowered->image);
  rt::TimedScheduler scheduler(rt::Policy::Uniform, false, 9);
  rt::EventFeed feed(core);
  // The state also holds how many instants of resuming were drawn.
  scheduler.prepare(core);
  REQUIRE(core.time().draws_resumes());
  REQUIRE(core.initialize());
  scheduler.start(core);
  const auto run = [&](int steps) {
    std::string told;
    for (int k = 0; k < steps; ++k) {
      REQUIRE(scheduler.wait(core, feed) == rt::Due::Step);
      told += fmt::format("{}:{} ", core.now(), core.candidate(scheduler.choice()).connector);
      REQUIRE(core.time().take(scheduler.choice()));
    }
    return told;
  };
  (void)run(7);
  const rt::State state = core.snapshot();
  const std::vector<rt::InteractionId> order = core.enabled().list_order();
  const rt::TimedScheduler then = scheduler;
  const std::string first = run(12);
  REQUIRE(core.restore(state));
  CHECK(core.snapshot() == state);
  core.set_list_order(order);
  scheduler = then;
  CHECK(run(12) == first);
}

TEST_CASE("each instant at which a busy atom may resume is as likely") {
  pipeline::Compilation c(pipeline::CompileOptions{});
  c.open_texts["m.bip"] =
      "package m\n  port type S()\n  connector type C(S a)\n    define a\n  end\n  connector type D(S a, S b)\n    "
      "define a "
      "b resume sync\n  end\n  atom type A(int least, int most)\n    clock x unit nanosecond\n    export port S p(), "
      "q()\n "
      "   place P, Q\n    initial to P\n    on p from P to Q do { x = 0; } resume (x >= least && x <= most)\n    on q "
      "from Q "
      "to P eager\n  end\n  atom type B()\n    clock x unit nanosecond\n    export port S p(), q()\n    place P, Q\n   "
      " "
      "initial to P\n    on p from P to Q do { x = 0; } resume (x >= 2)\n    on q from Q to P eager\n  end\n  compound "
      "type "
      "R()\n    component A a(2, 6), b(0, 4), c(3, 9)\n    component B d()\n    connector C pa(a.p), qa(a.q), pd(d.p), "
      "qd(d.q), qb(b.q), qc(c.q)\n    connector D both(b.p, c.p)\n  end\nend\n";
  REQUIRE(pipeline::compile(c, "m.bip", pipeline::Stage::Image));
  const interp::Interpreter interpreter(*c.lowered);
  rt::Core core(c.lowered->image);
  rt::TimedScheduler scheduler(rt::Policy::Uniform, false, 5);
  rt::EventFeed feed(core);
  scheduler.prepare(core);
  REQUIRE(core.initialize());
  scheduler.start(core);
  std::vector<int> alone(10), together(10);
  double waited = 0;
  int waits = 0;
  for (int k = 0; k < 40'000; ++k) {
    REQUIRE(scheduler.wait(core, feed) == rt::Due::Step);
    REQUIRE(core.time().take(scheduler.choice()));
    const std::vector<rt::u32>& resuming = core.time().resuming();
    for (const rt::u32 atom : resuming) {
      const std::int64_t length = core.time().busy_until(atom) - core.now();
      if (atom == 0) ++alone.at(static_cast<std::size_t>(length));
      if (atom == 1) ++together.at(static_cast<std::size_t>(length));
      if (atom == 3) waited += static_cast<double>(length), ++waits;
    }
    // One instant for both.
    if (resuming.size() == 2) CHECK(core.time().busy_until(1) == core.time().busy_until(2));
  }
  const auto is_even = [](const std::vector<int>& counts, std::size_t first, std::size_t last) {
    int all = 0, least = counts[first], most = counts[first];
    for (std::size_t k = 0; k < counts.size(); ++k) {
      if (k < first || k > last) {
        if (counts[k] != 0) return false;
        continue;
      }
      all += counts[k];
      least = std::min(least, counts[k]);
      most = std::max(most, counts[k]);
    }
    return all > 1000 && most - least < all / 10;
  };
  CHECK(is_even(alone, 2, 6));
  CHECK(is_even(together, 3, 4));
  // Past the first instant exponential, with the unit as mean: whole ns, so 2 + a geometric number.
  CHECK(waits > 1000);
  CHECK(waited / waits > 2.3);
  CHECK(waited / waits < 2.9);
}
