// The outline of a document, and the kind of each name in it.
#include <algorithm>

#include "tools/lsp/features.hpp"

namespace bip::lsp {

using index::Index;
using index::Symbol;
using index::SymbolId;
using index::SymbolKind;
using index::UseKind;

int outline_kind(SymbolKind kind) {
  switch (kind) {
    case SymbolKind::Package: return 4;
    case SymbolKind::AtomType:
    case SymbolKind::CompoundType: return 5;    // class
    case SymbolKind::ConnectorType: return 11;  // interface
    case SymbolKind::PortType:
    case SymbolKind::ExternType: return 23;  // struct
    case SymbolKind::Function: return 12;
    case SymbolKind::Constant: return 14;
    case SymbolKind::Data:
    case SymbolKind::ExportedData:
    case SymbolKind::Clock: return 13;  // variable
    case SymbolKind::Port:
    case SymbolKind::ExportedPort: return 24;  // event
    case SymbolKind::Place: return 22;         // enum member
    case SymbolKind::Component: return 19;     // object
    case SymbolKind::Connector: return 6;      // method
    case SymbolKind::Priority:
    case SymbolKind::Invariant: return 20;  // key
    case SymbolKind::Parameter:
    case SymbolKind::LoopVariable: return 0;
  }
  return 0;
}

namespace {

constexpr const char* kTokenTypes[] = {"namespace", "type",     "class",      "interface", "function", "parameter",
                                       "variable",  "property", "enumMember", "event",     "method"};
enum TokenModifier : std::uint32_t { kDeclaration = 1, kReadonly = 2, kModification = 4 };

std::uint32_t token_type(SymbolKind kind) {
  switch (kind) {
    case SymbolKind::Package: return 0;
    case SymbolKind::ExternType:
    case SymbolKind::PortType: return 1;
    case SymbolKind::AtomType:
    case SymbolKind::CompoundType: return 2;
    case SymbolKind::ConnectorType: return 3;
    case SymbolKind::Function: return 4;
    case SymbolKind::Parameter:
    case SymbolKind::LoopVariable: return 5;
    case SymbolKind::Constant:
    case SymbolKind::Data:
    case SymbolKind::Clock:
    case SymbolKind::ExportedData: return 6;
    case SymbolKind::Component:
    case SymbolKind::Priority:
    case SymbolKind::Invariant: return 7;
    case SymbolKind::Place: return 8;
    case SymbolKind::Port:
    case SymbolKind::ExportedPort: return 9;
    case SymbolKind::Connector: return 10;
  }
  return 6;
}

Json outline(const Workspace& w, const Document& d, const Symbol& s) {
  const Index& index = d.analysis.index;
  Json made{{"name", s.name},
            {"kind", outline_kind(s.kind)},
            {"detail", s.type_text},
            {"range", w.range(d.analysis, s.range)},
            {"selectionRange", w.range(d.analysis, s.name_range)}};
  // A port's members are its variables, which are the atom's own.
  if (s.kind == SymbolKind::Port || s.kind == SymbolKind::ExportedPort || s.members.empty()) return made;
  Json children = Json::array();
  for (const SymbolId m : s.members) {
    if (outline_kind(index.symbols[m].kind) != 0) children.push_back(outline(w, d, index.symbols[m]));
  }
  if (!children.empty()) made["children"] = std::move(children);
  return made;
}

}  // namespace

Reply document_symbols(Workspace& w, const Document& d) {
  Json list = Json::array();
  Json* into = &list;
  for (const SymbolId id : d.analysis.index.file_symbols) {
    const Symbol& s = d.analysis.index.symbols[id];
    if (s.name_range.file != d.analysis.file) continue;
    into->push_back(outline(w, d, s));
    if (s.kind != SymbolKind::Package) continue;
    // Everything else of the file is in its package.
    into->back()["children"] = Json::array();
    into = &into->back()["children"];
  }
  return list;
}

Json semantic_legend() {
  return {{"tokenTypes", kTokenTypes}, {"tokenModifiers", {"declaration", "readonly", "modification"}}};
}

Reply semantic_tokens(Workspace& w, const Document& d, std::uint32_t from, std::uint32_t to) {
  Json data = Json::array();
  Position last;
  for (const index::Use& u : d.analysis.index.uses) {
    if (u.range.file != d.analysis.file || u.range.end <= from || u.range.begin >= to) continue;
    const Position begin = d.text.position(u.range.begin, w.encoding);
    const Position end = d.text.position(u.range.end, w.encoding);
    if (begin.line != end.line || begin.character >= end.character) continue;
    const SymbolKind kind = d.analysis.index.symbols[u.symbol].kind;
    std::uint32_t modifiers = u.kind == UseKind::Declaration ? kDeclaration : 0u;
    if (u.kind == UseKind::Write) modifiers = kModification;
    if (kind == SymbolKind::Constant) modifiers |= kReadonly;
    data.push_back(begin.line - last.line);
    data.push_back(begin.line == last.line ? begin.character - last.character : begin.character);
    data.push_back(end.character - begin.character);
    data.push_back(token_type(kind));
    data.push_back(modifiers);
    last = begin;
  }
  return Json{{"data", std::move(data)}};
}

}  // namespace bip::lsp
