// The prover against exhaustive search: every proof must agree with a visit of all reachable states, on random models
// with data, guards, triggers, hierarchy, merged ports and priorities (tools/gen), and on small nets without data.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <string>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/portfolio/prove_by_invariants.hpp"
#include "compiler/verify/portfolio/search_bad_state.hpp"
#include "tests/verify/small_net.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/description.hpp"

namespace {

using namespace bip;

struct NetTally {
  int free = 0, deadlock = 0, open = 0, skipped = 0, candidates_that_were_free = 0;
};

void compare(const std::vector<std::string>& texts, NetTally& tally) {
  const gen::Compiled c = gen::compile_texts(texts);
  // What C++ remembers is outside of a state: `bipc verify` does not take such models.
  if (!c.problem.empty() || !c.system->code.functions.empty() || !c.system->code.ffi_types.empty()) {
    ++tally.skipped;
    return;
  }
  const verify::Net net = verify::build_net(*c.system);
  const verify::Proof proof = verify::prove_deadlock_freedom(net, verify::within_seconds(5));
  const interp::Interpreter interpreter(*c.lowered);
  const verify::SearchLimits limits{.cancellation = verify::within_seconds(1), .megabytes = 200};
  const verify::SearchResult all =
      verify::search(net, c.lowered->image, {.stuck = true, .faults = false, .state = {}}, {}, limits);
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
    const verify::SearchResult guided =
        verify::search(net, c.lowered->image, {.stuck = true, .faults = false, .state = {}}, proof.candidate, limits);
    if (guided.end != verify::SearchEnd::Limit) CHECK(guided.end == all.end);
  }
}

std::uint64_t count_of_runs(std::uint64_t usual) {
  const char* wanted = std::getenv("BIP_VERIFY_RUNS");
  return wanted == nullptr ? usual : std::strtoull(wanted, nullptr, 10);
}

void report(const char* what, const NetTally& t) {
  WARN(what << ": free " << t.free << ", deadlock " << t.deadlock << ", too large " << t.open << ", skipped "
            << t.skipped << ", free but left open by the invariants " << t.candidates_that_were_free);
}

}  // namespace

TEST_CASE("proofs agree with exhaustive search on small nets") {
  NetTally tally;
  const std::uint64_t runs = count_of_runs(400);
  for (std::uint64_t seed = 1; seed <= runs; ++seed) compare({verify::test::small_net(seed)}, tally);
  report("small nets", tally);
  CHECK(tally.skipped == 0);
  CHECK(tally.free > 0);
  CHECK(tally.deadlock > 0);
}

TEST_CASE("proofs agree with exhaustive search on random models") {
  NetTally tally;
  const std::uint64_t runs = count_of_runs(150);
  for (std::uint64_t seed = 1; seed <= runs; ++seed) compare(gen::print_packages(gen::generate(seed)), tally);
  report("random models", tally);
  CHECK(tally.skipped < static_cast<int>(runs) / 2);
  CHECK(tally.free > 0);
  CHECK(tally.deadlock > 0);
}
