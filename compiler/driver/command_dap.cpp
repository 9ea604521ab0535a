// `bipc dap`: the debug adapter on standard input and output (compiler/docs/dap.md). Nothing else is written to
// standard output; what a model's C++ prints there would break the protocol, so it goes to standard error.
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "bip/process.hpp"
#include "compiler/base/framed_output.hpp"
#include "compiler/base/framing.hpp"
#include "compiler/debug/dap_server.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/host_compiler.hpp"
#include "compiler/driver/load_moves.hpp"
#include "compiler/pipeline/executor.hpp"
#include "runtime/engine/policies.hpp"

namespace bip::driver {

namespace {

// The products of a launch, in the order in which they need each other.
struct LaunchedModel final : debug::Debuggee {
  explicit LaunchedModel(CompileOptions options) : compilation(std::move(options)) {}
  Compilation compilation;
  Executor executor;
  std::unique_ptr<rt::DebugSession> started;
};

std::string diagnostics_of(const Compilation& c) {
  RenderOptions options;
  options.format = DiagnosticFormat::Short;
  return render(c.diags, c.sources, options);
}

Result<std::unique_ptr<debug::Debuggee>> launch_model(const debug::LaunchRequest& request) {
  CompileOptions options;
  options.root = request.root;
  options.folders = request.folders;
  options.refuses_cpp = request.refuses_cpp;
  auto model = std::make_unique<LaunchedModel>(std::move(options));
  Compilation& c = model->compilation;
  rt::SessionOptions session;
  session.seed = request.seed;
  session.asap = request.asap;
  session.trusts_cpp = request.trusts_cpp;
  if (!request.policy.empty()) {
    const rt::PolicyRow* const policy = rt::find_policy(request.policy);
    if (policy == nullptr) return Failure{fmt::format("there is no policy `{}`", request.policy)};
    session.policy = policy->policy;
  }
  std::optional<RunFileText> run;
  bool is_ready = compile(c, request.program, Stage::Image);
  if (is_ready && !request.trace.empty()) {
    run = read_run(c, request.trace, session);
    is_ready = run.has_value();
  }
  if (!is_ready || !model->executor.prepare(c, Backend::Interp, Optimisation::Auto)) return Failure{diagnostics_of(c)};
  model->started = std::make_unique<rt::DebugSession>(c.lowered->image, session);
  if (!request.events.empty()) {
    if (const Result<bool> are_read = model->started->read_events(request.events); !are_read)
      return Failure{are_read.error()};
  }
  (void)model->started->start();
  if (run && !load_moves(c, *run, *model->started)) return Failure{diagnostics_of(c)};
  model->session = model->started.get();
  model->model = std::make_unique<debug::DebugModel>(*c.system, c.lowered->image);
  return std::unique_ptr<debug::Debuggee>(std::move(model));
}

bool has_bytes() {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  return ::poll(&input, 1, 0) > 0;
}

}  // namespace

int command_dap() {
  constexpr std::size_t kChunk = 1u << 16;
  // The protocol has the only copy of standard output.
  const int out = ::dup(STDOUT_FILENO);
  if (out < 0 || ::dup2(STDERR_FILENO, STDOUT_FILENO) < 0) return report_lost_output(errno);
  FramedOutput output(out);
  debug::DapServer server(launch_model, [&](const std::string& body) { output.write(body); });
  Framing framing;
  int read_error = 0;
  server.has_input = has_bytes;
  std::string chunk;
  // A signal that came while the model's C++ was compiled ends the session.
  while (output.error() == 0 && !server.is_finished() && signal_during_program() == 0) {
    bool has_message = false;
    while (auto frame = framing.next()) {
      has_message = true;
      server.handle(frame->kind == Framing::Kind::Message ? frame->body : std::string_view());
      if (server.is_finished()) break;
    }
    if (server.is_finished()) break;
    if (server.is_running() && !has_bytes()) {
      server.run();
      continue;
    }
    if (has_message && !server.is_running() && framing.has_more()) continue;
    chunk.resize(kChunk);
    const ssize_t got = ::read(STDIN_FILENO, chunk.data(), chunk.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) read_error = errno;
    if (got <= 0) break;
    framing.feed(std::string_view(chunk).substr(0, static_cast<std::size_t>(got)));
  }
  ::close(out);
  if (output.error() != 0) return report_lost_output(output.error());
  if (read_error != 0) {
    print_error_words(fmt::format("error: cannot read standard input: {}", std::strerror(read_error)));
    return kOutputLost;
  }
  if (!server.is_finished() && signal_during_program() == 0)
    print_error_words("error: standard input has ended before a request `disconnect`");
  return server.is_finished() ? kOk : kModelErrors;
}

}  // namespace bip::driver
