// Local lemmas: which cubes are candidates, given sampled states, and which of them say the same.
#include <catch2/catch.hpp>

#include <algorithm>

#include "compiler/verify/invariants/local_lemmas.hpp"
#include "compiler/verify/net/net.hpp"
#include "tools/gen/compiled.hpp"

namespace bip::verify {

namespace {

// Lamps 0 and 1 turn together, and so do 1 and 2.
const char* const kLamps = R"(package p
  port type Signal()
  connector type Two(Signal a, Signal b)
    define a b
  end
  atom type Lamp()
    export port Signal turn()
    place DARK, LIT
    initial to DARK
    on turn from DARK to LIT
    on turn from LIT to DARK
  end
  compound type Root()
    component Lamp lamp[3]()
    connector Two first(lamp[0].turn, lamp[1].turn), second(lamp[1].turn, lamp[2].turn)
  end
end
)";

struct Lamps {
  Lamps() : compiled(gen::compile_texts({kLamps})) {
    INFO(compiled.problem);
    REQUIRE(compiled.problem.empty());
    machine = build_transition_system(*compiled.system, compiled.lowered->image);
    REQUIRE(machine.bits.size() == 6);
  }
  /// Of lamps that are lit in the states, a digit each: "010".
  [[nodiscard]] SampledStates sampled(const std::vector<std::string>& states) const {
    SampledStates result;
    for (const StateBit& bit : machine.bits) {
      // Bits of the word that are beyond the states repeat the first one.
      std::uint64_t word = 0;
      for (std::size_t k = 0; k < 64; ++k) {
        const bool is_lit = states[k < states.size() ? k : 0][bit.atom] == '1';
        word |= std::uint64_t{is_lit == (bit.row == 1) ? 1u : 0u} << k;
      }
      result.values.push_back({word});
    }
    return result;
  }
  [[nodiscard]] std::vector<Cube> candidates(const std::vector<std::string>& states, std::size_t most = 100) const {
    const Net net = build_net(*compiled.system);
    std::vector<Cube> cubes = find_local_candidates(machine, net.graph.atom_of_port, sampled(states),
                                                    std::vector<std::uint8_t>(12, 0), most, within_seconds(60));
    std::sort(cubes.begin(), cubes.end());
    return cubes;
  }
  [[nodiscard]] u32 at(u32 atom, bool is_lit) const {
    for (u32 row = 0; row < machine.bits.size(); ++row) {
      if (machine.bits[row].atom == atom && (machine.bits[row].row == 1) == is_lit) return cube_literal_of(row, true);
    }
    FAIL("no such bit");
    return 0;
  }

  gen::Compiled compiled;
  TransitionSystem machine;
};

}  // namespace

TEST_CASE("local lemmas: of neighbours, what no sampled state has") {
  const Lamps lamps;
  // 0 and 2 are no neighbours: that both are never lit is no candidate.
  const std::vector<Cube> cubes = lamps.candidates({"000", "110", "011"});
  CHECK(cubes == std::vector<Cube>{{lamps.at(0, true), lamps.at(1, false)}, {lamps.at(1, false), lamps.at(2, true)}});
  CHECK(lamps.candidates({"000", "110", "011", "100", "001"}).empty());
}

TEST_CASE("local lemmas: one literal instead of two that it subsumes") {
  const Lamps lamps;
  CHECK(lamps.candidates({"000", "110", "010", "100"}) == std::vector<Cube>{{lamps.at(2, true)}});
}

TEST_CASE("local lemmas: none if there would be too many") {
  const Lamps lamps;
  CHECK(lamps.candidates({"000", "110", "011"}, 1).empty());
}

TEST_CASE("local lemmas: groups by what they say") {
  const Lamps lamps;
  const std::vector<Cube> cubes{{lamps.at(0, true), lamps.at(1, false)},
                                {lamps.at(1, true), lamps.at(2, false)},
                                {lamps.at(0, false), lamps.at(1, true)},
                                {lamps.at(2, true)}};
  const std::vector<std::vector<Cube>> groups = group_by_shape(cubes, lamps.machine, *lamps.compiled.system);
  CHECK(groups.size() == 3);
  CHECK(std::count_if(groups.begin(), groups.end(), [](const auto& group) { return group.size() == 2; }) == 1);
}

}  // namespace bip::verify
