// The syntax tree: one tree for both notations (BIP2 and the paper's), before names are resolved.
//
// Plain immutable structs in an arena; lists are spans; names are views into the source text. Every node has its byte
// range. Text that could not be parsed has no node (and a diagnostic). No pointer is null unless the field says "may be
// null".
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "compiler/base/arena.hpp"
#include "compiler/source/source.hpp"
#include "compiler/syntax/ops.def"
#include "compiler/syntax/stmt_kinds.def"
#include "runtime/include/bip/assert.hpp"

namespace bip::syntax {

struct Expr;

struct Name {
  std::string_view text{};
  SourceRange range{};
};

/// `a`, `a.b`, `a[i].b`, `t[*].tick`. Also a qualified name when no part has an index.
struct PathPart {
  Name name{};
  const Expr* index = nullptr;  // null: no index
  bool star = false;            // [*]
};
struct Path {
  std::span<const PathPart> parts{};  // never empty in a parsed tree
  SourceRange range{};
};

// ---- expressions -----------------------------------------------------------------------------------------------
enum class ExprKind : std::uint8_t { Int, Float, Bool, String, Report, Path, Unary, Binary, Call };
#define BIP_OP_NAME(name, ...) name,
enum class UnaryOp : std::uint8_t { BIP_SIGN_OPS(BIP_OP_NAME) Plus };
enum class BinaryOp : std::uint8_t { BIP_BINARY_OPS(BIP_OP_NAME) };
#undef BIP_OP_NAME
struct Expr {
  ExprKind kind = ExprKind::Bool;
  SourceRange range{};
  std::string_view text{};   // Int, Float: as written; String: without quotes, unescaped; Report: UPPER-CASE-NAME
  bool truth = false;        // Bool
  Path path{};               // Path; Call: the function's name
  bool clock_speed = false;  // Path followed by ' (the speed of a clock)
  UnaryOp unary{};
  BinaryOp binary{};
  SourceRange op_range{};                   // Unary, Binary: the operator
  bool parenthesised = false;               // written in ( )
  std::span<const Expr* const> operands{};  // Unary 1, Binary 2, Call n
};

// ---- statements ------------------------------------------------------------------------------------------------
enum class StmtKind : std::uint8_t {
#define BIP_STMT_KIND(name, node, before, parts) name,
  BIP_STMT_KINDS(BIP_STMT_KIND)
#undef BIP_STMT_KIND
};
/// Which parts a statement has, besides its value.
enum class StmtParts : std::uint8_t {
  Target,  // target, clock_speed
  ValueAlone,
  Bodies  // then_body, else_body, shares_fi
};
struct StmtKindInfo {
  std::string_view node;    // in --emit=syntax
  std::string_view before;  // before the value in the source
  StmtParts parts;
};
inline constexpr std::array kStmtKinds{
#define BIP_STMT_KIND_INFO(name, node, before, parts) StmtKindInfo{node, before, StmtParts::parts},
    BIP_STMT_KINDS(BIP_STMT_KIND_INFO)
#undef BIP_STMT_KIND_INFO
};

struct Stmt {
  StmtKind kind = StmtKind::Call;
  SourceRange range{};
  Path target{};                // Assign
  bool clock_speed = false;     // Assign: x' = 2.0
  const Expr* value = nullptr;  // Assign: right side; Call: the call; If: the condition
  std::span<const Stmt* const> then_body{};
  std::span<const Stmt* const> else_body{};
  bool shares_fi = false;  // If after `else`: ended by the `fi` of the one before it
};
[[nodiscard]] constexpr const StmtKindInfo& info_of(StmtKind kind) {
  BIP_ASSERT(static_cast<std::size_t>(kind) < kStmtKinds.size(), "statement {}", static_cast<std::size_t>(kind));
  return kStmtKinds[static_cast<std::size_t>(kind)];
}
[[nodiscard]] constexpr StmtParts parts_of(const Stmt& s) { return info_of(s.kind).parts; }

/// `{ … }`. present tells an empty block from none.
struct Block {
  bool present = false;
  std::span<const Stmt* const> stmts{};
  SourceRange range{};
};

// ---- common pieces ---------------------------------------------------------------------------------------------
struct AnnotationArg {
  Name key{};
  std::string_view value{};  // empty if none; strings unescaped
};
struct Annotation {
  Name name{};
  std::span<const AnnotationArg> args{};
  SourceRange range{};
};
using Annotations = std::span<const Annotation>;

struct TypeRef {
  Path name{};  // parts empty: no type written
  bool is_const = false;
  [[nodiscard]] bool is_written() const { return !name.parts.empty(); }
};
struct Param {
  TypeRef type{};
  Name name{};  // text empty for unnamed prototype parameters
};
struct Var {
  Name name{};
  const Expr* init = nullptr;  // may be null
};
struct DataDecl {
  Annotations annotations{};
  TypeRef type{};
  bool exported = false;
  std::span<const Var> vars{};
  SourceRange range{};
};

// ---- connectors ------------------------------------------------------------------------------------------------
enum class PortExprKind : std::uint8_t { Port, Group };
/// The `define` tree. A group without a trigger is a rendezvous, with one or more a weak synchronisation.
struct PortExpr {
  PortExprKind kind = PortExprKind::Port;
  bool trigger = false;
  Path port{};                                  // Port: a parameter's name, or a.p in an inline connector
  std::span<const PortExpr* const> children{};  // Group
  SourceRange range{};
};
struct Clause {  // on p q provided (…) up {…} down {…} do {…}
  Annotations annotations{};
  std::span<const Path> ports{};
  const Expr* guard = nullptr;  // may be null
  Block up{};
  Block down{};
  Block action{};  // the paper's `do`
  SourceRange range{};
};
struct ConnectorExport {
  bool present = false;
  Annotations annotations{};
  TypeRef type{};  // may be unwritten in the paper's notation
  Name name{};
  std::span<const Name> vars{};
  SourceRange range{};
};
struct ConnectorBody {
  std::span<const DataDecl> data{};
  ConnectorExport exported{};
  const PortExpr* define = nullptr;  // null: `define` missing (reported in BIP2, all subsets in the paper's notation)
  Name resume{};                     // "async" or "sync" or empty
  std::span<const Clause> clauses{};
};

// ---- atoms -----------------------------------------------------------------------------------------------------
enum class PortRole : std::uint8_t { Internal, Exported, External };
struct PortItem {
  Name name{};
  std::span<const Name> vars{};
  bool has_vars = false;  // ( ) was written
};
/// `[export] port T p(x), q(y) [as e]`, `extern port …`. In the paper's notation role is Exported and type may be
/// unwritten.
struct PortDecl {
  Annotations annotations{};
  PortRole role = PortRole::Internal;
  TypeRef type{};
  std::span<const PortItem> items{};
  Name merged_as{};                 // export … as e; empty: none
  std::string_view extern_class{};  // extern … as "Class"
  Name extern_policy{};             // remember | ignore | error
  SourceRange range{};
};
struct ClockDecl {
  Annotations annotations{};
  std::span<const Name> names{};
  Name unit{};
  SourceRange range{};
};
struct Transition {
  Annotations annotations{};
  bool internal = false;
  Name port{};  // empty if internal
  std::span<const Name> from{};
  std::span<const Name> to{};
  const Expr* guard = nullptr;  // may be null
  Name urgency{};               // lazy | delayable | eager | empty
  Block action{};
  bool resumes = false;
  const Expr* resume = nullptr;
  SourceRange range{};
};
struct Initial {
  bool present = false;
  std::span<const Name> to{};
  Block action{};
  bool resumes = false;
  const Expr* resume = nullptr;
  SourceRange range{};
};
struct AtomPriority {
  Name name{};
  Name low{};  // text "*" for the wildcard
  Name high{};
  const Expr* guard = nullptr;
  SourceRange range{};
};
/// A line `final A, B`: where a run may end (an extension).
struct FinalPlaces {
  std::span<const Name> places{};
  SourceRange range{};
};
enum class InvariantScope : std::uint8_t { Always, At, From };
struct Invariant {
  Name name{};
  InvariantScope scope = InvariantScope::Always;
  std::span<const Name> places{};
  const Expr* expr = nullptr;
  SourceRange range{};
};

// ---- compounds -------------------------------------------------------------------------------------------------
struct NamedArg {
  Name name{};  // empty: by position
  const Expr* value = nullptr;
};
enum class ItemKind : std::uint8_t { Component, Connector, For, Priority, Property };
struct CompoundPriority;
struct CompoundItem {
  ItemKind kind = ItemKind::Component;
  Annotations annotations{};
  SourceRange range{};
  Name name{};                       // Component, Connector, Property; For: the loop variable
  TypeRef type{};                    // Component, Connector (unwritten if inline)
  const Expr* index = nullptr;       // name[index]: an array's size outside `for`, an element inside; may be null
  std::span<const NamedArg> args{};  // Component
  std::span<const Path> ports{};     // Connector
  const ConnectorBody* inline_body = nullptr;  // Connector in the paper's notation; null: a typed one
  const Expr* low = nullptr;                   // For i in low..high (high excluded)
  const Expr* high = nullptr;
  std::span<const CompoundItem* const> items{};  // For
  const CompoundPriority* priority = nullptr;    // Priority: one in a `for`; name and index are its own
  Name property{};                               // Property: what stands between the braces
};
/// One side of a compound priority: c:a.p,b.q | c:* | *:*
struct InteractionPattern {
  bool any_connector = false;  // *:*
  Path connector{};
  bool any_interaction = false;  // c:*   (also a bare connector name in the paper's notation)
  std::span<const Path> ports{};
  SourceRange range{};
};
struct CompoundPriority {
  Annotations annotations{};
  Name name{};
  const Expr* index = nullptr;  // in a `for`: name[index]
  InteractionPattern low{};
  InteractionPattern high{};
  const Expr* guard = nullptr;
  SourceRange range{};
};
struct CompoundExport {
  Annotations annotations{};
  bool is_data = false;
  std::span<const Path> targets{};  // more than one merges
  Name name{};                      // as
  SourceRange range{};
};

// ---- declarations ----------------------------------------------------------------------------------------------
enum class DeclKind : std::uint8_t {
  ConstData,
  ExternType,
  ExternFunction,
  ExternOperator,
  Function,
  PortType,
  ConnectorType,
  AtomType,
  CompoundType
};
/// `int`, `bool`, `float` and `string` need no declaration.
[[nodiscard]] inline bool is_native_type(std::string_view name) {
  return name == "int" || name == "bool" || name == "float" || name == "string";
}
enum class Notation : std::uint8_t { Bip2, Paper };
struct Decl {
  DeclKind kind = DeclKind::PortType;
  Notation notation = Notation::Bip2;
  Annotations annotations{};
  SourceRange range{};
  Name name{};
  std::span<const Param>
      params{};  // types: parameters; PortType: its variables; ConnectorType: its ports; Extern*: parameters

  // ConstData; AtomType, paper compounds: data
  std::span<const DataDecl> data{};

  // ExternType
  std::span<const Path> refines{};
  std::string_view cpp_name{};
  // ExternFunction, ExternOperator, Function
  TypeRef result{};
  Name op{};
  const Expr* body = nullptr;  // Function: `function int f(int x) = x + 1`, a function without C++ (an extension)

  // ConnectorType
  const ConnectorBody* connector = nullptr;

  // AtomType
  std::span<const PortDecl> ports{};
  std::span<const ClockDecl> clocks{};
  std::span<const Name> places{};
  Initial initial{};
  std::span<const FinalPlaces> finals{};
  std::span<const Transition> transitions{};
  std::span<const AtomPriority> atom_priorities{};
  std::span<const Invariant> invariants{};

  // CompoundType
  std::span<const CompoundItem* const> items{};
  std::span<const CompoundPriority> priorities{};
  std::span<const CompoundExport> exports{};
};

struct Package {
  Annotations annotations{};
  Path name{};  // parts empty: a file of the paper's notation without a package line
  std::span<const Path> uses{};
  std::span<const Decl* const> decls{};
  SourceRange range{};
};

/// A comment with its place, for the printer.
struct Comment {
  SourceRange range{};  // with its // or /* */
};

/// One file. Owns its nodes; the texts belong to the source map.
struct Syntax {
  FileId file;
  std::unique_ptr<Arena> arena;
  const Package* package = nullptr;
  std::vector<Comment> comments;
};

}  // namespace bip::syntax
