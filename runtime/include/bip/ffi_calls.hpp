// What emitted code and the shared object of `bipc run` need around calls of C++: faults from exceptions, variables
// that are C++ objects. Not part of emitted programs that call nothing.
#pragma once
#include <exception>

#include "bip/emitted.hpp"
#include "bip/ffi.hpp"

namespace bip::rt {

/// In a handler: the exception becomes the fault of the call at `site`.
[[noreturn]] inline void raise(FfiContext& ffi, std::uint32_t site) {
  try {
    throw;
  } catch (const std::exception& exception) {
    ffi.set_message(exception.what());
  } catch (...) {
    ffi.set_message("");
  }
  throw CodeFault{fault_status(site, FaultKind{})};
}

/// A variable of an FFI type. Assignment copies the object.
template <class T>
class FfiVariable {
 public:
  explicit FfiVariable(const Cell& cell) : object_(object_in<T>(cell)) {}
  FfiVariable(const FfiVariable&) = delete;
  FfiVariable& operator=(const T& value) {
    object_ = value;
    return *this;
  }
  FfiVariable& operator=(const FfiVariable& other) { return *this = other.object_; }
  operator T&() const { return object_; }

 private:
  T& object_;
};

}  // namespace bip::rt
