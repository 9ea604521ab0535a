// Cancellation: each question of a process answers to its own token, deadlines are not cancellations, and engines that
// share a proof cache do not disturb each other.
#include "compiler/verify/solver/cancellation.hpp"

#include <catch2/catch.hpp>

#include <atomic>
#include <chrono>
#include <thread>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/portfolio/portfolio.hpp"
#include "compiler/verify/portfolio/proof_context.hpp"
#include "compiler/verify/solver/solver.hpp"
#include "tests/unit/base/scratch_folder.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;
using verify::Outcome;

// A pseudo-random sequence of 2^32 values: no engine decides within a test whether it meets two given values at once.
const char* const kEndless = R"(package endless
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Generator()
    data int x = 1
    data int y = 1
    export port Signal next()
    place S
    initial to S
    on next from S to S do { x = x * 1664525 + 1013904223; y = y * 22695477 + x; }
  end
  compound type Root()
    component Generator g()
    connector One next(g.next)
  end
end
)";
const char* const kEndlessProperty = "never g.x == 123456789 && g.y == 987654321";

// Users take turns at a lock: free of deadlock by the invariants of structure.
const char* const kLock = R"(package lock
  port type Signal()
  connector type Two(Signal a, Signal b)
    define a b
  end
  atom type Lock()
    export port Signal take(), give()
    place FREE, TAKEN
    initial to FREE
    on take from FREE to TAKEN
    on give from TAKEN to FREE
  end
  atom type User()
    export port Signal take(), give()
    place OUT, IN
    initial to OUT
    on take from OUT to IN
    on give from IN to OUT
  end
  compound type Root()
    component Lock k()
    component User u[5]()
    for i in 0..5 connector Two take[i](u[i].take, k.take), give[i](u[i].give, k.give)
  end
end
)";

struct Asked {
  explicit Asked(const char* text, const char* property = nullptr)
      : compiled(gen::compile_texts({text})), interpreter(*compiled.lowered) {
    REQUIRE(compiled.problem.empty());
    if (property == nullptr) return;
    Result<verify::Property> parsed = verify::parse_property(property, *compiled.system);
    REQUIRE(parsed);
    question.what = verify::QuestionKind::State;
    question.property = std::move(*parsed);
  }
  verify::Decision decide(const verify::CancellationToken& cancellation, verify::Report report,
                          verify::ProofCache* cache = nullptr) {
    verify::Portfolio portfolio(
        *compiled.system, compiled.lowered->image, verify::StateAccess::Searchable, [] { return true; },
        std::move(report));
    portfolio.use_cache(cache);
    verify::PortfolioLimits limits;
    limits.cancellation = cancellation;
    limits.megabytes = 200;
    return portfolio.decide(question, limits);
  }
  gen::Compiled compiled;
  interp::Interpreter interpreter;
  verify::Question question;
};

void wait_for(const std::atomic<bool>& flag) {
  while (!flag) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}
void ignore_progress(const char*, std::uint64_t, const char*) {}

}  // namespace

TEST_CASE("a token is over when its own source is cancelled or its deadline has passed") {
  verify::CancellationSource mine, other;
  const verify::CancellationToken token(mine), soon = token.within(0), later = token.within(1e6);
  CHECK(token.within_wall_clock(0).is_over());
  CHECK(!token.within_wall_clock(1e6).is_over());
  CHECK(token.within_wall_clock(0).within(1e6).is_over());
  CHECK(!token.within_wall_clock(0).is_cancelled());
  CHECK(!token.is_over());
  CHECK_FALSE(token.is_over());
  CHECK(soon.is_over());
  CHECK_FALSE(soon.is_cancelled());
  CHECK_FALSE(later.is_over());
  // A deadline never moves back.
  CHECK(later.within(1e7).seconds_left() <= 1e6);
  other.cancel();
  CHECK_FALSE(token.is_over());
  mine.cancel();
  CHECK(token.is_cancelled());
  CHECK(later.is_over());
  CHECK(later.seconds_left() == 0);
  CHECK_FALSE(verify::within_seconds(1e300).is_over());
}

TEST_CASE("a solver stops when its token is cancelled") {
  // Pigeons in too few holes: exponential for resolution.
  constexpr int kHoles = 12;
  verify::Solver solver;
  std::vector<std::vector<verify::Lit>> in(kHoles + 1);
  for (std::vector<verify::Lit>& pigeon : in) {
    for (int hole = 0; hole < kHoles; ++hole) pigeon.push_back(solver.new_variable());
    solver.add(pigeon);
  }
  for (int hole = 0; hole < kHoles; ++hole) {
    for (int a = 0; a <= kHoles; ++a) {
      for (int b = 0; b < a; ++b) solver.add({-in[a][hole], -in[b][hole]});
    }
  }
  verify::CancellationSource source;
  verify::Answer answer = verify::Answer::Satisfiable;
  std::thread thread([&] { answer = solver.solve(verify::CancellationToken(source)); });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  source.cancel();
  thread.join();
  CHECK(answer == verify::Answer::Unknown);
}

TEST_CASE("of two proofs at once one is cancelled and the other finishes, with a shared proof cache") {
  const testing::ScratchFolder folder;
  Asked endless(kEndless, kEndlessProperty), lock(kLock);
  verify::CancellationSource endless_source, lock_source;
  std::atomic<bool> is_endless_running{false}, is_endless_cancelled{false};
  verify::Decision cancelled, finished;
  verify::ReuseCounts cancelled_counts, finished_counts;
  const auto with_cache = [&](Asked& asked, const verify::CancellationSource& source, const verify::Report& report,
                              verify::ReuseCounts& counts) {
    ContentCache cache(ContentKind::Proof, folder.path(), std::uint64_t{1} << 30);
    verify::ProofCache proofs(cache, "unit", verify::StorePolicy::All);
    verify::Decision decision = asked.decide(verify::CancellationToken(source).within(300), report, &proofs);
    counts = proofs.counts;
    return decision;
  };
  std::thread first([&] {
    const verify::Report report = [&](const char*, std::uint64_t, const char*) { is_endless_running = true; };
    cancelled = with_cache(endless, endless_source, report, cancelled_counts);
  });
  std::thread second([&] {
    // In the middle of its proof it waits until the other one was cancelled.
    const verify::Report report = [&](const char*, std::uint64_t, const char*) { wait_for(is_endless_cancelled); };
    finished = with_cache(lock, lock_source, report, finished_counts);
  });
  wait_for(is_endless_running);
  endless_source.cancel();
  is_endless_cancelled = true;
  first.join();
  second.join();
  CHECK(cancelled.outcome == Outcome::Unknown);
  CHECK(cancelled.reason == "interrupted");
  CHECK(cancelled_counts.stored == 0);
  CHECK(finished.outcome == Outcome::Holds);
  CHECK(std::holds_alternative<verify::InvariantProof>(finished.evidence));
  CHECK(finished_counts.stored > 0);

  // The finished proof is in the cache; of the cancelled question nothing is.
  (void)with_cache(lock, lock_source, ignore_progress, finished_counts);
  CHECK(finished_counts.is_whole);
  (void)with_cache(endless, endless_source, ignore_progress, cancelled_counts);
  CHECK_FALSE(cancelled_counts.is_whole);
}

TEST_CASE("a proof whose time is over is not interrupted") {
  Asked endless(kEndless, kEndlessProperty);
  const verify::Decision decision = endless.decide(verify::within_seconds(0.2), ignore_progress);
  CHECK(decision.outcome == Outcome::Unknown);
  CHECK(decision.reason.find("interrupted") == std::string::npos);
  CHECK(decision.reason.find("time") != std::string::npos);
}

TEST_CASE("a transition system is not built when the time is over, and is built once when there is time") {
  const gen::Compiled compiled = gen::compile_texts({kLock});
  REQUIRE(compiled.problem.empty());
  verify::SystemParts parts(*compiled.system, compiled.lowered->image, verify::StateAccess::Searchable,
                            [] { return true; });
  constexpr std::size_t kMegabytes = 100;
  CHECK(parts.transition_system(kMegabytes, verify::within_seconds(0)) == nullptr);
  CHECK(parts.built_transition_system() == nullptr);
  const verify::TransitionSystem* const built = parts.transition_system(kMegabytes, {});
  REQUIRE(built != nullptr);
  CHECK_FALSE(built->steps.empty());
  CHECK(parts.transition_system(kMegabytes, verify::within_seconds(0)) == built);
}
