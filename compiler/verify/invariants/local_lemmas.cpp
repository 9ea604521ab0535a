// See local_lemmas.hpp.
#include "compiler/verify/invariants/local_lemmas.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Of a step with more components each two would be neighbours: their number is not linear.
constexpr std::size_t kMostNeighbours = 4;

// Which literals hold in which sampled states.
class Samples {
 public:
  explicit Samples(const SampledStates& states) : states_(states) {}
  [[nodiscard]] bool refute(u32 literal) const {
    const std::vector<std::uint64_t>& row = states_.values[cube_bit(literal)];
    const std::uint64_t flip = cube_value(literal) ? 0 : ~std::uint64_t{0};
    return std::any_of(row.begin(), row.end(), [&](std::uint64_t word) { return (word ^ flip) != 0; });
  }
  [[nodiscard]] bool refute(u32 a, u32 b) const {
    const std::vector<std::uint64_t>&row_a = states_.values[cube_bit(a)], &row_b = states_.values[cube_bit(b)];
    const std::uint64_t flip_a = cube_value(a) ? 0 : ~std::uint64_t{0}, flip_b = cube_value(b) ? 0 : ~std::uint64_t{0};
    for (std::size_t k = 0; k < row_a.size(); ++k) {
      if (((row_a[k] ^ flip_a) & (row_b[k] ^ flip_b)) != 0) return true;
    }
    return false;
  }

 private:
  const SampledStates& states_;
};

// Each two components that take part in a step together, in ascending order, and each component with itself.
std::vector<std::pair<u32, u32>> find_neighbours(const TransitionSystem& machine,
                                                 const std::vector<u32>& atom_of_port) {
  std::vector<std::pair<u32, u32>> pairs;
  for (u32 atom = 0; atom < machine.marks.size(); ++atom) pairs.emplace_back(atom, atom);
  std::vector<u32> atoms;
  for (const SystemStep& step : machine.steps) {
    atoms.clear();
    for (const auto& [port, when] : step.parts) atoms.push_back(atom_of_port[port]);
    std::sort(atoms.begin(), atoms.end());
    atoms.erase(std::unique(atoms.begin(), atoms.end()), atoms.end());
    if (atoms.size() > kMostNeighbours) continue;
    for (std::size_t i = 0; i < atoms.size(); ++i) {
      for (std::size_t j = i + 1; j < atoms.size(); ++j) pairs.emplace_back(atoms[i], atoms[j]);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace

std::vector<Cube> find_local_candidates(const TransitionSystem& machine, const std::vector<u32>& atom_of_port,
                                        const SampledStates& states, const std::vector<std::uint8_t>& is_possible,
                                        std::size_t most, const CancellationToken& cancellation) {
  BIP_ASSERT(states.values.size() == machine.bits.size(), "{} rows of {} bits", states.values.size(),
             machine.bits.size());
  BIP_ASSERT(is_possible.size() == 2 * machine.bits.size(), "{} literals of {} bits", is_possible.size(),
             machine.bits.size());
  const Samples samples(states);
  std::vector<Cube> cubes;
  // By atom: literals that some state has, or may have. One without any is a lemma by itself.
  std::vector<std::vector<u32>> literals(machine.marks.size());
  for (u32 bit = 0; bit < machine.bits.size(); ++bit) {
    for (const bool value : {true, false}) {
      if (machine.bits[bit].is_place && !value) continue;
      const u32 literal = cube_literal_of(bit, value);
      if (is_possible[literal] != 0 || samples.refute(literal)) literals[machine.bits[bit].atom].push_back(literal);
      else cubes.push_back({literal});
    }
  }
  for (const auto& [atom, other] : find_neighbours(machine, atom_of_port)) {
    for (const u32 a : literals[atom]) {
      if (cubes.size() > most || cancellation.is_over()) return {};
      for (const u32 b : literals[other]) {
        const StateBit &bit_a = machine.bits[cube_bit(a)], &bit_b = machine.bits[cube_bit(b)];
        if (cube_bit(a) >= cube_bit(b)) continue;
        // Of an automaton two places are never marked.
        if (atom == other && bit_a.is_alone && bit_b.is_alone) continue;
        if (!samples.refute(a, b)) cubes.push_back({a, b});
      }
    }
  }
  if (cubes.size() > most) return {};
  return cubes;
}

std::vector<std::vector<Cube>> group_by_shape(const std::vector<Cube>& cubes, const TransitionSystem& machine,
                                              const System& system) {
  using Shape = std::vector<std::array<u32, 6>>;
  std::map<Shape, std::vector<Cube>> groups;
  for (const Cube& cube : cubes) {
    Shape shape;
    const u32 first = machine.bits[cube_bit(cube[0])].atom;
    for (const u32 literal : cube) {
      const StateBit& bit = machine.bits[cube_bit(literal)];
      const u32 type = system.atoms[AtomId(std::size_t{bit.atom})].type.value;
      shape.push_back({type, bit.is_place ? 1u : 0u, bit.row, bit.position, cube_value(literal) ? 1u : 0u,
                       bit.atom == first ? 1u : 0u});
    }
    groups[std::move(shape)].push_back(cube);
  }
  std::vector<std::vector<Cube>> result;
  for (auto& [shape, group] : groups) result.push_back(std::move(group));
  return result;
}

}  // namespace bip::verify
