// The tree as text, for goldens and `--emit=syntax`: one node per line, `Kind @line:column-line:column details`. Small
// nodes (expressions, paths, lists of names) are printed on the line of their parent, fully parenthesised.
#include "compiler/syntax/dump_syntax.hpp"

#include <algorithm>

#include "compiler/syntax/print.hpp"

namespace bip::syntax {

std::string dump(const Syntax& syntax, const SourceMap& sources) {
  std::string out;
  if (syntax.package != nullptr) Dumper(sources, out).package(*syntax.package);
  return out;
}

void Dumper::line(std::string_view kind, SourceRange r, std::string_view details) {
  const Loc from = sources_.loc(r.file, r.begin);
  const Loc to = sources_.loc(r.file, r.end);
  out_.append(static_cast<std::size_t>(indent_) * 2, ' ').append(kind);
  out_ += fmt::format(" @{}:{}-{}:{}", from.line, from.column, to.line, to.column);
  if (!details.empty()) out_.append(" ").append(details);
  out_ += '\n';
}

void Dumper::package(const Package& p) {
  std::string details = p.name.parts.empty() ? std::string("(none)") : text(p.name);
  for (const Path& use : p.uses) details += " use " + text(use);
  line("Package", p.range, details);
  ++indent_;
  annotations(p.annotations);
  for (const Decl* d : p.decls) decl(*d);
  --indent_;
}

void Dumper::annotations(Annotations list) {
  for (const Annotation& a : list) {
    std::string details(a.name.text);
    for (const AnnotationArg& arg : a.args) details.append(" ").append(arg.key.text).append("=").append(arg.value);
    line("Annotation", a.range, details);
  }
}

void Dumper::data(const DataDecl& d) {
  std::string details = (d.exported ? "export " : "") + text(d.type);
  for (const Var& v : d.vars) {
    details.append(" ").append(v.name.text);
    if (v.init != nullptr) details += "=" + text(v.init);
  }
  line("Data", d.range, details);
  ++indent_;
  annotations(d.annotations);
  --indent_;
}

void Dumper::block(std::string_view word, const Block& b) {
  if (!b.present) return;
  line(word, b.range, "");
  ++indent_;
  for (const Stmt* s : b.stmts) stmt(*s);
  --indent_;
}

void Dumper::stmt(const Stmt& s) {
  const std::string target =
      parts_of(s) == StmtParts::Target ? text(s.target) + (s.clock_speed ? "'" : "") + " = " : "";
  line(info_of(s.kind).node, s.range, target + text(s.value));
  if (parts_of(s) == StmtParts::Bodies) bodies(s);
}

void Dumper::bodies(const Stmt& s) {
  ++indent_;
  for (const Stmt* inner : s.then_body) stmt(*inner);
  if (!s.else_body.empty()) {
    line("Else", s.else_body.front()->range, "");
    ++indent_;
    for (const Stmt* inner : s.else_body) stmt(*inner);
    --indent_;
  }
  --indent_;
}

std::string_view Dumper::kind_name(DeclKind kind) {
  switch (kind) {
    case DeclKind::ConstData: return "ConstData";
    case DeclKind::ExternType: return "ExternType";
    case DeclKind::ExternFunction: return "ExternFunction";
    case DeclKind::ExternOperator: return "ExternOperator";
    case DeclKind::Function: return "Function";
    case DeclKind::PortType: return "PortType";
    case DeclKind::ConnectorType: return "ConnectorType";
    case DeclKind::AtomType: return "AtomType";
    case DeclKind::CompoundType: return "CompoundType";
  }
  return "Decl";
}

void Dumper::decl(const Decl& d) {
  std::string details(d.name.text);
  details += "(";
  for (std::size_t i = 0; i < d.params.size(); ++i) {
    details += (i > 0 ? ", " : "") + text(d.params[i].type);
    if (!d.params[i].name.text.empty()) details.append(" ").append(d.params[i].name.text);
  }
  details += ")";
  if (d.notation == Notation::Paper) details += " paper";
  if (d.result.is_written()) details += " -> " + text(d.result);
  for (const Path& r : d.refines) details += " refine " + text(r);
  if (d.body != nullptr) details += " = " + text(d.body);
  if (!d.cpp_name.empty()) details.append(" as ").append(d.cpp_name);
  line(kind_name(d.kind), d.range, details);
  ++indent_;
  annotations(d.annotations);
  for (const DataDecl& x : d.data) data(x);
  if (d.connector != nullptr) connector(*d.connector);
  atom(d);
  for (const CompoundItem* i : d.items) item(*i);
  for (const CompoundPriority& p : d.priorities) {
    line("Priority", p.range, std::string(p.name.text) + " " + text(p.low) + " < " + text(p.high) + guard(p.guard));
  }
  for (const CompoundExport& e : d.exports) {
    std::string what = e.is_data ? "data" : "port";
    for (const Path& t : e.targets) what += " " + text(t);
    line("Export", e.range, what + " as " + std::string(e.name.text));
  }
  --indent_;
}

void Dumper::connector(const ConnectorBody& c) {
  for (const DataDecl& d : c.data) data(d);
  if (c.exported.present) {
    std::string details = text(c.exported.type) + " " + std::string(c.exported.name.text);
    line("ExportPort", c.exported.range, details + names(c.exported.vars));
  }
  if (c.define != nullptr) {
    line("Define", c.define->range,
         text(*c.define) + (c.resume.text.empty() ? "" : " resume " + std::string(c.resume.text)));
  }
  for (const Clause& clause : c.clauses) {
    std::string ports;
    for (const Path& p : clause.ports) ports += (ports.empty() ? "" : " ") + text(p);
    line("Clause", clause.range, ports + guard(clause.guard));
    ++indent_;
    annotations(clause.annotations);
    block("Up", clause.up);
    block("Down", clause.down);
    block("Do", clause.action);
    --indent_;
  }
}

void Dumper::atom(const Decl& d) {
  for (const PortDecl& p : d.ports) {
    std::string details = p.role == PortRole::Exported ? "export " : p.role == PortRole::External ? "extern " : "";
    details += text(p.type);
    for (const PortItem& i : p.items) details.append(" ").append(i.name.text).append(names(i.vars));
    if (!p.merged_as.text.empty()) details.append(" as ").append(p.merged_as.text);
    if (!p.extern_class.empty()) details.append(" as ").append(p.extern_class);
    if (!p.extern_policy.text.empty()) details.append(" ").append(p.extern_policy.text);
    line("Port", p.range, details);
  }
  for (const ClockDecl& c : d.clocks) line("Clock", c.range, names(c.names) + " " + std::string(c.unit.text));
  for (const Name& p : d.places) line("Place", p.range, p.text);
  if (d.initial.present) {
    line("Initial", d.initial.range,
         names(d.initial.to) + (d.initial.resumes ? " resume" + guard(d.initial.resume) : ""));
    ++indent_;
    block("Do", d.initial.action);
    --indent_;
  }
  for (const FinalPlaces& f : d.finals) line("Final", f.range, names(f.places));
  for (const Transition& t : d.transitions) {
    std::string details = t.internal ? "internal" : std::string(t.port.text);
    details += " " + names(t.from) + " -> " + names(t.to) + guard(t.guard);
    if (!t.urgency.text.empty()) details.append(" ").append(t.urgency.text);
    if (t.resumes) details += " resume" + guard(t.resume);
    line("Transition", t.range, details);
    ++indent_;
    annotations(t.annotations);
    block("Do", t.action);
    --indent_;
  }
  for (const AtomPriority& p : d.atom_priorities) {
    line("Priority", p.range, fmt::format("{} {} < {}{}", p.name.text, p.low.text, p.high.text, guard(p.guard)));
  }
  for (const Invariant& i : d.invariants) {
    const char* scope = i.scope == InvariantScope::At ? " at " : i.scope == InvariantScope::From ? " from " : " always";
    line("Invariant", i.range, std::string(i.name.text) + scope + names(i.places) + guard(i.expr));
  }
}

void Dumper::item(const CompoundItem& i) {
  std::string details = i.type.is_written() ? text(i.type) + " " : "";
  details += i.name.text;
  if (i.index != nullptr) details += "[" + text(i.index) + "]";
  switch (i.kind) {
    case ItemKind::Component:
      details += "(";
      for (const NamedArg& a : i.args) {
        if (details.back() != '(') details += ", ";
        if (!a.name.text.empty()) details.append(a.name.text).append(" = ");
        details += text(a.value);
      }
      return line("Component", i.range, details + ")");
    case ItemKind::Connector:
      for (const Path& p : i.ports) details += " " + text(p);
      line(i.inline_body != nullptr ? "InlineConnector" : "Connector", i.range, details);
      ++indent_;
      if (i.inline_body != nullptr) connector(*i.inline_body);
      --indent_;
      return;
    case ItemKind::Priority:
      return line("Priority", i.range,
                  details + " " + text(i.priority->low) + " < " + text(i.priority->high) + guard(i.priority->guard));
    case ItemKind::Property: return line("Property", i.range, details + " {" + std::string(i.property.text) + "}");
    case ItemKind::For:
      line("For", i.range, details + " in " + text(i.low) + ".." + text(i.high));
      ++indent_;
      for (const CompoundItem* inner : i.items) item(*inner);
      --indent_;
  }
}

}  // namespace bip::syntax
