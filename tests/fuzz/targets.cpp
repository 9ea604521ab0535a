// Three of the targets; the language server's is in target_lsp.cpp. Each uses the stages as the driver does and keeps
// nothing between two inputs.
#include "tests/fuzz/targets.hpp"

#include "compiler/pipeline/pipeline.hpp"
#include "compiler/pipeline/roots.hpp"
#include "compiler/parse/parse.hpp"
#include "compiler/syntax/print.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/system/instantiate.hpp"
#include "tests/fuzz/run_system.hpp"

namespace bip::fuzz {
namespace {

std::string unsound(const System& system) {
  const std::vector<std::string> broken = system::validate(system);
  return broken.empty() ? std::string() : "unsound system: " + broken.front();
}

// Written and read back it is the same.
std::string changed_by_print(const System& system) {
  const std::string text = system::print(system);
  const Result<System> again = system::parse_bsys(text);
  if (!again) return "a printed system does not read back: " + again.error();
  return system::print(*again) == text ? std::string() : "a printed system reads back as another";
}

}  // namespace

Verdict try_text(std::string_view input) {
  // The folder does not exist: what other packages say is another test's affair.
  static const std::string kPath = "/nowhere/fuzz.bip";
  pipeline::Compilation c({});
  c.open_texts.emplace(kPath, std::string(input));
  const bool is_accepted = pipeline::check(c, kPath);
  const std::string text = render(c.diags, c.sources, {});
  if (is_accepted == c.diags.has_errors()) return {is_accepted ? "accepted with errors" : "refused without an error"};
  if (!is_accepted) return {text.empty() ? "errors that nobody can read" : ""};
  // As `check` does, but each root's system is kept for a look.
  const std::optional<Model> known = model::build_model(c.packages, c.sources, c.diags);
  if (!known) return {"accepted once, refused the second time"};
  for (const std::string& root : pipeline::root_candidates(*known)) {
    std::optional<Model> model = model::build_model(c.packages, c.sources, c.diags);
    const std::optional<System> system = system::instantiate(*model, root, {}, c.diags, c.root_range);
    if (!system) return {"accepted once, refused the second time"};
    if (std::string problem = unsound(*system); !problem.empty()) return {problem};
    // Megabytes of text say no more than kilobytes.
    if (system->atoms.size() + system->connectors.size() > 1000) continue;
    if (std::string problem = changed_by_print(*system); !problem.empty()) return {problem};
    if (std::string problem = try_running(*system); !problem.empty()) return {problem};
  }
  return {.problem = {}, .is_accepted = true};
}

Verdict try_bsys(std::string_view input) {
  const Result<System> system = system::parse_bsys(input);
  if (!system)
    return {system.error().find(':') == std::string::npos ? "a failure without a place: " + system.error()
                                                          : std::string()};
  if (std::string problem = unsound(*system); !problem.empty()) return {problem};
  if (std::string problem = changed_by_print(*system); !problem.empty()) return {problem};
  return {try_running(*system), true};
}

Verdict try_format(std::string_view input) {
  SourceMap sources;
  Diagnostics diags;
  const FileId file = sources.add("fuzz.bip", std::string(input));
  const std::optional<syntax::Syntax> syntax = parse::parse_file(sources, file, diags);
  if (!syntax || diags.has_errors()) return {};
  const std::string once = syntax::print(*syntax, sources);
  const FileId second = sources.add("once.bip", once);
  const std::optional<syntax::Syntax> again = parse::parse_file(sources, second, diags);
  if (!again || diags.has_errors())
    return {"what was formatted does not parse: " +
            first_line(render(diags, sources, {.format = DiagnosticFormat::Short}))};
  return {syntax::print(*again, sources) == once ? "" : "formatting twice is not formatting once", true};
}

Target find_target(std::string_view name) {
  if (name == "text") return try_text;
  if (name == "bsys") return try_bsys;
  if (name == "format") return try_format;
  if (name == "lsp") return try_lsp;
  if (name == "genom") return try_genom;
  if (name == "rules") return try_rules;
  if (name == "property") return try_property;
  if (name == "frame") return try_frame;
  if (name == "bip1") return try_bip1;
  return nullptr;
}

}  // namespace bip::fuzz
