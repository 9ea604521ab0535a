// `bipc fmt`: formats files, on standard output, compared (--check) or in place (-i).
//
// Formatting in place is safe: the new text must parse and print as itself, and replaces the old file by renaming.
#include <cstdio>

#include "compiler/base/stage_scope.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/syntax/print.hpp"

namespace bip::driver {
namespace {

void confirm_stable(const std::string& text) {
  SourceMap sources;
  Diagnostics diags;
  const FileId file = sources.add("formatted", text);
  const auto again = parse::parse_file(sources, file, diags);
  BIP_ENSURE(again.has_value() && !diags.has_errors());
  BIP_ENSURE(syntax::print(*again, sources) == text);
}

// 0, or 1 if the file has errors or (--check) is not in house style.
int format_one(const FmtArguments& arguments, const std::string& path) {
  Compilation c(arguments.compile);
  bool differs = false;
  if (path.ends_with(".bsys")) {
    c.diags.report(Diag::kB5008, {}, path, "syntax");
  } else if (compile(c, path, Stage::Syntax)) {
    const StageScope doing("formatting", path);
    const std::string text = syntax::print(*c.syntax, c.sources);
    confirm_stable(text);
    differs = c.sources.text(c.file) != text;
    if (arguments.check) {
      if (differs) print_words(path + " is not in house style: `bipc fmt -i` would change it");
    } else if (!arguments.in_place) {
      std::fwrite(text.data(), 1, text.size(), stdout);
    } else if (differs) {
      const Result<bool> written = write_file(path, text);
      if (!written) c.diags.report(Diag::kB5004, {}, path, written.error());
    }
  }
  const int code = report(c);
  return arguments.check && differs ? kModelErrors : code;
}

}  // namespace

int command_fmt(const FmtArguments& arguments) {
  int worst = kOk;
  for (const std::string& file : arguments.files) worst = std::max(worst, format_one(arguments, file));
  return worst;
}

}  // namespace bip::driver
