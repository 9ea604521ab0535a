// Emits the C++ classes behind event ports: their names, their getters, and their rows of Image::event_classes.
#pragma once
#include <string>
#include <vector>

#include "compiler/lower/event_classes.hpp"

namespace bip::emit_cpp {

/// In namespace `ffi`, after ffi_text. `mark`: what a compiler says about use k names the file "bip-class-k".
[[nodiscard]] std::string event_class_text(const System& system, const std::vector<lower::EventClassUse>& uses,
                                           bool mark);
/// The initializer of row k.
[[nodiscard]] std::string event_class_row(const System& system, const std::vector<lower::EventClassUse>& uses,
                                          std::size_t k);

}  // namespace bip::emit_cpp
