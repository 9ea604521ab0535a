// Result<T>: a value, or the message of an expected failure (I/O, limits). Model errors are diagnostics instead. A
// function that has no value to give returns Result<bool>, whose value is true.
#pragma once
#include <string>
#include <utility>
#include <variant>

#include "assert.hpp"  // beside this file: a build without the runtime has no other path to it

namespace bip {

struct Failure {
  std::string message;
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : outcome_(std::move(value)) {}
  Result(Failure f) : outcome_(std::move(f)) {}
  [[nodiscard]] explicit operator bool() const { return outcome_.index() == 0; }
  [[nodiscard]] T& operator*() {
    require_value();
    return std::get<0>(outcome_);
  }
  [[nodiscard]] const T& operator*() const {
    require_value();
    return std::get<0>(outcome_);
  }
  [[nodiscard]] T* operator->() { return &**this; }
  [[nodiscard]] const std::string& error() const {
    BIP_ENSURE(!*this, "asked a value for its error");
    return std::get<1>(outcome_).message;
  }

 private:
  void require_value() const {
    BIP_ENSURE(outcome_.index() == 0, "asked a failure for its value: {}", std::get<1>(outcome_).message);
  }

  std::variant<T, Failure> outcome_;
};

}  // namespace bip
