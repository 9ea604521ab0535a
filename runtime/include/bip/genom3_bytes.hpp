// Values of GenoM 3 types as bytes, for posters between processes on one machine: the object itself, then what it
// points to. Header only.
#pragma once
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

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

/// All that a port holds, and its number.
template <class T>
std::uint64_t pack(Written<T>& written, std::string& out) {
  const std::lock_guard<std::mutex> hold(written.lock);
  processes::append(out, static_cast<std::uint32_t>(written.values.size()));
  for (auto& [id, value] : written.values) {
    processes::append_text(out, id);
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
    pack_parts(out, value);
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
    T value;
    if (!in.take_text(id) || !in.take_bytes(&value, sizeof value) || !unpack_parts(in, value)) return false;
    const auto [at, is_new] = written.values.try_emplace(std::string(id));
    if (!is_new) release(at->second);
    std::memcpy(static_cast<void*>(&at->second), &value, sizeof value);
  }
  return true;
}

}  // namespace bip::genom3
