// See validate_syntax.hpp. One function per kind of node; each gets the range that it must lie in.
#include "compiler/syntax/validate_syntax.hpp"

#include <fmt/format.h>

#include "compiler/syntax/code_paths.hpp"

namespace bip::syntax {
namespace {

class SyntaxValidator {
 public:
  SyntaxValidator(const Syntax& syntax, const SourceMap& sources) : syntax_(syntax), sources_(sources) {}

  std::vector<std::string> run() {
    const auto size = static_cast<std::uint32_t>(sources_.text(syntax_.file).size());
    const SourceRange whole{.file = syntax_.file, .begin = 0, .end = size};
    std::uint32_t last = 0;
    for (const Comment& comment : syntax_.comments) {
      inside(comment.range, whole, "a comment");
      expect(comment.range.begin >= last, "comments are in order", comment.range);
      last = comment.range.end;
    }
    expect(syntax_.arena != nullptr, "a file has an arena", whole);
    if (syntax_.package != nullptr) package(*syntax_.package, whole);
    return std::move(broken_);
  }

 private:
  void expect(bool holds, const char* promise, SourceRange at) {
    if (holds || broken_.size() >= kMaxBroken) return;
    broken_.push_back(fmt::format("syntax: {} ({}..{})", promise, at.begin, at.end));
  }
  bool inside(SourceRange range, SourceRange around, const char* what) {
    const bool is_nested =
        range.file == around.file && around.begin <= range.begin && range.begin <= range.end && range.end <= around.end;
    if (!is_nested && broken_.size() < kMaxBroken) {
      broken_.push_back(fmt::format("syntax: {} ({}..{}) leaves what is around it ({}..{})", what, range.begin,
                                    range.end, around.begin, around.end));
    }
    return is_nested;
  }

  // A name that is not written has no text.
  void name(const Name& n, SourceRange around) {
    if (n.text.empty()) return;
    if (inside(n.range, around, "a name")) expect(sources_.text(n.range) == n.text, "a name is its text", n.range);
  }
  void names(std::span<const Name> list, SourceRange around) {
    for (const Name& n : list) name(n, around);
  }
  void path(const Path& p, SourceRange around) {
    if (p.parts.empty() || !inside(p.range, around, "a path")) return;
    for (const PathPart& part : p.parts) {
      expect(!part.star || part.index == nullptr, "a path's part has `*` or an index", p.range);
      optional(part.index, p.range);
    }
  }
  void paths(std::span<const Path> list, SourceRange around) {
    for (const Path& p : list) path(p, around);
  }
  void optional(const Expr* e, SourceRange around) {
    if (e != nullptr) expr(e, around);
  }
  void expr(const Expr* e, SourceRange around) {
    if (e == nullptr) return expect(false, "an expression is there", around);
    if (!inside(e->range, around, "an expression")) return;
    switch (e->kind) {
      case ExprKind::Int:
      case ExprKind::Float:
      case ExprKind::Report: expect(!e->text.empty(), "a literal has a text", e->range); break;
      case ExprKind::Bool:
      case ExprKind::String: break;
      case ExprKind::Path:
      case ExprKind::Call:
        expect(!e->path.parts.empty(), "a name has a part", e->range);
        path(e->path, e->range);
        break;
      case ExprKind::Unary: expect(e->operands.size() == 1, "a prefix operator has one operand", e->range); break;
      case ExprKind::Binary: expect(e->operands.size() == 2, "an infix operator has two operands", e->range); break;
    }
    for (const Expr* operand : e->operands) expr(operand, e->range);
  }
  void statements(std::span<const Stmt* const> list, SourceRange around) {
    for (const Stmt* s : list) statement(s, around);
  }
  void statement(const Stmt* s, SourceRange around) {
    if (s == nullptr) return expect(false, "a statement is there", around);
    if (!inside(s->range, around, "a statement")) return;
    expr(s->value, s->range);
    path(s->target, s->range);
    expect((assigned_path(*s) != nullptr) != s->target.parts.empty(), "an assignment alone has a target", s->range);
    const bool is_leaf = s->then_body.empty() && s->else_body.empty();
    expect(parts_of(*s) == StmtParts::Bodies || is_leaf, "only `if` has bodies", s->range);
    statements(s->then_body, s->range);
    statements(s->else_body, s->range);
  }
  void block(const Block& b, SourceRange around) {
    if (b.present && inside(b.range, around, "a block")) return statements(b.stmts, b.range);
    expect(b.present || b.stmts.empty(), "statements stand in a block", around);
  }
  void data(std::span<const DataDecl> list, SourceRange around) {
    for (const DataDecl& d : list) {
      if (!inside(d.range, around, "a data declaration")) continue;
      path(d.type.name, d.range);
      for (const Var& v : d.vars) {
        name(v.name, d.range);
        optional(v.init, d.range);
      }
    }
  }
  void define(const PortExpr* e, SourceRange around) {
    if (e == nullptr) return expect(false, "a port expression is there", around);
    if (!inside(e->range, around, "a port expression")) return;
    const bool is_port = e->kind == PortExprKind::Port;
    expect(is_port != e->port.parts.empty(), "a port alone has a path", e->range);
    expect(!is_port || e->children.empty(), "a port has no parts", e->range);
    path(e->port, e->range);
    for (const PortExpr* child : e->children) define(child, e->range);
  }
  void connector(const ConnectorBody& body, SourceRange around) {
    data(body.data, around);
    if (body.exported.present) {
      path(body.exported.type.name, around);
      name(body.exported.name, around);
      names(body.exported.vars, around);
    }
    if (body.define != nullptr) define(body.define, around);
    for (const Clause& c : body.clauses) {
      if (!inside(c.range, around, "a clause")) continue;
      paths(c.ports, c.range);
      optional(c.guard, c.range);
      block(c.up, c.range);
      block(c.down, c.range);
      block(c.action, c.range);
    }
  }
  void atom(const Decl& d) {
    for (const PortDecl& p : d.ports) {
      if (!inside(p.range, d.range, "a port")) continue;
      path(p.type.name, p.range);
      for (const PortItem& item : p.items) {
        name(item.name, p.range);
        names(item.vars, p.range);
      }
      name(p.merged_as, p.range);
    }
    for (const ClockDecl& c : d.clocks) {
      if (inside(c.range, d.range, "a clock")) names(c.names, c.range);
    }
    names(d.places, d.range);
    if (d.initial.present && inside(d.initial.range, d.range, "`initial`")) {
      names(d.initial.to, d.initial.range);
      block(d.initial.action, d.initial.range);
      optional(d.initial.resume, d.initial.range);
    }
    for (const FinalPlaces& f : d.finals) {
      if (inside(f.range, d.range, "`final`")) names(f.places, f.range);
    }
    for (const Transition& t : d.transitions) {
      if (!inside(t.range, d.range, "a transition")) continue;
      expect(t.internal == t.port.text.empty(), "a transition has a port or is internal", t.range);
      name(t.port, t.range);
      names(t.to, t.range);
      optional(t.guard, t.range);
      block(t.action, t.range);
      optional(t.resume, t.range);
    }
    for (const AtomPriority& p : d.atom_priorities) {
      if (!inside(p.range, d.range, "a priority")) continue;
      name(p.low, p.range);
      name(p.high, p.range);
      optional(p.guard, p.range);
    }
    for (const Invariant& i : d.invariants) {
      if (!inside(i.range, d.range, "an invariant")) continue;
      names(i.places, i.range);
      expr(i.expr, i.range);
    }
  }
  void pattern(const InteractionPattern& p, SourceRange around) {
    if (!inside(p.range, around, "a pattern")) return;
    path(p.connector, p.range);
    paths(p.ports, p.range);
  }
  void priority(const CompoundPriority& p, SourceRange around) {
    if (!inside(p.range, around, "a priority")) return;
    optional(p.index, p.range);
    pattern(p.low, p.range);
    pattern(p.high, p.range);
    optional(p.guard, p.range);
  }
  void items(std::span<const CompoundItem* const> list, SourceRange around) {
    for (const CompoundItem* item : list) {
      if (item == nullptr) expect(false, "an item is there", around);
      else if (inside(item->range, around, "an item")) this->item(*item);
    }
  }
  // The type of `C t a(…), b(…)` is written once, before the range of each item.
  void item(const CompoundItem& i) {
    optional(i.index, i.range);
    for (const NamedArg& arg : i.args) expr(arg.value, i.range);
    paths(i.ports, i.range);
    if (i.inline_body != nullptr) connector(*i.inline_body, i.range);
    switch (i.kind) {
      case ItemKind::For:
        expr(i.low, i.range);
        expr(i.high, i.range);
        items(i.items, i.range);
        break;
      case ItemKind::Priority:
        expect(i.priority != nullptr, "a priority item has a priority", i.range);
        if (i.priority != nullptr) priority(*i.priority, i.range);
        break;
      case ItemKind::Property: name(i.property, i.range); break;
      case ItemKind::Component:
      case ItemKind::Connector: expect(i.items.empty(), "only `for` has items", i.range); break;
    }
  }
  void declaration(const Decl& d) {
    name(d.name, d.range);
    for (const Param& p : d.params) {
      path(p.type.name, d.range);
      name(p.name, d.range);
    }
    data(d.data, d.range);
    paths(d.refines, d.range);
    path(d.result.name, d.range);
    expect((d.kind == DeclKind::ConnectorType) == (d.connector != nullptr), "a connector type alone has a body",
           d.range);
    if (d.connector != nullptr) connector(*d.connector, d.range);
    expect((d.kind == DeclKind::Function) == (d.body != nullptr), "a function alone has an expression", d.range);
    if (d.body != nullptr) expr(d.body, d.range);
    atom(d);
    items(d.items, d.range);
    for (const CompoundPriority& p : d.priorities) priority(p, d.range);
    for (const CompoundExport& e : d.exports) {
      if (!inside(e.range, d.range, "an export")) continue;
      expect(!e.targets.empty(), "an export has a target", e.range);
      paths(e.targets, e.range);
      name(e.name, e.range);
    }
  }
  void package(const Package& p, SourceRange whole) {
    if (!inside(p.range, whole, "a package")) return;
    path(p.name, p.range);
    paths(p.uses, whole);
    for (const Decl* d : p.decls) {
      if (d == nullptr) expect(false, "a declaration is there", p.range);
      else if (inside(d->range, whole, "a declaration")) declaration(*d);
    }
  }

  const Syntax& syntax_;
  const SourceMap& sources_;
  std::vector<std::string> broken_;
};

}  // namespace

std::vector<std::string> validate(const Syntax& syntax, const SourceMap& sources) {
  return SyntaxValidator(syntax, sources).run();
}

}  // namespace bip::syntax
