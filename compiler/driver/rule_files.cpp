// See rule_files.hpp. Paths in a .rules file are relative to its folder, those of a file that it extends to that one's.
#include "compiler/driver/rule_files.hpp"

#include <filesystem>
#include <set>
#include <string>
#include <utility>

#include "compiler/driver/genom_files.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/rules/merge_rules.hpp"
#include "compiler/rules/parse_rules.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {
namespace {

namespace fs = std::filesystem;

// The file with all that it extends, each file once; nothing if one cannot be read. Its paths are relative no more.
std::optional<rules::RuleFile> read_rules(Compilation& c, const std::string& path) {
  std::vector<genom::Name> names{{.text = path, .range = {}}};
  std::set<fs::path> known;
  std::optional<rules::RuleFile> all;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const genom::Name name = names[k];
    std::error_code ignored;
    if (!known.insert(fs::weakly_canonical(name.text, ignored)).second) continue;
    const Result<FileId> file = genom::load_description(c.sources, name.text);
    if (!file) {
      c.diags.report(Diag::kB0090, name.range, name.text, file.error());
      return std::nullopt;
    }
    rules::RuleFile next = rules::parse_rules(c.sources, *file, c.diags);
    const fs::path folder = fs::path(name.text).parent_path();
    const auto place = [&](genom::Name& n) { n.text = (folder / n.text).string(); };
    for (genom::Name& m : next.modules) place(m);
    if (next.side_file.is_set()) place(next.side_file);
    for (genom::Name& n : next.extends) place(names.emplace_back(n));
    if (all) rules::extend(*all, std::move(next));
    else all = std::move(next);
  }
  BIP_ASSERT(all.has_value(), "no file was read");
  rules::expand_groups(*all, c.diags);
  return all;
}

}  // namespace

std::optional<RuleLevel> load_rules(Compilation& c, const GenomArguments& a, genom::Types types) {
  std::optional<rules::RuleFile> read = read_rules(c, a.files.front());
  if (!read) return std::nullopt;
  RuleLevel level{std::move(*read), {}, {}, {}};
  std::vector<std::string> files;
  for (const genom::Name& m : level.file.modules) files.push_back(m.text);
  if (files.empty())
    c.diags.report(Diag::kB6007, level.file.package.range, "this file", "modules")
        .help("`modules \"ndd.gen\", \"rflex.gen\";`");
  if (c.diags.has_errors()) return std::nullopt;
  level.options = translate_options(a, files, genom::bip_name(level.file.package.text));
  level.options.types = types;
  const std::string side = a.side_file.empty() ? level.file.side_file.text : a.side_file;
  auto modules = load_modules(c, files, side, level.options);
  if (!modules) return std::nullopt;
  level.modules = std::move(*modules);
  auto checked = rules::check_rules(c.sources, level.file, level.modules, c.diags);
  if (!checked) return std::nullopt;
  level.checked = std::move(*checked);
  return level;
}

}  // namespace bip::driver
