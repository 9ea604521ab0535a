// See serve_image.hpp.
#include "compiler/serve/serve_image.hpp"

#include <dlfcn.h>

#include <cstdio>
#include <string_view>

#include "bip/process.hpp"
#include "compiler/serve/model_server.hpp"
#include "compiler/serve/safe_stop.hpp"
#include "compiler/serve/service_calls.hpp"
#include "runtime/core/text.hpp"

namespace bip::serve {

namespace {

void print(const char* kind, std::string_view text) {
  std::fprintf(stderr, "%s: %s\n", kind, rt::printable(text).c_str());
}

template <class Function>
void find(void* library, const char* name, Function*& function) {
  function = reinterpret_cast<Function*>(::dlsym(library, name));
}

WatchOptions watch_options(const ServeSettings& settings, const SafeStop& safe_stop, void* library) {
  WatchOptions watch;
  watch.safe_stop = safe_stop.stop;
  watch.safe_stop_name = safe_stop.name;
  watch.stall = safe_stop.stall_after;
  watch.names_late = settings.late_after > 0;
  watch.late = settings.late_after < 0 ? kLateByDefault : settings.late_after;
  if (library == nullptr) return watch;
  find(library, "bip_called_now", watch.called_now);
  find(library, "bip_set_module_hook", watch.set_module_hook);
  find(library, "bip_set_crash_hook", watch.set_crash_hook);
  return watch;
}

void find_functions(void* library, Requests& requests) {
  if (library == nullptr) return;
  find(library, "bip_reply_result", requests.result_of);
  find(library, "bip_poster_value", requests.poster_value);
  // With processes the module's own is asked.
  if (requests.poster_value != nullptr && ::dlsym(library, "bip_module_poster_value") != nullptr)
    find(library, "bip_module_poster_value", requests.poster_value);
  find(library, "bip_codel_times", requests.codel_times);
  find(library, "bip_input_problem", requests.input_problem);
}

}  // namespace

int serve_image(const rt::Image& image, void* library, const ServeSettings& settings) {
  ExecutionOptions options;
  options.seed = settings.seed;
  options.policy = settings.policy;
  options.asap = settings.asap;
  options.speed = settings.speed;
  Result<SafeStop> safe_stop = find_safe_stop(library, settings.safe_stop, settings.stall_after);
  if (!safe_stop) {
    print("error", safe_stop.error());
    return kUsage;
  }
  if (settings.silent_after > 0 && safe_stop->stop == nullptr) {
    print("error",
          "`--silent-after` stops the robot: the model's C++ has no function `extern \"C\" void safe_stop(const char* "
          "why)`");
    return kUsage;
  }
  Controller controller(image, options, settings.paused ? Controller::Begin::Paused : Controller::Begin::Running,
                        watch_options(settings, *safe_stop, library));
  find_functions(library, controller.requests());
  const ServiceCalls calls(controller.requests(), library);
  controller.real_time_priority = settings.real_time_priority;
  controller.on_problem = [](const std::string& problem) { print("warning", problem); };
  if (!settings.trace_path.empty() && !controller.trace(settings.trace_path, settings.trace_format)) {
    print("error", "cannot write `" + settings.trace_path + "`");
    return kUsage;
  }
  ServerOptions server;
  server.uses_stdio = settings.socket.empty() && !settings.has_port;
  server.socket_path = settings.socket;
  server.uses_tcp = settings.has_port;
  server.tcp_port = settings.port;
  server.silent_after = settings.silent_after;
  server.close_after = settings.close_after;
  server.idle_after = settings.idle_after;
  const auto [end, problem] = serve(controller, server);
  if (end != ServeEnd::Done) print("error", problem);
  if (end == ServeEnd::NotOpened) return kUsage;
  if (!controller.end_trace()) {
    print("error", "not all of `" + settings.trace_path + "` could be written");
    return kOutputLost;
  }
  return end == ServeEnd::Done ? 0 : kOutputLost;
}

}  // namespace bip::serve
