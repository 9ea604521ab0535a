// The prover against exhaustive search: every proof must agree with a visit of all reachable states, on random models
// with data, guards, triggers, hierarchy, merged ports and priorities (tools/gen), and on small nets without data.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <string>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/follow.hpp"
#include "compiler/verify/pdr.hpp"
#include "compiler/verify/prove.hpp"
#include "compiler/verify/search.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/description.hpp"
#include "tools/gen/prng.hpp"

namespace {

using namespace bip;

struct Tally {
  int free = 0, deadlock = 0, open = 0, skipped = 0, candidates_that_were_free = 0;
};

void compare(const std::vector<std::string>& texts, Tally& tally) {
  const gen::Compiled c = gen::compile_texts(texts);
  // What C++ remembers is outside of a state: `bipc verify` does not take such models.
  if (!c.problem.empty() || !c.system->code.functions.empty() || !c.system->code.extern_types.empty()) {
    ++tally.skipped;
    return;
  }
  const verify::Net net = verify::build_net(*c.system);
  const verify::Proof proof = verify::prove_deadlock_freedom(net, verify::Clock::now() + std::chrono::seconds(5));
  const interp::Interpreter interpreter(*c.lowered);
  const verify::SearchLimits limits{.end = verify::Clock::now() + std::chrono::seconds(1), .megabytes = 200};
  const verify::SearchResult all = verify::search(net, c.lowered->image, {.stuck = true, .faults = false, .state = {}}, {}, limits);
  if (all.end == verify::SearchEnd::Limit) {
    ++tally.open;
    return;
  }
  const bool has_deadlock = all.end == verify::SearchEnd::Found;
  ++(has_deadlock ? tally.deadlock : tally.free);
  if (proof.end == verify::ProofEnd::Free && has_deadlock) {
    INFO(texts.back());
    FAIL("proved free, but there is a deadlock");
  }
  if (proof.end == verify::ProofEnd::Candidate) {
    if (!has_deadlock) ++tally.candidates_that_were_free;
    // The guided search must find the same answer.
    const verify::SearchResult guided = verify::search(net, c.lowered->image, {.stuck = true, .faults = false, .state = {}}, proof.candidate, limits);
    if (guided.end != verify::SearchEnd::Limit) CHECK(guided.end == all.end);
  }
}

std::string number(std::uint64_t n) { return std::to_string(n); }

// Atoms of up to four places, connectors of two or three with and without triggers, one level of hierarchy.
std::string small_net(std::uint64_t seed) {
  gen::Prng random(seed);
  const auto below = [&](std::uint64_t n) { return random.below(n); };
  const std::uint64_t types = 2 + below(2), atoms = 2 + below(4);
  std::string text = "package p\n  port type Signal()\n";
  text += "  connector type Two(Signal a, Signal b)\n    define a b\n  end\n";
  text += "  connector type Cast(Signal a, Signal b, Signal c)\n    define a' b c\n  end\n";
  text += "  connector type Both(Signal a, Signal b)\n    define a' b'\n  end\n";
  text += "  connector type Inner(Signal a, Signal b)\n    export port Signal e()\n    define a' b\n  end\n";
  text += "  connector type Nested(Signal a, Signal b, Signal c)\n    define (a b)' c\n  end\n";
  for (std::uint64_t t = 0; t < types; ++t) {
    const std::uint64_t places = 2 + below(3);
    text += "  atom type A" + number(t) + "()\n    export port Signal p(), q(), r()\n    place P0";
    for (std::uint64_t k = 1; k < places; ++k) text += ", P" + number(k);
    text += "\n    initial to P0\n";
    for (const char* port : {"p", "q", "r"}) {
      // One transition a port and place at most.
      for (std::uint64_t k = 0; k < places; ++k) {
        if (below(10) < 5) text += std::string("    on ") + port + " from P" + number(k) + " to P" + number(below(places)) + "\n";
      }
      text += std::string("    on ") + port + " from P0 to P" + number(below(places)) + " provided (false)\n";
    }
    text += "  end\n";
  }
  text += "  compound type Root()\n";
  for (std::uint64_t a = 0; a < atoms; ++a) text += "    component A" + number(below(types)) + " a" + number(a) + "()\n";
  const char* ports[] = {"p", "q", "r"};
  const auto distinct = [&](std::uint64_t count, std::uint64_t first) {
    std::string list;
    for (std::uint64_t k = 0; k < count; ++k) list += (k != 0 ? ", a" : "a") + number((first + k) % atoms) + "." + ports[below(3)];
    return list;
  };
  for (std::uint64_t k = 0; k < 3 + below(5); ++k) {
    const std::uint64_t first = below(atoms);
    const std::string c = "c" + number(k);
    switch (below(atoms >= 3 ? 5 : 2)) {
      case 0: text += "    connector Two " + c + "(" + distinct(2, first) + ")\n"; break;
      case 1: text += "    connector Both " + c + "(" + distinct(2, first) + ")\n"; break;
      case 2: text += "    connector Cast " + c + "(" + distinct(3, first) + ")\n"; break;
      case 3: text += "    connector Nested " + c + "(" + distinct(3, first) + ")\n"; break;
      default:
        text += "    connector Inner i" + number(k) + "(" + distinct(2, first) + ")\n";
        text += "    connector Two " + c + "(i" + number(k) + ".e, " + distinct(1, first + 2) + ")\n";
    }
  }
  return text + "  end\nend\n";
}

std::uint64_t count_of_runs(std::uint64_t usual) {
  const char* wanted = std::getenv("BIP_VERIFY_RUNS");
  return wanted == nullptr ? usual : std::strtoull(wanted, nullptr, 10);
}

void report(const char* what, const Tally& t) {
  WARN(what << ": free " << t.free << ", deadlock " << t.deadlock << ", too large " << t.open << ", skipped " << t.skipped
            << ", free but left open by the invariants " << t.candidates_that_were_free);
}

}  // namespace

struct ReachTally {
  int safe = 0, reached = 0, stopped = 0, unsupported = 0, skipped = 0, open = 0, vague = 0;
};

// The complete engine alone, without invariants, against a visit of all states.
void compare_reach(const std::string& text, ReachTally& tally) {
  const gen::Compiled c = gen::compile_text(text);
  if (!c.problem.empty()) {
    ++tally.skipped;
    return;
  }
  const interp::Interpreter interpreter(*c.lowered);
  const verify::Net net = verify::build_net(*c.system);
  const verify::SearchLimits limits{.end = verify::Clock::now() + std::chrono::seconds(1), .megabytes = 200};
  const verify::SearchResult all = verify::search(net, c.lowered->image, {.stuck = true, .faults = false, .state = {}}, {}, limits);
  if (all.end == verify::SearchEnd::Limit) {
    ++tally.open;
    return;
  }
  const verify::Machine machine = verify::build_machine(*c.system, c.lowered->image);
  INFO(text);
  if (!machine.unsupported.empty()) {
    ++tally.unsupported;
    WARN(machine.unsupported);
    return;
  }
  if (machine.starts_with_fault) return;
  verify::ReachProblem problem;
  problem.machine = &machine;
  problem.bad = machine.stuck;
  problem.end = verify::Clock::now() + std::chrono::seconds(10);
  const verify::ReachAnswer answer = verify::find_reachable(problem);
  const bool has_deadlock = all.end == verify::SearchEnd::Found;
  if (answer.end == verify::ReachEnd::Stopped) {
    ++tally.stopped;
    WARN("stopped; states: " << all.states << ", bits " << machine.bits.size() << ", nodes " << machine.circuit.size());
  } else if (answer.end == verify::ReachEnd::Safe) {
    ++tally.safe;
    if (has_deadlock) FAIL("proved safe, but there is a deadlock");
  } else {
    ++tally.reached;
    const auto choices = verify::follow(c.lowered->image, machine, answer.steps);
    const bool is_real = choices && verify::reaches(c.lowered->image, {.stuck = true, .faults = false, .state = {}}, *choices);
    if (!machine.vague.empty()) ++tally.vague;
    else if (!is_real) FAIL("the engine does not go the way of the counterexample");
  }
}

TEST_CASE("the complete engine agrees with exhaustive search") {
  ReachTally tally;
  const char* first = std::getenv("BIP_VERIFY_FROM");
  const std::uint64_t from = first == nullptr ? 1 : std::strtoull(first, nullptr, 10);
  const std::uint64_t runs = count_of_runs(150);
  for (std::uint64_t seed = from; seed < from + runs; ++seed) {
    INFO("seed " << seed);
    compare_reach(small_net(seed), tally);
    compare_reach(gen::print(gen::generate(seed)), tally);
  }
  WARN("safe " << tally.safe << ", reached " << tally.reached << ", stopped " << tally.stopped << ", unsupported " << tally.unsupported
               << ", skipped " << tally.skipped << ", too large " << tally.open << ", vague " << tally.vague);
  CHECK(tally.safe > 0);
  CHECK(tally.reached > 0);
}

TEST_CASE("proofs agree with exhaustive search on small nets") {
  Tally tally;
  const std::uint64_t runs = count_of_runs(400);
  for (std::uint64_t seed = 1; seed <= runs; ++seed) compare({small_net(seed)}, tally);
  report("small nets", tally);
  CHECK(tally.skipped == 0);
  CHECK(tally.free > 0);
  CHECK(tally.deadlock > 0);
}

TEST_CASE("proofs agree with exhaustive search on random models") {
  Tally tally;
  const std::uint64_t runs = count_of_runs(150);
  for (std::uint64_t seed = 1; seed <= runs; ++seed) compare(gen::print_packages(gen::generate(seed)), tally);
  report("random models", tally);
  CHECK(tally.skipped < static_cast<int>(runs) / 2);
}
