// Descriptions of robot modules: errors that can be read, or a text that is BIP without a single warning.
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/genom/translate.hpp"
#include "tests/fuzz/targets.hpp"

namespace bip::fuzz {
Verdict try_genom(std::string_view input) {
  SourceMap sources;
  Diagnostics diags;
  const FileId file = sources.add("fuzz.gen", genom::as_utf8(std::string(input)));
  genom::TranslateOptions options;
  options.generate.package = "fuzz";
  const std::optional<std::vector<genom::Module>> modules =
      genom::read_modules(sources, {{"/nowhere/fuzz.gen", file}}, {}, options, diags);
  const std::string messages = render(diags, sources, {});
  if (!modules)
    return {diags.has_errors() && !messages.empty() ? "" : "genom: neither a product nor a diagnostic", false};
  if (diags.has_errors()) return {"genom: a product and errors", true};
  const std::string text = genom::write_package(*modules, options.generate).bip;
  if (text.size() > kMaxBip) return {"", true};
  pipeline::Compilation c{pipeline::CompileOptions{}};
  c.open_texts["/nowhere/fuzz.bip"] = text;
  if (!pipeline::check(c, "/nowhere/fuzz.bip") || c.diags.warning_count() > 0) {
    return {"genom: what was written is not clean: " +
                first_line(render(c.diags, c.sources, {.format = DiagnosticFormat::Short})),
            true};
  }
  return {"", true};
}

}  // namespace bip::fuzz
