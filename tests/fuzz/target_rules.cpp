// Rules over fixed modules: errors that can be read, or a functional level that is BIP without a single warning.
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/genom/translate.hpp"
#include "compiler/rules/check_rules.hpp"
#include "compiler/rules/merge_rules.hpp"
#include "compiler/rules/parse_rules.hpp"
#include "tests/fuzz/targets.hpp"

namespace bip::fuzz {
namespace {

// Two modules that have everything that rules speak of; what a text names as its modules is not read.
constexpr const char* kModules[] = {
    "module wheel { number: 7; internal_data: DATA; };\n"
    "request SetSpeed { type: exec; exec_task: Motion; codel_main: setSpeed; };\n"
    "request Turn { type: exec; exec_task: Motion; codel_main: turn; codel_inter: brake; interrupt_activity: Turn; };\n"
    "request Park { type: exec; exec_task: Motion; codel_main: park; interrupt_activity: Turn; };\n"
    "request Stop { type: control; interrupt_activity: Turn; };\n"
    "poster Speed { update: auto; data: s::speed; exec_task: Motion; };\n"
    "exec_task Motion { period: 5; codel_task_main: cycle; };\n",
    "module arm { number: 8; internal_data: DATA; };\n"
    "request SetSpeed { type: exec; exec_task: Joint; codel_main: setArmSpeed; };\n"
    "request Lift { type: exec; exec_task: Joint; codel_main: lift; };\n"
    "exec_task Joint { period: 5; };\n"};
}  // namespace

Verdict try_rules(std::string_view input) {
  SourceMap sources;
  Diagnostics diags;
  const FileId file = sources.add("fuzz.rules", genom::as_utf8(std::string(input)));
  genom::TranslateOptions options;
  options.generate.package = "fuzz";
  std::vector<genom::Description> descriptions;
  for (const char* text : kModules) descriptions.push_back({"/nowhere/module.gen", sources.add("module.gen", text)});
  const auto modules = genom::read_modules(sources, descriptions, {}, options, diags);
  if (!modules) return {"rules: the modules are no good", false};
  rules::RuleFile rule_file = rules::parse_rules(sources, file, diags);
  rules::expand_groups(rule_file, diags);
  const auto checked = diags.has_errors() ? std::nullopt : rules::check_rules(sources, rule_file, *modules, diags);
  const std::string messages = render(diags, sources, {});
  if (!checked)
    return {diags.has_errors() && !messages.empty() ? "" : "rules: neither a product nor a diagnostic", false};
  options.generate.constraints = checked->constraints;
  const std::string text = genom::write_package(*modules, options.generate).bip;
  if (text.size() > kMaxBip) return {"", true};
  pipeline::Compilation c{pipeline::CompileOptions{}};
  c.open_texts["/nowhere/fuzz.bip"] = text;
  if (!pipeline::check(c, "/nowhere/fuzz.bip") || c.diags.warning_count() > 0) {
    return {"rules: what was written is not clean: " +
                first_line(render(c.diags, c.sources, {.format = DiagnosticFormat::Short})),
            true};
  }
  return {"", true};
}

}  // namespace bip::fuzz
