// Houdini by parts, on rings of cells: which candidates remain, given which others.
#include <catch2/catch.hpp>

#include <algorithm>

#include "compiler/system/system.hpp"
#include "compiler/verify/invariants/houdini.hpp"
#include "compiler/verify/invariants/local_houdini.hpp"
#include "compiler/verify/net/net.hpp"
#include "tools/gen/compiled.hpp"

namespace bip::verify {

namespace {

// A token goes round; the last cell drops it, or not.
const char* const kRing = R"(package p
  port type Signal()
  connector type Pass(Signal a, Signal b)
    define a b
  end
  connector type Alone(Signal a)
    define a
  end
  atom type Cell(bool first)
    data bool is_first = first
    export port Signal give(), take(), copy()
    place EMPTY, FULL
    initial to EMPTY
    internal from EMPTY to FULL provided (is_first) do { is_first = false; }
    on give from FULL to EMPTY
    on take from EMPTY to FULL
    on copy from EMPTY to FULL
  end
  compound type Ring(int n)
    for i in 0..n component Cell cell[i](i == 0)
    for i in 0..n connector Pass pass[i](cell[i].give, cell[(i + 1) % n].take)
  end
  compound type Leaky(int n)
    for i in 0..n component Cell cell[i](i == 0)
    for i in 0..n connector Pass pass[i](cell[i].give, cell[(i + 1) % n].take)
    connector Alone copy(cell[n - 1].copy)
  end
)";

struct Ring {
  explicit Ring(const std::string& root)
      : compiled(gen::compile_texts({kRing + ("  compound type Root()\n    component " + root + "\n  end\nend\n")})) {
    INFO(compiled.problem);
    REQUIRE(compiled.problem.empty());
    machine = build_transition_system(*compiled.system, compiled.lowered->image);
    questions.system = &machine;
    questions.atom_of_port = build_net(*compiled.system).graph.atom_of_port;
    questions.type_of_atom.assign(machine.marks.size(), 0);
    questions.kind_of_step.assign(machine.steps.size(), 0);
  }
  /// That both cells are full.
  [[nodiscard]] Cube both(u32 a, u32 b) const {
    Cube cube;
    for (u32 row = 0; row < machine.bits.size(); ++row) {
      const StateBit& bit = machine.bits[row];
      if (bit.is_place && bit.row == 1 && (bit.atom == a || bit.atom == b)) cube.push_back(cube_literal_of(row, true));
    }
    REQUIRE(cube.size() == 2);
    return cube;
  }
  [[nodiscard]] std::vector<Cube> all_pairs() const {
    std::vector<Cube> cubes;
    for (u32 a = 0; a < machine.marks.size(); ++a) {
      for (u32 b = a + 1; b < machine.marks.size(); ++b) cubes.push_back(both(a, b));
    }
    return cubes;
  }
  /// With the candidate that the first token is not put in again.
  [[nodiscard]] std::vector<Cube> kept(std::vector<Cube> cubes) const {
    for (u32 row = 0; row < machine.bits.size(); ++row) {
      if (!machine.bits[row].is_place) cubes.push_back({cube_literal_of(row, true)});
    }
    std::vector<Cube> kept = keep_locally_inductive(questions, std::move(cubes), within_seconds(60));
    std::erase_if(kept, [](const Cube& cube) { return cube.size() == 1; });
    return kept;
  }

  gen::Compiled compiled;
  TransitionSystem machine;
  LocalQuestions questions;
};

}  // namespace

TEST_CASE("local Houdini: keeps what two components of a step and one neighbour prove") {
  const Ring ring("Ring all(9)");
  CHECK(ring.kept(ring.all_pairs()) == ring.all_pairs());
}

TEST_CASE("local Houdini: a candidate falls with the one that it needs, and so on") {
  const Ring ring("Ring all(5)");
  std::vector<Cube> cubes = ring.all_pairs();
  std::erase(cubes, ring.both(1, 3));
  CHECK(ring.kept(cubes).empty());
}

TEST_CASE("local Houdini: exclusions stand for candidates") {
  Ring ring("Ring all(5)");
  std::vector<Cube> neighbours;
  for (u32 a = 0; a < 5; ++a) neighbours.push_back(ring.both(a, (a + 1) % 5));
  CHECK(ring.kept(neighbours).empty());
  Exclusion& exclusion = ring.questions.exclusions.emplace_back();
  for (u32 atom = 0; atom < 5; ++atom) exclusion.signals.push_back({atom, 1, ring.machine.marks[atom][1]});
  CHECK(ring.kept(neighbours) == neighbours);
}

TEST_CASE("local Houdini: one component that differs refutes all") {
  const Ring leaky("Leaky all(6)");
  CHECK(leaky.kept(leaky.all_pairs()).empty());
  // Houdini, which knows the whole system, says the same.
  CHECK(houdini({.system = &leaky.machine,
                 .invariants = {},
                 .observed = {},
                 .followed = {},
                 .cancellation = {},
                 .report = {}},
                leaky.all_pairs())
            .lemmas.empty());
}

TEST_CASE("local Houdini: no candidate that an initial state has") {
  const Ring ring("Ring all(3)");
  Cube first = ring.both(0, 1);
  first.resize(1);
  CHECK(keep_locally_inductive(ring.questions, {first}, within_seconds(60)).empty());
}

TEST_CASE("local Houdini: nothing after its time") {
  const Ring ring("Ring all(4)");
  CHECK(keep_locally_inductive(ring.questions, ring.all_pairs(), within_seconds(0)).empty());
}

}  // namespace bip::verify
