// See rule_files.hpp. Paths in a .rules file are relative to its folder.
#include "compiler/driver/rule_files.hpp"

#include <filesystem>
#include <string>

#include "compiler/driver/genom_files.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/rules/parse_rules.hpp"

namespace bip::driver {

std::optional<RuleLevel> load_rules(Compilation& c, const GenomArguments& a, genom::Types types) {
  namespace fs = std::filesystem;
  const Result<FileId> file = genom::load_description(c.sources, a.files.front());
  if (!file) {
    c.diags.report(Diag::kB0090, {}, a.files.front(), file.error());
    return std::nullopt;
  }
  RuleLevel level{rules::parse_rules(c.sources, *file, c.diags), {}, {}, {}};
  const fs::path folder = fs::path(a.files.front()).parent_path();
  std::vector<std::string> files;
  for (const genom::Name& m : level.file.modules) files.push_back((folder / m.text).string());
  if (files.empty())
    c.diags.report(Diag::kB6007, level.file.package.range, "this file", "modules")
        .help("`modules \"ndd.gen\", \"rflex.gen\";`");
  if (c.diags.has_errors()) return std::nullopt;
  level.options = translate_options(a, files, genom::bip_name(level.file.package.text));
  level.options.types = types;
  const std::string side = !a.side_file.empty()            ? a.side_file
                           : level.file.side_file.is_set() ? (folder / level.file.side_file.text).string()
                                                           : "";
  auto modules = load_modules(c, files, side, level.options);
  if (!modules) return std::nullopt;
  level.modules = std::move(*modules);
  auto checked = rules::check_rules(c.sources, level.file, level.modules, c.diags);
  if (!checked) return std::nullopt;
  level.checked = std::move(*checked);
  return level;
}

}  // namespace bip::driver
