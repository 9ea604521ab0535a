// The state of the dumper, shared by dump_syntax.cpp (nodes) and dump_text.cpp (details on the line of a node).
#pragma once
#include <fmt/format.h>

#include <string>

#include "compiler/syntax/syntax.hpp"

namespace bip::syntax {

class Dumper {
 public:
  Dumper(const SourceMap& sources, std::string& out) : sources_(sources), out_(out) {}
  void package(const Package& p);

 private:
  void line(std::string_view kind, SourceRange r, std::string_view details);
  void annotations(Annotations list);
  void data(const DataDecl& d);
  void block(std::string_view word, const Block& b);
  void stmt(const Stmt& s);
  void bodies(const Stmt& s);
  void decl(const Decl& d);
  void connector(const ConnectorBody& c);
  void atom(const Decl& d);
  void item(const CompoundItem& i);
  [[nodiscard]] static std::string_view kind_name(DeclKind kind);

  // dump_text.cpp
  [[nodiscard]] static std::string text(const Expr* e);
  [[nodiscard]] static std::string text(const Path& p);
  [[nodiscard]] static std::string text(const TypeRef& t);
  [[nodiscard]] static std::string text(const PortExpr& e);
  [[nodiscard]] static std::string text(const InteractionPattern& p);
  [[nodiscard]] static std::string names(std::span<const Name> list);
  [[nodiscard]] static std::string guard(const Expr* e);

  const SourceMap& sources_;
  std::string& out_;
  int indent_ = 0;
};

}  // namespace bip::syntax
