// Result<T>: a value, or the message of an expected failure (I/O, limits). Model errors are diagnostics instead.
#pragma once
#include <string>
#include <utility>
#include <variant>

namespace bip {

struct Failure {
  std::string message;
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : v_(std::move(value)) {}
  Result(Failure f) : v_(std::move(f)) {}
  [[nodiscard]] explicit operator bool() const { return v_.index() == 0; }
  [[nodiscard]] T& operator*() { return std::get<0>(v_); }
  [[nodiscard]] const T& operator*() const { return std::get<0>(v_); }
  [[nodiscard]] T* operator->() { return &std::get<0>(v_); }
  [[nodiscard]] const std::string& error() const { return std::get<1>(v_).message; }

 private:
  std::variant<T, Failure> v_;
};

}  // namespace bip
