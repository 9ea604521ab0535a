// `bipc migrate`: replaces deprecated spellings and leaves the rest of the text unchanged.
//
// A deprecated spelling is a warning whose help contains the edit, so there is one list of them. The new text is
// migrated again before it is written: it must parse, and nothing may be left to replace.
#include <algorithm>
#include <cstdio>

#include "compiler/base/stage_scope.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/report.hpp"
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

int migrate_one(const MigrateArguments& arguments, const std::string& path) {
  Compilation c(arguments.compile);
  if (path.ends_with(".bsys")) {
    c.diags.report(Diag::kB5008, {}, path, "syntax");
  } else if (compile(c, path, Stage::Syntax)) {
    const StageScope doing("migrating", path);
    const std::vector<syntax::Edit> edits = syntax::deprecated_spellings(*c.syntax, c.sources.text(c.file));
    const std::string text = edited(c.sources.text(c.file), edits);
    confirm_migrated(text);
    if (!arguments.in_place) {
      std::fwrite(text.data(), 1, text.size(), stdout);
    } else if (!edits.empty()) {
      const Result<bool> written = write_file(path, text);
      if (!written) c.diags.report(Diag::kB5004, {}, path, written.error());
      if (written)
        std::printf("%s: %zu spelling%s replaced\n", path.c_str(), edits.size(), edits.size() == 1 ? "" : "s");
    }
  }
  return report(c);
}

}  // namespace

int command_migrate(const MigrateArguments& arguments) {
  int worst = kOk;
  for (const std::string& file : arguments.files) worst = std::max(worst, migrate_one(arguments, file));
  return worst;
}

}  // namespace bip::driver
