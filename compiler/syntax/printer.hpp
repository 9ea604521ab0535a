// The state of the printer, shared by its files. Lines are appended to one text. Comments are taken from the source in
// order and printed before the line that they preceded, or after the line that they followed.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "compiler/syntax/syntax.hpp"

namespace bip::syntax {

class SyntaxPrinter {
 public:
  SyntaxPrinter(const Syntax& syntax, const SourceMap& sources)
      : syntax_(syntax), sources_(sources), source_(sources.text(syntax.file)) {}
  std::string run();

 private:
  /// Of an expression as a whole; inner ones always stay.
  enum class Parentheses : std::uint8_t { Kept, Dropped };
  enum class Level : std::uint8_t { Root, Inner };
  /// InState: below `state S`, which says where it begins.
  enum class TransitionForm : std::uint8_t { Alone, InState };
  enum class Layout : std::uint8_t { OwnLine, SameLine };
  /// Something with a place among its siblings: printed in source order, whatever list of the tree it is in.
  struct Piece {
    std::uint32_t begin = 0;
    std::function<void()> print;
  };
  static void print_in_order(std::vector<Piece>& pieces);

  // print.cpp: lines, comments, blank lines
  void lead_in(std::uint32_t begin, std::uint32_t limit);
  void begin_line();
  void put(std::string_view text) { out_ += text; }
  void end_line(std::uint32_t source_end);
  void header_line(std::uint32_t name_end);
  void end_block(std::uint32_t source_end);
  void annotations(Annotations list, std::uint32_t begin);
  void comment_line(const Comment& c);
  void blank_line_if_source_has_one(std::uint32_t begin);
  [[nodiscard]] bool has_comment_before(std::uint32_t offset) const;
  [[nodiscard]] std::string comment_text(const Comment& c) const;
  [[nodiscard]] std::size_t column() const { return out_.size() - line_start_; }
  [[nodiscard]] std::string_view source(SourceRange r) const { return source_.substr(r.begin, r.end - r.begin); }

  // print_text.cpp: pieces of lines
  [[nodiscard]] std::string text(const Expr* e, Parentheses parentheses = Parentheses::Kept) const;
  [[nodiscard]] std::string text(const Path& p) const;
  [[nodiscard]] std::string text(const TypeRef& t) const;
  [[nodiscard]] std::string text(std::span<const Name> names) const;
  [[nodiscard]] std::string text(std::span<const Path> paths, std::string_view separator = ", ") const;
  [[nodiscard]] std::string text(std::span<const Param> params) const;
  [[nodiscard]] std::string text(std::span<const Var> vars) const;
  [[nodiscard]] std::string text(std::span<const NamedArg> args) const;
  [[nodiscard]] std::string text(const PortExpr& e, Level level) const;
  [[nodiscard]] std::string text(const InteractionPattern& p) const;
  [[nodiscard]] std::string text(const Annotation& a) const;
  /// The text of a statement of one line. Requires is_simple(s).
  [[nodiscard]] std::string simple(const Stmt& s) const;
  [[nodiscard]] static bool is_simple(const Stmt& s);
  [[nodiscard]] std::string guard(const Expr* e) const;

  // print_action.cpp
  void block(std::string_view word, const Block& b);
  void stmts(std::span<const Stmt* const> list);
  void stmt(const Stmt& s);
  void if_chain(const Stmt& s);

  // print_decl.cpp
  void package(const Package& p);
  void decl(const Decl& d);
  void one_line_decl(const Decl& d);
  void data(const DataDecl& d);
  void connector_parts(const ConnectorBody& body);
  void clause(const Clause& c);

  // print_body.cpp
  void atom(const Decl& d);
  void ports(const PortDecl& p);
  void initial_parts(const Initial& i);
  void transition(const Transition& t, TransitionForm form);
  void behavior(const Decl& d);
  [[nodiscard]] std::uint32_t end_of_word(std::string_view word, std::uint32_t from) const;
  [[nodiscard]] static bool has_state_form(const Decl& d);

  // print_compound.cpp
  void compound(const Decl& d);
  void items(std::span<const CompoundItem* const> list, std::vector<Piece>& pieces);
  void property(const CompoundItem& item);
  void priority(const CompoundPriority& p);
  void item_group(std::span<const CompoundItem* const> group, Layout layout);

  const Syntax& syntax_;
  const SourceMap& sources_;
  std::string_view source_;
  std::string out_;
  std::size_t line_start_ = 0;
  std::size_t next_comment_ = 0;
  std::uint32_t last_end_ = 0;  // in the source: what was printed so far ends here
  int indent_ = 0;
  bool first_in_block_ = true;
  Notation notation_ = Notation::Bip2;
};

}  // namespace bip::syntax
