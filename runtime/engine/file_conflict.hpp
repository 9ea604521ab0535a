// Files that the options of a command name: is one that would be written also another one of them?
#pragma once
#include <string>
#include <vector>

namespace bip::rt {

/// Updated: written, and it may take the place of an input.
enum class FileUse : unsigned char { Input, Output, Updated };

struct NamedFile {
  std::string option;  // as a person writes it
  std::string path;    // not empty
  FileUse use = FileUse::Input;
};

/// Returns a sentence about an output that is also an input or another output, by whatever links; empty: there is none.
/// Devices and pipes may be both. Files of one option are not compared.
[[nodiscard]] std::string file_conflict(const std::vector<NamedFile>& files);

}  // namespace bip::rt
