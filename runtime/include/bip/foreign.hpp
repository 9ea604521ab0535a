// What emitted code and the shared object of `bipc run` need around calls of C++: faults from exceptions, variables
// that are C++ objects. Not part of emitted programs that call nothing.
#pragma once
#include <exception>

#include "bip/emitted.hpp"
#include "bip/outside.hpp"

namespace bip::rt {

/// In a handler: the exception becomes the fault of the call at `site`.
[[noreturn]] inline void raise(Outside& outside, std::uint32_t site) {
  try {
    throw;
  } catch (const std::exception& exception) {
    outside.set_message(exception.what());
  } catch (...) {
    outside.set_message("");
  }
  throw CodeFault{fault_status(site, FaultKind{})};
}

/// A variable of an extern type. Assignment copies the object.
template <class T>
class ExternVar {
 public:
  explicit ExternVar(const Cell& cell) : object_(object_in<T>(cell)) {}
  ExternVar(const ExternVar&) = delete;
  ExternVar& operator=(const T& value) {
    object_ = value;
    return *this;
  }
  ExternVar& operator=(const ExternVar& other) { return *this = other.object_; }
  operator T&() const { return object_; }

 private:
  T& object_;
};

}  // namespace bip::rt
