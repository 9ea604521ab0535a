// Values of GenoM 3's types in C and C++: deep copies, and JSON. Header only.
//
// A struct has a function `genom_members(value, f)`, which calls f(name, member) for each member (of a union: for the
// discriminant, then for the member that it names), an enumeration `genom_enumerators(value)`; generated headers have
// them. Everything else is seen from the type's form: sequences have `_buffer`, optionals `_present`. Structs and
// unions of the C++ mapping have `genom_cxx_members` instead; nothing in a value is of both mappings.
#pragma once
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "bip/codels.hpp"
#include "bip/genom3.h"
#include "bip/genom3.hpp"
#include "bip/json_value.hpp"

namespace bip::genom3 {

using Json = bip::JsonValue;
using bip::JsonMember;
using bip::JsonReader;

// ---- forms of types

template <class T>
concept Sequence = requires(T& v) {
  v._buffer, v._length, v._maximum;
};
template <class T>
concept BoundedSequence = Sequence<T> && std::is_array_v<decltype(T::_buffer)>;
template <class T>
concept Optional = requires(T& v) {
  v._present, v._value;
};
template <class T>
concept Struct = requires(T& v) {
  genom_members(v, [](const char*, auto&) {});
};
/// A union of the C mapping: `genom_members` visits `_d`, then the member that it names.
template <class T>
concept Union = Struct<T> && requires(T& v) {
  v._d, v._u;
};
template <class T>
concept Enumeration = requires(T& v) {
  genom_enumerators(v);
};
/// A bounded string.
template <class T>
concept Text = std::is_array_v<T> && std::is_same_v < std::remove_extent_t<T>,
char > ;

// Of the C++ mapping.
template <class T>
concept CxxStruct = requires(T& v) {
  genom_cxx_members(v, [](const char*, auto&) {});
};
template <class T>
inline constexpr bool is_cxx_text = std::is_same_v<T, std::string>;
template <std::size_t n>
inline constexpr bool is_cxx_text<::genom::bounded_string<n>> = true;
template <class T>
inline constexpr bool is_cxx_sequence = false;
template <class T>
inline constexpr bool is_cxx_sequence<std::vector<T>> = true;
template <class T, std::size_t n>
inline constexpr bool is_cxx_sequence<::genom::bounded_vector<T, n>> = true;
template <class T>
inline constexpr bool is_cxx_array = false;
template <class T, std::size_t n>
inline constexpr bool is_cxx_array<std::array<T, n>> = true;
template <class T>
inline constexpr bool is_cxx_optional = false;
template <class T>
inline constexpr bool is_cxx_optional<std::optional<T>> = true;
template <class T>
concept CxxValue = CxxStruct<T> || is_cxx_text<T> || is_cxx_sequence<T> || is_cxx_array<T> || is_cxx_optional<T>;

/// Members of a struct or union of either mapping.
template <class T, class F>
void visit_members(T& v, F f) {
  if constexpr (CxxStruct<T>) genom_cxx_members(v, f);
  else genom_members(v, f);
}

/// All zero, and the bounds of sequences set.
template <class T>
void set_bounds(T& v) {
  if constexpr (BoundedSequence<T>) {
    v._maximum = sizeof v._buffer / sizeof v._buffer[0];
    for (auto& element : v._buffer) set_bounds(element);
  } else if constexpr (Optional<T>) {
    set_bounds(v._value);
  } else if constexpr (Struct<T>) {
    genom_members(v, [](const char*, auto& member) { set_bounds(member); });
  } else if constexpr (std::is_array_v<T> && !Text<T>) {
    for (auto& element : v) set_bounds(element);
  }
}
template <class T>
void clear(T& v) {
  if constexpr (is_cxx_text<T> || is_cxx_sequence<T>) {
    v.clear();
  } else if constexpr (is_cxx_optional<T>) {
    v.reset();
  } else if constexpr (is_cxx_array<T>) {
    for (auto& element : v) clear(element);
  } else if constexpr (CxxStruct<T>) {
    genom_cxx_members(v, [](const char*, auto& member) { clear(member); });
  } else {
    std::memset(static_cast<void*>(&v), 0, sizeof v);
    set_bounds(v);
  }
}

/// Calls f(part) for what is in v.
template <class T, class F>
void for_each_part(T& v, F f) {
  if constexpr (Sequence<T>) {
    for (uint32_t k = 0; k < v._length; ++k) f(v._buffer[k]);
  } else if constexpr (Optional<T>) {
    if (v._present) f(v._value);
  } else if constexpr (Struct<T> || CxxStruct<T>) {
    visit_members(v, [&](const char*, auto& member) { f(member); });
  } else if constexpr (is_cxx_optional<T>) {
    if (v) f(*v);
  } else if constexpr (std::is_same_v<T, std::vector<bool>>) {
    for (std::size_t k = 0; k < v.size(); ++k) {
      bool bit = v[k];
      f(bit);
      v[k] = bit;
    }
  } else if constexpr (is_cxx_sequence<T> || is_cxx_array<T> || (std::is_array_v<T> && !Text<T>)) {
    for (auto& element : v) f(element);
  }
}
/// Gives back the memory of strings and sequences.
template <class T>
void release(T& v) {
  if constexpr (!CxxValue<T>) for_each_part(v, [](auto& part) { release(part); });
  if constexpr (std::is_same_v<T, char*>) {
    std::free(v);
    v = nullptr;
  } else if constexpr (Sequence<T> && !BoundedSequence<T>) {
    if (v._release != nullptr) v._release(v._buffer);
    v = T{};
  }
}
/// After a copy byte by byte: makes what it points to its own.
template <class T>
void own(T& v) {
  if constexpr (std::is_same_v<T, char*>) {
    if (v != nullptr) v = ::strdup(v);
  } else if constexpr (Sequence<T> && !BoundedSequence<T>) {
    const T from = v;
    v = T{};
    if (genom_sequence_reserve(&v, from._length) != 0) throw std::bad_alloc();
    if (from._length != 0) std::memcpy(static_cast<void*>(v._buffer), from._buffer, from._length * sizeof *v._buffer);
    v._length = from._length;
  }
  for_each_part(v, [](auto& part) { own(part); });
}
/// A deep copy. Natives, which only codels know, stay shared.
template <class T>
void assign(T& to, const T& from) {
  if constexpr (CxxValue<T>) {
    to = from;
  } else {
    release(to);
    std::memcpy(static_cast<void*>(&to), &from, sizeof to);
    own(to);
  }
}

// ---- JSON

[[noreturn]] inline void refuse(const std::string& where, const std::string& what) {
  throw std::runtime_error("`" + where + "` " + what);
}

template <class T>
std::string number_text(T v) {
  char text[40];
  return {text, std::to_chars(text, text + sizeof text, v).ptr};
}

/// What is nearer to 0 than any number of the type is 0; what is beyond its numbers is refused.
template <class T>
void read_number(const Json& json, T& v, const std::string& where) {
  const char* const begin = json.text.data();
  const char* const end = begin + json.text.size();
  T value{};
  std::from_chars_result read{};
  if (json.kind == Json::Kind::Number) read = std::from_chars(begin, end, value);
  const bool is_number = json.kind == Json::Kind::Number && read.ptr == end;
  const std::string range =
      " from " + number_text(std::numeric_limits<T>::lowest()) + " to " + number_text(std::numeric_limits<T>::max());
  if constexpr (std::is_floating_point_v<T>) {
    if (!is_number) refuse(where, "is a number");
    long double wide = 0;
    if (read.ec != std::errc() && (std::from_chars(begin, end, wide).ec != std::errc() || std::fabs(wide) > 1))
      refuse(where, "is a number" + range);
  } else if (!is_number || read.ec != std::errc()) {
    refuse(where, "is a whole number" + range);
  }
  v = value;
}

/// Texts of C end at their first zero byte, so codels would get another text than rules. In C++ alike, for ports
/// connect both.
inline void refuse_zero_bytes(const Json& json, const std::string& where) {
  if (json.text.find('\0') != std::string::npos) refuse(where, "is a text without zero bytes");
}

template <class T>
void from_json(const Json& json, T& v, const std::string& where);

/// Makes the member of a union that `json` has the current one, empty, unless it is already: the bytes of another one
/// are no value of it.
template <Union T>
void choose_member(const Json& json, T& v, const std::string& where) {
  const Json* const given = json.kind == Json::Kind::Object ? json.find("_d")
                            : json.items.empty()            ? nullptr
                                                            : &json.items[0];
  if (given == nullptr) return;
  auto chosen = v._d;
  from_json(*given, chosen, where + "._d");
  if (chosen == v._d) return;
  release(v);
  std::memset(static_cast<void*>(&v._u), 0, sizeof v._u);
  v._d = chosen;
  set_bounds(v);
}

/// `v` is a value that may be written over; members that JSON does not have keep what is there.
template <class T>
void from_json(const Json& json, T& v, const std::string& where) {
  if constexpr (std::is_same_v<T, bool>) {
    if (json.kind != Json::Kind::Bool) refuse(where, "is true or false");
    v = json.is_true;
  } else if constexpr (Enumeration<T>) {
    const std::string name = json.text.substr(json.text.rfind(':') == std::string::npos ? 0 : json.text.rfind(':') + 1);
    std::string all;
    for (const auto& [enumerator, value] : genom_enumerators(v)) {
      if ((json.kind == Json::Kind::Text && name == enumerator) ||
          (json.kind == Json::Kind::Number && json.text == std::to_string(static_cast<int>(value)))) {
        v = value;
        return;
      }
      all.append(all.empty() ? "" : ", ").append(enumerator);
    }
    refuse(where, "is one of " + all);
  } else if constexpr (std::is_same_v<T, char>) {
    if (json.kind != Json::Kind::Text || json.text.size() != 1) refuse(where, "is a text of one character");
    v = json.text[0];
  } else if constexpr (std::is_arithmetic_v<T>) {
    read_number(json, v, where);
  } else if constexpr (std::is_same_v<T, char*>) {
    if (json.kind != Json::Kind::Text) refuse(where, "is a text");
    refuse_zero_bytes(json, where);
    std::free(v);
    v = ::strdup(json.text.c_str());
  } else if constexpr (is_cxx_text<T>) {
    if (json.kind != Json::Kind::Text) refuse(where, "is a text");
    if (json.text.size() > v.max_size())
      refuse(where, "is a text of at most " + std::to_string(v.max_size()) + " bytes");
    refuse_zero_bytes(json, where);
    v.assign(json.text);
  } else if constexpr (Text<T>) {
    if (json.kind != Json::Kind::Text || json.text.size() >= sizeof v)
      refuse(where, "is a text of at most " + std::to_string(sizeof v - 1) + " bytes");
    refuse_zero_bytes(json, where);
    std::memset(v, 0, sizeof v);
    std::memcpy(v, json.text.data(), json.text.size());
  } else if constexpr (is_cxx_sequence<T>) {
    if (json.kind != Json::Kind::Array) refuse(where, "is an array");
    if (json.items.size() > v.max_size()) refuse(where, "has at most " + std::to_string(v.max_size()) + " elements");
    v.resize(json.items.size());
    std::size_t k = 0;
    for_each_part(v, [&](auto& part) {
      from_json(json.items[k], part, where + "[" + std::to_string(k) + "]");
      ++k;
    });
  } else if constexpr (is_cxx_optional<T>) {
    if (json.kind == Json::Kind::Null) v.reset();
    else from_json(json, v ? *v : v.emplace(), where);
  } else if constexpr (std::is_array_v<T> || is_cxx_array<T>) {
    if (json.kind != Json::Kind::Array || json.items.size() != std::size(v))
      refuse(where, "is an array of " + std::to_string(std::size(v)));
    for (std::size_t k = 0; k < json.items.size(); ++k)
      from_json(json.items[k], v[k], where + "[" + std::to_string(k) + "]");
  } else if constexpr (Sequence<T>) {
    if (json.kind != Json::Kind::Array) refuse(where, "is an array");
    const auto length = static_cast<uint32_t>(json.items.size());
    if constexpr (BoundedSequence<T>) {
      if (length > v._maximum) refuse(where, "has at most " + std::to_string(v._maximum) + " elements");
    } else if (genom_sequence_reserve(&v, length) != 0) {
      throw std::bad_alloc();
    }
    for (uint32_t k = v._length; k < length; ++k) clear(v._buffer[k]);
    for (uint32_t k = length; k < v._length; ++k) release(v._buffer[k]);
    v._length = length;
    for (uint32_t k = 0; k < length; ++k) from_json(json.items[k], v._buffer[k], where + "[" + std::to_string(k) + "]");
  } else if constexpr (Optional<T>) {
    v._present = json.kind != Json::Kind::Null;
    if (v._present) from_json(json, v._value, where);
  } else if constexpr (Struct<T> || CxxStruct<T>) {
    if (json.kind != Json::Kind::Object && json.kind != Json::Kind::Array) refuse(where, "is an object");
    if constexpr (Union<T>) choose_member(json, v, where);
    std::size_t known = 0, k = 0;
    visit_members(v, [&](const char* name, auto& member) {
      const Json* const given = json.kind == Json::Kind::Object ? json.find(name)
                                : k < json.items.size()         ? &json.items[k]
                                                                : nullptr;
      ++k;
      if (given == nullptr) return;
      ++known;
      from_json(*given, member, where + "." + name);
    });
    if (known == json.members.size() + json.items.size()) return;
    for (const JsonMember& given : json.members) {
      bool is_member = false;
      visit_members(v, [&](const char* member, auto&) { is_member = is_member || given.name == member; });
      if (!is_member) refuse(where, "has no member `" + given.name + "`");
    }
    refuse(where, "has too many values");
  } else {
    refuse(where, "cannot be given");
  }
}

template <class T>
void to_json(std::string& out, const T& v) {
  T& value = const_cast<T&>(v);  // members are visited to be written, too
  const auto list = [&](const char* begin, const char* end, auto each) {
    out += begin;
    bool is_first = true;
    each([&](const auto& write) {
      if (!std::exchange(is_first, false)) out += ",";
      write();
    });
    out += end;
  };
  if constexpr (std::is_same_v<T, bool>) {
    out += v ? "true" : "false";
  } else if constexpr (Enumeration<T>) {
    for (const auto& [name, enumerator] : genom_enumerators(value)) {
      if (enumerator == v) return void(out += json_text(name));
    }
    out += std::to_string(static_cast<int>(v));
  } else if constexpr (std::is_same_v<T, char>) {
    out += json_text(std::string_view(&v, v == '\0' ? 0 : 1));
  } else if constexpr (std::is_arithmetic_v<T>) {
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(v)) return void(out += "null");
    }
    out += number_text(v);
  } else if constexpr (std::is_same_v<T, char*>) {
    out += json_text(v == nullptr ? "" : v);
  } else if constexpr (Text<T>) {
    out += json_text(std::string_view(v, ::strnlen(v, sizeof v)));
  } else if constexpr (is_cxx_text<T>) {
    out += json_text(std::string_view(v.c_str(), v.size()));
  } else if constexpr (Optional<T>) {
    if (v._present) to_json(out, v._value);
    else out += "null";
  } else if constexpr (is_cxx_optional<T>) {
    if (v) to_json(out, *v);
    else out += "null";
  } else if constexpr (Struct<T> || CxxStruct<T>) {
    list("{", "}", [&](auto add) {
      visit_members(value, [&](const char* name, auto& member) {
        add([&] {
          out += json_text(name) + ":";
          to_json(out, member);
        });
      });
    });
  } else if constexpr (Sequence<T> || is_cxx_sequence<T> || is_cxx_array<T> || std::is_array_v<T>) {
    list("[", "]", [&](auto add) { for_each_part(value, [&](auto& part) { add([&] { to_json(out, part); }); }); });
  } else {
    out += "null";
  }
}

}  // namespace bip::genom3
