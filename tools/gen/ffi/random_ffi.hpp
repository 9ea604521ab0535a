// The FFI of random models: functions and types that their `@cpp` names. Compiled into emitted programs, called by
// the interpreter and the JIT through bind_ffi.cpp, and by the oracle. Pure where the models call them from guards
// or `up`.
//
// All arithmetic wraps, so that nothing here depends on the compiler.
#pragma once
#include <cstdint>
#include <stdexcept>
#include <string>

struct Pair {
  int a = 0, b = 0;
};
struct Wide : Pair {
  int c = 0;
};

inline int wrapped(std::int64_t value) {
  return static_cast<int>(static_cast<std::uint32_t>(static_cast<std::uint64_t>(value)));
}

// ---- native values
inline int mix(int x, int y) { return wrapped(std::int64_t{x} * 31 + y) ^ 0x55; }
inline double scale(double f, int k) { return f * 0.5 + k; }
inline bool odd(int x) { return (x & 1) != 0; }
/// Another answer than that of `odd`, so that a call of the wrong one shows.
inline bool const_odd(int x) { return (x & 2) != 0; }
inline std::string label(int x) { return "n" + std::to_string(x & 3); }
inline std::string joined(const std::string& x, const std::string& y) { return (x + y).substr(0, 9); }
inline int length(const std::string& x) { return static_cast<int>(x.size()); }
inline void bump(int& x) { x = wrapped(std::int64_t{x} + 3); }
inline int after(int& x) { return x = wrapped(std::int64_t{x} + 1); }
inline void grow(double& x) { x = x * 0.5 + 1.0; }
inline void exchange(int& x, int& y) {
  const int before = x;
  x = y;
  y = before;
}
/// An exception for one value in sixteen: a fault of the model's call.
inline int picky(int x) {
  if ((x & 15) == 7) throw std::runtime_error("seven");
  return x ^ 1;
}

// ---- objects
inline Pair make_two(int a, int b) { return {a, b}; }
inline Wide widened(const Pair& p, int c) {
  Wide w;
  w.a = p.b;
  w.b = p.a;
  w.c = c;
  return w;
}
inline int first(const Pair& p) { return p.a; }
inline int third(const Wide& w) { return w.c; }
inline void push(Pair& p, int x) {
  p.b = p.a;
  p.a = x;
}
inline Pair operator+(const Pair& x, const Pair& y) {
  return {wrapped(std::int64_t{x.a} + y.a), wrapped(std::int64_t{x.b} - y.b)};
}
inline bool operator==(const Pair& x, const Pair& y) { return x.a == y.a && x.b == y.b; }
inline bool operator<(const Pair& x, const Pair& y) { return x.a < y.a; }

// ---- one name, the most specific prototype
inline int sort_of(int x) { return x & 7; }
inline int sort_of(double x) { return x < 0 ? 10 : 11; }
inline int sort_of(const std::string& x) { return 20 + static_cast<int>(x.size() & 3); }
inline int sort_of(const Pair& p) { return 30 + (p.a & 3); }
inline int sort_of(const Wide& w) { return 40 + (w.c & 3); }
