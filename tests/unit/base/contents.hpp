// What was written to a temporary file. For tests of what prints to a FILE.
#pragma once
#include <cstdio>
#include <string>

namespace bip::testing {

/// All of it, from the beginning; closes the file.
inline std::string contents(std::FILE* file) {
  std::string text;
  std::rewind(file);
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) text += static_cast<char>(c);
  std::fclose(file);
  return text;
}

}  // namespace bip::testing
