// The three targets. Each uses the stages as the driver does and keeps nothing between two inputs.
#include "tests/fuzz/targets.hpp"

#include "compiler/lower/lower.hpp"
#include "compiler/parse/parse.hpp"
#include "compiler/syntax/print.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/system/instantiate.hpp"

namespace bip::fuzz {
namespace {

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::string unsound(const System& system) {
  const std::vector<std::string> broken = system::validate(system);
  return broken.empty() ? std::string() : "unsound system: " + broken.front();
}

// Rendered, so that ranges which point nowhere show.
std::string without_message(const Diagnostics& diags, const SourceMap& sources, const char* stage) {
  const std::string text = render(diags, sources, {});
  if (diags.has_errors()) return text.empty() ? std::string(stage) + ": errors that nobody can read" : std::string();
  return std::string(stage) + ": neither a product nor a diagnostic";
}

}  // namespace

std::string try_text(std::string_view input) {
  SourceMap sources;
  Diagnostics diags;
  const FileId file = sources.add("fuzz.bip", std::string(input));
  const std::optional<syntax::Syntax> syntax = parse::parse_file(sources, file, diags);
  if (!syntax || diags.has_errors()) return without_message(diags, sources, "parse");
  std::optional<Model> model = model::build_model(*syntax, sources, diags);
  if (!model || diags.has_errors()) return without_message(diags, sources, "model");
  const std::optional<System> system = system::instantiate(*model, "", {}, diags, {file, 0, 0});
  if (!system || diags.has_errors()) return without_message(diags, sources, "system");
  if (std::string problem = unsound(*system); !problem.empty()) return problem;
  // Megabytes of text say no more than kilobytes.
  if (system->atoms.size() + system->connectors.size() > 1000) return {};
  const std::string text = system::print(*system);
  const Result<System> again = system::parse_bsys(text);
  if (!again) return "a printed system does not read back: " + again.error();
  if (system::print(*again) != text) return "a printed system reads back as another";
  (void)lower::lower(*system, "fuzz");
  return {};
}

std::string try_bsys(std::string_view input) {
  const Result<System> system = system::parse_bsys(input);
  if (!system) return system.error().find(':') == std::string::npos ? "a failure without a place: " + system.error() : std::string();
  if (std::string problem = unsound(*system); !problem.empty()) return problem;
  const std::string text = system::print(*system);
  const Result<System> again = system::parse_bsys(text);
  if (!again) return "what was printed does not read back: " + again.error();
  return system::print(*again) == text ? std::string() : "what was printed reads back as another";
}

std::string try_format(std::string_view input) {
  SourceMap sources;
  Diagnostics diags;
  const FileId file = sources.add("fuzz.bip", std::string(input));
  const std::optional<syntax::Syntax> syntax = parse::parse_file(sources, file, diags);
  if (!syntax || diags.has_errors()) return {};
  const std::string once = syntax::print(*syntax, sources);
  const FileId second = sources.add("once.bip", once);
  const std::optional<syntax::Syntax> again = parse::parse_file(sources, second, diags);
  if (!again || diags.has_errors()) return "what was formatted does not parse: " + first_line(render(diags, sources, {.format = DiagnosticFormat::Short}));
  return syntax::print(*again, sources) == once ? std::string() : "formatting twice is not formatting once";
}

Target find_target(std::string_view name) {
  if (name == "text") return try_text;
  if (name == "bsys") return try_bsys;
  if (name == "format") return try_format;
  return nullptr;
}

}  // namespace bip::fuzz
