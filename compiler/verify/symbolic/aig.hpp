// And-inverter graphs (AIG): boolean functions as and-nodes over inputs, with negated edges. Each node exists once
// (structural hashing); operands stand before the nodes that use them.
//
// An int is a word of signals in two's complement, as wide as it needs to be: arithmetic widens its result up to 32
// bits and wraps there, as the language does. Constants fold, so code over known values costs no nodes. Cost: amortised
// constant time per node. A graph with a bound on its nodes returns constants once it is full: test
// `is_full` before use.
//
// A. Kuehlmann, V. Paruthi, F. Krohm, M. Ganai: Robust Boolean Reasoning for Equivalence Checking and Functional
// Property Verification (2002), section III.
#pragma once
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace bip::verify {

/// Twice a node, plus one if negated. Node 0 is the constant.
using Signal = std::uint32_t;
inline constexpr Signal kFalse = 0, kTrue = 1;
[[nodiscard]] constexpr Signal negated(Signal s) { return s ^ 1u; }
[[nodiscard]] constexpr std::uint32_t node_of(Signal s) { return s >> 1; }

/// Least significant bit first, the last one is the sign. Empty: the value is not followed.
using Word = std::vector<Signal>;

class Aig {
 public:
  /// Signals are 32 bits wide. A node takes about kBytesPerNode with its entry in the hash table.
  static constexpr std::size_t kMostNodes = std::size_t{1} << 31;
  static constexpr std::size_t kBytesPerNode = 64;
  struct Node {
    Signal a = kFalse, b = kFalse;  // an input has both kTrue
  };

  Aig() : nodes_(1) {}
  [[nodiscard]] Signal make_input();
  [[nodiscard]] Signal make_and(Signal a, Signal b);
  [[nodiscard]] Signal make_or(Signal a, Signal b) { return negated(make_and(negated(a), negated(b))); }
  [[nodiscard]] Signal make_xor(Signal a, Signal b);
  [[nodiscard]] Signal make_ite(Signal condition, Signal yes, Signal no);
  [[nodiscard]] Signal make_and_of(const std::vector<Signal>& signals);
  [[nodiscard]] Signal make_or_of(const std::vector<Signal>& signals);

  /// Bounds what is built from here on, for graphs whose size no caller can tell; kMostNodes ends the bound.
  void set_bound(std::size_t nodes) { bound_ = nodes; }
  [[nodiscard]] bool is_full() const { return nodes_.size() > bound_; }
  [[nodiscard]] std::size_t size() const { return nodes_.size(); }
  [[nodiscard]] const Node& node(std::uint32_t row) const { return nodes_[row]; }
  [[nodiscard]] bool is_input(std::uint32_t row) const {
    return row != 0 && nodes_[row].a == kTrue && nodes_[row].b == kTrue;
  }

 private:
  std::vector<Node> nodes_;
  std::size_t bound_ = kMostNodes;
  std::unordered_map<std::uint64_t, std::uint32_t> node_of_operands_;  // structural hashing
};

/// Returns the cofactors of functions where inputs are fixed (by node; kFree: it is not). Cost: linear in the nodes
/// below the roots.
inline constexpr Signal kFree = 0xffffffffu;
[[nodiscard]] std::vector<Signal> with_fixed(Aig& aig, const std::vector<Signal>& roots,
                                             const std::vector<Signal>& fixed);

// ---- Words. No argument may be empty.
[[nodiscard]] Word word_of(std::int32_t value);
[[nodiscard]] inline Word word_of_bool(Signal s) { return {s, kFalse}; }
/// Returns bit k; beyond the width the sign.
[[nodiscard]] inline Signal bit(const Word& w, std::size_t k) { return k < w.size() ? w[k] : w.back(); }
[[nodiscard]] Word trimmed(Word w);
[[nodiscard]] Word make_ite(Aig& aig, Signal condition, const Word& yes, const Word& no);
[[nodiscard]] Word add(Aig& aig, const Word& a, const Word& b, Signal carry = kFalse);
[[nodiscard]] Word complement(const Word& a);
[[nodiscard]] Word subtract(Aig& aig, const Word& a, const Word& b);
[[nodiscard]] Word negate(Aig& aig, const Word& a);
[[nodiscard]] Word multiply(Aig& aig, const Word& a, const Word& b);
/// Truncates, as C does. The result for divisor 0 has no meaning.
struct Division {
  Word quotient, remainder;
};
[[nodiscard]] Division divide(Aig& aig, const Word& a, const Word& b);
[[nodiscard]] Word bitwise_and(Aig& aig, const Word& a, const Word& b);
[[nodiscard]] Word bitwise_or(Aig& aig, const Word& a, const Word& b);
[[nodiscard]] Word bitwise_xor(Aig& aig, const Word& a, const Word& b);
[[nodiscard]] Signal equal(Aig& aig, const Word& a, const Word& b);
[[nodiscard]] Signal less(Aig& aig, const Word& a, const Word& b);

}  // namespace bip::verify
