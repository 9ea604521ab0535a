// See service_calls.hpp.
#include "compiler/serve/service_calls.hpp"

#include <dlfcn.h>

#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "bip/assert.hpp"
#include "compiler/serve/requests.hpp"

namespace bip::serve {
namespace {

/// Who is called, and how many codels are in a call: the end of the level waits until all have left it.
struct Called {
  std::mutex lock;
  std::condition_variable left;
  Requests* requests = nullptr;
  unsigned callers = 0;

  Requests* enter() {
    const std::lock_guard<std::mutex> hold(lock);
    if (requests != nullptr) ++callers;
    return requests;
  }
  void leave() {
    const std::lock_guard<std::mutex> hold(lock);
    BIP_ASSERT(callers > 0, "a caller leaves twice");
    --callers;
    left.notify_all();
  }
};
Called called;

// {"report":"OK","result":{…}}, or {"report":"","problem":…}.
const char* call_service(const char* service, const char* input) {
  thread_local std::string text;
  nlohmann::json answer = nlohmann::json::object();
  if (Requests* const requests = called.enter(); requests != nullptr) {
    const RequestReply reply = requests->call(service, input);
    called.leave();
    answer["report"] = reply.report;
    if (reply.report.empty()) answer["problem"] = reply.result;
    else if (!reply.result.empty()) answer["result"] = nlohmann::json::parse(reply.result, nullptr, false);
  }
  text = answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return text.c_str();
}

}  // namespace

ServiceCalls::ServiceCalls(Requests& requests, void* library) : requests_(requests) {
  if (library == nullptr) return;
  set_caller_ = reinterpret_cast<void (*)(Caller)>(::dlsym(library, "bip_set_service_caller"));
  if (set_caller_ == nullptr) return;
  {
    const std::lock_guard<std::mutex> hold(called.lock);
    BIP_ASSERT(called.requests == nullptr, "two models are served in one process");
    called.requests = &requests;
  }
  set_caller_(&call_service);
}

ServiceCalls::~ServiceCalls() {
  if (set_caller_ == nullptr) return;
  set_caller_(nullptr);
  std::unique_lock<std::mutex> hold(called.lock);
  called.requests = nullptr;
  requests_.end_calls();
  // A codel that a call has held up may not have woken yet: what it waits for is about to be destroyed.
  called.left.wait(hold, [] { return called.callers == 0; });
}

}  // namespace bip::serve
