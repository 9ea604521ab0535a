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
#include "compiler/serve/model_server.hpp"
#include "compiler/serve/service_calls.hpp"

namespace bip::driver {

namespace {

// False: a function is asked for that there is not.
bool find_safe_stop(const ServeArguments& arguments, void* library, serve::WatchOptions& watch) {
  watch.safe_stop_name = arguments.safe_stop.empty() ? "safe_stop" : arguments.safe_stop;
  if (library != nullptr) {
    watch.safe_stop = reinterpret_cast<void (*)(const char*)>(::dlsym(library, watch.safe_stop_name.c_str()));
    watch.called_now = reinterpret_cast<const std::atomic<const char*>* (*)()>(::dlsym(library, "bip_called_now"));
    watch.set_module_hook = reinterpret_cast<void (*)(void (*)(const char*))>(::dlsym(library, "bip_set_module_hook"));
    watch.set_crash_hook = reinterpret_cast<void (*)(void (*)(const char*))>(::dlsym(library, "bip_set_crash_hook"));
  }
  watch.late = arguments.late_after;
  watch.stall = arguments.stall_after >= 0 ? arguments.stall_after : watch.safe_stop == nullptr ? 0 : 1'000'000'000;
  return arguments.safe_stop.empty() || watch.safe_stop != nullptr;
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
  serve::WatchOptions watch;
  if (!find_safe_stop(arguments, c.lowered->library, watch)) {
    std::fprintf(stderr, "error: the model's C++ has no function `extern \"C\" void %s(const char* why)`\n",
                 arguments.safe_stop.c_str());
    return kUsage;
  }
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
