// C structs of a GenoM 2 description, as far as messages of ROS 2 are made of them (compiler/ros2).
#pragma once
#include <vector>

#include "compiler/genom/module.hpp"
#include "compiler/genom/tokens.hpp"

namespace bip::genom {

/// Reads `struct TAG { … }` and `typedef struct { … } NAME`; names that `typedef` gives to plain types are replaced by
/// these, enumerations by int. What is written otherwise (pointers, bit fields, functions) is left out with its struct.
/// Nothing is reported. Linear.
[[nodiscard]] std::vector<CStruct> read_c_structs(const std::vector<Token>& tokens);

/// `NAME::PATH`, `NAME::all` with commas between them, as a poster's `data` has it. Empty if it is something else.
[[nodiscard]] std::vector<DataRef> read_data_refs(const std::vector<std::string>& words);

}  // namespace bip::genom
