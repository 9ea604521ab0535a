// Traces that bipc wrote for other programs (MCAP, Perfetto), read back as the JSON lines of the same run. Values and
// places are not needed for that: the run is repeated on its model. Files of others are refused by name, and so is a
// part of a run.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "compiler/base/result.hpp"

namespace bip::traces {

[[nodiscard]] bool is_mcap(std::string_view bytes);
/// As `bipc run --trace-format=perfetto` writes it: one event a line.
[[nodiscard]] bool is_perfetto(std::string_view text);

/// Whether the model has time: without it the instants of these formats are numbers of steps.
enum class Instants : std::uint8_t { OfTheModel, OfNothing };

/// Returns head and steps as JSON lines, or why they cannot be read. Linear in the file; chunks may be compressed with
/// zstd.
[[nodiscard]] Result<std::string> lines_of_mcap(std::string_view bytes, Instants instants);
[[nodiscard]] Result<std::string> lines_of_perfetto(std::string_view text, Instants instants);

}  // namespace bip::traces
