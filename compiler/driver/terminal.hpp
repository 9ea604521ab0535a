// Shared by commands that visit states: limits for printed runs, units, unbuffered text for a terminal.
#pragma once
#include <cstdint>
#include <cstdio>
#include <string>

namespace bip::driver {

/// Longest run that a story prints step by step.
inline constexpr std::size_t kStepsShown = 100;
/// Bytes of a megabyte in options and output.
inline constexpr std::uint64_t kMega = 1000000;

/// Writes the text and flushes, so that it is there before the next long piece of work.
inline void write_now(std::FILE* file, const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), file);
  std::fflush(file);
}

}  // namespace bip::driver
