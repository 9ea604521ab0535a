// The FFI of a running model: strings that were made at run time, the last exception, objects of FFI types.
//
// Header only: the emitted program, the shared object of `bipc run` and the compiler all use it. Strings are rows;
// those of the image come first, C++ results are interned above them, so that equal texts stay equal rows. Several
// threads may call functions at a time; each sees the exception of its own last call.
#pragma once
#include <algorithm>
#include <cstdint>
#include <deque>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <vector>

#include "bip/image.hpp"

namespace bip::rt {

class FfiContext {
 public:
  FfiContext() = default;
  /// The first row of a string that is made at run time, unless the image's are as many: tests begin near the last row.
  explicit FfiContext(std::int32_t first) : next_(first) {}
  FfiContext(const FfiContext&) = delete;
  FfiContext& operator=(const FfiContext&) = delete;

  /// Takes over the image's strings; once, before anything is called.
  void attach(Span<const char*> strings) {
    if (is_attached_) return;
    is_attached_ = true;
    for (const char* text : strings) {
      const auto row = static_cast<std::int32_t>(texts_.size());
      rows_.try_emplace(texts_.emplace_back(text), row);
    }
    next_ = std::max(next_, static_cast<std::int32_t>(texts_.size()));
  }
  /// Takes over where the image's code calls C++; once, before anything is called.
  void name_sites(Span<Site> sites, Span<const char*> files) {
    if (!sites_.empty()) return;
    for (const Site& site : sites) {
      const bool is_known = site.loc.line != 0 && site.loc.file < files.size;
      sites_.push_back(is_known ? files[site.loc.file] + (':' + std::to_string(site.loc.line)) : std::string());
    }
  }
  /// "model.bip:14", where the call at this site is; empty if that is not known. Lives as long as this.
  [[nodiscard]] const char* site(std::uint32_t row) const { return row < sites_.size() ? sites_[row].c_str() : ""; }
  [[nodiscard]] const char* text(std::int32_t row) const {
    const std::lock_guard guard(lock_);
    if (row < static_cast<std::int32_t>(texts_.size())) return texts_[static_cast<std::size_t>(row)].c_str();
    const auto it = made_.find(row);
    return it != made_.end() ? it->second.text.c_str() : "";
  }
  [[nodiscard]] std::int32_t intern(std::string_view text) {
    const std::lock_guard guard(lock_);
    const auto it = rows_.find(text);
    return it != rows_.end() ? it->second : make(text);
  }
  /// A null pointer is the empty string.
  [[nodiscard]] std::int32_t intern(const char* text) { return intern(std::string_view(text == nullptr ? "" : text)); }
  /// Returns whether so many strings were made since the last keep_only() that looking for unused ones pays.
  [[nodiscard]] bool wants_collection() const {
    const std::lock_guard guard(lock_);
    return made_.size() >= enough_;
  }
  /// Frees the strings made at run time whose rows are not in `live`, which is sorted. A row is used again only when
  /// all rows behind it have been used, so that what compares old rows with new ones finds no false equality. Requires
  /// that no row exists outside of `live`.
  void keep_only(const std::vector<std::int32_t>& live) {
    const std::lock_guard guard(lock_);
    for (auto it = made_.begin(); it != made_.end();) {
      if (it->second.is_pinned || std::binary_search(live.begin(), live.end(), it->first)) {
        ++it;
        continue;
      }
      rows_.erase(it->second.text);
      it = made_.erase(it);
    }
    enough_ = std::max(kFewStrings, 2 * made_.size());
  }
  /// Keeps these strings for ever, if they are rows of strings made at run time: copies of states refer to them.
  void pin(const std::vector<std::int32_t>& rows) {
    const std::lock_guard guard(lock_);
    for (const std::int32_t row : rows) {
      const auto made = made_.find(row);
      if (made != made_.end()) made->second.is_pinned = true;
    }
  }
  /// What the exception that ended the last call said.
  [[nodiscard]] std::string message() const {
    const std::lock_guard guard(lock_);
    const auto it = messages_.find(std::this_thread::get_id());
    return it == messages_.end() ? std::string() : it->second;
  }
  void set_message(const char* message) {
    const std::lock_guard guard(lock_);
    messages_[std::this_thread::get_id()] = message;
  }

 private:
  static constexpr std::size_t kFewStrings = 4096;

  struct Made {
    std::string text;
    bool is_pinned = false;
  };

  // Requires fewer than 2^31 strings at a time, which memory does not hold.
  std::int32_t make(std::string_view text) {
    while (made_.count(next_) != 0) advance();
    const std::int32_t row = next_;
    advance();
    const auto made = made_.try_emplace(row, Made{std::string(text)}).first;
    rows_.try_emplace(made->second.text, row);
    return row;
  }
  void advance() {
    const bool is_last = next_ == std::numeric_limits<std::int32_t>::max();
    next_ = is_last ? static_cast<std::int32_t>(texts_.size()) : next_ + 1;
  }

  bool is_attached_ = false;
  std::vector<std::string> sites_;               // by row of Image::sites
  std::deque<std::string> texts_;                // of the image; never moves
  std::unordered_map<std::int32_t, Made> made_;  // at run time, by row; nodes never move
  std::int32_t next_ = 0;                        // the next row, if it is free
  std::size_t enough_ = kFewStrings;
  std::unordered_map<std::string_view, std::int32_t> rows_;
  std::unordered_map<std::thread::id, std::string> messages_;
  mutable std::mutex lock_;
};

/// A C++ function behind an adapter: 0, or 1 after an exception. An FFI result is assigned to the object that
/// `result` points to. Behind the arguments `args` has one cell more: the call's row of Image::sites, as an int.
using FfiFunction = std::int32_t (*)(FfiContext* ffi, Cell* result, Cell* const* args);

/// A string of a running model.
[[nodiscard]] inline const char* string_of(const Image& image, Cell row) {
  if (image.ffi != nullptr) return image.ffi->text(row.i);
  return image.strings.size == 0 ? "" : image.strings[static_cast<std::uint32_t>(row.i)];
}

template <class T>
[[nodiscard]] T& object_in(const Cell& cell) {
  return *reinterpret_cast<T*>(static_cast<std::uintptr_t>(cell.bits));
}
[[nodiscard]] inline Cell object_cell(void* object) { return Cell{.bits = reinterpret_cast<std::uintptr_t>(object)}; }

/// The row of a C++ type.
template <class T>
[[nodiscard]] constexpr FfiType ffi_type_of(const char* name) {
  FfiType type{name, []() -> void* { return new T(); },
               // In place: an object may be larger than the stack.
               [](void* object) {
                 std::destroy_at(static_cast<T*>(object));
                 std::construct_at(static_cast<T*>(object));
               },
               [](void* to, const void* from) { *static_cast<T*>(to) = *static_cast<const T*>(from); }, nullptr,
               [](void* object) { delete static_cast<T*>(object); }};
  if constexpr (requires(const T& value) { static_cast<bool>(value == value); }) {
    type.equal = [](const void* a, const void* b) {
      return static_cast<bool>(*static_cast<const T*>(a) == *static_cast<const T*>(b));
    };
  }
  return type;
}

}  // namespace bip::rt
