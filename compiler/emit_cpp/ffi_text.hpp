// Emits the FFI of a system: one wrapper per function of the code table, with native parameters, so that C++ resolves
// overloads, conversions and exceptions in one place.
//
// It has two users: the emitted program calls the wrappers by name; the shared object of `bipc run` adds adapters
// (rt::FfiFunction) around them.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "compiler/system/system_ids.hpp"

namespace bip::emit_cpp {

/// How C++ calls the types and functions of a code table. All of it is in namespace `ffi`.
class FfiNames {
 public:
  explicit FfiNames(const CodeTable& code);
  /// "std::int32_t", "bool", "double", "ffi::List_type"; strings are rows.
  [[nodiscard]] std::string type(Type type) const;
  /// "ffi::call_push_back", "draws::uniform"
  [[nodiscard]] const std::string& function(std::size_t row) const { return functions_[row]; }
  [[nodiscard]] static bool is_needed(const CodeTable& code) { return code.has_cpp(); }

 private:
  std::vector<std::string> types_, functions_;
};

/// `name` of C++ functions that have a `const_name` for places where nothing may change.
using ConstNames = std::set<std::string>;

/// #includes for ffi_text, the C++ files' too.
[[nodiscard]] std::string ffi_includes(const CodeTable& code);

/// Namespace `ffi`. With `own_context` the strings and messages are kept there, else a
/// pointer must be set before a call. `mark`: what a compiler says about function k names the file "bip-prototype-k",
/// about FFI type k "bip-type-k".
struct FfiTextOptions {
  bool own_context = true;
  bool mark = false;
  bool names_crashes = false;        // a signal in C++ says in which function
  std::vector<std::string> files{};  // rows of Loc::file
};
[[nodiscard]] std::string ffi_text(const CodeTable& code, const ConstNames& const_names, const FfiTextOptions& options);

/// Namespace `draws`: the distributions that the code draws from, by FfiNames' names. Needs bip/draws.hpp.
[[nodiscard]] std::string draws_text(const CodeTable& code);

/// What `bipc serve` finds in the model's C++ to watch it: exports `bip_called_now`, `bip_set_crash_hook`. Of models
/// that call C++.
[[nodiscard]] std::string watch_text();

/// The source of the shared object: exports `bip_call_<row>`, and `bip_ffi_types` and `bip_event_classes` if there
/// are any.
[[nodiscard]] std::string shim_text(const System& system, const ConstNames& const_names);

/// "int min(int, int)" of a row, for messages.
[[nodiscard]] std::string signature_text(const CodeTable& code, const Function& function);

}  // namespace bip::emit_cpp
