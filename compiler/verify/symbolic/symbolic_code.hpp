// Guards, actions and transfers as AIGs, bit by bit as the language defines them.
//
// int, bool and string (row of the string table) are exact. What a float, an FFI value or a call of C++ gives is any
// value: a comparison with it is a new input, and the place is noted, so that a verdict can name what it could not see.
#pragma once
#include <functional>
#include <set>

#include "compiler/model/abstract_interpreter.hpp"
#include "compiler/verify/symbolic/aig.hpp"

namespace bip::verify {

/// What code reads and writes.
struct Variables {
  std::function<Word(std::uint32_t)> self, bind;
  std::function<void(std::uint32_t, Word)> set_self, set_bind;
};
/// Returns whether AIGs follow values of the type exactly, as words of 32 bits (a bool: two).
[[nodiscard]] constexpr bool is_followed(Type type) {
  return type == Type::Int || type == Type::Bool || type == Type::String;
}
/// What AIGs do not follow exactly.
struct Imprecision {
  Loc loc{};
  std::string what;  // "a float", "a call of `f`"
  friend bool operator<(const Imprecision& a, const Imprecision& b) {
    return std::tuple(a.loc.file, a.loc.line, a.what) < std::tuple(b.loc.file, b.loc.line, b.what);
  }
};

/// Returns the value of an operator without faults (no division) over words of ints, bools or rows of strings.
[[nodiscard]] Word apply(Aig& aig, Op op, const Word& a, const Word& b);
[[nodiscard]] Word apply(Aig& aig, Op op, const Word& a);

/// Where a piece of code is evaluated: `fault` is raised where `condition` holds and the code would end the run.
struct SymbolicPoint {
  const Variables& variables;
  Signal condition;
  Signal& fault;
};

/// The domain of words of an AIG.
class SymbolicCode : public AbstractInterpreter<SymbolicCode, Word, SymbolicPoint> {
 public:
  SymbolicCode(Aig& aig, const CodeTable& code) : AbstractInterpreter(code), aig_(aig) {}

  /// A new value of the type; empty for types that are not followed.
  [[nodiscard]] Word any(Type type);
  /// A guard; no guard is true.
  [[nodiscard]] Signal test(ExprId guard, const Variables& variables, Signal condition, Signal& fault);
  void execute(StmtId body, const Variables& variables, Signal condition, Signal& fault);

  [[nodiscard]] const std::set<Imprecision>& imprecisions() const { return vague_; }
  void note(Loc loc, std::string what) { vague_.insert({loc, std::move(what)}); }

 private:
  friend AbstractInterpreter;
  [[nodiscard]] Word constant(const Expr& e);
  [[nodiscard]] Word load(const Expr& e, SymbolicPoint& at);
  Word drawn(const Expr& e, SymbolicPoint& at);
  [[nodiscard]] Word call(const Expr& e, SymbolicPoint& at);
  void forget(const Expr& load, SymbolicPoint& at);
  [[nodiscard]] Word unary(const Expr& e, const Word& a, SymbolicPoint& at);
  [[nodiscard]] Word binary(const Expr& e, const Word& a, const Word& b, SymbolicPoint& at);
  [[nodiscard]] Word divided(const Expr& e, const Word& a, const Word& b, SymbolicPoint& at);
  [[nodiscard]] Word logic(const Expr& e, SymbolicPoint& at);
  [[nodiscard]] Word merged(Signal condition, const Word& yes, const Word& no, Type type);
  [[nodiscard]] bool goes_on(const SymbolicPoint& at) const { return at.condition != kFalse; }
  void store(const Stmt& s, SymbolicPoint& at);
  void branch(const Stmt& s, SymbolicPoint& at);
  void run_call(const Stmt& s, SymbolicPoint& at) { (void)evaluate(s.value, at); }

  Aig& aig_;
  std::set<Imprecision> vague_;
};

}  // namespace bip::verify
