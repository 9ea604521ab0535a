// Adapters by templates: one cell per parameter, exceptions as faults with their message. A row of the code table is
// found by its name, and by the type of its argument where random_ffi.hpp overloads a function.
#include "tools/gen/bind_ffi.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/ffi.hpp"
#include "tools/gen/ffi/random_ffi.hpp"

namespace bip::gen {
namespace {

template <class T>
T read(rt::FfiContext* ffi, rt::Cell& cell) {
  using Plain = std::remove_cvref_t<T>;
  if constexpr (std::is_same_v<T, int&>) {
    return cell.i;
  } else if constexpr (std::is_same_v<T, double&>) {
    return cell.f;
  } else if constexpr (std::is_same_v<Plain, int>) {
    return cell.i;
  } else if constexpr (std::is_same_v<Plain, double>) {
    return cell.f;
  } else {
    (void)ffi;
    return rt::object_in<Plain>(cell);
  }
}

/// A string is made for the call, so it is handed on by value.
struct Text {
  std::string value;
  operator const std::string&() const { return value; }
};
template <class T>
struct Read {
  using Result = T;
  static T from(rt::FfiContext* ffi, rt::Cell& cell) { return read<T>(ffi, cell); }
};
template <>
struct Read<const std::string&> {
  using Result = Text;
  static Text from(rt::FfiContext* ffi, rt::Cell& cell) { return {ffi->text(cell.i)}; }
};

void write(rt::FfiContext*, rt::Cell& cell, int value) { cell = rt::Cell{.bits = static_cast<std::uint32_t>(value)}; }
void write(rt::FfiContext*, rt::Cell& cell, bool value) { cell = rt::Cell{.bits = value ? 1u : 0u}; }
void write(rt::FfiContext*, rt::Cell& cell, double value) { cell.f = value; }
void write(rt::FfiContext* ffi, rt::Cell& cell, const std::string& value) {
  cell = rt::Cell{.bits = static_cast<std::uint32_t>(ffi->intern(std::string_view(value)))};
}
template <class T>
requires std::is_base_of_v<Pair, T>
void write(rt::FfiContext*, rt::Cell& cell, const T& value) { rt::object_in<T>(cell) = value; }

template <auto function, class R, class... A, std::size_t... k>
void call_with(R (*)(A...), std::index_sequence<k...>, rt::FfiContext* ffi, rt::Cell* result, rt::Cell* const* args) {
  if constexpr (std::is_void_v<R>) {
    (void)result;
    function(Read<A>::from(ffi, *args[k])...);
  } else {
    write(ffi, *result, function(Read<A>::from(ffi, *args[k])...));
  }
}
template <class R, class... A>
constexpr std::size_t arity(R (*)(A...)) {
  return sizeof...(A);
}

template <auto function>
std::int32_t call(rt::FfiContext* ffi, rt::Cell* result, rt::Cell* const* args) {
  try {
    call_with<function>(function, std::make_index_sequence<arity(function)>(), ffi, result, args);
    return 0;
  } catch (const std::exception& e) {
    ffi->set_message(e.what());
    return 1;
  }
}

template <auto function>
constexpr rt::FfiFunction kCall = &call<function>;

template <class R, class A>
using Unary = R (*)(A);

int larger(int a, int b) { return std::max(a, b); }
int smaller(int a, int b) { return std::min(a, b); }
double rounded_down(double a) { return std::floor(a); }
bool is_greater(double a, double b) { return std::isgreater(a, b); }

std::int32_t to_pair(rt::FfiContext*, rt::Cell* result, rt::Cell* const* args) {
  rt::object_in<Pair>(*result) = static_cast<Pair>(rt::object_in<Wide>(*args[0]));
  return 0;
}

const std::map<std::string, rt::FfiFunction>& adapters() {
  static const std::map<std::string, rt::FfiFunction> kAdapters = {
      {"mix", kCall<&mix>},
      {"scale", kCall<&scale>},
      {"odd", kCall<&odd>},
      {"const_odd", kCall<&const_odd>},
      {"label", kCall<&label>},
      {"joined", kCall<&joined>},
      {"length", kCall<&length>},
      {"bump", kCall<&bump>},
      {"after", kCall<&after>},
      {"grow", kCall<&grow>},
      {"exchange", kCall<&exchange>},
      {"picky", kCall<&picky>},
      {"make_two", kCall<&make_two>},
      {"widened", kCall<&widened>},
      {"first", kCall<&first>},
      {"third", kCall<&third>},
      {"push", kCall<&push>},
      {"+", kCall<static_cast<Pair (*)(const Pair&, const Pair&)>(&operator+)>},
      {"==", kCall<static_cast<bool (*)(const Pair&, const Pair&)>(&operator==)>},
      {"<", kCall<static_cast<bool (*)(const Pair&, const Pair&)>(&operator<)>},
      {"sort_of int", kCall<static_cast<Unary<int, int>>(&sort_of)>},
      {"sort_of float", kCall<static_cast<Unary<int, double>>(&sort_of)>},
      {"sort_of string", kCall<static_cast<Unary<int, const std::string&>>(&sort_of)>},
      {"sort_of Pair", kCall<static_cast<Unary<int, const Pair&>>(&sort_of)>},
      {"sort_of Wide", kCall<static_cast<Unary<int, const Wide&>>(&sort_of)>},
      {"max", kCall<&larger>},
      {"min", kCall<&smaller>},
      {"floor", kCall<&rounded_down>},
      {"isgreater", kCall<&is_greater>}};
  return kAdapters;
}

}  // namespace

std::string bind_ffi(lower::LoweredSystem& lowered) {
  std::string missing;
  const CodeTable& code = lowered.system->code;
  for (std::size_t row = 0; row < code.functions.size(); ++row) {
    const Function& f = code.functions[row];
    if (f.kind == FunctionKind::Draw) continue;
    std::string name = f.name;
    if (f.is_const && f.kind == FunctionKind::Function && adapters().contains("const_" + name)) name = "const_" + name;
    if (name == "sort_of") name += " " + code.type_name(f.params[0].type);
    const auto found = adapters().find(name);
    lowered.functions[row] = f.kind == FunctionKind::Cast ? &to_pair
                             : found == adapters().end()  ? nullptr
                                                          : found->second;
    if (lowered.functions[row] == nullptr) missing = name;
  }
  for (rt::FfiType& type : lowered.ffi_types) {
    type = std::string_view(type.name) == "Pair" ? rt::ffi_type_of<Pair>("Pair") : rt::ffi_type_of<Wide>("Wide");
  }
  return missing;
}

}  // namespace bip::gen
