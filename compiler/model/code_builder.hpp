// From expressions and statements of the syntax tree to typed code: the only place where expressions are type-checked.
//
// The scope says what each name means there. Errors are reported once, at the smallest range; a part that is wrong
// yields nothing (nullopt) and silences what contains it.
#pragma once
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "compiler/model/model.hpp"

namespace bip::model {

/// What a name in code stands for: a variable to load (and store), or a fixed expression.
struct Binding {
  Op load = Op::LoadSelf;
  std::uint32_t index = 0;
  Type type = Type::Int;
  std::string read_only{};        // why it cannot be assigned; empty: it can
  ExprId value{};                 // valid: the name stands for this expression
  mutable bool is_fresh = false;  // `value` has no place in a tree yet: the first use takes it, others copy
  bool is_constant = false;       // declared `const`
  bool poison = false;            // its declaration was wrong or is not supported: uses say nothing more
  bool is_clock = false;  // index: the first of its hidden variables. Code sets it, and reads and sets its speed
  SourceRange declared{};
};

struct Scope {
  std::unordered_map<std::string, Binding> names;  // "x", "p.d", "t[0].tick.v": keys as path_key makes them
  std::string owner;                               // "atom type `Fork`", for messages
  AtomType* drawing = nullptr;                     // whose actions these are: only those draw random numbers
};

/// The path without white space: parts joined by '.', indices as written.
[[nodiscard]] std::string path_key(const syntax::Path& path, const SourceMap& sources);

/// "1 argument", "2 arguments", for messages.
[[nodiscard]] std::string counted(std::size_t n, std::string_view what);

struct Typed {
  ExprId id;
  Type type = Type::Int;
};

struct Argument;  // ffi_declarations.hpp

class CodeBuilder {
 public:
  CodeBuilder(Model& model, Diagnostics& diags, const Scope& scope) : model_(model), diags_(diags), scope_(scope) {}

  /// Code of the body of `function`.
  CodeBuilder(Model& model, Diagnostics& diags, const Scope& scope, const syntax::Decl& function,
              const CodeBuilder* caller = nullptr)
      : model_(model),
        diags_(diags),
        scope_(scope),
        function_(&function),
        caller_(caller),
        unfold_start_(caller == nullptr ? model.code.exprs.size() : caller->unfold_start_),
        const_calls_(caller != nullptr && caller->const_calls_) {}

  /// The expression with its own type.
  std::optional<Typed> expr(const syntax::Expr* e);
  /// The expression as `type` (an int is converted to float). `what` is what it is for: "the guard".
  ExprId expr_as(const syntax::Expr* e, Type type, const std::string& what);
  /// The initial value of data: it is a part of the initial action, so it may be drawn.
  ExprId initial_value(const syntax::Expr* e, Type type, const std::string& what) {
    may_draw_ = true;
    const ExprId id = expr_as(e, type, what);
    may_draw_ = false;
    return id;
  }
  /// Null gives the invalid id, which is true.
  ExprId guard(const syntax::Expr* e) {
    const bool before = const_calls_;
    const_calls_ = true;
    const ExprId id = e == nullptr ? ExprId{} : expr_as(e, Type::Bool, "the guard");
    const_calls_ = before;
    if (e != nullptr) warn_never_true(e, id);
    return id;
  }
  /// Warns if the guard, written as `e`, is made of literals and false.
  void warn_never_true(const syntax::Expr* e, ExprId guard);
  /// From now on C++ functions are called by their `const_` names where they have one: `up`, invariants.
  void set_const_calls() { const_calls_ = true; }
  /// The chain of statements; `tail` is appended after it.
  StmtId block(std::span<const syntax::Stmt* const> stmts, StmtId tail = {});
  /// Data initialiser as a store into Self variable.
  StmtId store_self(std::uint32_t variable, Type type, ExprId value, Loc loc, StmtId next);
  /// The value of a constant in a few rows: itself, or the division that faults wherever the constant is read.
  ExprId folded(ExprId value);
  /// Code is a tree: what stands for a name is copied to each place where the name does.
  ExprId copy(ExprId from);
  /// A default-valued constant, so that building can go on after an error.
  ExprId poison(Type type);
  Typed convert(Typed v, Type to);

 private:
  enum class CallUse : std::uint8_t { Statement, Value };
  /// Reported: an unknown name is an error.
  enum class Lookup : std::uint8_t { Silent, Reported };
  std::optional<Typed> path(const syntax::Expr* e);
  std::optional<Typed> clock_path(const syntax::Expr* e);
  StmtId clock_statement(const syntax::Stmt* s, const Binding& target, StmtId next);
  std::optional<Typed> literal(const syntax::Expr* e);
  std::optional<Typed> unary(const syntax::Expr* e);
  std::optional<Typed> binary(const syntax::Expr* e);
  std::optional<Typed> call(const syntax::Expr* e);
  std::optional<Argument> argument(const syntax::Expr* e);
  /// Of a C++ function, which may be given a clock's value.
  std::optional<Argument> call_argument(const syntax::Expr* e);
  /// A clock's value at the instant of the step, in its unit.
  Argument clock_argument(const syntax::Expr* e, const Binding& clock);
  /// The clocks among the arguments as numbers of whole units, for prototypes that take ints.
  std::vector<Argument> with_whole_clocks(const std::vector<Argument>& args);
  std::optional<Typed> ffi_call(const std::string& name, const std::vector<const syntax::Decl*>& prototypes,
                                std::vector<Argument> args, SourceRange at, CallUse use);
  std::optional<Typed> ffi_function(const syntax::Expr* e, const std::string& name,
                                    const std::vector<const syntax::Decl*>& prototypes);
  /// handled: the operator is C++'s, and nothing is left to say.
  std::optional<Typed> ffi_operator(const syntax::Expr* e, std::string_view sign, std::vector<Argument> args,
                                    bool& handled);
  Typed cast(Typed v, Type to);
  /// A call of a distribution whose prototype has been found.
  std::optional<Typed> draw(const Function& prototype, const std::vector<ExprId>& args, SourceRange at);
  std::optional<Typed> type_error(const syntax::Expr* e, const syntax::Expr* at, const char* wants, Type got,
                                  std::string_view help = "");
  /// The prototype of an operator that takes a string, "" if neither operand is one.
  [[nodiscard]] std::string operator_help(const syntax::Expr* e, const Typed& a, const Typed& b) const;
  StmtId statement(const syntax::Stmt* s, StmtId next);
  StmtId assignment(const syntax::Stmt* s, StmtId next);
  void warn_zero_divisor(const syntax::Expr* e, Typed divisor);
  const Binding* find(const syntax::Path& p, Lookup lookup);
  bool may_inline(const syntax::Expr* e, const syntax::Decl& function);
  bool is_small(ExprId unfolded, const syntax::Expr* e);
  void report_too_large(const syntax::Expr* e);
  Loc loc(SourceRange r) const { return model_.sources->loc(r); }
  ExprId make(Expr e) { return model_.code.exprs.push(std::move(e)); }

  Model& model_;
  Diagnostics& diags_;
  const Scope& scope_;
  // The function whose body this is, and who calls it: a chain that must not close.
  const syntax::Decl* function_ = nullptr;
  const CodeBuilder* caller_ = nullptr;
  std::size_t unfold_start_ = 0;  // rows of code when the outermost call began
  bool const_calls_ = false;
  bool may_draw_ = false;      // actions of atoms
  bool in_block_ = false;      // statements: variables may change
  bool is_statement_ = false;  // the call that comes next is one
};

/// The type that a native type name means (`double` is float, with a warning); nullopt if it is none.
[[nodiscard]] std::optional<Type> native_type(const syntax::TypeRef& type, Diagnostics& diags);

}  // namespace bip::model
