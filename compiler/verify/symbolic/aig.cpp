// See aig.hpp.
#include "compiler/verify/symbolic/aig.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {
constexpr std::size_t kWidth = 32;
}

Signal Aig::make_input() {
  nodes_.push_back({kTrue, kTrue});
  BIP_ASSERT(nodes_.size() - 1 <= 0x7fffffffu, "{} nodes", nodes_.size());
  return static_cast<Signal>(nodes_.size() - 1) << 1;
}

Signal Aig::make_and(Signal a, Signal b) {
  BIP_ASSERT(node_of(a) < nodes_.size() && node_of(b) < nodes_.size(), "operands {} and {} of {} nodes", node_of(a),
             node_of(b), nodes_.size());
  // One order of the operands, then the one-level simplifications: constant, complement, idempotence.
  if (a > b) std::swap(a, b);
  if (a == kFalse || a == negated(b)) return kFalse;
  if (a == kTrue || a == b) return b;
  if (is_full()) return kFalse;
  const std::uint64_t key = std::uint64_t{a} << 32 | b;
  const auto [found, is_new] = node_of_operands_.try_emplace(key, static_cast<std::uint32_t>(nodes_.size()));
  if (is_new) nodes_.push_back({a, b});
  BIP_ASSERT(nodes_[found->second].a == a && nodes_[found->second].b == b, "node {} is hashed by other operands",
             found->second);
  return found->second << 1;
}

Signal Aig::make_xor(Signal a, Signal b) {
  // Nodes are numbered as they are made. Arguments of one call are evaluated in an order that is the compiler's, so
  // here and below each call of one that makes nodes is a statement.
  const Signal only_b = make_and(negated(a), b);
  const Signal only_a = make_and(a, negated(b));
  return make_or(only_a, only_b);
}

Signal Aig::make_ite(Signal condition, Signal yes, Signal no) {
  if (yes == no || condition == kTrue) return yes;
  if (condition == kFalse) return no;
  const Signal otherwise = make_and(negated(condition), no);
  return make_or(make_and(condition, yes), otherwise);
}

Signal Aig::make_and_of(const std::vector<Signal>& signals) {
  Signal result = kTrue;
  for (Signal s : signals) result = make_and(result, s);
  return result;
}
Signal Aig::make_or_of(const std::vector<Signal>& signals) {
  Signal result = kFalse;
  for (Signal s : signals) result = make_or(result, s);
  return result;
}

std::vector<Signal> with_fixed(Aig& aig, const std::vector<Signal>& roots, const std::vector<Signal>& fixed) {
  std::unordered_map<std::uint32_t, Signal> made{{0, kFalse}};
  const auto is_fixed = [&](std::uint32_t row) { return row < fixed.size() && fixed[row] != kFree; };
  const auto of = [&](Signal s) { return made.at(node_of(s)) ^ (s & 1); };
  std::vector<std::uint32_t> todo;
  for (Signal root : roots) todo.push_back(node_of(root));
  while (!todo.empty()) {
    const std::uint32_t row = todo.back();
    if (made.contains(row)) {
      todo.pop_back();
      continue;
    }
    if (is_fixed(row) || aig.is_input(row)) {
      made.emplace(row, is_fixed(row) ? fixed[row] : Signal{row << 1});
      continue;
    }
    const Aig::Node node = aig.node(row);
    // What one side decides needs no other: most of what a step that is not chosen would do is never looked at.
    const auto is_false = [&](Signal side) {
      const std::uint32_t below = node_of(side);
      if (is_fixed(below)) return (fixed[below] ^ (side & 1)) == kFalse;
      const auto found = made.find(below);
      return found != made.end() && (found->second ^ (side & 1)) == kFalse;
    };
    if (is_false(node.a) || is_false(node.b)) {
      made.emplace(row, kFalse);
      continue;
    }
    if (!made.contains(node_of(node.a))) {
      todo.push_back(node_of(node.a));
      continue;
    }
    if (!made.contains(node_of(node.b))) {
      todo.push_back(node_of(node.b));
      continue;
    }
    const Signal both = aig.make_and(of(node.a), of(node.b));
    made.emplace(row, both);
  }
  std::vector<Signal> result;
  BIP_ASSERT(std::all_of(roots.begin(), roots.end(), [&](Signal root) { return made.contains(node_of(root)); }),
             "a root of {} was not made", roots.size());
  for (Signal root : roots) result.push_back(of(root));
  return result;
}

Word trimmed(Word w) {
  if (w.size() > kWidth) w.resize(kWidth);
  while (w.size() > 1 && w[w.size() - 1] == w[w.size() - 2]) w.pop_back();
  return w;
}

Word word_of(std::int32_t value) {
  Word w;
  for (std::size_t k = 0; k < kWidth; ++k)
    w.push_back((static_cast<std::uint32_t>(value) >> k & 1u) != 0 ? kTrue : kFalse);
  return trimmed(w);
}

Word make_ite(Aig& aig, Signal condition, const Word& yes, const Word& no) {
  if (condition == kTrue) return yes;
  if (condition == kFalse) return no;
  Word w;
  for (std::size_t k = 0; k < std::max(yes.size(), no.size()); ++k)
    w.push_back(aig.make_ite(condition, bit(yes, k), bit(no, k)));
  return trimmed(w);
}

Word add(Aig& aig, const Word& a, const Word& b, Signal carry) {
  Word w;
  BIP_ASSERT(!a.empty() && !b.empty(), "words of {} and {} bits", a.size(), b.size());
  const std::size_t width = std::min(kWidth, std::max(a.size(), b.size()) + 1);
  for (std::size_t k = 0; k < width; ++k) {
    const Signal x = bit(a, k), y = bit(b, k);
    const Signal sum = aig.make_xor(x, y);
    w.push_back(aig.make_xor(sum, carry));
    const Signal is_passed_on = aig.make_and(sum, carry);
    carry = aig.make_or(aig.make_and(x, y), is_passed_on);
  }
  return trimmed(w);
}

Word complement(const Word& a) {
  Word w;
  for (Signal s : a) w.push_back(negated(s));
  return w;
}
Word subtract(Aig& aig, const Word& a, const Word& b) { return add(aig, a, complement(b), kTrue); }
Word negate(Aig& aig, const Word& a) { return subtract(aig, word_of(0), a); }

Word multiply(Aig& aig, const Word& a, const Word& b) {
  // Modulo 2^width the sign bit of b counts like any other once b is extended.
  const std::size_t width = std::min(kWidth, a.size() + b.size());
  Word sum(width, kFalse);
  for (std::size_t k = 0; k < width; ++k) {
    const Signal digit = bit(b, k);
    if (digit == kFalse) continue;
    Signal carry = kFalse;
    for (std::size_t i = k; i < width; ++i) {
      const Signal x = sum[i], y = aig.make_and(digit, bit(a, i - k));
      const Signal half = aig.make_xor(x, y);
      sum[i] = aig.make_xor(half, carry);
      const Signal is_passed_on = aig.make_and(half, carry);
      carry = aig.make_or(aig.make_and(x, y), is_passed_on);
    }
  }
  return trimmed(sum);
}

Division divide(Aig& aig, const Word& a, const Word& b) {
  // Magnitudes, schoolbook, then signs. One bit more than the words have: the magnitude of the least number.
  const std::size_t width = std::max(a.size(), b.size()) + 1;
  BIP_ASSERT(!a.empty() && !b.empty() && width <= kWidth + 1, "words of {} and {} bits", a.size(), b.size());
  const auto magnitude = [&](const Word& w) {
    Word m;
    Signal carry = w.back();
    for (std::size_t k = 0; k < width; ++k) {
      const Signal x = aig.make_xor(bit(w, k), w.back());
      m.push_back(aig.make_xor(x, carry));
      carry = aig.make_and(x, carry);
    }
    return m;
  };
  const Word x = magnitude(a), y = magnitude(b);
  Word rest(width, kFalse), quotient(width, kFalse);
  for (std::size_t k = width; k-- > 0;) {
    rest.insert(rest.begin(), x[k]);
    rest.pop_back();
    Signal borrow = kFalse;
    Word difference;
    for (std::size_t i = 0; i < width; ++i) {
      const Signal d = aig.make_xor(rest[i], y[i]);
      difference.push_back(aig.make_xor(d, borrow));
      borrow = aig.make_ite(d, y[i], borrow);
    }
    quotient[k] = negated(borrow);
    for (std::size_t i = 0; i < width; ++i) rest[i] = aig.make_ite(borrow, rest[i], difference[i]);
  }
  const auto with_sign = [&](Word magnitude_bits, Signal is_negative) {
    magnitude_bits.push_back(kFalse);
    return make_ite(aig, is_negative, negate(aig, magnitude_bits), trimmed(magnitude_bits));
  };
  return {with_sign(quotient, aig.make_xor(a.back(), b.back())), with_sign(rest, a.back())};
}

namespace {
template <class Each>
Word bitwise(const Word& a, const Word& b, const Each& each) {
  Word w;
  for (std::size_t k = 0; k < std::max(a.size(), b.size()); ++k) w.push_back(each(bit(a, k), bit(b, k)));
  return trimmed(w);
}
}  // namespace

Word bitwise_and(Aig& aig, const Word& a, const Word& b) {
  return bitwise(a, b, [&](Signal x, Signal y) { return aig.make_and(x, y); });
}
Word bitwise_or(Aig& aig, const Word& a, const Word& b) {
  return bitwise(a, b, [&](Signal x, Signal y) { return aig.make_or(x, y); });
}
Word bitwise_xor(Aig& aig, const Word& a, const Word& b) {
  return bitwise(a, b, [&](Signal x, Signal y) { return aig.make_xor(x, y); });
}

Signal equal(Aig& aig, const Word& a, const Word& b) {
  Signal result = kTrue;
  for (std::size_t k = 0; k < std::max(a.size(), b.size()); ++k)
    result = aig.make_and(result, negated(aig.make_xor(bit(a, k), bit(b, k))));
  return result;
}

Signal less(Aig& aig, const Word& a, const Word& b) {
  // From the least bit on: the highest difference decides; at the sign the other way round.
  Signal result = kFalse;
  const std::size_t width = std::max(a.size(), b.size());
  for (std::size_t k = 0; k < width; ++k) {
    const Signal x = bit(a, k), y = bit(b, k);
    result = aig.make_ite(aig.make_xor(x, y), k + 1 == width ? x : y, result);
  }
  return result;
}

}  // namespace bip::verify
