// `bipc view`: a page with the pictures of a model and a run of it (compiler/docs/view.md).
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "compiler/base/read_file.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/debug/back_refusal.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/open_session.hpp"
#include "compiler/driver/page_title.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/live/page_server.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/view/page.hpp"
#include "compiler/view/proof_record.hpp"
#include "compiler/view/run_record.hpp"
#include "runtime/explore/counterexample.hpp"

namespace bip::driver {

namespace {

// The session is in its initial state, with the moves of a trace ahead.
int serve_live(const Compilation& c, rt::DebugSession& session, const ViewArguments& arguments, std::uint64_t seed,
               const nlohmann::ordered_json& proof) {
  const debug::DebugModel model(*c.system, c.lowered->image);
  live::LiveSession pages(*c.system, session, model, seed);
  live::PageServerOptions options;
  options.port = arguments.port;
  const auto page = [&](const std::string& connects_to) {
    return view::page(*c.system, page_title(*c.system, arguments.file), arguments.picture, pages.initial(),
                      {connects_to, proof});
  };
  const auto announce = [](const std::string& address) {
    std::printf("%s\n", address.c_str());
    std::fflush(stdout);
  };
  const Result<bool> served = live::serve_page(pages, options, page, announce);
  if (served) return kOk;
  std::fprintf(stderr, "error: %s\n", served.error().c_str());
  return kUsage;
}

}  // namespace

int command_view(const ViewArguments& arguments) {
  Compilation c(arguments.compile);
  Executor executor;
  rt::SessionOptions options = arguments.session;
  const std::string output = arguments.is_live ? std::string()
                             : arguments.output.empty()
                                 ? std::filesystem::path(arguments.file).stem().string() + ".html"
                                 : arguments.output;
  if (!compile(c, arguments.file, Stage::Image) || !check_outputs(c, {output})) return report(c);
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
  nlohmann::ordered_json proof;
  if (!arguments.certificate.empty()) {
    const std::optional<std::string> text = read_file(arguments.certificate);
    if (!text) {
      c.diags.report(Diag::kB0090, {}, arguments.certificate, std::strerror(errno));
      return report(c);
    }
    Result<nlohmann::ordered_json> read = view::record_proof(*c.system, *text);
    if (!read) {
      std::fprintf(stderr, "error: `%s` is no certificate of this model: %s\n", arguments.certificate.c_str(),
                   read.error().c_str());
      return kUsage;
    }
    proof = std::move(*read);
  }
  if (arguments.is_live) return serve_live(c, session, arguments, options.seed, proof);
  const std::string page = view::page(*c.system, page_title(*c.system, arguments.file), arguments.picture,
                                      view::record_run(*c.system, session, steps, options.seed), {{}, proof});
  if (const auto written = write_file(output, page); !written) {
    c.diags.report(Diag::kB5004, {}, output, written.error());
    return report(c);
  }
  std::printf("%s: %s; a browser opens it\n", output.c_str(), rt::counted(session.position(), "step").c_str());
  return kOk;
}

}  // namespace bip::driver
