// Values of GenoM 3 types as bytes, for posters between processes on one machine. Header only.
//
// Of the C mapping: the object itself, then what it points to. Of the C++ mapping, and between the two: part by part,
// the same bytes for both (`put`, `take`).
#pragma once
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "bip/codel_calls.hpp"
#include "bip/genom3_codels.hpp"

namespace bip::genom3 {

inline constexpr std::uint32_t kNoText = UINT32_MAX;

template <class T>
void pack_parts(std::string& out, T& v) {
  if constexpr (std::is_same_v<T, char*>) {
    if (v == nullptr) processes::append(out, kNoText);
    else processes::append_text(out, v);
  } else {
    if constexpr (Sequence<T> && !BoundedSequence<T>) {
      if (v._length != 0) out.append(reinterpret_cast<const char*>(v._buffer), v._length * sizeof *v._buffer);
    }
    for_each_part(v, [&](auto& part) { pack_parts(out, part); });
  }
}

// `v` has the bytes of the object, whose pointers mean nothing here.
template <class T>
bool unpack_parts(processes::Taker& in, T& v) {
  bool is_sound = true;
  if constexpr (std::is_same_v<T, char*>) {
    v = nullptr;
    std::uint32_t size = 0;
    if (!in.take(size)) return false;
    if (size == kNoText) return true;
    if (size > in.rest().size()) return false;
    v = ::strndup(in.rest().data(), size);
    return in.skip(size);
  } else if constexpr (std::is_pointer_v<T>) {
    v = nullptr;  // a native is its component's own
  } else if constexpr (BoundedSequence<T>) {
    v._maximum = sizeof v._buffer / sizeof v._buffer[0];
    if (v._length > v._maximum) return false;
  } else if constexpr (Sequence<T>) {
    const std::uint32_t length = v._length;
    v = T{};
    if (length > in.rest().size() / sizeof *v._buffer || genom_sequence_reserve(&v, length) != 0) return false;
    is_sound = in.take_bytes(v._buffer, length * sizeof *v._buffer);
    v._length = length;
  }
  if constexpr (!std::is_pointer_v<T>)
    for_each_part(v, [&](auto& part) { is_sound = is_sound && unpack_parts(in, part); });
  return is_sound;
}

// ---- part by part

template <class T>
inline constexpr bool is_text = is_cxx_text<T> || Text<T> || std::is_same_v<T, char*>;
// One element after the other in memory.
template <class T>
inline constexpr bool is_block = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

template <class T>
std::string_view text_of(const T& v) {
  if constexpr (is_cxx_text<T>) return {v.c_str(), v.size()};
  else if constexpr (Text<T>) return {v, ::strnlen(v, sizeof v)};
  else return v == nullptr ? "" : v;
}
template <class T>
void put(std::string& out, T& v) {
  const auto elements = [&](auto* first, std::size_t count) {
    processes::append(out, static_cast<std::uint32_t>(count));
    if constexpr (is_block<std::remove_reference_t<decltype(*first)>>) {
      if (count != 0) out.append(reinterpret_cast<const char*>(first), count * sizeof *first);
    } else {
      for (std::size_t k = 0; k < count; ++k) put(out, first[k]);
    }
  };
  if constexpr (is_text<T>) processes::append_text(out, text_of(v));
  else if constexpr (std::is_enum_v<T>) processes::append(out, static_cast<std::int64_t>(v));
  else if constexpr (std::is_arithmetic_v<T>) processes::append(out, v);
  else if constexpr (Sequence<T>) elements(v._buffer, v._length);
  else if constexpr (std::is_same_v<T, std::vector<bool>>) {
    processes::append(out, static_cast<std::uint32_t>(v.size()));
    for_each_part(v, [&](auto& part) { put(out, part); });
  } else if constexpr (is_cxx_sequence<T> || is_cxx_array<T>) elements(v.data(), v.size());
  else if constexpr (std::is_array_v<T>) elements(&v[0], std::extent_v<T>);
  else if constexpr (Optional<T> || is_cxx_optional<T>) {
    bool is_present = false;
    for_each_part(v, [&](auto&) { is_present = true; });
    processes::append(out, is_present);
    for_each_part(v, [&](auto& part) { put(out, part); });
  } else if constexpr (Struct<T> || CxxStruct<T>)
    visit_members(v, [&](const char*, auto& member) { put(out, member); });
}
// `v` is a value that may be written over. A native stays what it is.
template <class T>
bool take(processes::Taker& in, T& v) {
  const auto take_bool = [&](bool& flag) {
    std::uint8_t byte = 0;
    if (!in.take(byte)) return false;
    flag = byte != 0;
    return true;
  };
  const auto elements = [&](auto* first, std::size_t count) {
    using Element = std::remove_reference_t<decltype(*first)>;
    if constexpr (is_block<Element>) return in.take_bytes(first, count * sizeof(Element));
    bool is_sound = true;
    for (std::size_t k = 0; is_sound && k < count; ++k) is_sound = take(in, first[k]);
    return is_sound;
  };
  // Bounds what damaged bytes can claim.
  const auto count_of = [&](std::size_t most, std::uint32_t& count) {
    return in.take(count) && count <= most && count <= in.rest().size();
  };
  std::uint32_t count = 0;
  if constexpr (is_text<T>) {
    std::string_view text;
    if (!in.take_text(text)) return false;
    if constexpr (is_cxx_text<T>) {
      if (text.size() > v.max_size()) return false;
      v.assign(text);
    } else if constexpr (Text<T>) {
      if (text.size() >= sizeof v) return false;
      std::memset(v, 0, sizeof v);
      std::memcpy(v, text.data(), text.size());
    } else {
      std::free(v);
      v = ::strndup(text.data(), text.size());
    }
    return true;
  } else if constexpr (std::is_enum_v<T>) {
    std::int64_t value = 0;
    if (!in.take(value)) return false;
    v = static_cast<T>(value);
    return true;
  } else if constexpr (std::is_same_v<T, bool>) {
    return take_bool(v);
  } else if constexpr (std::is_arithmetic_v<T>) {
    return in.take(v);
  } else if constexpr (Sequence<T>) {
    if constexpr (BoundedSequence<T>) {
      if (!count_of(sizeof v._buffer / sizeof v._buffer[0], count)) return false;
    } else if (!count_of(UINT32_MAX, count) || genom_sequence_reserve(&v, count) != 0) {
      return false;
    }
    for (std::uint32_t k = v._length; k < count; ++k) clear(v._buffer[k]);
    for (std::uint32_t k = count; k < v._length; ++k) release(v._buffer[k]);
    v._length = count;
    return elements(v._buffer, count);
  } else if constexpr (std::is_same_v<T, std::vector<bool>>) {
    if (!count_of(UINT32_MAX, count)) return false;
    v.resize(count);
    bool is_sound = true;
    for_each_part(v, [&](auto& part) { is_sound = is_sound && take(in, part); });
    return is_sound;
  } else if constexpr (is_cxx_sequence<T>) {
    if (!count_of(v.max_size(), count)) return false;
    v.resize(count);
    return elements(v.data(), count);
  } else if constexpr (is_cxx_array<T> || std::is_array_v<T>) {
    return in.take(count) && count == std::size(v) && elements(&v[0], count);
  } else if constexpr (Optional<T>) {
    return take_bool(v._present) && (!v._present || take(in, v._value));
  } else if constexpr (is_cxx_optional<T>) {
    bool is_present = false;
    if (!take_bool(is_present)) return false;
    if (is_present) return take(in, v ? *v : v.emplace());
    v.reset();
    return true;
  } else if constexpr (Struct<T> || CxxStruct<T>) {
    bool is_sound = true;
    visit_members(v, [&](const char*, auto& member) { is_sound = is_sound && take(in, member); });
    return is_sound;
  } else {
    return true;
  }
}

/// From a port of one mapping to one of the other.
template <class From, class To>
bool fetch_converted(Written<From>& written, std::string_view id, To& into) {
  std::string bytes;
  {
    const std::lock_guard<std::mutex> hold(written.lock);
    const auto found = written.values.find(id);
    if (found == written.values.end()) return false;
    put(bytes, found->second);
  }
  processes::Taker taker(bytes);
  return take(taker, into);
}

/// All that a port holds, and its number.
template <class T>
std::uint64_t pack(Written<T>& written, std::string& out) {
  const std::lock_guard<std::mutex> hold(written.lock);
  processes::append(out, static_cast<std::uint32_t>(written.values.size()));
  for (auto& [id, value] : written.values) {
    processes::append_text(out, id);
    if constexpr (CxxValue<T>) {
      put(out, value);
    } else {
      out.append(reinterpret_cast<const char*>(&value), sizeof value);
      pack_parts(out, value);
    }
  }
  return written.version;
}
/// False: the bytes are none. What was unpacked before stays.
template <class T>
bool unpack(Written<T>& written, std::string_view bytes) {
  processes::Taker in(bytes);
  const std::lock_guard<std::mutex> hold(written.lock);
  ++written.version;
  std::uint32_t count = 0;
  if (!in.take(count)) return false;
  for (; count > 0; --count) {
    std::string_view id;
    T value{};
    if (!in.take_text(id)) return false;
    if constexpr (CxxValue<T>) {
      if (!take(in, value)) return false;
      written.values.insert_or_assign(std::string(id), std::move(value));
    } else {
      if (!in.take_bytes(&value, sizeof value) || !unpack_parts(in, value)) return false;
      const auto [at, is_new] = written.values.try_emplace(std::string(id));
      if (!is_new) release(at->second);
      std::memcpy(static_cast<void*>(&at->second), &value, sizeof value);
    }
  }
  return true;
}

}  // namespace bip::genom3
