// Prints files, packages and their declarations.
#include "compiler/base/quote.hpp"
#include "compiler/syntax/printer.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::syntax {
namespace {

bool has_block(const Decl& d) {
  return d.kind == DeclKind::ConnectorType || d.kind == DeclKind::AtomType || d.kind == DeclKind::CompoundType;
}

}  // namespace

void SyntaxPrinter::package(const Package& p) {
  const bool named = !p.name.parts.empty();
  if (named) {
    annotations(p.annotations, p.name.range.begin);
    lead_in(p.name.range.begin, p.name.range.begin);
    begin_line();
    put("package " + text(p.name));
    header_line(p.name.range.end);
  }
  for (const Path& use : p.uses) {
    lead_in(use.range.begin, use.range.end);
    begin_line();
    put("use " + text(use));
    end_line(use.range.end);
  }
  bool after_block = !p.uses.empty();
  for (const Decl* d : p.decls) {
    const bool apart = after_block || has_block(*d);
    if (apart && !first_in_block_ && out_.substr(out_.size() >= 2 ? out_.size() - 2 : 0) != "\n\n") out_ += '\n';
    decl(*d);
    after_block = has_block(*d);
  }
  if (!named) return;
  // The package's `end` is the last token of the file; comments after it stay after it.
  std::uint32_t end = static_cast<std::uint32_t>(source_.size());
  for (std::size_t i = syntax_.comments.size(); i-- > next_comment_;) {
    const std::string_view gap = source_.substr(syntax_.comments[i].range.end, end - syntax_.comments[i].range.end);
    if (gap.find_first_not_of(" \t\r\n\f") != std::string_view::npos) break;
    end = syntax_.comments[i].range.begin;
  }
  while (end > 0 &&
         (source_[end - 1] == ' ' || source_[end - 1] == '\n' || source_[end - 1] == '\t' || source_[end - 1] == '\r'))
    --end;
  end_block(end);
}

void SyntaxPrinter::data(const DataDecl& d) {
  annotations(d.annotations, d.range.begin);
  lead_in(d.range.begin, d.range.end);
  begin_line();
  put((d.exported ? "export data " : "data ") + text(d.type) + " " + text(d.vars));
  end_line(d.range.end);
}

void SyntaxPrinter::one_line_decl(const Decl& d) {
  const std::string params = "(" + text(d.params) + ")";
  switch (d.kind) {
    case DeclKind::ConstData: put("const data " + text(d.data[0].type.name) + " " + text(d.data[0].vars)); break;
    case DeclKind::ExternType: {
      put("extern data type ");
      put(d.name.text);
      if (!d.refines.empty()) put(" refine " + text(d.refines));
      if (!d.cpp_name.empty()) put(" as " + quoted(d.cpp_name));
      break;
    }
    case DeclKind::ExternFunction:
      put("extern function ");
      if (d.result.is_written()) put(text(d.result) + " ");
      put(d.name.text);
      put(params);
      break;
    case DeclKind::Function:
      put("function " + text(d.result) + " ");
      put(d.name.text);
      put(params + " = " + text(d.body, Parentheses::Dropped));
      break;
    case DeclKind::ExternOperator:
      put("extern operator " + text(d.result) + " ");
      put(d.op.text);
      put(params);
      break;
    case DeclKind::PortType:
      put("port type ");
      put(d.name.text);
      put(params);
      break;
    case DeclKind::ConnectorType:
    case DeclKind::AtomType:
    case DeclKind::CompoundType: BIP_UNREACHABLE("a declaration with a block");
  }
  end_line(d.range.end);
}

void SyntaxPrinter::decl(const Decl& d) {
  notation_ = d.notation;
  annotations(d.annotations, d.name.range.begin);
  lead_in(d.annotations.empty() ? d.range.begin : d.name.range.begin, has_block(d) ? d.name.range.begin : d.range.end);
  begin_line();
  if (!has_block(d)) return one_line_decl(d);
  const bool paper = d.notation == Notation::Paper;
  switch (d.kind) {
    case DeclKind::ConnectorType: put("connector type "); break;
    case DeclKind::AtomType: put(paper ? "component " : "atom type "); break;
    case DeclKind::CompoundType: put(paper ? "component " : "compound type "); break;
    case DeclKind::ConstData:
    case DeclKind::ExternType:
    case DeclKind::ExternFunction:
    case DeclKind::ExternOperator:
    case DeclKind::Function:
    case DeclKind::PortType: BIP_UNREACHABLE("a declaration without a block");
  }
  put(d.name.text);
  if (!paper || !d.params.empty()) put("(" + text(d.params) + ")");
  header_line(d.params.empty() ? d.name.range.end : d.params.back().name.range.end);
  if (d.kind == DeclKind::ConnectorType) connector_parts(*d.connector);
  if (d.kind == DeclKind::AtomType) atom(d);
  if (d.kind == DeclKind::CompoundType) compound(d);
  end_block(d.range.end);
  notation_ = Notation::Bip2;
}

void SyntaxPrinter::clause(const Clause& c) {
  annotations(c.annotations, c.range.begin);
  std::uint32_t limit = c.range.end;
  for (const Block* b : {&c.up, &c.down, &c.action}) {
    if (b->present) limit = std::min(limit, b->range.begin);
  }
  lead_in(c.range.begin, limit);
  begin_line();
  put("on " + text(c.ports, notation_ == Notation::Paper ? ", " : " "));
  if (c.guard != nullptr) put(guard(c.guard));
  block("up", c.up);
  block("down", c.down);
  block("do", c.action);
  end_line(c.range.end);
}

void SyntaxPrinter::connector_parts(const ConnectorBody& body) {
  std::vector<Piece> pieces;
  for (const DataDecl& d : body.data) pieces.push_back({d.range.begin, [this, &d] { data(d); }});
  if (body.exported.present) {
    pieces.push_back({body.exported.range.begin, [this, &body] {
                        const ConnectorExport& e = body.exported;
                        annotations(e.annotations, e.range.begin);
                        lead_in(e.range.begin, e.range.end);
                        begin_line();
                        put("export port ");
                        if (e.type.is_written()) put(text(e.type) + " ");
                        put(e.name.text);
                        if (notation_ == Notation::Bip2 || !e.vars.empty()) put("(" + text(e.vars) + ")");
                        end_line(e.range.end);
                      }});
  }
  if (body.define != nullptr) {
    pieces.push_back({body.define->range.begin, [this, &body] {
                        lead_in(body.define->range.begin, body.define->range.end);
                        begin_line();
                        put("define " + text(*body.define, Level::Root));
                        std::uint32_t end = body.define->range.end;
                        if (!body.resume.text.empty()) {
                          put(" resume ");
                          put(body.resume.text);
                          end = body.resume.range.end;
                        }
                        end_line(end);
                      }});
  }
  for (const Clause& c : body.clauses) pieces.push_back({c.range.begin, [this, &c] { clause(c); }});
  print_in_order(pieces);
}

}  // namespace bip::syntax
