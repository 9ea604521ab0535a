// The table of functions. The oracle calls the same C++ functions as the executors, but decides by itself which
// function is called, with which arguments and how often.
#include "tools/gen/ffi_prototypes.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace bip::gen {
namespace {

using Args = std::vector<Value*>;

void set(Value& to, int value) { to.i = value; }
void set(Value& to, bool value) {
  to.type = Ty::Bool;
  to.i = value ? 1 : 0;
}
void set(Value& to, double value) {
  to.type = Ty::Float;
  to.f = value;
}
void set(Value& to, std::string value) {
  to.type = Ty::String;
  to.s = std::move(value);
}
void set(Value& to, const Pair& value) {
  to.type = Ty::Pair;
  to.w = Wide{value, 0};
}
void set(Value& to, const Wide& value) {
  to.type = Ty::Wide;
  to.w = value;
}

/// apply of a function that cannot fail: an expression over `a`, the arguments.
#define BIP_GEN_CALL(expression)                            \
  [](const Args& a, bool is_const, Value& result) -> bool { \
    (void)is_const;                                         \
    set(result, expression);                                \
    return true;                                            \
  }
#define BIP_GEN_ACT(statement)              \
  [](const Args& a, bool, Value&) -> bool { \
    statement;                              \
    return true;                            \
  }

bool call_picky(const Args& a, bool, Value& result) {
  try {
    set(result, picky(a[0]->i));
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

std::vector<FfiPrototype> table() {
  constexpr FfiParam kInt{Ty::Int, false}, kFloat{Ty::Float, false}, kString{Ty::String, false}, kPair{Ty::Pair, false},
      kWide{Ty::Wide, false};
  constexpr FfiParam kIntRef{Ty::Int, true}, kFloatRef{Ty::Float, true}, kPairRef{Ty::Pair, true};
  std::vector<FfiPrototype> t;
  const auto add = [&](const char* name, const char* prototype, Ty result, std::vector<FfiParam> params,
                       bool (*apply)(const Args&, bool, Value&)) -> FfiPrototype& {
    return t.emplace_back(FfiPrototype{
        .name = name, .prototype = prototype, .result = result, .params = std::move(params), .apply = apply});
  };
  add("mix", "function int mix(const int, const int)", Ty::Int, {kInt, kInt}, BIP_GEN_CALL(mix(a[0]->i, a[1]->i)));
  add("scale", "function float scale(const float f, const int k)", Ty::Float, {kFloat, kInt},
      BIP_GEN_CALL(scale(a[0]->f, a[1]->i)));
  add("odd", "function bool odd(const int)", Ty::Bool, {kInt},
      BIP_GEN_CALL(is_const ? const_odd(a[0]->i) : odd(a[0]->i)));
  add("label", "function string label(const int)", Ty::String, {kInt}, BIP_GEN_CALL(label(a[0]->i)));
  add("joined", "function string joined(const string, const string)", Ty::String, {kString, kString},
      BIP_GEN_CALL(joined(a[0]->s, a[1]->s)));
  add("length", "function int length(const string)", Ty::Int, {kString}, BIP_GEN_CALL(length(a[0]->s)));
  add("bump", "function bump(int)", Ty::Int, {kIntRef}, BIP_GEN_ACT(bump(a[0]->i))).has_result = false;
  add("after", "function int after(int x)", Ty::Int, {kIntRef}, BIP_GEN_CALL(after(a[0]->i)));
  add("grow", "function grow(float x)", Ty::Int, {kFloatRef}, BIP_GEN_ACT(grow(a[0]->f))).has_result = false;
  add("exchange", "function exchange(int x, int y)", Ty::Int, {kIntRef, kIntRef},
      BIP_GEN_ACT(exchange(a[0]->i, a[1]->i)))
      .has_result = false;
  add("picky", "function int picky(const int)", Ty::Int, {kInt}, call_picky).may_fault = true;
  add("make_two", "function Pair make_two(const int, const int)", Ty::Pair, {kInt, kInt},
      BIP_GEN_CALL(make_two(a[0]->i, a[1]->i)));
  add("widened", "function Wide widened(const Pair, const int)", Ty::Wide, {kPair, kInt},
      BIP_GEN_CALL(widened(a[0]->w, a[1]->i)));
  add("first", "function int first(const Pair)", Ty::Int, {kPair}, BIP_GEN_CALL(first(a[0]->w)));
  add("third", "function int third(const Wide)", Ty::Int, {kWide}, BIP_GEN_CALL(third(a[0]->w)));
  add("push", "function push(Pair, const int)", Ty::Int, {kPairRef, kInt}, BIP_GEN_ACT(push(a[0]->w, a[1]->i)))
      .has_result = false;
  add("+", "operator Pair +(const Pair, const Pair)", Ty::Pair, {kPair, kPair}, BIP_GEN_CALL(a[0]->w + a[1]->w))
      .is_operator = true;
  add("==", "operator bool ==(const Pair, const Pair)", Ty::Bool, {kPair, kPair}, BIP_GEN_CALL(a[0]->w == a[1]->w))
      .is_operator = true;
  add("<", "operator bool <(const Pair, const Pair)", Ty::Bool, {kPair, kPair}, BIP_GEN_CALL(a[0]->w < a[1]->w))
      .is_operator = true;
  add("sort_of", "function int sort_of(const int)", Ty::Int, {kInt}, BIP_GEN_CALL(sort_of(a[0]->i)));
  add("sort_of", "function int sort_of(const float)", Ty::Int, {kFloat}, BIP_GEN_CALL(sort_of(a[0]->f)));
  add("sort_of", "function int sort_of(const string)", Ty::Int, {kString}, BIP_GEN_CALL(sort_of(a[0]->s)));
  add("sort_of", "function int sort_of(const Pair)", Ty::Int, {kPair},
      BIP_GEN_CALL(sort_of(static_cast<const Pair&>(a[0]->w))));
  add("sort_of", "function int sort_of(const Wide)", Ty::Int, {kWide}, BIP_GEN_CALL(sort_of(a[0]->w)));
  add("max", "function int max(const int, const int)", Ty::Int, {kInt, kInt}, BIP_GEN_CALL(std::max(a[0]->i, a[1]->i)))
      .is_library = true;
  add("min", "function int min(const int, const int)", Ty::Int, {kInt, kInt}, BIP_GEN_CALL(std::min(a[0]->i, a[1]->i)))
      .is_library = true;
  add("floor", "function float floor(const float)", Ty::Float, {kFloat}, BIP_GEN_CALL(std::floor(a[0]->f))).is_library =
      true;
  add("isgreater", "function bool isgreater(const float, const float)", Ty::Bool, {kFloat, kFloat},
      BIP_GEN_CALL(std::isgreater(a[0]->f, a[1]->f)))
      .is_library = true;
  return t;
}

#undef BIP_GEN_CALL
#undef BIP_GEN_ACT

}  // namespace

bool FfiPrototype::is_pure() const {
  return has_result && std::none_of(params.begin(), params.end(), [](const FfiParam& p) { return p.by_reference; });
}

const std::vector<FfiPrototype>& ffi_functions() {
  static const std::vector<FfiPrototype> kTable = table();
  return kTable;
}

bool has_const_variant(const std::string& name) { return name == "odd"; }

}  // namespace bip::gen
