// Moves nodes of a syntax tree to another place of another text, for a piece of a file that did not change while text
// before it did.
//
// `move` corrects the ranges and the views that a node holds itself; the arrays and nodes to which it points are moved
// on their own (compiler/parse/tree_arena.hpp knows all of them). So no node is moved twice, however many share it.
#pragma once
#include <cstdint>
#include <string_view>

#include "compiler/syntax/syntax.hpp"

namespace bip::syntax {

struct NodeMove {
  std::uintptr_t from = 0;  // where the piece's text was, as an address: the text may be freed
  std::size_t size = 0;     // of the piece
  const char* to = nullptr;
  std::uint32_t shift = 0;  // of offsets, modulo 2^32
  FileId file;              // of the new text
};

inline void move(SourceRange& range, const NodeMove& by) {
  if (!range.is_valid()) return;
  range = {by.file, range.begin + by.shift, range.end + by.shift};
}
/// Texts that are not the source's (unescaped strings) stay where they are.
inline void move(std::string_view& text, const NodeMove& by) {
  const std::uintptr_t at = reinterpret_cast<std::uintptr_t>(text.data()) - by.from;
  if (!text.empty() && at < by.size) text = {by.to + at, text.size()};
}

inline void move(Name& n, const NodeMove& by) {
  move(n.text, by);
  move(n.range, by);
}
inline void move(PathPart& p, const NodeMove& by) { move(p.name, by); }
inline void move(Path& p, const NodeMove& by) { move(p.range, by); }
inline void move(Expr& e, const NodeMove& by) {
  move(e.range, by);
  move(e.text, by);
  move(e.path, by);
  move(e.op_range, by);
}
inline void move(Stmt& s, const NodeMove& by) {
  move(s.range, by);
  move(s.target, by);
}
inline void move(Block& b, const NodeMove& by) { move(b.range, by); }
inline void move(AnnotationArg& a, const NodeMove& by) {
  move(a.key, by);
  move(a.value, by);
}
inline void move(Annotation& a, const NodeMove& by) {
  move(a.name, by);
  move(a.range, by);
}
inline void move(TypeRef& t, const NodeMove& by) { move(t.name, by); }
inline void move(Param& p, const NodeMove& by) {
  move(p.type, by);
  move(p.name, by);
}
inline void move(Var& v, const NodeMove& by) { move(v.name, by); }
inline void move(DataDecl& d, const NodeMove& by) {
  move(d.type, by);
  move(d.range, by);
}
inline void move(PortExpr& e, const NodeMove& by) {
  move(e.port, by);
  move(e.range, by);
}
inline void move(Clause& c, const NodeMove& by) {
  move(c.up, by);
  move(c.down, by);
  move(c.action, by);
  move(c.range, by);
}
inline void move(ConnectorExport& e, const NodeMove& by) {
  move(e.type, by);
  move(e.name, by);
  move(e.range, by);
}
inline void move(ConnectorBody& b, const NodeMove& by) {
  move(b.exported, by);
  move(b.resume, by);
}
inline void move(PortItem& p, const NodeMove& by) { move(p.name, by); }
inline void move(PortDecl& p, const NodeMove& by) {
  move(p.type, by);
  move(p.merged_as, by);
  move(p.extern_class, by);
  move(p.extern_policy, by);
  move(p.range, by);
}
inline void move(ClockDecl& c, const NodeMove& by) {
  move(c.unit, by);
  move(c.range, by);
}
inline void move(Transition& t, const NodeMove& by) {
  move(t.port, by);
  move(t.urgency, by);
  move(t.action, by);
  move(t.range, by);
}
inline void move(Initial& i, const NodeMove& by) {
  move(i.action, by);
  move(i.range, by);
}
inline void move(AtomPriority& p, const NodeMove& by) {
  move(p.name, by);
  move(p.low, by);
  move(p.high, by);
  move(p.range, by);
}
inline void move(FinalPlaces& f, const NodeMove& by) { move(f.range, by); }
inline void move(Invariant& i, const NodeMove& by) {
  move(i.name, by);
  move(i.range, by);
}
inline void move(NamedArg& a, const NodeMove& by) { move(a.name, by); }
inline void move(CompoundItem& i, const NodeMove& by) {
  move(i.range, by);
  move(i.name, by);
  move(i.type, by);
  move(i.property, by);
}
inline void move(InteractionPattern& p, const NodeMove& by) {
  move(p.connector, by);
  move(p.range, by);
}
inline void move(CompoundPriority& p, const NodeMove& by) {
  move(p.name, by);
  move(p.low, by);
  move(p.high, by);
  move(p.range, by);
}
inline void move(CompoundExport& e, const NodeMove& by) {
  move(e.name, by);
  move(e.range, by);
}
inline void move(Decl& d, const NodeMove& by) {
  move(d.range, by);
  move(d.name, by);
  move(d.cpp_name, by);
  move(d.result, by);
  move(d.op, by);
  move(d.initial, by);
}
inline void move(Package& p, const NodeMove& by) {
  move(p.name, by);
  move(p.range, by);
}
inline void move(Comment& c, const NodeMove& by) { move(c.range, by); }

}  // namespace bip::syntax
