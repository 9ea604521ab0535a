// `bipc serve`: runs a model in real time while clients communicate with it (compiler/docs/serve.md).
#include <dlfcn.h>

#include <cstdio>

#include "bip/process.hpp"
#include <fmt/format.h>

#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/driver/safe_stop.hpp"
#include "compiler/serve/model_server.hpp"
#include "compiler/serve/service_calls.hpp"

namespace bip::driver {

namespace {

serve::WatchOptions watch_options(const ServeArguments& arguments, const SafeStop& safe_stop, void* library) {
  serve::WatchOptions watch;
  watch.safe_stop = safe_stop.stop;
  watch.safe_stop_name = safe_stop.name;
  watch.stall = safe_stop.stall_after;
  watch.late = arguments.late_after;
  if (library == nullptr) return watch;
  watch.called_now = reinterpret_cast<const std::atomic<const char*>* (*)()>(::dlsym(library, "bip_called_now"));
  watch.set_module_hook = reinterpret_cast<void (*)(void (*)(const char*))>(::dlsym(library, "bip_set_module_hook"));
  watch.set_crash_hook = reinterpret_cast<void (*)(void (*)(const char*))>(::dlsym(library, "bip_set_crash_hook"));
  return watch;
}

}  // namespace

int command_serve(const ServeArguments& arguments) {
  Compilation c(arguments.compile);
  Executor executor;
  const bool ready = compile(c, arguments.file, Stage::Image) && check_outputs(c, {arguments.trace_path}) &&
                     executor.prepare(c, arguments.backend, Optimisation::Auto);
  if (const int code = report(c); code != 0 || !ready) return code;
  ExecutionOptions options;
  options.seed = arguments.seed;
  options.policy = arguments.policy;
  options.asap = arguments.asap;
  options.speed = arguments.speed;
  const Result<SafeStop> safe_stop = find_safe_stop(c.lowered->library, arguments.safe_stop, arguments.stall_after);
  if (!safe_stop) {
    print_error_words(fmt::format("error: {}", safe_stop.error()));
    return kUsage;
  }
  const serve::WatchOptions watch = watch_options(arguments, *safe_stop, c.lowered->library);
  serve::Controller controller(c.lowered->image, options,
                               arguments.paused ? serve::Controller::Begin::Paused : serve::Controller::Begin::Running,
                               watch);
  if (void* const library = c.lowered->library; library != nullptr) {
    serve::Requests& requests = controller.requests();
    requests.result_of = reinterpret_cast<decltype(requests.result_of)>(::dlsym(library, "bip_reply_result"));
    // With processes the module's own is asked.
    for (const char* const name : {"bip_poster_value", "bip_module_poster_value"}) {
      void* const function = ::dlsym(library, name);
      if (function == nullptr) break;
      requests.poster_value = reinterpret_cast<decltype(requests.poster_value)>(function);
    }
    requests.codel_times = reinterpret_cast<decltype(requests.codel_times)>(::dlsym(library, "bip_codel_times"));
    requests.input_problem = reinterpret_cast<decltype(requests.input_problem)>(::dlsym(library, "bip_input_problem"));
  }
  const serve::ServiceCalls calls(controller.requests(), c.lowered->library);
  controller.real_time_priority = arguments.real_time_priority;
  controller.on_problem = [](const std::string& problem) { print_error_words(fmt::format("warning: {}", problem)); };
  if (!arguments.trace_path.empty() && !controller.trace(arguments.trace_path, arguments.trace_format)) {
    print_error_words(fmt::format("error: cannot write `{}`", arguments.trace_path));
    return kUsage;
  }
  serve::ServerOptions server;
  server.uses_stdio = arguments.socket.empty() && !arguments.has_port;
  server.socket_path = arguments.socket;
  server.uses_tcp = arguments.has_port;
  server.tcp_port = arguments.port;
  server.silent_after = arguments.silent_after;
  if (arguments.silent_after > 0 && watch.safe_stop == nullptr) {
    std::fputs(
        "error: `--silent-after` stops the robot: the model's C++ has no function `extern \"C\" void "
        "safe_stop(const char* why)`\n",
        stderr);
    return kUsage;
  }
  const auto [end, problem] = serve::serve(controller, server);
  if (end != serve::ServeEnd::Done) print_error_words(fmt::format("error: {}", problem));
  if (end == serve::ServeEnd::NotOpened) return kUsage;
  if (!controller.end_trace()) {
    print_error_words(fmt::format("error: not all of `{}` could be written", arguments.trace_path));
    return kOutputLost;
  }
  return end == serve::ServeEnd::Done ? kOk : kOutputLost;
}

}  // namespace bip::driver
