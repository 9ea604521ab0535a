// A text, its tree and its diagnostics, for the tests of this folder and of syntax.
#pragma once
#include <string>

#include "compiler/parse/parse.hpp"
#include "compiler/syntax/print.hpp"

namespace bip::test {

struct Parsed {
  explicit Parsed(const std::string& text)
      : file(sources.add("test.bip", text)), syntax(parse::parse_file(sources, file, diags)) {}
  SourceMap sources;
  FileId file;
  Diagnostics diags;
  std::optional<syntax::Syntax> syntax;

  /// "B0001 B0006": the codes in the order of the text.
  [[nodiscard]] std::string codes() const {
    std::string out;
    for (const Diagnostic* d : diags.sorted()) out += (out.empty() ? "" : " ") + std::string(info(d->kind).code);
    return out;
  }
  [[nodiscard]] std::string messages() const { return render(diags, sources, {.format = DiagnosticFormat::Short}); }
  [[nodiscard]] const syntax::Decl& decl(std::size_t i) const { return *syntax->package->decls[i]; }
  /// The dump without positions.
  [[nodiscard]] std::string shape() const {
    std::string out;
    bool in_place = false;
    const std::string full = syntax::dump(*syntax, sources);
    for (std::size_t i = 0; i < full.size(); ++i) {
      if (full[i] == '@' && i + 1 < full.size() && full[i + 1] >= '0' && full[i + 1] <= '9') {
        in_place = true;
        out.pop_back();
      }
      if (full[i] == ' ' || full[i] == '\n') in_place = false;
      if (!in_place) out += full[i];
    }
    return out;
  }
  [[nodiscard]] std::string printed() const { return syntax::print(*syntax, sources); }
};

/// `lines` inside an atom type with data x, y and places A, B.
inline std::string in_atom(const std::string& lines) {
  return "package p\natom type N()\ndata int x, y\nplace A, B\ninitial to A\n" + lines + "\nend\nend\n";
}

}  // namespace bip::test
