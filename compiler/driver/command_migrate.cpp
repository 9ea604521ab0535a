// `bipc migrate`: replaces deprecated spellings and leaves the rest of the text unchanged.
//
// A deprecated spelling is a warning whose help contains the edit, so there is one list of them. The new text is
// migrated again before it is written: it must parse, and nothing may be left to replace. A file of BIP1 is written
// anew (migrate_bip1.hpp).
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "compiler/base/stage_scope.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/migrate_bip1.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/parse/head_of_bip1.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/syntax/deprecated.hpp"

namespace bip::driver {
namespace {

// The edits applied to the text; they do not overlap and are in order.
std::string edited(std::string_view text, const std::vector<syntax::Edit>& edits) {
  std::string out;
  std::size_t done = 0;
  for (const syntax::Edit& edit : edits) {
    out += text.substr(done, edit.range.begin - done);
    out += edit.with;
    done = edit.range.end;
  }
  return out + std::string(text.substr(done));
}

void confirm_migrated(const std::string& text) {
  SourceMap sources;
  Diagnostics diags;
  const FileId file = sources.add("migrated", text);
  const auto again = parse::parse_file(sources, file, diags);
  BIP_ENSURE(again.has_value() && !diags.has_errors());
  BIP_ENSURE(syntax::deprecated_spellings(*again, text).empty());
}

// False after a report.
bool write_text(Compilation& c, const std::string& path, const std::string& text) {
  const Result<bool> written = write_file(path, text);
  if (!written) c.diags.report(Diag::kB5004, {}, path, written.error());
  return static_cast<bool>(written);
}

void migrate_spellings(Compilation& c, const MigrateArguments& arguments) {
  c.syntax = pipeline::parse_text(c, c.file);
  if (!c.syntax || c.diags.has_errors()) return;
  const StageScope doing("migrating", c.path);
  const std::vector<syntax::Edit> edits = syntax::deprecated_spellings(*c.syntax, c.sources.text(c.file));
  const std::string text = edited(c.sources.text(c.file), edits);
  confirm_migrated(text);
  if (!arguments.output.empty()) {
    if (check_outputs(c, {arguments.output})) (void)write_text(c, arguments.output, text);
  } else if (!arguments.in_place) {
    std::fwrite(text.data(), 1, text.size(), stdout);
  } else if (!edits.empty() && write_text(c, c.path, text)) {
    print_words(fmt::format("{}: {} spelling{} replaced", c.path, edits.size(), edits.size() == 1 ? "" : "s"));
  }
}

void migrate_model(Compilation& c, const MigrateArguments& arguments) {
  const bool is_file = arguments.in_place || !arguments.output.empty();
  const std::string output = arguments.output.empty() ? c.path : arguments.output;
  if (!check_outputs(c, {arguments.output})) return;
  const auto migration = migrate_bip1(c, output);
  if (!migration) return;
  if (!is_file) {
    std::fwrite(migration->text.data(), 1, migration->text.size(), stdout);
    if (!migration->source.empty())
      c.diags.report(Diag::kB6141, {}, c.path, migration->header_path, migration->source_path);
    return;
  }
  // What has no counterpart is in the old file only.
  if (arguments.in_place && c.diags.has_errors()) return;
  if (!write_cpp_files(c, *migration) || !write_text(c, output, migration->text)) return;
  if (!arguments.in_place) return;
  std::string line = c.path + ": written in BIP2";
  if (!migration->source.empty())
    line += fmt::format(", its C code in {} and {}", migration->header_path, migration->source_path);
  print_words(line);
}

int migrate_one(const MigrateArguments& arguments, const std::string& path) {
  Compilation c(arguments.compile);
  if (path.ends_with(".bsys")) {
    c.diags.report(Diag::kB5008, {}, path, "syntax");
  } else if (compile(c, path, Stage::Source)) {
    if (parse::head_of_bip1(c.sources, c.file).is_valid()) {
      migrate_model(c, arguments);
    } else {
      migrate_spellings(c, arguments);
    }
  }
  return report(c);
}

}  // namespace

int command_migrate(const MigrateArguments& arguments) {
  if (!arguments.output.empty() && arguments.files.size() > 1) {
    return usage_error(fmt::format("`-o` names one file, and there are {} to migrate", arguments.files.size()));
  }
  int worst = kOk;
  for (const std::string& file : arguments.files) worst = std::max(worst, migrate_one(arguments, file));
  return worst;
}

}  // namespace bip::driver
