// Assertions for our own bugs; a user's input never reaches one. Shared by the compiler and the runtime; needs no
// library.
//
// BIP_ASSERT(condition, "text {}", value...) is a contract that is checked in the presets `debug` and `checked`
// (BIP_CHECKED) and costs nothing elsewhere: the condition is compiled, not evaluated. BIP_ENSURE(condition, ...) is
// always checked: for what is cheap and must not go wrong silently. BIP_UNREACHABLE(text) marks code that no input
// reaches. A failure prints the condition, the text with its values and the place, then ends the process with code 70.
#pragma once
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <type_traits>

#include "contract.hpp"  // beside this file: the compiler has no other path to it

namespace bip {

/// Prints what was being done when an assertion failed, or is null. The compiler sets it (compiler/base/assert.cpp).
inline void (*assertion_context)() = nullptr;

namespace assertions {

inline void append(std::string& out, std::string_view text) { out += text; }
inline void append(std::string& out, const char* text) { out += text; }
inline void append(std::string& out, bool value) { out += value ? "true" : "false"; }
template <class T>
requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) void append(std::string& out, T value) {
  if constexpr (std::is_enum_v<T>) out += std::to_string(static_cast<std::underlying_type_t<T>>(value));
  else out += std::to_string(value);
}
template <class T>
void append(std::string& out, const T& row) requires requires {
  row.value;
}
{ append(out, row.value); }

/// Returns the text; each "{}" in it stands for the next argument.
template <class... Arguments>
std::string text_of(std::string_view format, const Arguments&... arguments) {
  std::string out;
  [[maybe_unused]] const auto put = [&](const auto& argument) {
    const std::size_t place = format.find("{}");
    out += format.substr(0, place);
    format.remove_prefix(place == std::string_view::npos ? format.size() : place + 2);
    append(out, argument);
  };
  (put(arguments), ...);
  return out += format;
}
inline std::string text_of() { return {}; }

/// Returns the path from the repository's folder on: the rest is the machine that built the program.
inline const char* short_path(const char* file) {
  const std::string_view path(file);
  for (const char* folder : {"/compiler/", "/runtime/", "/tests/", "/tools/"}) {
    if (const std::size_t place = path.rfind(folder); place != std::string_view::npos) return file + place + 1;
  }
  return file;
}

/// Ends the process with code 70. Uses fprintf and _Exit: after a broken contract nothing heavier can be trusted.
[[noreturn]] inline void fail(const char* condition, const char* file, int line, const std::string& text) {
  std::fprintf(stderr, "bipc: internal error: %s%s%s (%s:%d)\n", condition, text.empty() ? "" : ": ", text.c_str(),
               short_path(file), line);
  if (assertion_context != nullptr) assertion_context();
  std::fprintf(stderr, "this is a bug of bipc, not of your model: please report it with the input\n");
  std::fflush(nullptr);
  std::_Exit(70);
}

}  // namespace assertions
}  // namespace bip

#define BIP_ENSURE(condition, ...)                                                                      \
  do {                                                                                                  \
    if (!(condition))                                                                                   \
      ::bip::assertions::fail(#condition, __FILE__, __LINE__, ::bip::assertions::text_of(__VA_ARGS__)); \
  } while (false)
#define BIP_UNREACHABLE(text) ::bip::assertions::fail(text, __FILE__, __LINE__, {})

#ifdef BIP_CHECKED
#define BIP_ASSERT(condition, ...) BIP_ENSURE(condition, __VA_ARGS__)
#endif
