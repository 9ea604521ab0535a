// `bipc view`: a page with the pictures of a model and a run of it (compiler/docs/view.md).
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "compiler/base/read_file.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/debug/back_refusal.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/open_session.hpp"
#include "compiler/driver/page_title.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/live/attached_session.hpp"
#include "compiler/live/live_session.hpp"
#include "compiler/live/page_server.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/view/page.hpp"
#include "compiler/view/proof_record.hpp"
#include "compiler/view/run_record.hpp"
#include "runtime/explore/counterexample.hpp"

namespace bip::driver {

namespace {

// Serves the page that `make` makes.
int serve_session(live::PageSession& session, const ViewArguments& arguments,
                  const std::function<std::string(const std::string& connects_to)>& make) {
  live::PageServerOptions options;
  options.port = arguments.port;
  const auto announce = [](const std::string& address) {
    std::printf("%s\n", address.c_str());
    return std::fflush(stdout) == 0;
  };
  const Result<bool> served = live::serve_page(session, options, make, announce);
  if (served) return kOk;
  print_error_words(fmt::format("error: {}", served.error()));
  return kUsage;
}

// The session is in its initial state, with the moves of a trace ahead.
int serve_live(const Compilation& c, rt::DebugSession& session, const ViewArguments& arguments, std::uint64_t seed,
               const nlohmann::ordered_json& proof) {
  const debug::DebugModel model(*c.system, c.lowered->image);
  live::LiveSession pages(*c.system, session, model, seed);
  return serve_session(pages, arguments, [&](const std::string& connects_to) {
    return view::page(*c.system, page_title(*c.system, arguments.file), arguments.picture, pages.initial(),
                      {connects_to, {}, proof});
  });
}

// The model runs elsewhere: neither its C++ nor a back end is needed here.
int serve_attached(Compilation& c, const ViewArguments& arguments, const nlohmann::ordered_json& proof) {
  const char* const token = std::getenv("BIPC_TOKEN");
  Result<std::unique_ptr<live::ModelConnection>> connection =
      live::ModelConnection::open(arguments.attached_to, token == nullptr ? "" : token);
  // The token is a secret.
  const std::string where = arguments.attached_to.substr(0, arguments.attached_to.find(':'));
  if (!connection) {
    c.diags.report(Diag::kB5090, {}, where, connection.error());
    return report(c);
  }
  live::AttachedSession pages(*c.system, std::move(*connection));
  if (const std::string problem = pages.begin(); !problem.empty()) {
    c.diags.report(Diag::kB5090, {}, where, problem);
    return report(c);
  }
  return serve_session(pages, arguments, [&](const std::string& connects_to) {
    return view::page(*c.system, page_title(*c.system, arguments.file), arguments.picture, pages.initial(),
                      {connects_to, pages.role(), proof});
  });
}

// The invariants of the certificate; null without one. False: it cannot be used, and `code` is the exit code.
bool read_proof(Compilation& c, const std::string& path, nlohmann::ordered_json& proof, int& code) {
  if (path.empty()) return true;
  const std::optional<std::string> text = read_file(path);
  if (!text) {
    c.diags.report(Diag::kB0090, {}, path, std::strerror(errno));
    code = report(c);
    return false;
  }
  Result<nlohmann::ordered_json> read = view::record_proof(*c.system, *text);
  if (!read) {
    print_error_words(fmt::format("error: `{}` is no certificate of this model: {}", path, read.error()));
    code = kUsage;
    return false;
  }
  proof = std::move(*read);
  return true;
}

}  // namespace

int command_view(const ViewArguments& arguments) {
  Compilation c(arguments.compile);
  Executor executor;
  rt::SessionOptions options = arguments.session;
  const std::string output = arguments.is_live || !arguments.attached_to.empty() ? std::string()
                             : arguments.output.empty()
                                 ? std::filesystem::path(arguments.file).stem().string() + ".html"
                                 : arguments.output;
  if (!compile(c, arguments.file, Stage::Image) ||
      !check_outputs(c, {output}, {arguments.trace_path, arguments.certificate, arguments.events_path}) ||
      !check_writable(c, {output}))
    return report(c);
  nlohmann::ordered_json proof;
  if (!arguments.attached_to.empty()) {
    int code = kOk;
    return read_proof(c, arguments.certificate, proof, code) ? serve_attached(c, arguments, proof) : code;
  }
  const OpenSession opened = open_session(c, executor, arguments, options);
  if (opened.session == nullptr) return opened.exit_code;
  rt::DebugSession& session = *opened.session;
  std::uint64_t steps = arguments.steps;
  if (!arguments.trace_path.empty()) {
    steps = session.position();
    // The page shows the run from its beginning.
    if (steps != 0 && session.go_to(0) == rt::Halt::Refused) {
      std::fprintf(stderr, "%s\n  = help: %s\n", debug::back_refused(session.problem()).c_str(), debug::kGoesBackHelp);
      return kUsage;
    }
  }
  if (int code = kOk; !read_proof(c, arguments.certificate, proof, code)) return code;
  if (arguments.is_live) return serve_live(c, session, arguments, options.seed, proof);
  const std::string page = view::page(*c.system, page_title(*c.system, arguments.file), arguments.picture,
                                      view::record_run(*c.system, session, steps, options.seed), {{}, {}, proof});
  if (const auto written = write_file(output, page); !written) {
    c.diags.report(Diag::kB5004, {}, output, written.error());
    return report(c);
  }
  // Standard output is the page then.
  if (output != "-")
    print_words(fmt::format("{}: {}; a browser opens it", output, rt::counted(session.position(), "step")));
  return kOk;
}

}  // namespace bip::driver
