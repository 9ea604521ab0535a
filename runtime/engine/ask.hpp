// Interactive runs: a person, or a script in a person's place, chooses.
#pragma once
#include <cstdint>
#include <cstdio>

namespace bip::rt {

/// Reads lines until one holds a number below `count`. A line that does not is answered on `out`; a prompt is written
/// only if `in` is a terminal. False at the end of input, or for `q`.
[[nodiscard]] bool ask_candidate(std::FILE* in, std::FILE* out, std::uint64_t count, std::uint64_t& k);

}  // namespace bip::rt
