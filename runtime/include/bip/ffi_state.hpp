// What a running model keeps of the C++ that it calls: strings that were made at run time, the last exceptions, where
// the calls are. Header only: emitted programs and the compiler make one each.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <deque>
#include <limits>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <vector>

#include "bip/ffi.hpp"

namespace bip::rt {

/// Strings are rows: those of the image come first, C++ results are interned above them, so that equal texts stay equal
/// rows. Several threads may call functions at a time; each sees the exception of its own last call.
class FfiState final : public FfiContext {
 public:
  using FfiContext::intern;

  FfiState() = default;
  /// The first row of a string that is made at run time, unless the image's are as many: tests begin near the last row.
  explicit FfiState(std::int32_t first) : next_(first) {}

  void attach(Span<const char*> strings) override {
    if (is_attached_) return;
    is_attached_ = true;
    rows_.reserve(strings.size);
    for (const char* text : strings) {
      const auto row = static_cast<std::int32_t>(texts_.size());
      rows_.try_emplace(texts_.emplace_back(text), row);
    }
    next_ = std::max(next_, static_cast<std::int32_t>(texts_.size()));
  }
  void name_sites(Span<Site> sites, Span<const char*> files) override {
    if (!sites_.empty()) return;
    for (const Site& site : sites) {
      const bool is_known = site.loc.line != 0 && site.loc.file < files.size;
      sites_.push_back(is_known ? files[site.loc.file] + (':' + std::to_string(site.loc.line)) : std::string());
    }
  }
  [[nodiscard]] const char* site(std::uint32_t row) const override {
    return row < sites_.size() ? sites_[row].c_str() : "";
  }
  [[nodiscard]] const char* text(std::int32_t row) const override {
    const std::lock_guard guard(lock_);
    if (row < static_cast<std::int32_t>(texts_.size())) return texts_[static_cast<std::size_t>(row)].c_str();
    const auto it = made_.find(row);
    return it != made_.end() ? it->second.text.c_str() : "";
  }
  [[nodiscard]] std::int32_t intern(std::string_view text) override {
    const std::lock_guard guard(lock_);
    const auto it = rows_.find(text);
    return it != rows_.end() ? it->second : make(text);
  }
  [[nodiscard]] bool wants_collection() const override { return wants_collection_.load(std::memory_order_relaxed); }
  void keep_only(Span<std::int32_t> live) override {
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
    wants_collection_.store(false, std::memory_order_relaxed);
  }
  void pin(Span<std::int32_t> rows) override {
    const std::lock_guard guard(lock_);
    for (const std::int32_t row : rows) {
      const auto made = made_.find(row);
      if (made != made_.end()) made->second.is_pinned = true;
    }
  }
  [[nodiscard]] std::string message() const override {
    const std::lock_guard guard(lock_);
    const auto it = messages_.find(std::this_thread::get_id());
    return it == messages_.end() ? std::string() : it->second;
  }
  void set_message(const char* message) override {
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
    if (made_.size() >= enough_) wants_collection_.store(true, std::memory_order_relaxed);
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
  std::atomic<bool> wants_collection_ = false;  // is asked after each step, without the lock
  std::unordered_map<std::string_view, std::int32_t> rows_;
  std::unordered_map<std::thread::id, std::string> messages_;
  mutable std::mutex lock_;
};

}  // namespace bip::rt
