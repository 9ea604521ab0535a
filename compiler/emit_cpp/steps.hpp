// Step functions as C++ text.
#pragma once
#include <string>

#include "compiler/emit_cpp/writer.hpp"
#include "compiler/lower/lower.hpp"

namespace bip::emit_cpp {

/// Writes a function a shape of lowered.steps into `namespace steps`; after the units' functions. Nothing without shapes.
void emit_steps(const lower::LoweredSystem& lowered, Writer& out);
/// "steps::shape_3"
[[nodiscard]] std::string step_name(std::size_t shape);

}  // namespace bip::emit_cpp
