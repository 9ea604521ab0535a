// Hover: the declaration of a name, its location, its members, and the comment above it.
#include "tools/lsp/features.hpp"

namespace bip::lsp {
namespace {

using index::Index;
using index::Symbol;
using index::SymbolId;
using index::SymbolKind;

constexpr std::size_t kMostMembers = 40;

bool is_type(SymbolKind kind) {
  return kind == SymbolKind::ConnectorType || kind == SymbolKind::AtomType || kind == SymbolKind::CompoundType;
}

/// What one sees of a type from outside: its ports and data, a line each.
std::string interface_of(const Index& index, const SourceMap& sources, const Symbol& type) {
  std::string lines;
  std::size_t count = 0;
  for (const SymbolId m : type.members) {
    const Symbol& s = index.symbols[m];
    if (!s.is_visible || count++ >= kMostMembers) continue;
    lines += "\n  " + detail_of(s, sources);
  }
  if (count > kMostMembers) lines += "\n  // and " + std::to_string(count - kMostMembers) + " more";
  return lines;
}

std::string code_of(const Index& index, const SourceMap& sources, const Symbol& s) {
  std::string code = detail_of(s, sources);
  if (is_type(s.kind)) return code + interface_of(index, sources, s);
  if (!s.type.is_valid()) return code;
  const Symbol& type = index.symbols[s.type];
  if (type.kind == SymbolKind::PortType) return code + "\n" + detail_of(type, sources);
  if (is_type(type.kind) && (s.kind == SymbolKind::Component || s.kind == SymbolKind::Connector))
    code += "\n" + detail_of(type, sources) + interface_of(index, sources, type);
  return code;
}

}  // namespace

Reply hover(Workspace& w, const Document& d, std::uint32_t offset) {
  const Index& index = d.analysis.index;
  const index::Use* at = d.analysis.file.is_valid() ? index.use_at(d.analysis.file, offset) : nullptr;
  if (at == nullptr) return Json(nullptr);
  const Symbol& s = index.symbols[at->symbol];
  const SourceMap& sources = d.analysis.compilation->sources;
  std::string text = "```bip\n" + code_of(index, sources, s) + "\n```\n" + index::name_of(s.kind);
  if (s.parent.is_valid())
    text += std::string(" of ") + index::name_of(index.symbols[s.parent].kind) + " `" +
            std::string(index.symbols[s.parent].name) + "`";
  if (s.name_range.file != d.analysis.file) text += " in `" + sources.name(s.name_range.file) + "`";
  if (!s.doc.empty()) text += "\n\n---\n" + s.doc;
  return Json{{"contents", {{"kind", "markdown"}, {"value", text}}}, {"range", w.range(d.analysis, at->range)}};
}

}  // namespace bip::lsp
