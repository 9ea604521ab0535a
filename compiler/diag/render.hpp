// What the three renderers share. Inside compiler/diag only; everyone else calls `render` of diagnostics.hpp.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "compiler/diag/diagnostics.hpp"

namespace bip::diag {

[[nodiscard]] const char* severity_name(Severity severity);  // "error", "warning"

/// ANSI escapes, empty strings when colour is off.
struct Palette {
  std::string_view error, warning, note, gutter, bold, reset;
  [[nodiscard]] std::string_view of(Severity severity) const { return severity == Severity::Error ? error : warning; }
};
[[nodiscard]] Palette palette(Color color);

/// `text` on one line: control characters (which could drive the reader's terminal) are shown as U+FFFD.
[[nodiscard]] std::string printable(std::string_view text);

/// `json`, which must be UTF-8, with each control character of block C1 and of direction as `\uXXXX`: it says the same
/// to a program, and nothing else to a terminal.
[[nodiscard]] std::string with_hidden_escaped(std::string_view json);

void render_frame(std::string& out, const Diagnostic& d, const SourceMap& sources, const Palette& colors);
/// One place with its line, as in the frame of an error. Columns count bytes, from 1.
[[nodiscard]] std::string excerpt(const SourceMap& sources, Loc at, const Palette& colors);
void render_short(std::string& out, const Diagnostic& d, const SourceMap& sources, const Palette& colors);
void render_json(std::string& out, const Diagnostic& d, const SourceMap& sources);
/// All of them: SARIF is one document.
[[nodiscard]] std::string render_sarif(const std::vector<const Diagnostic*>& diags, const SourceMap& sources);

}  // namespace bip::diag
