// See service_calls.hpp.
#include "compiler/serve/service_calls.hpp"

#include <dlfcn.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <string>

#include "bip/assert.hpp"
#include "compiler/serve/requests.hpp"

namespace bip::serve {
namespace {

std::atomic<Requests*> called_requests{nullptr};

// {"report":"OK","result":{…}}, or {"report":"","problem":…}.
const char* call_service(const char* service, const char* input) {
  thread_local std::string text;
  nlohmann::json answer = nlohmann::json::object();
  if (Requests* const requests = called_requests.load(); requests != nullptr) {
    const RequestReply reply = requests->call(service, input);
    answer["report"] = reply.report;
    if (reply.report.empty()) answer["problem"] = reply.result;
    else if (!reply.result.empty()) answer["result"] = nlohmann::json::parse(reply.result, nullptr, false);
  }
  text = answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return text.c_str();
}

}  // namespace

ServiceCalls::ServiceCalls(Requests& requests, void* library) {
  if (library == nullptr) return;
  set_caller_ = reinterpret_cast<void (*)(Caller)>(::dlsym(library, "bip_set_service_caller"));
  if (set_caller_ == nullptr) return;
  Requests* none = nullptr;
  [[maybe_unused]] const bool is_first = called_requests.compare_exchange_strong(none, &requests);
  BIP_ASSERT(is_first, "two models are served in one process");
  set_caller_(&call_service);
}

ServiceCalls::~ServiceCalls() {
  if (set_caller_ == nullptr) return;
  set_caller_(nullptr);
  called_requests.store(nullptr);
}

}  // namespace bip::serve
