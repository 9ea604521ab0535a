// `bipc migrate` of BIP1: an error of syntax that can be read, or BIP2 that parses and that the formatter keeps, in
// which each comment is.
#include "compiler/migrate/write_bip2.hpp"
#include "compiler/parse/parse.hpp"
#include "compiler/parse/bip1/parse_bip1.hpp"
#include "compiler/syntax/print.hpp"
#include "tests/fuzz/targets.hpp"

namespace bip::fuzz {

Verdict try_bip1(std::string_view input) {
  SourceMap sources;
  Diagnostics diags;
  const Result<FileId> loaded = sources.load_text("fuzz.bip", std::string(input));
  if (!loaded) return {};
  const FileId file = *loaded;
  const std::optional<syntax::bip1::Model> model = parse::parse_bip1(sources, file, diags);
  if (!model) {
    const std::string messages = render(diags, sources, {});
    return {diags.has_errors() && !messages.empty() ? "" : "bip1: neither a model nor a diagnostic", false};
  }
  const migrate::Bip2Text made = migrate::write_bip2(*model, sources, "fuzz", diags);
  if (made.bip.size() > kMaxBip) return {"", true};
  SourceMap written;
  Diagnostics problems;
  const FileId bip = written.add("written.bip", made.bip);
  const std::optional<syntax::Syntax> read = parse::parse_file(written, bip, problems);
  if (!read || problems.has_errors()) {
    return {"bip1: what was written does not parse: " +
                first_line(render(problems, written, {.format = DiagnosticFormat::Short})),
            true};
  }
  const std::string once = syntax::print(*read, written);
  const FileId second = written.add("once.bip", once);
  const std::optional<syntax::Syntax> again = parse::parse_file(written, second, problems);
  if (!again || syntax::print(*again, written) != once) return {"bip1: the formatter changes it twice", true};
  if (read->comments.size() < model->comments.size()) return {"bip1: a comment is lost", true};
  return {"", true};
}

}  // namespace bip::fuzz
