// See lemma_patterns.hpp.
#include "compiler/verify/scaling/lemma_patterns.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// A cube has at most as many patterns as 2 to this power: pairs of equal letters.
constexpr std::size_t kMostPairs = 3;

ElementLiteral element_literal(u32 cube_literal, const TransitionSystem& machine, const InstanceView& view) {
  BIP_ASSERT(cube_bit(cube_literal) < machine.bits.size(), "bit {} of {}", cube_bit(cube_literal), machine.bits.size());
  const StateBit& bit = machine.bits[cube_bit(cube_literal)];
  return {.family = view.large_family_of[view.families.of_atom[bit.atom].family],
          .is_place = bit.is_place ? 1u : 0u,
          .row = bit.row,
          .position = bit.position,
          .value = cube_value(cube_literal) ? 1u : 0u};
}

// Blocks of equal letters. `pairs`: which of the blocks of two letters are two elements, a bit for each in order.
std::vector<LetterBlock> blocks_of(const std::vector<Letter>& word, std::size_t pairs, std::size_t& pair_count) {
  std::vector<LetterBlock> blocks;
  for (std::size_t begin = 0, end = 0; begin < word.size(); begin = end) {
    while (end < word.size() && word[end] == word[begin]) ++end;
    const bool is_pair = end - begin == 2 && !word[begin].empty();
    const bool is_two = is_pair && pair_count < kMostPairs && ((pairs >> pair_count) & 1) != 0;
    pair_count += is_pair ? 1 : 0;
    if (is_two) blocks.insert(blocks.end(), 2, {word[begin], false});
    else blocks.push_back({word[begin], word[begin].empty() || end - begin > 1});
  }
  return blocks;
}

// State bits by what they are.
class BitRows {
 public:
  BitRows(const TransitionSystem& machine, std::size_t atoms) : machine_(machine), first_(atoms + 1, 0) {
    for (const StateBit& bit : machine.bits) ++first_[bit.atom + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    BIP_ASSERT(std::is_sorted(machine.bits.begin(), machine.bits.end(),
                              [](const StateBit& a, const StateBit& b) { return a.atom < b.atom; }),
               "bits of {} atoms are not in their order", atoms);
  }
  /// kNoRow: the atom has no such bit.
  [[nodiscard]] u32 row(u32 atom, const ElementLiteral& literal) const {
    for (u32 row = first_[atom]; row < first_[atom + 1]; ++row) {
      const StateBit& bit = machine_.bits[row];
      if ((bit.is_place ? 1u : 0u) == literal.is_place && bit.row == literal.row && bit.position == literal.position)
        return row;
    }
    return kNoRow;
  }

 private:
  const TransitionSystem& machine_;
  std::vector<u32> first_;  // by atom
};

// Writes the instances of one pattern.
class Instantiation {
 public:
  Instantiation(const LemmaPattern& pattern, const BitRows& rows, const InstanceView& view,
                const std::function<void(Cube)>& add)
      : pattern_(pattern), rows_(rows), view_(view), add_(add) {}

  void run() {
    if (!demand(pattern_.fixed, 0, Demand::Element)) return;
    dimension(0);
  }

  /// How many there are at most, and how many literals they have.
  static std::pair<double, double> size(const LemmaPattern& pattern, const InstanceView& view) {
    double count = 1, literals = static_cast<double>(pattern.fixed.size());
    for (std::size_t d = 0; d < pattern.words.size(); ++d) {
      std::size_t repeats = 0, singles = 0;
      double demanding = 0;
      for (const LetterBlock& block : pattern.words[d]) {
        (block.repeats ? repeats : singles) += 1;
        demanding += block.repeats && !block.letter.empty() ? 1 : 0;
        if (!block.repeats) literals += static_cast<double>(block.letter.size());
      }
      if (pattern.words[d].empty()) continue;
      if (singles > view.lengths[d] || (repeats == 0 && singles != view.lengths[d])) return {0, 0};
      const double free = static_cast<double>(view.lengths[d] - singles);
      // Compositions of the free positions into the blocks that repeat.
      for (std::size_t k = 1; k < repeats; ++k) count *= (free + static_cast<double>(k)) / static_cast<double>(k);
      if (repeats != 0) literals += demanding * free / static_cast<double>(repeats);
    }
    return {count, count * literals};
  }

 private:
  enum class Demand : std::uint8_t { Element, Repeated };

  // False: the instance has no such element or bit. Of a block that repeats, an array that is shorter ends sooner.
  bool demand(const Letter& letter, u32 index, Demand kind) {
    for (const ElementLiteral& literal : letter) {
      const std::vector<u32>& atoms = view_.families.rows[view_.family_of_large[literal.family]].atoms;
      const u32 element = literal.index + index;
      if (element >= atoms.size()) {
        if (kind == Demand::Repeated) continue;
        return false;
      }
      const u32 row = rows_.row(atoms[element], literal);
      if (row == kNoRow) return false;
      cube_.push_back(cube_literal_of(row, literal.value != 0));
    }
    return true;
  }
  void dimension(std::size_t d) {
    while (d < pattern_.words.size() && pattern_.words[d].empty()) ++d;
    if (d == pattern_.words.size()) {
      Cube cube = cube_;
      std::sort(cube.begin(), cube.end());
      const bool is_cube = std::adjacent_find(cube.begin(), cube.end(),
                                              [](u32 a, u32 b) { return cube_bit(a) == cube_bit(b); }) == cube.end();
      if (is_cube && !cube.empty()) add_(std::move(cube));
      return;
    }
    const std::vector<LetterBlock>& word = pattern_.words[d];
    const std::size_t singles = static_cast<std::size_t>(
        std::count_if(word.begin(), word.end(), [](const LetterBlock& b) { return !b.repeats; }));
    if (singles > view_.lengths[d]) return;
    block(d, 0, 0, static_cast<u32>(view_.lengths[d] - singles), word.size() - singles);
  }
  // Block `k` of dimension `d` begins at `position`; `free` positions are left for `repeats` blocks.
  void block(std::size_t d, std::size_t k, u32 position, u32 free, std::size_t repeats) {
    BIP_ASSERT(position + free <= view_.lengths[d] && repeats <= pattern_.words[d].size() - k,
               "block {} at {} with {} free positions of {}", k, position, free, view_.lengths[d]);
    const std::vector<LetterBlock>& word = pattern_.words[d];
    if (k == word.size()) {
      if (free == 0) dimension(d + 1);
      return;
    }
    const std::size_t before = cube_.size();
    if (!word[k].repeats) {
      if (demand(word[k].letter, position, Demand::Element)) block(d, k + 1, position + 1, free, repeats);
      cube_.resize(before);
      return;
    }
    for (u32 length = 0; length <= free; ++length) {
      // The last block that repeats takes what is left.
      if (repeats != 1 || length == free) block(d, k + 1, position + length, free - length, repeats - 1);
      if (length == free || !demand(word[k].letter, position + length, Demand::Repeated)) break;
    }
    cube_.resize(before);
  }

  const LemmaPattern& pattern_;
  const BitRows& rows_;
  const InstanceView& view_;
  const std::function<void(Cube)>& add_;
  Cube cube_;
};

}  // namespace

void add_patterns(const Cube& cube, const TransitionSystem& machine, const InstanceView& view,
                  const Dimensions& dimensions, std::set<LemmaPattern>& patterns) {
  Letter fixed;
  std::vector<std::vector<Letter>> words(dimensions.count);
  for (u32 cube_literal : cube) {
    ElementLiteral literal = element_literal(cube_literal, machine, view);
    const u32 index = view.families.of_atom[machine.bits[cube_bit(cube_literal)].atom].index;
    const u32 dimension = dimensions.of_family[literal.family];
    if (dimension == Dimensions::kFixed) {
      literal.index = index;
      fixed.push_back(literal);
      continue;
    }
    BIP_ASSERT(dimension < words.size() && index < view.lengths[dimension], "element {} of dimension {}", index,
               dimension);
    words[dimension].resize(view.lengths[dimension]);
    words[dimension][index].push_back(literal);
  }
  std::sort(fixed.begin(), fixed.end());
  for (std::vector<Letter>& word : words) {
    for (Letter& letter : word) std::sort(letter.begin(), letter.end());
  }
  std::size_t pair_count = 1;
  for (std::size_t pairs = 0; pairs < (std::size_t{1} << std::min(pair_count, kMostPairs)); ++pairs) {
    LemmaPattern pattern{fixed, {}};
    pair_count = 0;
    for (const std::vector<Letter>& word : words) pattern.words.push_back(blocks_of(word, pairs, pair_count));
    patterns.insert(std::move(pattern));
  }
}

bool add_templates(const TransitionSystem& machine, const InstanceView& view, const Dimensions& dimensions,
                   std::size_t most, std::set<LemmaPattern>& patterns) {
  // By dimension: what one element may be asked for, and what a range of them may.
  std::vector<std::set<Letter>> letters(dimensions.count), ranges(dimensions.count);
  std::set<Letter> fixed;
  std::vector<std::set<ElementLiteral>> places(view.families.rows.size()), data(view.families.rows.size());
  for (u32 row = 0; row < machine.bits.size(); ++row) {
    const StateBit& bit = machine.bits[row];
    const Element element = view.families.of_atom[bit.atom];
    for (const bool value : {false, true}) {
      if (bit.is_place && !value) continue;
      ElementLiteral literal = element_literal(cube_literal_of(row, value), machine, view);
      if (dimensions.of_family[literal.family] == Dimensions::kFixed) {
        literal.index = element.index;
        fixed.insert({literal});
      } else {
        (bit.is_place ? places : data)[element.family].insert(literal);
      }
    }
  }
  for (std::size_t family = 0; family < places.size(); ++family) {
    const u32 dimension = dimensions.of_family[view.large_family_of[family]];
    if (dimension == Dimensions::kFixed) continue;
    for (const ElementLiteral& place : places[family]) {
      letters[dimension].insert({place});
      ranges[dimension].insert({place});
      for (const ElementLiteral& bit : data[family]) {
        Letter both{place, bit};
        std::sort(both.begin(), both.end());
        letters[dimension].insert(std::move(both));
      }
    }
    for (const ElementLiteral& bit : data[family]) {
      letters[dimension].insert({bit});
      if (places[family].empty()) ranges[dimension].insert({bit});
    }
  }
  fixed.insert(Letter{});
  std::set<LemmaPattern> result;
  const LetterBlock any{{}, true};
  for (u32 d = 0; d < dimensions.count; ++d) {
    const auto add = [&](const Letter& beside, std::vector<LetterBlock> word) {
      LemmaPattern pattern{beside, std::vector<std::vector<LetterBlock>>(dimensions.count)};
      for (std::size_t other = 0; other < dimensions.count; ++other) pattern.words[other] = {any};
      pattern.words[d] = std::move(word);
      result.insert(std::move(pattern));
    };
    std::set<Letter> between = ranges[d];
    between.insert(Letter{});
    const std::size_t pairs = letters[d].size() * letters[d].size() * between.size(),
                      beside = 2 * letters[d].size() * between.size() * fixed.size(),
                      all = ranges[d].size() * fixed.size() * fixed.size();
    if (result.size() + pairs + beside + all > most) return false;
    for (const Letter& range : between) {
      for (const Letter& a : letters[d]) {
        for (const Letter& b : letters[d]) add({}, {any, {a, false}, {range, true}, {b, false}, any});
        for (const Letter& f : fixed) {
          add(f, {{range, true}, {a, false}, any});
          add(f, {any, {a, false}, {range, true}});
        }
      }
      for (const Letter& f : fixed) {
        for (const Letter& g : fixed) {
          Letter both = f;
          both.insert(both.end(), g.begin(), g.end());
          std::sort(both.begin(), both.end());
          both.erase(std::unique(both.begin(), both.end()), both.end());
          if (!both.empty() || !range.empty()) add(both, {{range, true}});
        }
      }
    }
  }
  patterns.merge(result);
  return true;
}

double literal_estimate(const LemmaPattern& pattern, const InstanceView& view) {
  return Instantiation::size(pattern, view).second;
}

std::vector<PatternInstance> instantiate(const std::vector<LemmaPattern>& patterns, const TransitionSystem& machine,
                                         const InstanceView& view, const Dimensions& dimensions,
                                         const InstanceLimits& limits) {
  BIP_ASSERT(view.lengths.size() == dimensions.count, "{} of {} dimensions", view.lengths.size(), dimensions.count);
  const BitRows rows(machine, view.families.of_atom.size());
  std::vector<std::pair<double, u32>> order;
  for (u32 k = 0; k < patterns.size(); ++k) order.emplace_back(Instantiation::size(patterns[k], view).second, k);
  std::sort(order.begin(), order.end());
  std::vector<PatternInstance> result;
  std::map<Cube, std::size_t> rows_of_cubes;
  double cubes = 0, literals = 0;
  for (const auto& [weight, k] : order) {
    const auto [count, size] = Instantiation::size(patterns[k], view);
    cubes += count;
    literals += size;
    if (cubes > static_cast<double>(limits.cubes) || literals > static_cast<double>(limits.literals)) break;
    Instantiation(patterns[k], rows, view, [&, row = k](Cube cube) {
      const auto [found, is_new] = rows_of_cubes.try_emplace(cube, result.size());
      if (is_new) result.push_back({std::move(cube), {}});
      result[found->second].patterns.push_back(row);
    }).run();
  }
  return result;
}

}  // namespace bip::verify
