// The image (image_tables.hpp) and the paths of its parts as texts.
#pragma once
#include <string>

#include "bip/assert.hpp"
#include "bip/ids.hpp"
#include "bip/image_tables.hpp"

namespace bip::rt {

/// `name`, with the index where `#` is, unless there is none.
[[nodiscard]] inline std::string path_text(const char* name, std::uint32_t index) {
  std::string path = name;
  BIP_ASSERT(index == kNone || path.find('#') != std::string::npos, "no place for the index {}", index);
  if (index != kNone) path.replace(path.find('#'), 1, std::to_string(index));
  return path;
}

inline std::string Atom::path() const { return path_text(name, index); }
inline std::string Connector::path() const { return path_text(name, index); }

}  // namespace bip::rt
