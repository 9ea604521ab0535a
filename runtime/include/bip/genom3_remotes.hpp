// Calls of services of other components by GenoM 3 codels (`remote` arguments). Header only; what `bipc genom --codels`
// writes calls it.
//
// A call is a request like those of clients: bip::service_caller() hands it over and waits for the final reply, so it
// takes at least a control cycle of the other component. Only codels that run beside their task make calls.
#pragma once
#include <cstring>
#include <mutex>
#include <span>
#include <string>
#include <string_view>

#include "bip/codels.hpp"
#include "bip/genom3_codels.hpp"
#include "bip/genom3_values.hpp"

namespace bip::genom3 {

/// A service that has the parameters of a remote: "eye/watch" for `connect_service`, "eye.watch" for requests.
struct RemoteTarget {
  const char *name, *service;
};
/// What a remote is connected to.
class RemoteService {
 public:
  RemoteService(std::span<const RemoteTarget> targets, const char* service) : targets_(targets), service_(service) {}
  /// Empty: nothing.
  [[nodiscard]] std::string service() {
    const std::lock_guard<std::mutex> hold(lock_);
    return service_;
  }
  /// False: there is no such service, or it has other parameters.
  bool connect(std::string_view remote) {
    for (const RemoteTarget& target : targets_) {
      if (remote != target.name) continue;
      const std::lock_guard<std::mutex> hold(lock_);
      service_ = target.service;
      return true;
    }
    return false;
  }

 private:
  std::span<const RemoteTarget> targets_;
  std::mutex lock_;
  std::string service_;
};
struct RemoteRow {
  const char* name;
  RemoteService* service;
};
/// The service `connect_service` of a component.
inline genom_event connect_service(std::span<const RemoteRow> remotes, std::string_view local, std::string_view remote,
                                   genom_context self) {
  for (const RemoteRow& row : remotes) {
    if (local == row.name && row.service->connect(remote)) return genom_ok;
  }
  return self->raise(genom_no_such_service_id, nullptr, 0, self);
}

template <class T>
void write_input(std::string& members, const char* name, const T& v) {
  members += (members.empty() ? "" : ",") + json_text(name) + ":";
  to_json(members, v);
}
template <class T>
void read_output(const Json& output, const char* name, T& v) {
  clear(v);
  if (const Json* const given = output.find(name)) from_json(*given, v, name);
}
/// To where a parameter of C points. Only what was `inout` had a value before.
template <class T>
void hand_over(void* to, T& from, bool has_value) {
  if (has_value) release(*static_cast<T*>(to));
  std::memcpy(to, &from, sizeof from);
}

enum class Mapping { C, Cxx };
/// Asks for the service with an input of these members. `take` gets the output. Returns genom_ok, or the exception with
/// which the service ended: its own, or one of genom3's; what is neither is `unkown_error`.
template <Mapping mapping, class Take>
genom_event call_service(RemoteService& remote, const std::string& members, std::span<const ExceptionRow> exceptions,
                         genom_context self, Take take) {
  const auto raise_named = [&](std::string_view name, const Json* detail) -> genom_event {
    for (const ExceptionRow& row : exceptions) {
      if (name != row.event) continue;
      const auto again = mapping == Mapping::C ? row.again : row.object_again;
      return again == nullptr ? self->raise(row.event, nullptr, 0, self) : again(detail, self);
    }
    return genom_ok;
  };
  const std::string service = remote.service();
  const auto caller = service_caller().load();
  if (service.empty() || caller == nullptr) return self->raise(genom_no_such_service_id, nullptr, 0, self);
  const Json reply = JsonReader::read(caller(service.c_str(), ("{" + members + "}").c_str()));
  const Json *const report = reply.find("report"), *const result = reply.find("result");
  const std::string text = report == nullptr ? "no reply" : report->text;
  if (text == "OK") {
    const Json* const output = result == nullptr ? nullptr : result->find("output");
    take(output == nullptr ? Json{} : *output);
    return genom_ok;
  }
  const Json* const exception = result == nullptr ? nullptr : result->find("exception");
  if (const Json* const name = exception == nullptr ? nullptr : exception->find("name"); name != nullptr) {
    if (const genom_event event = raise_named(name->text, exception->find("detail")); event != genom_ok) return event;
  }
  if (const genom_event event = raise_named("::genom::" + text, nullptr); event != genom_ok) return event;
  const Json* const problem = reply.find("problem");
  const std::string what = service + ": " + (problem == nullptr ? text : problem->text);
  Json detail;
  detail.kind = Json::Kind::Object;
  detail.members.push_back(
      {"what", {.kind = Json::Kind::Text, .text = what.substr(0, 128), .items = {}, .members = {}}});
  return raise_named("::genom::unkown_error", &detail);
}

}  // namespace bip::genom3
