// What the C++ written by `bipc emit` is made of: variables by name, divisions that fault, tables as constants.
//
// An emitted function stays one readable piece: its variables are references into the slots (IntVar, BoolVar, …), and a
// faulting division leaves it as a CodeFault that the same function catches and returns as its status. No exception leaves
// a CodeFn. Header only; everything but a fault is free after inlining.
#pragma once
#include <cstddef>
#include <cstdint>

#include "bip/arith.hpp"
#include "bip/image.hpp"
#include "bip/image_time.hpp"

// A function whose loops become vectors is made for newer processors, too; at the program's start the loader chooses. Sanitizers
// are not ready that early.
#if defined(__x86_64__) && defined(__linux__) && defined(__OPTIMIZE__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define BIP_FOR_PROCESSORS [[gnu::target_clones("avx2", "default")]]
#else
#define BIP_FOR_PROCESSORS
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

/// A slot with its unused bits zero. It is read and written as a whole: so loops over neighbouring slots become vectors.
constexpr Slot int_slot(std::int32_t value) { return Slot{.bits = static_cast<std::uint32_t>(value)}; }
constexpr std::int32_t int_in(const Slot& slot) { return static_cast<std::int32_t>(slot.bits); }
constexpr Slot float_slot(double value) { return Slot{.f = value}; }

/// An int variable in a slot. Copying the object copies the value, as assignment in the model does.
class IntVar {
 public:
  constexpr explicit IntVar(Slot& slot) : slot_(slot) {}
  IntVar(const IntVar&) = delete;
  IntVar& operator=(std::int32_t value) {
    slot_.bits = int_slot(value).bits;
    return *this;
  }
  IntVar& operator=(const IntVar& other) { return *this = int_in(other.slot_); }
  operator std::int32_t() const { return int_in(slot_); }
  /// For C++ functions that change their argument.
  std::int32_t& ref() { return slot_.i; }

 private:
  Slot& slot_;
};
/// Strings are rows of Image::strings.
using StringVar = IntVar;

class BoolVar {
 public:
  constexpr explicit BoolVar(Slot& slot) : slot_(slot) {}
  BoolVar(const BoolVar&) = delete;
  BoolVar& operator=(bool value) {
    slot_ = int_slot(value ? 1 : 0);
    return *this;
  }
  BoolVar& operator=(const BoolVar& other) { return *this = other.slot_.i != 0; }
  operator bool() const { return slot_.i != 0; }

 private:
  Slot& slot_;
};

class FloatVar {
 public:
  constexpr explicit FloatVar(Slot& slot) : slot_(slot) {}
  FloatVar(const FloatVar&) = delete;
  FloatVar& operator=(double value) {
    slot_ = float_slot(value);
    return *this;
  }
  FloatVar& operator=(const FloatVar& other) { return *this = other.slot_.f; }
  operator double() const { return slot_.f; }
  double& ref() { return slot_.f; }

 private:
  Slot& slot_;
};

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
