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

// The text of an outline, written from its front to its back.
class OutlineWriter {
 public:
  OutlineWriter(const Workspace& w, const Document& d)
      : document_(d), index_(d.analysis.index), encoding_(w.encoding) {}

  std::string run() {
    out_ = '[';
    // Everything else of the file is in its package.
    std::size_t open = 0;
    for (const SymbolId id : index_.file_symbols) {
      const Symbol& s = index_.symbols[id];
      if (s.name_range.file != document_.analysis.file) continue;
      separate();
      if (s.kind != SymbolKind::Package) {
        write(s);
        continue;
      }
      write_head(s);
      out_ += R"(,"children":[)";
      ++open;
    }
    for (; open != 0; --open) out_ += "]}";
    out_ += ']';
    return std::move(out_);
  }

 private:
  void separate() {
    if (out_.back() != '[') out_ += ',';
  }
  void write(const Symbol& s) {
    write_head(s);
    // A port's members are its variables, which are the atom's own.
    if (s.kind != SymbolKind::Port && s.kind != SymbolKind::ExportedPort) {
      const std::size_t before = out_.size();
      out_ += R"(,"children":[)";
      const std::size_t begin = out_.size();
      for (const SymbolId m : s.members) {
        if (outline_kind(index_.symbols[m].kind) == 0) continue;
        separate();
        write(index_.symbols[m]);
      }
      if (out_.size() == begin) out_.resize(before);
      else out_ += ']';
    }
    out_ += '}';
  }
  void write_head(const Symbol& s) {
    out_ += R"({"name":)";
    write_text(s.name);
    out_ += R"(,"kind":)";
    out_ += std::to_string(outline_kind(s.kind));
    out_ += R"(,"detail":)";
    write_text(s.type_text);
    out_ += R"(,"range":)";
    write_range(s.range);
    out_ += R"(,"selectionRange":)";
    write_range(s.name_range);
  }
  // Names and types as written need no escapes but in few cases.
  void write_text(std::string_view text) {
    const bool is_plain =
        std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c < 127 && c != '"' && c != '\\'; });
    if (is_plain) ((out_ += '"') += text) += '"';
    else out_ += Json(std::string(text)).dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  void write_range(SourceRange r) {
    out_ += R"({"start":)";
    write_position(r.begin);
    out_ += R"(,"end":)";
    write_position(r.end);
    out_ += '}';
  }
  void write_position(std::uint32_t offset) {
    const Position at = document_.text.position(offset, encoding_);
    out_ += R"({"line":)";
    out_ += std::to_string(at.line);
    out_ += R"(,"character":)";
    out_ += std::to_string(at.character);
    out_ += '}';
  }

  const Document& document_;
  const Index& index_;
  Encoding encoding_;
  std::string out_;
};

}  // namespace

Reply document_symbols(Workspace& w, const Document& d) { return JsonText{OutlineWriter(w, d).run()}; }

Json semantic_legend() {
  return {{"tokenTypes", kTokenTypes}, {"tokenModifiers", {"declaration", "readonly", "modification"}}};
}

Reply semantic_tokens(Workspace& w, const Document& d, std::uint32_t from, std::uint32_t to) {
  std::string data = R"({"data":[)";
  Position last;
  const auto put = [&data](std::uint32_t number) {
    if (data.back() != '[') data += ',';
    data += std::to_string(number);
  };
  for (const index::Use& u : d.analysis.index.uses) {
    if (u.range.file != d.analysis.file || u.range.end <= from || u.range.begin >= to) continue;
    const Position begin = d.text.position(u.range.begin, w.encoding);
    const Position end = d.text.position(u.range.end, w.encoding);
    if (begin.line != end.line || begin.character >= end.character) continue;
    const SymbolKind kind = d.analysis.index.symbols[u.symbol].kind;
    std::uint32_t modifiers = u.kind == UseKind::Declaration ? kDeclaration : 0u;
    if (u.kind == UseKind::Write) modifiers = kModification;
    if (kind == SymbolKind::Constant) modifiers |= kReadonly;
    put(begin.line - last.line);
    put(begin.line == last.line ? begin.character - last.character : begin.character);
    put(end.character - begin.character);
    put(token_type(kind));
    put(modifiers);
    last = begin;
  }
  return JsonText{data + "]}"};
}

}  // namespace bip::lsp
