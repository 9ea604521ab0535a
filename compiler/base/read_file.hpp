// The bytes of a file.
#pragma once
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "compiler/base/out_of_memory.hpp"

namespace bip {

/// Nothing: it cannot be opened, is a folder, or an error ended reading; errno says which. Throws std::bad_alloc.
[[nodiscard]] inline std::optional<std::string> read_file(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(path.c_str(), "rbe"), std::fclose);
  if (in == nullptr) {
    if (errno == ENOMEM) throw_out_of_memory();
    return std::nullopt;
  }
  std::string text;
  char piece[1 << 14];
  while (const std::size_t got = std::fread(piece, 1, sizeof piece, in.get())) text.append(piece, got);
  if (std::ferror(in.get()) != 0) return std::nullopt;
  return text;
}

}  // namespace bip
