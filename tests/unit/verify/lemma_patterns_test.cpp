// Patterns of lemmas: which words a cube becomes, and which cubes they are in a longer array.
#include <catch2/catch.hpp>

#include <algorithm>

#include "compiler/verify/scaling/lemma_patterns.hpp"
#include "tools/gen/compiled.hpp"

namespace bip::verify {

namespace {

// n lamps in a row with a bit each, n - 1 wires between them, one key.
std::string lamps(int n) {
  return R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Lamp()
    data bool bit = false
    export port Signal turn()
    place DARK, LIT
    initial to DARK
    on turn from DARK to LIT do { bit = !bit; }
    on turn from LIT to DARK
  end
  compound type Row(int n)
    component Lamp lamp[n], wire[n - 1]
    component Lamp key()
    for i in 0..n connector One a[i](lamp[i].turn)
    for i in 0..n - 1 connector One b[i](wire[i].turn)
    connector One c(key.turn)
  end
  compound type Root()
    component Row row()" +
         std::to_string(n) + R"()
  end
end
)";
}

struct LampRow {
  explicit LampRow(int n) : compiled(gen::compile_texts({lamps(n)})) {
    INFO(compiled.problem);
    REQUIRE(compiled.problem.empty());
    machine = build_transition_system(*compiled.system, compiled.lowered->image);
    REQUIRE(machine.unsupported.empty());
  }
  [[nodiscard]] u32 atom(const std::string& path) const {
    for (std::size_t k = 0; k < compiled.system->atoms.size(); ++k) {
      if (compiled.system->atoms[AtomId(k)].path == "ROOT.row." + path) return static_cast<u32>(k);
    }
    FAIL("no component " << path);
    return 0;
  }
  /// "lit": place 1; else the bit.
  [[nodiscard]] u32 literal(const std::string& path, bool is_place) const {
    for (u32 row = 0; row < machine.bits.size(); ++row) {
      const StateBit& bit = machine.bits[row];
      if (bit.atom == atom(path) && bit.is_place == is_place && (!is_place || bit.row == 1))
        return cube_literal_of(row, true);
    }
    FAIL("no bit of " << path);
    return 0;
  }
  [[nodiscard]] u32 lit(const std::string& path) const { return literal(path, true); }
  [[nodiscard]] u32 bit(const std::string& path) const { return literal(path, false); }

  gen::Compiled compiled;
  TransitionSystem machine;
};

Cube sorted(Cube cube) {
  std::sort(cube.begin(), cube.end());
  return cube;
}

/// What a cube of an instance becomes in a larger one.
std::set<Cube> grown(const LampRow& small, const LampRow& large, const Cube& cube) {
  const std::optional<IndexFamilies> of_large = find_families(*large.compiled.system),
                                     of_small = find_families(*small.compiled.system);
  REQUIRE(of_large);
  REQUIRE(of_small);
  const std::optional<Dimensions> dimensions =
      find_dimensions(*of_large, *large.compiled.system, *of_small, *small.compiled.system);
  REQUIRE(dimensions);
  CHECK(dimensions->count == 1);
  const std::optional<InstanceView> from = view_instance(*small.compiled.system, *of_large, *large.compiled.system,
                                                         *dimensions),
                                    to = view_instance(*large.compiled.system, *of_large, *large.compiled.system,
                                                       *dimensions);
  REQUIRE(from);
  REQUIRE(to);
  std::set<LemmaPattern> patterns;
  add_patterns(sorted(cube), small.machine, *from, *dimensions, patterns);
  std::set<Cube> cubes;
  for (PatternInstance& instance : instantiate({patterns.begin(), patterns.end()}, large.machine, *to, *dimensions))
    CHECK(cubes.insert(std::move(instance.cube)).second);
  return cubes;
}

}  // namespace

TEST_CASE("lemma patterns: single elements keep their order, gaps stretch") {
  const LampRow small(4), large(6);
  std::set<Cube> expected;
  for (int i = 0; i < 6; ++i) {
    for (int j = i + 1; j < 6; ++j)
      expected.insert(
          sorted({large.lit("lamp[" + std::to_string(i) + "]"), large.bit("lamp[" + std::to_string(j) + "]")}));
  }
  CHECK(grown(small, large, {small.lit("lamp[1]"), small.bit("lamp[3]")}).size() == 5);
  // Nothing beyond the last letter: it stays at the end.
  CHECK(grown(small, large, {small.lit("lamp[1]"), small.bit("lamp[2]")}) == [&] {
    std::set<Cube> neighbours;
    for (int i = 0; i + 1 < 6; ++i)
      neighbours.insert(
          sorted({large.lit("lamp[" + std::to_string(i) + "]"), large.bit("lamp[" + std::to_string(i + 1) + "]")}));
    return neighbours;
  }());
  const LampRow five(5);
  CHECK(grown(five, large, {five.lit("lamp[1]"), five.bit("lamp[3]")}) == expected);
}

TEST_CASE("lemma patterns: equal letters are a range or two elements") {
  const LampRow small(4), large(6);
  // All are lit: a range of all, and of less where nothing else is demanded there.
  const std::set<Cube> all =
      grown(small, large, {small.lit("lamp[0]"), small.lit("lamp[1]"), small.lit("lamp[2]"), small.lit("lamp[3]")});
  REQUIRE(all.size() == 1);
  CHECK(all.begin()->size() == 6);
  // Two at the beginning: ranges from the beginning, and exactly these two, which are one of the ranges.
  const std::set<Cube> first = grown(small, large, {small.lit("lamp[0]"), small.lit("lamp[1]")});
  CHECK(first.size() == 6);
  CHECK(first.contains(sorted({large.lit("lamp[0]"), large.lit("lamp[1]")})));
  CHECK(first.contains(Cube{large.lit("lamp[0]")}));
  // Two in the middle: any range, any two neighbours.
  const std::set<Cube> middle = grown(small, large, {small.lit("lamp[1]"), small.lit("lamp[2]")});
  CHECK(middle.size() == 21);
}

TEST_CASE("lemma patterns: arrays that grow together have positions in common, single components stay") {
  const LampRow small(4), large(6);
  const std::set<Cube> cubes = grown(small, large, {small.lit("lamp[1]"), small.lit("wire[1]"), small.bit("key")});
  // A wire to the right of each lamp but the last one.
  CHECK(cubes.size() == 5);
  for (int i = 0; i < 5; ++i)
    CHECK(cubes.contains(sorted({large.lit("lamp[" + std::to_string(i) + "]"),
                                 large.lit("wire[" + std::to_string(i) + "]"), large.bit("key")})));
}

TEST_CASE("lemma patterns: what would be too many instances is left out") {
  const LampRow small(5), large(40);
  const std::optional<IndexFamilies> families = find_families(*large.compiled.system),
                                     of_small = find_families(*small.compiled.system);
  REQUIRE((families && of_small));
  const std::optional<Dimensions> dimensions =
      find_dimensions(*families, *large.compiled.system, *of_small, *small.compiled.system);
  REQUIRE(dimensions);
  const std::optional<InstanceView> from = view_instance(*small.compiled.system, *families, *large.compiled.system,
                                                         *dimensions),
                                    to = view_instance(*large.compiled.system, *families, *large.compiled.system,
                                                       *dimensions);
  REQUIRE((from && to));
  std::set<LemmaPattern> patterns;
  add_patterns(sorted({small.lit("lamp[1]"), small.bit("lamp[3]")}), small.machine, *from, *dimensions, patterns);
  add_patterns({small.lit("lamp[2]")}, small.machine, *from, *dimensions, patterns);
  const std::vector<LemmaPattern> rows(patterns.begin(), patterns.end());
  CHECK(instantiate(rows, large.machine, *to, *dimensions).size() == 780 + 40);
  CHECK(instantiate(rows, large.machine, *to, *dimensions, {.cubes = 100}).size() == 40);
}

}  // namespace bip::verify
