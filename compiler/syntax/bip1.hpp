// The syntax tree of BIP1, the language before BIP2, for `bipc migrate` (compiler/docs/bip1.md).
//
// Plain values in the order of the source; names are views into its text. C code has its text, and its statements if
// they are among those that BIP2 has.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/syntax/syntax.hpp"

namespace bip::syntax::bip1 {

using Names = std::vector<Name>;
/// `a.b.c`: never empty.
using Path = std::vector<Name>;

// ---- C code ------------------------------------------------------------------------------------------------------
enum class ExprKind : std::uint8_t { Int, Float, Bool, String, Variable, Call, Unary, Binary, Parenthesised };
struct Expr {
  ExprKind kind = ExprKind::Int;
  SourceRange range{};
  std::string text{};  // literals: as BIP2 writes them; Unary, Binary: the operator
  Path path{};         // Variable, Call
  std::vector<Expr> operands{};
};
enum class StmtKind : std::uint8_t { Assign, Change, Call, If };
struct Stmt {
  StmtKind kind = StmtKind::Assign;
  SourceRange range{};
  Path target{};              // Assign, Change; Call: the function
  std::string op{};           // Change: `x op= value`
  std::vector<Expr> exprs{};  // Assign, Change: the value; If: the condition; Call: the arguments
  std::vector<Stmt> then_body{}, else_body{};
};
/// `{ … }` or `{# … #}`.
struct Code {
  bool is_present = false;
  SourceRange range{};                       // without the braces
  std::optional<std::vector<Stmt>> stmts{};  // nothing: more of C than BIP2 has
};
struct Guard {
  SourceRange range{};         // without braces
  std::optional<Expr> expr{};  // nothing: more of C than BIP2 has
};

// ---- common pieces -------------------------------------------------------------------------------------------------
struct Type {
  std::string text{};  // `unsigned int`, `FILE *`: words and signs with one blank between
  SourceRange range{};
};
struct Param {
  Type type{};
  Name name{};
};
struct Var {
  Type type{};
  Name name{};
  std::optional<Guard> init{};
  SourceRange range{};
};
struct Data {
  bool is_exported = false;
  std::vector<Var> vars{};
  bool is_readable = true;  // false: `data {# … #}` with more than declarations
  SourceRange range{};
};
struct PortItem {
  Name name{};
  Names vars{};
};
struct Port {
  bool is_exported = false;
  Name completeness{};  // `complete`, `incomplete` or empty
  Name type{};          // may be empty
  std::vector<PortItem> items{};
  Name exported_as{};  // may be empty
  SourceRange range{};
};
struct Condition {
  Guard guard{};
  SourceRange range{};
};
struct PrioritySide {
  bool is_any = false;              // `*` or `*:*`
  Path connector{};                 // else
  bool has_interaction = false;     // `c:…`
  std::vector<Path> interaction{};  // empty: `c:*`
};
struct Priority {
  Name name{};  // may be empty
  std::vector<Condition> conditions{};
  PrioritySide low{}, high{};
  SourceRange range{};
};

// ---- connectors ----------------------------------------------------------------------------------------------------
struct PortTerm {
  bool is_trigger = false;
  Path port{};                       // empty: a group
  std::vector<PortTerm> children{};  // of a group
  SourceRange range{};
};
/// `complete p, q|r`
struct Completeness {
  bool is_complete = false;
  std::vector<std::vector<Path>> interactions{};
  SourceRange range{};
};
struct Clause {
  std::vector<Path> ports{};
  std::vector<Guard> guards{};
  Code up{}, down{};
  SourceRange range{};
};
struct ConnectorBody {
  std::vector<Data> data{};
  std::vector<Port> exports{};
  std::vector<PortTerm> define{};  // empty: none
  SourceRange define_range{};
  std::vector<Completeness> completeness{};
  std::vector<Clause> clauses{};
};

// ---- atoms ---------------------------------------------------------------------------------------------------------
struct Clock {
  Names names{};
  std::string unit{};  // `1 second`; empty: none
  SourceRange range{};
};
struct Initial {
  Names to{};
  Code action{};
  SourceRange range{};
};
/// `when x in [low, high]`, or `when` with any condition.
struct When {
  Path clock{};               // empty: the guard
  std::vector<Guard> ends{};  // low and high; or the guard
  SourceRange range{};
};
struct Transition {
  bool is_internal = false;
  Name port{};
  Names from{}, to{};
  std::vector<Guard> guards{};
  std::vector<When> whens{};
  Name urgency{};
  Names resets{};
  Code action{};
  SourceRange range{};
};

// ---- compounds -----------------------------------------------------------------------------------------------------
struct Instance {
  Name name{};
  std::vector<Guard> args{};
};
struct Instances {
  Name type{};
  std::vector<Instance> items{};
  SourceRange range{};
};
struct Connector {
  Name type{};  // empty: an inline connector, with a body
  Name name{};
  std::vector<Path> ports{};
  ConnectorBody body{};
  SourceRange range{};
};
struct Export {
  bool is_data = false;
  Path target{};
  Name name{};  // empty: the export names no element of the compound
  SourceRange range{};
};

// ---- declarations --------------------------------------------------------------------------------------------------
enum class DeclKind : std::uint8_t { PortType, ConnectorType, AtomType, CompoundType };
struct Decl {
  DeclKind kind = DeclKind::PortType;
  Name name{};
  std::vector<Param> params{};
  SourceRange range{};
  std::vector<Code> headers{};  // AtomType
  ConnectorBody connector{};
  std::vector<Data> data{};
  std::vector<Port> ports{};
  std::vector<Clock> clocks{};
  Names places{};
  SourceRange places_range{};  // of the first
  std::vector<Initial> initials{};
  std::vector<Transition> transitions{};
  std::vector<Priority> priorities{};
  std::vector<Instances> instances{};
  std::vector<Connector> connectors{};
  std::vector<Export> exports{};
};
struct Model {
  FileId file{};
  Name name{};
  std::vector<Code> headers{};
  std::vector<Decl> decls{};
  std::vector<Instances> roots{};
  std::vector<Comment> comments{};  // in source order; without those of C code that is more than BIP2 has
  SourceRange range{};
};

}  // namespace bip::syntax::bip1
