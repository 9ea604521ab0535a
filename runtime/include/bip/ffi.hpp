// The FFI of a running model, as the C++ sees it that is called: strings, the last exception, objects of FFI types.
//
// Header only: the emitted program, the shared object of `bipc run` and the compiler all use it.
#pragma once
#include <cstdint>
#include <new>
#include <string>
#include <string_view>

#include "bip/image.hpp"

namespace bip::rt {

/// What a running model and the C++ that it calls share; FfiState (ffi_state.hpp) is the one that the engine uses. An
/// interface, since the shared object of `bipc run` is compiled for each model: it includes no container and no lock.
class FfiContext {
 public:
  FfiContext() = default;
  FfiContext(const FfiContext&) = delete;
  FfiContext& operator=(const FfiContext&) = delete;

  /// Takes over the image's strings; once, before anything is called.
  virtual void attach(Span<const char*> strings) = 0;
  /// Takes over where the image's code calls C++; once, before anything is called.
  virtual void name_sites(Span<Site> sites, Span<const char*> files) = 0;
  /// "model.bip:14", where the call at this site is; empty if that is not known. Lives as long as this.
  [[nodiscard]] virtual const char* site(std::uint32_t row) const = 0;
  /// The string of the row, as long as the row is used; empty if there is none.
  [[nodiscard]] virtual const char* text(std::int32_t row) const = 0;
  /// The row of the string, which is copied if it is new.
  [[nodiscard]] virtual std::int32_t intern(std::string_view text) = 0;
  /// A null pointer is the empty string.
  [[nodiscard]] std::int32_t intern(const char* text) { return intern(std::string_view(text == nullptr ? "" : text)); }
  /// Returns whether so many strings were made since the last keep_only() that looking for unused ones pays.
  [[nodiscard]] virtual bool wants_collection() const = 0;
  /// Frees the strings made at run time whose rows are not in `live`, which is sorted. A row is used again only when
  /// all rows behind it have been used, so that what compares old rows with new ones finds no false equality. Requires
  /// that no row exists outside of `live`.
  virtual void keep_only(Span<std::int32_t> live) = 0;
  /// Keeps these strings for ever, if they are rows of strings made at run time: copies of states refer to them.
  virtual void pin(Span<std::int32_t> rows) = 0;
  /// What the exception that ended the calling thread's last call said.
  [[nodiscard]] virtual std::string message() const = 0;
  virtual void set_message(const char* message) = 0;

 protected:
  ~FfiContext() = default;
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
                 static_cast<T*>(object)->~T();
                 new (object) T();
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
