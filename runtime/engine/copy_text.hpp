// Texts of the C interfaces (bip.h, bip/compiler.h).
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>

namespace bip::rt {

/// Copies the text into a C caller's buffer of `size` bytes, truncated and with a zero byte. Returns the length of the
/// whole text; a null buffer or size 0 copies nothing.
inline std::size_t copy_text(const std::string& text, char* buffer, std::size_t size) {
  if (buffer != nullptr && size != 0) {
    const std::size_t length = std::min(size - 1, text.size());
    std::memcpy(buffer, text.data(), length);
    buffer[length] = '\0';
  }
  return text.size();
}

}  // namespace bip::rt
