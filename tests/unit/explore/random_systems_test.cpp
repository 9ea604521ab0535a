// The explorer against the naive one on random systems (tools/gen): data, guards, triggers, hierarchy, merged ports,
// priorities, run-time errors. All counts, the ways, the successors of each state, deadlocks under partial-order
// reduction.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>

#include "compiler/interp/interp.hpp"
#include "runtime/explore/explore.hpp"
#include "runtime/explore/expander.hpp"
#include "tests/unit/explore/naive.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/description.hpp"

namespace {

using namespace bip;
using rt::testing::Naive;

constexpr std::uint64_t kMost = 400;  // states that are visited naively

std::uint64_t count_of_runs(std::uint64_t usual) {
  const char* wanted = std::getenv("BIP_EXPLORE_RUNS");
  return wanted == nullptr ? usual : std::strtoull(wanted, nullptr, 10);
}

struct Tally {
  int compared = 0, partial = 0, skipped = 0, with_error = 0, with_deadlock = 0, reduced = 0, broken = 0, unbroken = 0;
  std::uint64_t states = 0;
};

// Exploring is meant for systems that can be explored; the interpreter's faults and C++'s memory are tested elsewhere.
bool is_fit(const gen::Compiled& c) {
  return c.problem.empty() && c.system->code.functions.empty() && c.system->code.ffi_types.empty();
}

// The successors that tables give are those that the core gives, state by state.
void compare_successors(const rt::Image& image, rt::MaximalProgress progress, const Naive& naive) {
  rt::Core core(image, {.progress = progress});
  REQUIRE(core.initialize());
  rt::StateSpace space;
  space.image = &image;
  space.progress = progress;
  space.shapes = rt::shapes_of(core, progress);
  space.locals = std::make_unique<rt::Locals>(core);
  space.initial = core.snapshot();
  const auto number_all = [&] {
    for (rt::u32 atom = 0; atom < image.atoms.size; ++atom) (void)space.locals->number(atom, core);
  };
  // First all numbers, so that one layout does.
  for (const rt::State& state : naive.all) {
    for (std::uint64_t k = 0;; ++k) {
      REQUIRE(core.restore(state));
      number_all();
      if (k >= core.candidate_count()) break;
      if (core.fire(k)) number_all();
    }
  }
  space.layout = rt::Layout(*space.locals);
  rt::Expander expander(space, 1);
  rt::Outbox out;
  out.words.resize(1);
  const rt::u32 words = space.layout.words();
  std::vector<rt::u64> packed(words);
  for (const rt::State& state : naive.all) {
    std::vector<std::vector<rt::u64>> expected, found;
    REQUIRE(core.restore(state));
    REQUIRE(expander.pack(core, packed.data()));
    const std::vector<rt::u64> source = packed;
    const std::uint64_t count = core.candidate_count();
    for (std::uint64_t k = 0; k < count; ++k) {
      if (k != 0) REQUIRE(core.restore(state));
      if (!core.fire(k)) continue;
      REQUIRE(expander.pack(core, packed.data()));
      expected.push_back(packed);
    }
    out.clear();
    (void)expander.expand(source.data(), out);
    for (std::size_t at = 0; at < out.words[0].size(); at += words)
      found.emplace_back(out.words[0].begin() + static_cast<std::ptrdiff_t>(at),
                         out.words[0].begin() + static_cast<std::ptrdiff_t>(at + words));
    REQUIRE(found == expected);
  }
}

// States that are looked for: by what two atoms are in, and by what a connector offers.
void compare_broken(const rt::Image& image, rt::ExploreOptions options, const Naive& naive, Tally& tally) {
  const auto look = [&](const std::function<bool(const rt::Core&)>& is_so) {
    rt::Core core(image, {.progress = options.progress});
    REQUIRE(core.initialize());
    std::optional<std::size_t> first;
    for (std::size_t row = 0; row < naive.all.size() && !first; ++row) {
      REQUIRE(core.restore(naive.all[row]));
      if (is_so(core)) first = row;
    }
    options.predicate = is_so;
    for (const std::uint32_t threads : {1u, 3u}) {
      options.threads = threads;
      const rt::ExploreReport found = rt::explore_states(image, options);
      CHECK(found.end == rt::ExploreEnd::Complete);
      CHECK(found.states == naive.states);
      CHECK(found.has_match == first.has_value());
      if (first) CHECK(found.match == naive.way_to(*first));
    }
    ++(first ? tally.broken : tally.unbroken);
  };
  const rt::u32 a = 0, b = image.atoms.size - 1;
  // The place that the walk has come to at its end, so that it is reached at least there, and a value that may never
  // be.
  rt::Core last(image, {.progress = options.progress});
  REQUIRE(last.restore(naive.all.back()));
  const auto place_of = [&](rt::u32 atom) {
    rt::u32 place = 0;
    while (place + 1 < image.atom_types[image.atoms[atom].type].places.size && !last.is_marked(atom, place)) ++place;
    return place;
  };
  const rt::u32 at_a = place_of(a), at_b = image.atom_types[image.atoms[b].type].places.size - 1;
  options.predicate_reads = {a, b};
  look([=](const rt::Core& core) { return core.is_marked(a, at_a) && core.is_marked(b, at_b); });
  options.predicate_reads.clear();
  const rt::u32 connector = image.connectors.size - 1;
  options.predicate_connectors = {connector};
  look([=](const rt::Core& core) {
    for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
      if (core.candidate(k).connector == connector) return true;
    }
    return false;
  });
}

void compare(const std::vector<std::string>& texts, rt::MaximalProgress progress, Tally& tally) {
  const gen::Compiled c = gen::compile_texts(texts);
  if (!is_fit(c)) {
    ++tally.skipped;
    return;
  }
  INFO(texts.back());
  const interp::Interpreter interpreter(*c.lowered);
  const rt::Image& image = c.lowered->image;
  const Naive naive = rt::testing::explore_naively(image, progress, kMost);
  ++tally.compared;
  tally.states += naive.states;
  tally.with_error += naive.errors != 0 ? 1 : 0;
  tally.with_deadlock += naive.deadlocks != 0 ? 1 : 0;
  rt::ExploreOptions options{.progress = progress};
  if (!naive.is_complete) {
    // Which states are found before the limit depends on the order: with a limit it is the naive one.
    ++tally.partial;
    options.limit = kMost;
    const rt::ExploreReport found = rt::explore_states(image, options);
    CHECK(found.end == rt::ExploreEnd::States);
    CHECK(found.states == naive.states);
    CHECK(found.steps == naive.steps);
    CHECK(found.deadlocks == naive.deadlocks);
    CHECK(found.finals == naive.finals);
    if (naive.deadlocks != 0) CHECK(found.deadlock == naive.deadlock);
    return;
  }
  for (const std::uint32_t threads : {1u, 2u, 3u}) {
    options.threads = threads;
    const rt::ExploreReport found = rt::explore_states(image, options);
    INFO("threads " << threads);
    CHECK(found.end == rt::ExploreEnd::Complete);
    CHECK(found.states == naive.states);
    CHECK(found.steps == naive.steps);
    CHECK(found.deadlocks == naive.deadlocks);
    CHECK(found.finals == naive.finals);
    CHECK(found.errors == naive.errors);
    CHECK(found.depth == naive.depth);
    CHECK(found.are_paths_known);
    if (naive.deadlocks != 0) CHECK(found.deadlock == naive.deadlock);
    if (naive.has_error_way) CHECK(found.error == naive.error);
  }
  if (naive.initial_fault) return;
  compare_successors(image, progress, naive);
  if (image.atoms.size != 0 && image.connectors.size != 0) compare_broken(image, {.progress = progress}, naive, tally);
  options.reduction = rt::StateReduction::Por;
  if (naive.errors != 0 || !rt::reduction_problem(image, options).empty()) return;
  ++tally.reduced;
  const rt::ExploreReport found = rt::explore_states(image, options);
  CHECK(found.deadlocks == naive.deadlocks);
  CHECK(found.states <= naive.states);
}

}  // namespace

TEST_CASE("random systems are explored as the core would, one state at a time") {
  Tally tally;
  const std::uint64_t runs = count_of_runs(120);
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    compare(gen::print_packages(gen::generate(seed)),
            seed % 4 == 0 ? rt::MaximalProgress::Off : rt::MaximalProgress::On, tally);
  }
  WARN("compared " << tally.compared << " (" << tally.states << " states), up to a limit " << tally.partial
                   << ", with errors " << tally.with_error << ", with deadlocks " << tally.with_deadlock << ", reduced "
                   << tally.reduced << ", states looked for " << tally.broken << ", in vain " << tally.unbroken
                   << ", skipped " << tally.skipped);
  CHECK(tally.compared > static_cast<int>(runs) / 8);
  CHECK(tally.with_deadlock > 0);
  CHECK(tally.broken > 0);
  CHECK(tally.unbroken > 0);
}
