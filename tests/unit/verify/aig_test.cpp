// The and-inverter graph: folding and hashing, cofactors, and words against the arithmetic that they stand for.
#include <catch2/catch.hpp>

#include <optional>
#include <set>

#include "compiler/verify/symbolic/aig.hpp"

namespace bip::verify {

namespace {

/// The value of a signal where inputs (by node) are as given.
bool value_of(const Aig& aig, Signal signal, const std::vector<bool>& inputs) {
  std::vector<bool> values(aig.size(), false);
  for (std::uint32_t node = 1; node < aig.size(); ++node) {
    const auto [a, b] = aig.node(node);
    values[node] = aig.is_input(node)
                       ? node < inputs.size() && inputs[node]
                       : (values[node_of(a)] != ((a & 1) != 0)) && (values[node_of(b)] != ((b & 1) != 0));
  }
  return values[node_of(signal)] != ((signal & 1) != 0);
}
std::int32_t number_of(const Aig& aig, const Word& word, const std::vector<bool>& inputs) {
  std::uint32_t result = 0;
  for (std::size_t k = 0; k < 32; ++k) result |= value_of(aig, bit(word, k), inputs) ? 1u << k : 0u;
  return static_cast<std::int32_t>(result);
}
std::optional<std::int32_t> constant_of(const Word& word) {
  std::uint32_t result = 0;
  for (std::size_t k = 0; k < 32; ++k) {
    if (bit(word, k) > kTrue) return std::nullopt;
    result |= bit(word, k) << k;
  }
  return static_cast<std::int32_t>(result);
}
const std::vector<std::int32_t> kNumbers{0, 1, -1, 2, 3, -3, 7, 100, -128, 65535, 2147483647, -2147483647 - 1};
std::int32_t wrapped(std::int64_t value) { return static_cast<std::int32_t>(static_cast<std::uint32_t>(value)); }

}  // namespace

TEST_CASE("AIG: constants, equal and opposite operands fold") {
  Aig aig;
  const Signal x = aig.make_input(), y = aig.make_input();
  const std::size_t before = aig.size();
  CHECK(aig.make_and(x, kFalse) == kFalse);
  CHECK(aig.make_and(kTrue, x) == x);
  CHECK(aig.make_and(x, x) == x);
  CHECK(aig.make_and(x, negated(x)) == kFalse);
  CHECK(aig.make_or(x, negated(x)) == kTrue);
  CHECK(aig.make_xor(x, kTrue) == negated(x));
  CHECK(aig.make_ite(kTrue, x, y) == x);
  CHECK(aig.make_ite(x, y, y) == y);
  CHECK(aig.size() == before);
}

TEST_CASE("AIG: each node exists once, operands stand before it") {
  Aig aig;
  const Signal x = aig.make_input(), y = aig.make_input(), z = aig.make_input();
  const Signal first = aig.make_and(x, negated(y));
  const std::size_t size = aig.size();
  CHECK(aig.make_and(negated(y), x) == first);
  CHECK(aig.size() == size);
  CHECK(aig.make_and(x, y) != first);
  (void)aig.make_xor(aig.make_ite(x, y, z), aig.make_or(first, z));
  std::set<std::pair<Signal, Signal>> nodes;
  for (std::uint32_t node = 1; node < aig.size(); ++node) {
    if (aig.is_input(node)) continue;
    const auto [a, b] = aig.node(node);
    CHECK((node_of(a) < node && node_of(b) < node));
    CHECK(nodes.emplace(std::min(a, b), std::max(a, b)).second);
  }
}

TEST_CASE("AIG: connectives have their truth tables") {
  Aig aig;
  const Signal x = aig.make_input(), y = aig.make_input(), z = aig.make_input();
  const Signal conjunction = aig.make_and(x, y), disjunction = aig.make_or(x, y), parity = aig.make_xor(x, y),
               choice = aig.make_ite(x, y, z);
  for (unsigned row = 0; row < 8; ++row) {
    const bool a = (row & 1) != 0, b = (row & 2) != 0, c = (row & 4) != 0;
    const std::vector<bool> inputs{false, a, b, c};
    CHECK(value_of(aig, conjunction, inputs) == (a && b));
    CHECK(value_of(aig, disjunction, inputs) == (a || b));
    CHECK(value_of(aig, parity, inputs) == (a != b));
    CHECK(value_of(aig, choice, inputs) == (a ? b : c));
  }
}

TEST_CASE("AIG: words of constants fold to what the language computes") {
  Aig aig;
  for (const std::int32_t a : kNumbers) {
    CHECK(constant_of(word_of(a)) == a);
    CHECK(constant_of(negate(aig, word_of(a))) == wrapped(-std::int64_t{a}));
    for (const std::int32_t b : kNumbers) {
      INFO(a << ", " << b);
      const Word x = word_of(a), y = word_of(b);
      CHECK(constant_of(add(aig, x, y)) == wrapped(std::int64_t{a} + b));
      CHECK(constant_of(subtract(aig, x, y)) == wrapped(std::int64_t{a} - b));
      CHECK(constant_of(multiply(aig, x, y)) == wrapped(std::int64_t{a} * b));
      CHECK(constant_of(bitwise_and(aig, x, y)) == (a & b));
      CHECK(constant_of(bitwise_or(aig, x, y)) == (a | b));
      CHECK(constant_of(bitwise_xor(aig, x, y)) == (a ^ b));
      CHECK(equal(aig, x, y) == (a == b ? kTrue : kFalse));
      CHECK(less(aig, x, y) == (a < b ? kTrue : kFalse));
      if (b == 0 || (b == -1 && a == kNumbers.back())) continue;
      const Division division = divide(aig, x, y);
      CHECK(constant_of(division.quotient) == a / b);
      CHECK(constant_of(division.remainder) == a % b);
    }
  }
  CHECK(aig.size() == 1);
}

TEST_CASE("AIG: words of inputs compute the same for all their values") {
  Aig aig;
  const auto input_word = [&] {
    Word word;
    for (int k = 0; k < 3; ++k) word.push_back(aig.make_input());
    return word;
  };
  const Word x = input_word(), y = input_word();
  const Word sum = add(aig, x, y), product = multiply(aig, x, y), difference = subtract(aig, x, y);
  const Division division = divide(aig, x, y);
  const Signal is_less = less(aig, x, y), is_equal = equal(aig, x, y);
  for (unsigned row = 0; row < 64; ++row) {
    std::vector<bool> inputs{false};
    for (unsigned k = 0; k < 6; ++k) inputs.push_back((row >> k & 1u) != 0);
    const std::int32_t a = number_of(aig, x, inputs), b = number_of(aig, y, inputs);
    INFO(a << ", " << b);
    CHECK(number_of(aig, sum, inputs) == a + b);
    CHECK(number_of(aig, difference, inputs) == a - b);
    CHECK(number_of(aig, product, inputs) == a * b);
    CHECK(value_of(aig, is_less, inputs) == (a < b));
    CHECK(value_of(aig, is_equal, inputs) == (a == b));
    if (b == 0) continue;
    CHECK(number_of(aig, division.quotient, inputs) == a / b);
    CHECK(number_of(aig, division.remainder, inputs) == a % b);
  }
}

TEST_CASE("AIG: a cofactor has the fixed inputs in it") {
  Aig aig;
  const Signal x = aig.make_input(), y = aig.make_input(), z = aig.make_input();
  const Signal choice = aig.make_ite(x, y, z), parity = aig.make_xor(x, y);
  std::vector<Signal> fixed(aig.size(), kFree);
  fixed[node_of(x)] = kTrue;
  CHECK(with_fixed(aig, {choice, parity, negated(x)}, fixed) == std::vector<Signal>{y, negated(y), kFalse});
  fixed[node_of(x)] = kFalse;
  CHECK(with_fixed(aig, {choice, parity, z}, fixed) == std::vector<Signal>{z, y, z});
}

}  // namespace bip::verify
