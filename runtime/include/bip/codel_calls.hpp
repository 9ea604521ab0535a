// What the C++ of `bipc genom --processes` tells of a level whose modules are processes (codel_processes.hpp), and
// calls between them as bytes. Header only.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "bip/codels.hpp"

namespace bip::processes {

// ---- what the generated code tells

/// One call: of a codel of `owner`, or of another function of a module (`owner` is -1).
struct Call {
  int owner = -1;
  int answer = 0, report = 0;
  std::string in{}, out{};
};
struct FunctionRow {
  const char* name = "";
  std::int64_t limit_ms = 0;  // a call that takes longer is ended with its process; 0: never
  void (*run)(Call& call) = nullptr;
  bool is_codel = false;
  // A control that went well is called again, with what it was called with, in a process that takes the place of its
  // module's.
  bool is_repeated = false;
};
struct ModuleRow {
  const char* name = "";
  bool needs_init = false;  // after a restart its activities fail until its `init` has run again
};
struct OwnerRow {
  int module = 0;
  bool is_task = false, is_init = false;
};
/// A codel that a process runs first if it is not the first one of its module.
struct StartRow {
  int function = 0, owner = 0;
};
/// A poster that a module writes, and others read.
struct PosterRow {
  int writer = 0;
  /// Appends what it holds, and returns the number of this value, which grows; 0: nothing was written yet.
  std::uint64_t (*pack)(std::string& out) = nullptr;
  /// The number of what it holds.
  std::uint64_t (*version)() = nullptr;
  /// Replaces what it holds; false if the bytes are none of such a value.
  bool (*unpack)(std::string_view in) = nullptr;
};
struct ReaderRow {
  int module = 0, poster = 0;
};
struct Description {
  std::span<const ModuleRow> modules;
  std::span<const CodelOwner> owners;
  std::span<const OwnerRow> owner_rows;
  std::span<const FunctionRow> functions;
  std::span<const StartRow> starts{};
  std::span<const PosterRow> posters{};
  std::span<const ReaderRow> readers{};
  std::int64_t memory_mb = 0;  // of a module's process, beside what it has at its beginning; 0: no limit
};

// ---- bytes

template <class T>
void append(std::string& out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}
inline void append_text(std::string& out, std::string_view text) {
  append(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}
/// Takes values from the front of bytes that another process wrote, which may be anything.
class Taker {
 public:
  explicit Taker(std::string_view bytes) : bytes_(bytes) {}
  template <class T>
  bool take(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (bytes_.size() < sizeof value) return false;
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_.remove_prefix(sizeof value);
    return true;
  }
  bool take_text(std::string_view& text) {
    std::uint32_t size = 0;
    if (!take(size) || bytes_.size() < size) return false;
    text = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return true;
  }
  bool take_bytes(void* to, std::size_t size) {
    if (bytes_.size() < size) return false;
    if (size != 0) std::memcpy(to, bytes_.data(), size);
    bytes_.remove_prefix(size);
    return true;
  }
  bool skip(std::size_t size) {
    if (bytes_.size() < size) return false;
    bytes_.remove_prefix(size);
    return true;
  }
  [[nodiscard]] std::string_view rest() const { return bytes_; }

 private:
  std::string_view bytes_;
};

// ---- functions of the codels' C++ that are called with texts

inline void give_two_texts(std::string_view bytes, void (*function)(const char* first, const char* second)) {
  Taker taker(bytes);
  std::string_view first, second;
  if (taker.take_text(first) && taker.take_text(second))
    function(std::string(first).c_str(), std::string(second).c_str());
}
/// Answers with nothing, or with a sign and the text.
inline void ask_poster(Call& call, const char* (*value_of)(const char* poster)) {
  Taker taker(call.in);
  std::string_view name;
  if (!taker.take_text(name)) return;
  if (const char* const value = value_of(std::string(name).c_str()); value != nullptr)
    call.out = std::string("=") + value;
}
/// What that answer says; the text lasts until the thread asks again.
inline const char* poster_of(const std::optional<std::string>& answer) {
  thread_local std::string text;
  if (!answer || answer->empty()) return nullptr;
  text = answer->substr(1);
  return text.c_str();
}

}  // namespace bip::processes
