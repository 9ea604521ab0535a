// Shared by commands that visit states: unbuffered text for a terminal.
#pragma once
#include <cstdio>
#include <string>

#include "compiler/pipeline/limits.hpp"

namespace bip::driver {

/// Writes the text and flushes, so that it is there before the next long piece of work.
inline void write_now(std::FILE* file, const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), file);
  std::fflush(file);
}

}  // namespace bip::driver
