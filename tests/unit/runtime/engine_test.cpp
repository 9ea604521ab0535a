// The engine: formats byte by byte, policies, determinism, the numbers behind `uniform`, stories, options.
#include <catch2/catch.hpp>

#include <cstdio>
#include <cstring>

#include "bip/bip.h"
#include "bip/bip.hpp"
#include "runtime/include/bip/prng.hpp"
#include "runtime/engine/policies.hpp"
#include "runtime/engine/scheduler.hpp"
#include "runtime/trace/recorded.hpp"
#include "runtime/trace/trace_formats.hpp"
#include "tests/unit/base/contents.hpp"
#include "tests/unit/runtime/helpers.hpp"
#include "tests/unit/runtime/models.hpp"

using namespace bip::rt;
using namespace bip::rt::testing;
using bip::testing::contents;

namespace {

struct Ran {
  RunResult result;
  std::string out, err;
};
Ran ran(const Image& image, const RunOptions& options) {
  std::FILE* out = std::tmpfile();
  std::FILE* err = std::tmpfile();
  Ran result{run(image, options, out, err), "", ""};
  result.out = contents(out);
  result.err = contents(err);
  return result;
}
RunOptions seeded(std::uint64_t seed, std::uint64_t limit) {
  RunOptions options;
  options.seed = seed;
  options.has_seed = true;
  options.limit = limit;
  return options;
}
std::string trace_of(const Image& image, RunOptions options) {
  options.trace_path = std::tmpnam(nullptr);
  (void)ran(image, options);
  std::FILE* file = std::fopen(options.trace_path.c_str(), "rb");
  REQUIRE(file != nullptr);
  const std::string text = contents(file);
  std::remove(options.trace_path.c_str());
  return text;
}

}  // namespace

TEST_CASE("xoshiro256++ and SplitMix64 as published") {
  // An independent transcription of the two papers' reference code, in plain arithmetic.
  const std::uint64_t seed = 42;
  std::uint64_t state = seed;
  std::uint64_t s[4];
  for (std::uint64_t& word : s) {
    state += 11400714819323198485ull;
    std::uint64_t z = state;
    z = (z ^ (z >> 30)) * 13787848793156543929ull;
    z = (z ^ (z >> 27)) * 10723151780598845931ull;
    word = z ^ (z >> 31);
  }
  const auto left = [](std::uint64_t x, int k) { return (x << k) | (x >> (64 - k)); };
  Prng prng(seed);
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t expected = left(s[0] + s[3], 23) + s[0];
    const std::uint64_t t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = left(s[3], 45);
    REQUIRE(prng.next() == expected);
  }
  // The first word of SplitMix64 seeded with 0 is in every description of it.
  std::uint64_t z = 11400714819323198485ull;
  z = (z ^ (z >> 30)) * 13787848793156543929ull;
  z = (z ^ (z >> 27)) * 10723151780598845931ull;
  CHECK((z ^ (z >> 31)) == 0xe220a8397b1dcdafull);
}

TEST_CASE("below is uniform and in range") {
  Prng prng(1);
  std::vector<int> seen(7, 0);
  for (int i = 0; i < 70000; ++i) ++seen[prng.below(7)];
  for (int count : seen) CHECK((count > 9600 && count < 10400));
  // Large bounds are where rejection matters.
  const std::uint64_t big = (std::uint64_t{1} << 63) + 1;
  for (int i = 0; i < 1000; ++i) CHECK(prng.below(big) < big);
}

TEST_CASE("the enabled set agrees with a list") {
  for (const bool weighted : {false, true}) {
    for (const u32 interactions : {1u, 63u, 64u, 65u, 513u, 5000u, 40000u}) {
      EnabledSet set;
      set.reset(interactions, weighted);
      bip::IndexVector<InteractionId, u32> weights(interactions, 0);
      Prng prng(interactions);
      for (int i = 0; i < 400; ++i) {
        const InteractionId interaction(prng.below(interactions));
        weights[interaction] = static_cast<u32>(prng.below(weighted ? 4 : 2));
        set.set(interaction, weights[interaction]);
        if (i % 40 != 0) continue;
        std::uint64_t k = 0;
        for (const InteractionId s : weights.ids()) {
          if (weights[s] != 0 || s.value % 97 == 0) REQUIRE(set.rank(s) == k);
          for (u32 r = 0; r < weights[s]; ++r, ++k) {
            REQUIRE(set.select(k).interaction == s);
            REQUIRE(set.select(k).rank == r);
          }
        }
        REQUIRE(set.total() == k);
      }
    }
  }
}

TEST_CASE("the k-th one of a word, with and without the instruction") {
  Prng prng(5);
  for (int i = 0; i < 2000; ++i) {
    std::uint64_t word = prng.next() & prng.next();
    if (i == 0) word = ~std::uint64_t{0};
    u32 k = 0;
    for (u32 bit = 0; bit < 64; ++bit) {
      if ((word >> bit & 1) == 0) continue;
      REQUIRE(EnabledSet::select_bit(word, k) == bit);
      if (EnabledSet::has_fast_pdep()) REQUIRE(EnabledSet::select_bit_pdep(word, k) == bit);
      ++k;
    }
  }
}

TEST_CASE("a list that is put back knows what came and went since it was up to date") {
  EnabledSet set;
  set.reset(8, false);
  const std::vector<InteractionId> order{1_i, 2_i, 5_i};
  for (const InteractionId interaction : order) set.insert(interaction);
  set.list(8);
  set.erase(2_i);
  set.insert(7_i);
  set.unlist();
  set.list(order, 8);
  CHECK(set.weight(2_i) == 0);
  CHECK(set.weight(7_i) == 1);
  set.settle_list();
  REQUIRE(set.listed_count() == 3);
  CHECK(set.listed(0) == 1_i);
  CHECK(set.listed(1) == 5_i);
  CHECK(set.listed(2) == 7_i);
  set.erase(7_i);
  set.settle_list();
  CHECK(set.listed_count() == 2);
}

TEST_CASE("members of a word come and go together") {
  EnabledSet set;
  set.reset(200, false);
  set.insert(70_i);
  set.insert(130_i);
  // 70 goes, 65 and 99 come.
  set.flip(1, std::uint64_t{1} << 6 | std::uint64_t{1} << 1 | std::uint64_t{1} << 35, 1);
  REQUIRE(set.total() == 3);
  CHECK(set.select(0).interaction == 65_i);
  CHECK(set.select(1).interaction == 99_i);
  CHECK(set.select(2).interaction == 130_i);
  set.erase(65_i);
  set.erase(130_i);
  REQUIRE(set.total() == 1);
  CHECK(set.select(0).interaction == 99_i);
}

// The rule as semantics.md has it: in interaction order, the last one replaces what goes, what comes goes to the end.
TEST_CASE("the list's order follows the rule, and ranks are there when asked for") {
  for (const bool weighted : {false, true}) {
    constexpr u32 kInteractions = 300;
    constexpr InteractionId last(kInteractions - 1);
    EnabledSet set;
    set.reset(kInteractions, weighted);
    Prng prng(weighted ? 3 : 4);
    bip::IndexVector<InteractionId, u32> weights(kInteractions, 0);
    std::vector<InteractionId> order;
    for (const InteractionId interaction : weights.ids()) {
      if (interaction.value % 3 != 0) continue;
      set.set(interaction, weights[interaction] = 1);
      order.push_back(interaction);
    }
    set.list(kInteractions);
    for (int step = 0; step < 500; ++step) {
      bip::IndexVector<InteractionId, u32> after = weights;
      // Few and many: they are put in order in two ways.
      for (std::uint64_t changes = prng.below(step % 9 == 4 ? 60 : 6); changes > 0; --changes) {
        const InteractionId interaction(prng.below(kInteractions));
        after[interaction] = static_cast<u32>(prng.below(weighted ? 3 : 2));
        // There and back within a step counts as nothing.
        set.set(interaction, after[interaction] == 0 ? 1 : 0);
        set.set(interaction, after[interaction]);
      }
      for (const InteractionId interaction : weights.ids()) {
        if ((weights[interaction] == 0) == (after[interaction] == 0)) continue;
        if (after[interaction] != 0) {
          order.push_back(interaction);
          continue;
        }
        const auto at = std::find(order.begin(), order.end(), interaction);
        *at = order.back();
        order.pop_back();
      }
      weights = after;
      if (step % 50 == 20) CHECK(set.rank(last) + weights[last] == set.total());
      set.settle_list();
      REQUIRE(set.listed_count() == order.size());
      for (u32 i = 0; i < order.size(); ++i) REQUIRE(set.listed(i) == order[i]);
      if (step % 70 == 69) set.list(order, kInteractions);
    }
    set.unlist();
    std::uint64_t k = 0;
    for (const InteractionId interaction : weights.ids()) {
      for (u32 r = 0; r < weights[interaction]; ++r, ++k) REQUIRE(set.select(k).interaction == interaction);
    }
    CHECK(k == set.total());
  }
}

TEST_CASE("steps, limit, values before down") {
  ImageBuilder b;
  build_pairs(b, 2);
  const Ran one = ran(b.image(), seeded(42, 3));
  CHECK(one.out ==
        "bipc: seed 42, policy uniform\n"
        "#0  ROOT.there0  a0.put(v=0) b0.get(v=0)\n"
        "#1  ROOT.back0  b0.put(v=0) a0.get(v=0)\n"
        "#2  ROOT.there0  a0.put(v=1) b0.get(v=0)\n"
        "limit: 3 steps\n");
  CHECK(one.err.empty());
  CHECK(one.result.end == End::Limit);
  CHECK(one.result.steps == 3);
  RunOptions silent = seeded(42, 3);
  silent.silent = true;
  CHECK(ran(b.image(), silent).out == "bipc: seed 42, policy uniform\nlimit: 3 steps\n");
}

TEST_CASE("the published engine's lines") {
  ImageBuilder b;
  b.atom_type({.name = "T",
               .ports = {{.name = "p"}, {.name = "think", .exported = false}},
               .places = {"A", "B", "C"},
               .initial = {"A"},
               .transitions = {{"p", {"A"}, {"B"}}, {"think", {"B"}, {"C"}}}});
  b.connector_type({.name = "One", .params = {{"p", 0}}, .define = "p"});
  b.atom("a", "T");
  b.atom("c", "T");
  b.connector("k", "One", {"a.p"});
  b.connector("l", "One", {"c.p"});
  RunOptions options = seeded(7, 100);
  options.policy = Policy::First;
  options.format = TraceFormat::Bip2;
  CHECK(ran(b.image(), options).out ==
        "[BIP ENGINE]: initialize components...\n"
        "[BIP ENGINE]: first scheduling\n"
        "[BIP ENGINE]: state #0: 2 interactions:\n"
        "[BIP ENGINE]:   [0] ROOT.k: a.p()\n"
        "[BIP ENGINE]:   [1] ROOT.l: c.p()\n"
        "[BIP ENGINE]: -> choose [0] ROOT.k: a.p()\n"
        "[BIP ENGINE]: state #1: 1 interaction and 1 internal port:\n"
        "[BIP ENGINE]:   [0] ROOT.l: c.p()\n"
        "[BIP ENGINE]:   [1] ROOT.a.think\n"
        "[BIP ENGINE]: -> choose [0] ROOT.l: c.p()\n"
        "[BIP ENGINE]: state #2: 2 internal ports:\n"
        "[BIP ENGINE]:   [0] ROOT.a.think\n"
        "[BIP ENGINE]:   [1] ROOT.c.think\n"
        "[BIP ENGINE]: -> choose [0] ROOT.a.think\n"
        "[BIP ENGINE]: state #3: 1 internal port:\n"
        "[BIP ENGINE]:   [0] ROOT.c.think\n"
        "[BIP ENGINE]: -> choose [0] ROOT.c.think\n"
        "[BIP ENGINE]: state #4: deadlock!\n");
  options.policy = Policy::Uniform;
  options.seed = 42;
  const std::string uniform = ran(b.image(), options).out;
  CHECK(uniform.find("[BIP ENGINE]: random scheduling based on seed=42\n") != std::string::npos);
}

TEST_CASE("JSON lines") {
  ImageBuilder b;
  build_pairs(b, 2);
  CHECK(
      trace_of(b.image(), seeded(42, 2)) ==
      R"({"format":"bipc-trace","version":1,"model":"Test","seed":42,"policy":"uniform"})"
      "\n"
      R"({"step":0,"choice":0,"candidates":1,"interaction":"ROOT.there0","ports":[{"port":"ROOT.a0.put","values":{"v":0}},{"port":"ROOT.b0.get","values":{"v":0}}]})"
      "\n"
      R"({"step":1,"choice":0,"candidates":1,"interaction":"ROOT.back0","ports":[{"port":"ROOT.b0.put","values":{"v":0}},{"port":"ROOT.a0.get","values":{"v":0}}]})"
      "\n"
      R"({"end":"limit","steps":2})"
      "\n");
}

TEST_CASE("same seed, same trace; another seed, another") {
  ImageBuilder b;
  build_philosophers(b, 10, false);
  const std::string once = trace_of(b.image(), seeded(42, 500));
  CHECK(once == trace_of(b.image(), seeded(42, 500)));
  CHECK(once != trace_of(b.image(), seeded(43, 500)));
}

TEST_CASE("fair: what stays enabled has its turn in every round") {
  ImageBuilder b;
  build_pairs(b, 16);
  Core core(b.image());
  REQUIRE(core.initialize());
  Scheduler fair(Policy::Fair, 0);
  bip::IndexVector<InteractionId, int> fired(16, 0);
  for (int i = 0; i < 1600; ++i) {
    const Candidate candidate = core.candidate(fair.choose(core));
    ++fired[candidate.interaction];
    REQUIRE(core.fire(candidate));
    fair.fired(candidate.interaction);
  }
  for (int count : fired) CHECK((count >= 99 && count <= 101));
  // Cyclic: after the last interaction comes the first again.
  CHECK(core.enabled().next_after(15_i) == 0);
}

TEST_CASE("the first candidate after an interaction is the one with its number, near and far, at both ends") {
  constexpr std::uint32_t kSize = 4096;
  Prng prng(5);
  for (const bool is_weighted : {false, true}) {
    for (const std::uint32_t members : {1u, 3u, 40u, 2000u}) {
      EnabledSet set;
      set.reset(kSize, is_weighted);
      for (std::uint32_t k = 0; k < members; ++k)
        set.set(InteractionId(static_cast<std::uint32_t>(prng.below(kSize))), is_weighted ? 3 : 1);
      for (std::uint32_t k = 0; k < kSize; ++k) {
        const EnabledSet::Position first = set.first_after(InteractionId(k));
        const EnabledSet::Position same = set.select(set.next_after(InteractionId(k)));
        REQUIRE((first.interaction == same.interaction && first.rank == same.rank));
      }
    }
  }
}

TEST_CASE("policies and trace formats are found by the names of their rows") {
  for (const PolicyRow& row : policies()) {
    REQUIRE(find_policy(row.name) != nullptr);
    CHECK(find_policy(row.name)->policy == row.policy);
    CHECK(&row_of(row.policy) == find_policy(row.name));
  }
  for (const TraceFormatRow& row : trace_formats()) {
    REQUIRE(find_trace_format(row.name) != nullptr);
    CHECK(&row_of(row.format) == find_trace_format(row.name));
  }
  CHECK(find_policy("best") == nullptr);
  CHECK(find_trace_format("best") == nullptr);
}

TEST_CASE("a copy of a scheduler goes on as the original does") {
  ImageBuilder b;
  build_pairs(b, 16);
  for (const PolicyRow& row : policies()) {
    Core core(b.image());
    REQUIRE(core.initialize());
    Scheduler scheduler(row.policy, 5);
    scheduler.start(core);
    for (int i = 0; i < 10; ++i) {
      const EnabledSet::Position position = scheduler.choose(core);
      REQUIRE(core.fire(core.candidate(position)));
      scheduler.fired(position.interaction);
    }
    Scheduler copy = scheduler;
    const InteractionId chosen = copy.choose(core).interaction;
    CHECK(chosen == scheduler.choose(core).interaction);
    // The copy has a memory of its own.
    copy.fired(15_i);
    CHECK(scheduler.prng() == copy.prng());
    if (row.policy == Policy::Fair) CHECK(scheduler.choose(core).interaction == chosen);
  }
}

TEST_CASE("the head of a binary trace is read back; other versions are refused by name") {
  ImageBuilder b;
  build_pairs(b, 2);
  RecordedWriter writer;
  std::string bytes;
  writer.begin(bytes, {.image = &b.image(),
                       .seed = 300,
                       .policy = "of another bipc",
                       .engine = Engine::Batch,
                       .maximal_progress = false});
  RecordedReader reader;
  RecordedBegin begin;
  REQUIRE(reader.open(bytes, begin).empty());
  CHECK(begin.name == b.image().name);
  CHECK(begin.seed == 300);
  CHECK(begin.policy == "of another bipc");
  CHECK(begin.engine == Engine::Batch);
  CHECK(!begin.maximal_progress);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    RecordedBegin cut;
    CHECK(!RecordedReader().open(bytes.substr(0, size), cut).empty());
  }
  bytes[6] = '1';
  CHECK(reader.open(bytes, begin).find("version 1") != std::string::npos);
}

TEST_CASE("a deadlock is told as a cycle") {
  ImageBuilder b;
  build_philosophers(b, 2, true);
  Core core(b.image());
  RunOptions options = seeded(1, 1000000);
  options.silent = true;
  options.policy = Policy::Fair;
  const Ran one = ran(b.image(), options);
  CHECK(one.result.end == End::Deadlock);
  CHECK(one.result.exit_code == 0);
  CHECK(one.out ==
        "bipc: seed 1, policy fair\n"
        "deadlock[V0001]: 2 components wait for each other   (2 steps, seed 1)\n"
        "  phil[0] at `has_left`  test.bip:12   wants take_right  <- fork[1] at `busy`  test.bip:4\n"
        "  phil[1] at `has_left`  test.bip:12   wants take_right  <- fork[0] at `busy`  test.bip:4\n"
        "  cycle: phil[0] -> fork[1] -> phil[1] -> fork[0] -> phil[0]\n");
}

TEST_CASE("other deadlocks: the end, a false guard, somebody who has gone") {
  ImageBuilder b;
  b.atom_type({.name = "Once",
               .ports = {{.name = "p"}},
               .places = {"A", "B"},
               .initial = {"A"},
               .transitions = {{"p", {"A"}, {"B"}}}});
  b.atom_type(always_ready("T"));
  b.connector_type({.name = "One", .params = {{"p", 0}}, .define = "p"});
  b.atom("a", "Once");
  b.connector("k", "One", {"a.p"});
  RunOptions options = seeded(1, 100);
  options.silent = true;
  CHECK(ran(b.image(), options).out ==
        "bipc: seed 1, policy uniform\n"
        "deadlock[V0001]: no component offers a port: all have come to an end   (1 step, seed 1)\n");

  ImageBuilder c;
  c.atom_type({.name = "Once",
               .ports = {{.name = "p"}, {.name = "q"}},
               .places = {"A", "B"},
               .initial = {"A"},
               .transitions = {{"p", {"A"}, {"B"}}}});
  c.atom_type(always_ready("T"));
  c.connector_type({.name = "One", .params = {{"p", 0}}, .define = "p"});
  c.connector_type({.name = "No",
                    .params = {{"p", 0}},
                    .define = "p",
                    .clauses = {{.params = {"p"}, .guard = [](Cell*, Cell*, const u32*) { return 0; }}}});
  c.connector_type({.name = "Two", .params = {{"p", 0}, {"q", 0}}, .define = "p q"});
  c.atom("a", "Once");
  c.atom("t", "T");
  c.atom("u", "T");
  c.connector("k", "One", {"a.p"});
  c.connector("two", "Two", {"t.p", "a.q"});
  c.connector("no", "No", {"u.p"});
  CHECK(ran(c.image(), options).out ==
        "bipc: seed 1, policy uniform\n"
        "deadlock[V0001]: 2 components wait in vain   (1 step, seed 1)\n"
        "  t at `S`  test.bip:6   wants p  <- a at `B`  test.bip:12\n"
        "  u at `S`  test.bip:6   wants p, which is ready\n"
        "  connector ROOT.no: its guard is false  test.bip:17\n");
}

TEST_CASE("the command line of an emitted program") {
  ImageBuilder b;
  build_ring(b, 3);
  const auto main_of = [&](std::vector<std::string> words) {
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    return run_main(b.image(), static_cast<int>(argv.size()), argv.data());
  };
  CHECK(main_of({"model", "--silent", "--limit=5", "--seed", "1"}) == 0);
  CHECK(main_of({"model", "--limit", "x"}) == 2);
  CHECK(main_of({"model", "--nonsense"}) == 2);
  CHECK(main_of({"model", "--policy"}) == 2);
}

TEST_CASE("embedding: names of the steps that are needed") {
  ImageBuilder b;
  build_pairs(b, 4);
  std::vector<bip::Step> all, few;
  bip::Execution whole(b.image(), {.seed = 3}), part(b.image(), {.seed = 3});
  whole.on_step([&](const bip::Step& step) { all.push_back(step); });
  REQUIRE(whole.run(60) == 60);
  const std::string needed = all[0].ports[0];
  part.on_step([&](const bip::Step& step) { few.push_back(step); },
               [&](const std::string& port) { return port == needed; });
  CHECK(part.run(40) == 40);
  part.name_all_steps(true);
  CHECK(part.run(20) == 20);
  REQUIRE(few.size() == 60);
  std::size_t without = 0;
  for (std::size_t k = 0; k < 60; ++k) {
    CHECK(few[k].number == k);
    const bool is_needed = std::find(all[k].ports.begin(), all[k].ports.end(), needed) != all[k].ports.end();
    if (k >= 40 || is_needed) {
      CHECK(few[k].interaction == all[k].interaction);
      CHECK(few[k].ports == all[k].ports);
      CHECK(few[k].values.size() == all[k].values.size());
    } else {
      CHECK((few[k].interaction.empty() && few[k].ports.empty() && few[k].values.empty()));
      ++without;
    }
  }
  CHECK(without > 0);
}

TEST_CASE("embedding: names of the steps that are needed, of interactions of all kinds") {
  ImageBuilder b;
  b.atom_type({.name = "T",
               .ports = {{.name = "p"}, {.name = "own", .exported = false}},
               .places = {"S"},
               .initial = {"S"},
               .transitions = {{"p", {"S"}, {"S"}}, {"own", {"S"}, {"S"}}}});
  for (const char* name : {"a", "c", "d"}) b.atom(name, "T");
  b.connector_type({.name = "Pair", .params = {{"l", 0}, {"r", 0}}, .define = "l r"});
  b.connector_type({.name = "Cast", .params = {{"l", 0}, {"r", 0}}, .define = "l' r"});
  b.connector_type({.name = "Inner", .params = {{"l", 0}}, .define = "l", .exports = true});
  b.connector("flat", "Pair", {"a.p", "c.p"});
  b.connector("star", "Cast", {"a.p", "c.p"});
  b.connector("inner", "Inner", {"c.p"});
  b.connector("planned", "Pair", {"inner", "d.p"});
  for (const std::string needed : {"ROOT.a.p", "ROOT.c.p", "ROOT.d.p", "ROOT.d.own"}) {
    std::vector<bip::Step> all, few;
    bip::Execution whole(b.image(), {.seed = 5}), part(b.image(), {.seed = 5});
    whole.on_step([&](const bip::Step& step) { all.push_back(step); });
    part.on_step([&](const bip::Step& step) { few.push_back(step); },
                 [&](const std::string& port) { return port == needed; });
    REQUIRE(whole.run(60) == 60);
    REQUIRE(part.run(60) == 60);
    std::size_t named = 0;
    for (std::size_t k = 0; k < 60; ++k) {
      const bool is_needed = std::find(all[k].ports.begin(), all[k].ports.end(), needed) != all[k].ports.end();
      named += is_needed ? 1 : 0;
      CHECK(few[k].ports == (is_needed ? all[k].ports : std::vector<std::string>{}));
    }
    CHECK((named > 0 && named < 60));
  }
}

TEST_CASE("embedding: step, read, snapshot, callback") {
  ImageBuilder b;
  build_pairs(b, 4);
  bip::Execution system(b.image(), {.seed = 3});
  std::vector<std::string> seen;
  system.on_step([&](const bip::Step& step) { seen.push_back(step.interaction + " " + step.ports[0]); });
  CHECK(system.run(10) == 10);
  CHECK(seen.size() == 10);
  const bip::Execution::Snapshot snapshot = system.snapshot();
  CHECK(system.run(20) == 20);
  const std::vector<std::string> first(seen.begin() + 10, seen.end());
  seen.clear();
  system.restore(snapshot);
  CHECK(system.steps() == 10);
  CHECK(system.run(20) == 20);
  CHECK(seen == first);
  std::int32_t x = -1;
  CHECK(system.read("ROOT.a0.x", x));
  CHECK(x >= 0);
  double f = 0;
  CHECK(!system.read("ROOT.a0.x", f));
  CHECK(!system.read("ROOT.nobody.x", x));
  CHECK((system.place("ROOT.a0") == "A" || system.place("ROOT.a0") == "B"));
}

TEST_CASE("embedding in C") {
  ImageBuilder b;
  build_philosophers(b, 2, true);
  const auto* image = reinterpret_cast<const bip_image*>(&b.image());
  CHECK(bip_create(image, 1, 9) == nullptr);
  CHECK(bip_create(image, 1, -1) == nullptr);
  CHECK(bip_find_policy("fair") == BIP_FAIR);
  CHECK(bip_find_policy("best") == -1);
  CHECK(bip_find_policy(nullptr) == -1);
  bip_execution* system = bip_create(image, 1, BIP_FAIR);
  REQUIRE(system != nullptr);
  CHECK(bip_status(system) == BIP_STEPPED);
  CHECK(bip_candidate_count(system) == 2);
  char buffer[16];
  CHECK(bip_candidate(system, 0, buffer, sizeof buffer) == 12);
  CHECK(std::string(buffer) == "ROOT.left[0]");
  bip_snapshot* snapshot = bip_save(system);
  CHECK(bip_run(system, 100) == 2);
  CHECK(bip_status(system) == BIP_DEADLOCK);
  CHECK(bip_story(system, nullptr, 0) > 100);
  CHECK(bip_place(system, "ROOT.phil[1]", buffer, 4) == 8);
  CHECK(std::string(buffer) == "has");
  bip_restore(system, snapshot);
  CHECK(bip_steps(system) == 0);
  CHECK(bip_fire(system, 1) == BIP_STEPPED);
  bip_free_snapshot(snapshot);
  bip_destroy(system);
}
