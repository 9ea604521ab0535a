// `bipc rules`: translates constraints over robot modules to the connectors that enforce them (compiler/rules), and
// decides whether they can be met: each rule that takes part in a contradiction is named.
#include <cstdio>

#include "compiler/driver/commands.hpp"
#include "compiler/driver/contradictions.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/genom_files.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/driver/rule_files.hpp"
#include "compiler/rules/conflicts.hpp"
#include "compiler/rules/left_out.hpp"
#include "compiler/rules/reduce.hpp"

namespace bip::driver {
namespace {

// Everything but the files' own trouble.
void translate_rules(Compilation& c, const GenomArguments& a) {
  const std::optional<RuleLevel> level = load_rules(c, a);
  if (!level) return;
  genom::TranslateOptions options = level->options;
  rules::report_conflicts(level->file, level->modules, level->checked,
                          options.generate.tick_us > 0 ? options.generate.tick_us : genom::tick_of(level->modules),
                          c.diags);
  if (a.prove) report_contradictions(c, level->file, level->modules, level->checked, static_cast<double>(a.timeout));
  if (c.diags.has_errors()) return;
  if (a.lists_left_out) {
    for (const std::string& line : rules::find_left_out(level->modules, level->checked))
      std::printf("%s\n", line.c_str());
    return;
  }
  if (a.reduced) {
    const rules::Reduced reduced = rules::reduce(level->modules, level->checked.constraints);
    write_translation(c, a,
                      genom::write_package(reduced.modules, rules::reduced_options(reduced, options.generate.package)),
                      options.generate.package);
    return;
  }
  options.generate.constraints = level->checked.constraints;
  write_translation(c, a, genom::write_package(level->modules, options.generate), options.generate.package);
}

}  // namespace

int command_rules(const GenomArguments& arguments) {
  Compilation c(arguments.compile);
  if (arguments.skeleton && arguments.output.empty())
    return usage_error("`--skeleton` writes files beside the output", "add `-o FILE`");
  translate_rules(c, arguments);
  return report(c);
}

}  // namespace bip::driver
