// Emits the C++ classes behind event ports: their names, their getters, and their rows of Image::event_classes.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/lower/event_classes.hpp"

namespace bip::emit_cpp {

/// Whether what a compiler says about use k names the file "bip-class-k".
enum class LineMarks : std::uint8_t { None, OfUses };
/// Returns the classes in namespace `ffi`; they come after ffi_text.
[[nodiscard]] std::string event_class_text(const System& system, const std::vector<lower::EventClassUse>& uses,
                                           LineMarks marks);
/// The initializer of row k.
[[nodiscard]] std::string event_class_row(const System& system, const std::vector<lower::EventClassUse>& uses,
                                          std::size_t k);

}  // namespace bip::emit_cpp
