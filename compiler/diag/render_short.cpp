// One line per diagnostic: `file:line:column: error[B1001]: message`, the form that editors and scripts parse.
#include "compiler/diag/render.hpp"

namespace bip::diag {

void render_short(std::string& out, const Diagnostic& d, const SourceMap& sources, const Palette& colors) {
  if (d.range.is_valid()) {
    const Loc at = sources.loc(d.range);
    out += fmt::format("{}:{}:{}: ", printable(sources.name(d.range.file)), at.line, at.column);
  }
  out += fmt::format("{}{}[{}]{}: {}\n", colors.of(d.severity), severity_name(d.severity), info(d.kind).code,
                     colors.reset, printable(d.message));
}

}  // namespace bip::diag
