// `bipc dap`: the debug adapter on standard input and output (compiler/docs/dap.md). Nothing else is written to
// standard output; what a model's C++ prints there would break the protocol, so it goes to standard error.
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "compiler/base/framing.hpp"
#include "compiler/debug/dap_server.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/exit_codes.hpp"
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

std::unique_ptr<debug::Debuggee> launch_model(const debug::LaunchRequest& request, std::string& problem) {
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
    if (policy == nullptr) {
      problem = fmt::format("there is no policy `{}`", request.policy);
      return nullptr;
    }
    session.policy = policy->policy;
  }
  std::optional<RunFileText> run;
  bool is_ready = compile(c, request.program, Stage::Image);
  if (is_ready && !request.trace.empty()) {
    run = read_run(c, request.trace, session);
    is_ready = run.has_value();
  }
  if (!is_ready || !model->executor.prepare(c, Backend::Interp, Optimisation::Auto)) {
    problem = diagnostics_of(c);
    return nullptr;
  }
  model->started = std::make_unique<rt::DebugSession>(c.lowered->image, session);
  if (!request.events.empty()) {
    if (const Result<bool> are_read = model->started->read_events(request.events); !are_read) {
      problem = are_read.error();
      return nullptr;
    }
  }
  (void)model->started->start();
  if (run && !load_moves(c, *run, *model->started)) {
    problem = diagnostics_of(c);
    return nullptr;
  }
  model->session = model->started.get();
  model->model = std::make_unique<debug::DebugModel>(*c.system, c.lowered->image);
  return model;
}

bool write_whole(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(file, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(done));
  }
  return true;
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
  if (out < 0 || ::dup2(STDERR_FILENO, STDOUT_FILENO) < 0) return kUsage;
  bool is_heard = true;
  debug::DapServer server(launch_model,
                          [&](const std::string& body) { is_heard = is_heard && write_whole(out, framed(body)); });
  Framing framing;
  server.has_input = has_bytes;
  std::string chunk;
  while (is_heard && !server.is_finished()) {
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
    if (got <= 0) break;
    framing.feed(std::string_view(chunk).substr(0, static_cast<std::size_t>(got)));
  }
  ::close(out);
  return server.is_finished() ? kOk : kModelErrors;
}

}  // namespace bip::driver
