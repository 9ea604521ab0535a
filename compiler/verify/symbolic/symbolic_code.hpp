// Guards, actions and transfers as AIGs, bit by bit as the language defines them.
//
// int, bool and string (row of the string table) are exact. What a float, an FFI value or a call of C++ gives is any
// value: a comparison with it is a new input, and the place is noted, so that a verdict can name what it could not see.
#pragma once
#include <functional>
#include <set>

#include "compiler/model/code.hpp"
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

class SymbolicCode {
 public:
  SymbolicCode(Aig& aig, const CodeTable& code) : aig_(aig), code_(code) {}

  /// A new value of the type; empty for types that are not followed.
  [[nodiscard]] Word any(Type type);
  /// `fault` is raised where `condition` holds and the code would end the run.
  [[nodiscard]] Word evaluate(ExprId expr, const Variables& variables, Signal condition, Signal& fault);
  /// A guard; no guard is true.
  [[nodiscard]] Signal test(ExprId guard, const Variables& variables, Signal condition, Signal& fault);
  void execute(StmtId body, const Variables& variables, Signal condition, Signal& fault);

  [[nodiscard]] const std::set<Imprecision>& imprecisions() const { return vague_; }
  void note(Loc loc, std::string what) { vague_.insert({loc, std::move(what)}); }

 private:
  [[nodiscard]] Word call(const Expr& e, const Variables& variables, Signal condition, Signal& fault);
  [[nodiscard]] Word binary(const Expr& e, const Word& a, const Word& b, Signal condition, Signal& fault);
  [[nodiscard]] Word merged(Signal condition, const Word& yes, const Word& no, Type type);

  Aig& aig_;
  const CodeTable& code_;
  std::set<Imprecision> vague_;
};

}  // namespace bip::verify
