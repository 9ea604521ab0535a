// What the C++ written by `bipc emit` is made of: variables by name, divisions that fault, tables as constants.
//
// An emitted function stays one readable piece: its variables are references into the cells (IntVar, BoolVar, …), and a
// faulting division leaves it as a CodeFault that the same function catches and returns as its status. No exception
// leaves a CodeFn. Header only; everything but a fault is free after inlining.
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "bip/arith.hpp"
#include "bip/image_tables.hpp"
#include "bip/image_time.hpp"

// A function whose loops become vectors is made for newer processors, too; at the program's start the loader chooses.
// Sanitizers are not ready that early.
#if defined(__x86_64__) && defined(__linux__) && defined(__OPTIMIZE__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define BIP_FOR_PROCESSORS [[gnu::target_clones("avx512f", "avx2", "default")]]
#else
#define BIP_FOR_PROCESSORS
#endif
// Before a loop of a few instructions.
#if defined(__GNUC__) && !defined(__clang__)
#define BIP_UNROLL _Pragma("GCC unroll 4")
#else
#define BIP_UNROLL
#endif

namespace bip::rt {

/// Thrown by `divide` and `modulo`, caught in the function that called them.
struct CodeFault {
  std::int32_t status;
};

constexpr std::int32_t divide(std::int32_t a, std::int32_t b, std::uint32_t site) {
  if (const std::int32_t status = division_status(a, b, site); status != 0) throw CodeFault{status};
  return quotient(a, b);
}
constexpr std::int32_t modulo(std::int32_t a, std::int32_t b, std::uint32_t site) {
  if (const std::int32_t status = division_status(a, b, site); status != 0) throw CodeFault{status};
  return remainder(a, b);
}

/// A cell with its unused bits zero.
constexpr Cell int_cell(std::int32_t value) { return Cell{.bits = static_cast<std::uint32_t>(value)}; }
constexpr Cell float_cell(double value) { return Cell{.f = value}; }

/// A cell's value as a whole. g++ 12 makes vectors of copied memory, but not of loops that name a member of the union.
template <class T>
T read_cell(const Cell& cell) {
  static_assert(sizeof(T) == sizeof(Cell));
  T value;
  std::memcpy(&value, &cell, sizeof value);
  return value;
}
template <class T>
void write_cell(Cell& cell, T value) {
  static_assert(sizeof(T) == sizeof(Cell));
  std::memcpy(&cell, &value, sizeof value);
}

/// An int on its way between cells: the low half of a word as wide as they are, whatever the high half is. In a loop
/// over cells all vectors have lanes of one width then; narrowing and widening them again costs g++ more than the
/// vectors save.
struct Word {
  std::uint64_t bits;
  constexpr operator std::int32_t() const { return static_cast<std::int32_t>(bits); }
};

/// An int variable in a cell. Copying the object copies the value, as assignment in the model does.
class IntVar {
 public:
  constexpr explicit IntVar(Cell& cell) : cell_(cell) {}
  IntVar(const IntVar&) = delete;
  IntVar& operator=(std::int32_t value) { return *this = Word{static_cast<std::uint32_t>(value)}; }
  IntVar& operator=(Word value) {
    write_cell(cell_, value.bits & 0xffffffffu);
    return *this;
  }
  IntVar& operator=(const IntVar& other) {
    write_cell(cell_, other.bits());
    return *this;
  }
  operator std::int32_t() const { return Word{bits()}; }
  [[nodiscard]] std::uint64_t bits() const { return read_cell<std::uint64_t>(cell_); }
  /// For C++ functions that change their argument.
  std::int32_t& ref() { return cell_.i; }

 private:
  Cell& cell_;
};
/// Strings are rows of Image::strings.
using StringVar = IntVar;

constexpr std::uint64_t bits_of(std::int32_t value) { return static_cast<std::uint32_t>(value); }
constexpr std::uint64_t bits_of(Word value) { return value.bits; }
inline std::uint64_t bits_of(const IntVar& value) { return value.bits(); }
/// Two ints of which one at least is no plain one.
template <class A, class B>
concept Words = (std::is_same_v<A, Word> || std::is_same_v<A, IntVar> || std::is_same_v<B, Word> ||
                 std::is_same_v<B, IntVar>)&&requires(const A& a, const B& b) {
  bits_of(a);
  bits_of(b);
};

template <class A, class B>
requires Words<A, B>
constexpr Word wrap_add(const A& a, const B& b) { return {bits_of(a) + bits_of(b)}; }
template <class A, class B>
requires Words<A, B>
constexpr Word wrap_sub(const A& a, const B& b) { return {bits_of(a) - bits_of(b)}; }
template <class A, class B>
requires Words<A, B>
constexpr Word wrap_mul(const A& a, const B& b) { return {bits_of(a) * bits_of(b)}; }
template <class A>
requires Words<A, A>
constexpr Word wrap_neg(const A& a) { return {0 - bits_of(a)}; }
template <class A, class B>
requires Words<A, B>
constexpr Word operator&(const A& a, const B& b) { return {bits_of(a) & bits_of(b)}; }
template <class A, class B>
requires Words<A, B>
constexpr Word operator|(const A& a, const B& b) { return {bits_of(a) | bits_of(b)}; }
template <class A, class B>
requires Words<A, B>
constexpr Word operator^(const A& a, const B& b) { return {bits_of(a) ^ bits_of(b)}; }
template <class A>
requires Words<A, A>
constexpr Word operator~(const A& a) { return {~bits_of(a)}; }

/// Of the low half, in order.
constexpr std::int64_t ordered(std::uint64_t bits) { return static_cast<std::int64_t>(bits << 32); }
template <class A, class B>
requires Words<A, B>
constexpr bool operator==(const A& a, const B& b) { return ordered(bits_of(a)) == ordered(bits_of(b)); }
template <class A, class B>
requires Words<A, B>
constexpr auto operator<=>(const A& a, const B& b) { return ordered(bits_of(a)) <=> ordered(bits_of(b)); }

// What `reduce` does with the ints, or bools, of many cells: on words as wide as cells, in any order with the same
// result.
struct Sum {
  static std::uint64_t word(const Cell& cell) { return read_cell<std::uint64_t>(cell); }
  template <class T>
  static constexpr T join(T a, T b) {
    return a + b;
  }
  static constexpr Cell cell(std::uint64_t word) { return Cell{.bits = word & 0xffffffffu}; }
};
struct Product : Sum {
  template <class T>
  static constexpr T join(T a, T b) {
    return a * b;
  }
};
struct BitAnd : Sum {
  template <class T>
  static constexpr T join(T a, T b) {
    return a & b;
  }
};
struct BitOr : Sum {
  template <class T>
  static constexpr T join(T a, T b) {
    return a | b;
  }
};
struct BitXor : Sum {
  template <class T>
  static constexpr T join(T a, T b) {
    return a ^ b;
  }
};
struct Largest {
  static std::int64_t word(const Cell& cell) { return ordered(read_cell<std::uint64_t>(cell)); }
  template <class T>
  static constexpr T join(T a, T b) {
    return a > b ? a : b;
  }
  static constexpr Cell cell(std::int64_t word) { return Cell{.bits = static_cast<std::uint64_t>(word) >> 32}; }
};
struct Least : Largest {
  template <class T>
  static constexpr T join(T a, T b) {
    return a < b ? a : b;
  }
};
/// Joins from[0], from[stride], ... (count of them) to what `to` holds.
template <class Op>
inline void reduce(Cell& to, const Cell* from, std::ptrdiff_t stride, std::ptrdiff_t count) {
  auto word = Op::word(to);
  for (std::ptrdiff_t t = 0; t < count; ++t) word = Op::join(word, Op::word(from[stride * t]));
  to = Op::cell(word);
}

class BoolVar {
 public:
  constexpr explicit BoolVar(Cell& cell) : cell_(cell) {}
  BoolVar(const BoolVar&) = delete;
  BoolVar& operator=(bool value) {
    write_cell(cell_, std::uint64_t{value ? 1u : 0u});
    return *this;
  }
  BoolVar& operator=(const BoolVar& other) { return *this = static_cast<bool>(other); }
  operator bool() const { return read_cell<std::uint64_t>(cell_) != 0; }

 private:
  Cell& cell_;
};

class FloatVar {
 public:
  constexpr explicit FloatVar(Cell& cell) : cell_(cell) {}
  FloatVar(const FloatVar&) = delete;
  FloatVar& operator=(double value) {
    write_cell(cell_, value);
    return *this;
  }
  FloatVar& operator=(const FloatVar& other) { return *this = static_cast<double>(other); }
  operator double() const { return read_cell<double>(cell_); }
  double& ref() { return cell_.f; }

 private:
  Cell& cell_;
};

/// An int variable, or a row of strings, in a cell.
class IntCell {
 public:
  constexpr explicit IntCell(ColumnCell& cell) : cell_(cell) {}
  IntCell(const IntCell&) = delete;
  IntCell& operator=(std::int32_t value) {
    cell_.bits = static_cast<std::uint32_t>(value);
    return *this;
  }
  IntCell& operator=(const IntCell& other) { return *this = static_cast<std::int32_t>(other); }
  operator std::int32_t() const { return static_cast<std::int32_t>(cell_.bits); }

 private:
  ColumnCell& cell_;
};
using StringCell = IntCell;

class BoolCell {
 public:
  constexpr explicit BoolCell(ColumnCell& cell) : cell_(cell) {}
  BoolCell(const BoolCell&) = delete;
  BoolCell& operator=(bool value) {
    cell_.bits = value ? 1u : 0u;
    return *this;
  }
  BoolCell& operator=(const BoolCell& other) { return *this = static_cast<bool>(other); }
  operator bool() const { return cell_.bits != 0; }

 private:
  ColumnCell& cell_;
};

/// The same of cells, 32 bits a value: the low halves of what is joined above.
template <class Op>
inline void reduce(ColumnCell& to, const ColumnCell* from, std::ptrdiff_t stride, std::ptrdiff_t count) {
  if constexpr (std::is_base_of_v<Largest, Op>) {
    auto value = static_cast<std::int32_t>(to.bits);
    for (std::ptrdiff_t t = 0; t < count; ++t)
      value = Op::join(value, static_cast<std::int32_t>(from[stride * t].bits));
    to.bits = static_cast<std::uint32_t>(value);
  } else {
    std::uint32_t value = to.bits;
    for (std::ptrdiff_t t = 0; t < count; ++t) value = Op::join(value, from[stride * t].bits);
    to.bits = value;
  }
}

template <class T, std::size_t N>
constexpr Span<T> span(const T (&items)[N]) {
  return {items, static_cast<std::uint32_t>(N)};
}

template <std::uint32_t... Row>
inline constexpr std::uint32_t kRowList[] = {Row...};
/// A short list of rows written where it is used: rows<0, 2>.
template <std::uint32_t... Row>
inline constexpr Span<std::uint32_t> rows = {kRowList<Row...>, sizeof...(Row)};

}  // namespace bip::rt
