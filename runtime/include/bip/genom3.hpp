// What C++ codels of GenoM 3 see of the run time: bounded strings and sequences, exceptions. Included by the headers
// that `bipc genom --codels` writes for components whose codels include `acNAME.hpp`.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "bip/genom3.h"

namespace genom {

/// `string<n>`: at most n bytes, without memory of its own. A longer text throws std::length_error.
template <std::size_t n>
class bounded_string {
 public:
  bounded_string() = default;
  bounded_string(const char* text) { assign(text); }
  bounded_string(std::string_view text) { assign(text); }
  bounded_string(const std::string& text) { assign(text); }
  void assign(std::string_view text) {
    if (text.size() > n) throw std::length_error("a text of more than " + std::to_string(n) + " bytes");
    std::memset(bytes_, 0, sizeof bytes_);
    if (!text.empty()) std::memcpy(bytes_, text.data(), text.size());
  }
  [[nodiscard]] const char* c_str() const { return bytes_; }
  [[nodiscard]] std::string_view view() const { return std::string_view(bytes_, ::strnlen(bytes_, n)); }
  [[nodiscard]] std::string str() const { return std::string(view()); }
  operator std::string() const { return str(); }
  [[nodiscard]] std::size_t size() const { return view().size(); }
  [[nodiscard]] std::size_t length() const { return size(); }
  [[nodiscard]] bool empty() const { return bytes_[0] == '\0'; }
  [[nodiscard]] static constexpr std::size_t max_size() { return n; }
  void clear() { std::memset(bytes_, 0, sizeof bytes_); }
  friend bool operator==(const bounded_string& a, const bounded_string& b) { return a.view() == b.view(); }
  friend bool operator!=(const bounded_string& a, const bounded_string& b) { return a.view() != b.view(); }
  friend bool operator<(const bounded_string& a, const bounded_string& b) { return a.view() < b.view(); }

 private:
  char bytes_[n + 1]{};
};

/// `sequence<T, n>`: at most n elements, without memory of its own. One more throws std::length_error.
template <class T, std::size_t n>
class bounded_vector {
 public:
  using value_type = T;
  using size_type = std::size_t;
  using iterator = T*;
  using const_iterator = const T*;
  bounded_vector() = default;
  explicit bounded_vector(std::size_t count, const T& v = T{}) { resize(count, v); }
  bounded_vector(std::initializer_list<T> list) { assign(list.begin(), list.end()); }
  template <class It, class = typename std::iterator_traits<It>::iterator_category>
  bounded_vector(It begin, It end) {
    assign(begin, end);
  }
  template <class It, class = typename std::iterator_traits<It>::iterator_category>
  void assign(It begin, It end) {
    clear();
    for (; begin != end; ++begin) push_back(*begin);
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] static constexpr std::size_t max_size() { return n; }
  [[nodiscard]] static constexpr std::size_t capacity() { return n; }
  void reserve(std::size_t count) const { check(count); }
  void resize(std::size_t count, const T& v = T{}) {
    check(count);
    for (std::size_t k = size_; k < count; ++k) items_[k] = v;
    for (std::size_t k = count; k < size_; ++k) items_[k] = T{};
    size_ = count;
  }
  void clear() { resize(0); }
  void push_back(T v) {
    check(size_ + 1);
    items_[size_++] = std::move(v);
  }
  template <class... Arguments>
  T& emplace_back(Arguments&&... arguments) {
    push_back(T(std::forward<Arguments>(arguments)...));
    return back();
  }
  void pop_back() { items_[--size_] = T{}; }
  T& operator[](std::size_t k) { return items_[k]; }
  const T& operator[](std::size_t k) const { return items_[k]; }
  T& at(std::size_t k) { return k < size_ ? items_[k] : throw std::out_of_range("genom::bounded_vector::at"); }
  const T& at(std::size_t k) const {
    return k < size_ ? items_[k] : throw std::out_of_range("genom::bounded_vector::at");
  }
  T& front() { return items_[0]; }
  const T& front() const { return items_[0]; }
  T& back() { return items_[size_ - 1]; }
  const T& back() const { return items_[size_ - 1]; }
  T* data() { return items_.data(); }
  const T* data() const { return items_.data(); }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  friend bool operator==(const bounded_vector& a, const bounded_vector& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }
  friend bool operator!=(const bounded_vector& a, const bounded_vector& b) { return !(a == b); }

 private:
  static void check(std::size_t count) {
    if (count > n) throw std::length_error("a sequence of more than " + std::to_string(n) + " elements");
  }
  std::array<T, n> items_{};
  std::size_t size_ = 0;
};

/// What the classes of a description's exceptions derive from. A codel throws one, or returns `genom::raise(e, self)`.
class exception : public std::exception {
 public:
  [[nodiscard]] virtual genom_event event() const noexcept = 0;
  /// Its details; null: it has none.
  [[nodiscard]] virtual const void* details() const noexcept { return nullptr; }
  [[nodiscard]] virtual std::unique_ptr<exception> copy() const = 0;
  [[nodiscard]] const char* what() const noexcept override { return event(); }
};

/// For `return` in a codel.
inline genom_event raise(const exception& e, genom_context self) { return self->raise_object(&e, self); }
/// The exception that was raised last, if it is an E; else null.
template <class E>
const decltype(E::detail)* raised(genom_context self) {
  genom_event event = genom_ok;
  const void* const details = self->raised(&event, self);
  return event != genom_ok && event == E().event() ? static_cast<const decltype(E::detail)*>(details) : nullptr;
}

}  // namespace genom
