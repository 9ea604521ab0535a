// Codels of robot modules that call services of other modules: the model's C++ is given a function that asks for them
// as clients do (bip::service_caller(), compiler/docs/genom.md).
#pragma once

namespace bip::serve {

class Requests;

/// For as long as it lives; its end ends all calls, and waits until codels have left them. One at a time in a process:
/// what C++ calls is a function without an object.
class ServiceCalls {
 public:
  /// `library`: the model's C++, or null.
  ServiceCalls(Requests& requests, void* library);
  ServiceCalls(const ServiceCalls&) = delete;
  ServiceCalls& operator=(const ServiceCalls&) = delete;
  ~ServiceCalls();

 private:
  using Caller = const char* (*)(const char* service, const char* input);
  Requests& requests_;
  void (*set_caller_)(Caller) = nullptr;
};

}  // namespace bip::serve
