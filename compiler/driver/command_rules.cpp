// `bipc rules`: translates constraints over robot modules to the connectors that enforce them (compiler/rules), and
// decides whether they can be met: each rule that takes part in a contradiction is named.
#include <cstdio>
#include <filesystem>

#include "compiler/driver/commands.hpp"
#include "compiler/driver/contradictions.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/genom_files.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/rules/check_rules.hpp"
#include "compiler/rules/conflicts.hpp"
#include "compiler/rules/left_out.hpp"
#include "compiler/rules/parse_rules.hpp"

namespace bip::driver {
namespace {

namespace fs = std::filesystem;

// Everything but the files' own trouble.
void translate_rules(Compilation& c, const GenomArguments& a) {
  const Result<FileId> file = genom::load_description(c.sources, a.files.front());
  if (!file) {
    c.diags.report(Diag::kB0090, {}, a.files.front(), file.error());
    return;
  }
  const rules::RuleFile rule_file = rules::parse_rules(c.sources, *file, c.diags);
  const fs::path folder = fs::path(a.files.front()).parent_path();
  std::vector<std::string> files;
  for (const genom::Name& m : rule_file.modules) files.push_back((folder / m.text).string());
  if (files.empty())
    c.diags.report(Diag::kB6007, rule_file.package.range, "this file", "modules")
        .help("`modules \"ndd.gen\", \"rflex.gen\";`");
  if (c.diags.has_errors()) return;
  genom::TranslateOptions options = translate_options(a, files, genom::bip_name(rule_file.package.text));
  const std::string side = !a.side_file.empty()           ? a.side_file
                           : rule_file.side_file.is_set() ? (folder / rule_file.side_file.text).string()
                                                          : "";
  const auto modules = load_modules(c, files, side, options);
  if (!modules) return;
  const auto checked = rules::check_rules(c.sources, rule_file, *modules, c.diags);
  if (!checked) return;
  rules::report_conflicts(rule_file, *modules, *checked,
                          options.generate.tick_us > 0 ? options.generate.tick_us : genom::tick_of(*modules), c.diags);
  if (a.prove) report_contradictions(c, rule_file, *modules, *checked, static_cast<double>(a.timeout));
  if (c.diags.has_errors()) return;
  if (a.lists_left_out) {
    for (const std::string& line : rules::find_left_out(*modules, *checked)) std::printf("%s\n", line.c_str());
    return;
  }
  options.generate.constraints = checked->constraints;
  write_translation(c, a, genom::write_package(*modules, options.generate), options.generate.package);
}

}  // namespace

int command_rules(const GenomArguments& arguments) {
  Compilation c(arguments.compile);
  if (arguments.skeleton && arguments.output.empty()) {
    std::fputs("bipc: `--skeleton` writes files beside the output\n  = help: add `-o FILE`\n", stderr);
    return kUsage;
  }
  translate_rules(c, arguments);
  return report(c);
}

}  // namespace bip::driver
