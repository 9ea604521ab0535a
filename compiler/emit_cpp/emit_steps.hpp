// Emits step functions as C++ text.
#pragma once
#include <string>

#include "compiler/emit_cpp/writer.hpp"
#include "compiler/lower/lower.hpp"

namespace bip::emit_cpp {

/// Writes a function a shape of lowered.steps into `namespace steps`; after the units' functions. Nothing without
/// shapes.
void emit_steps(const lower::LoweredSystem& lowered, CppWriter& out);
/// Writes a function that takes many steps (bip/step_loop.hpp) with the operands in that array, if the
/// steps have a loop. Was it written?
bool emit_step_loop(const lower::LoweredSystem& lowered, const std::string& name, const std::string& operands,
                    CppWriter& out);
/// "steps::shape_3"
[[nodiscard]] std::string step_name(std::size_t shape);

}  // namespace bip::emit_cpp
