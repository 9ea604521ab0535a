// See file_conflict.hpp.
#include "runtime/engine/file_conflict.hpp"

#include <filesystem>
#include <system_error>

namespace bip::rt {

namespace {

// What is there and no regular file (a device, a pipe, a folder) loses nothing by being written.
bool is_one_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::exists(a, error)) return fs::is_regular_file(a, error) && fs::equivalent(a, b, error) && !error;
  if (fs::exists(b, error)) return false;
  const fs::path first = fs::weakly_canonical(fs::absolute(a, error), error);
  return !first.empty() && first == fs::weakly_canonical(fs::absolute(b, error), error);
}

}  // namespace

std::string file_conflict(const std::vector<NamedFile>& files) {
  for (const NamedFile& output : files) {
    if (output.use == FileUse::Input) continue;
    for (const NamedFile& other : files) {
      const bool is_input = other.use == FileUse::Input;
      if (other.option == output.option || (is_input && output.use == FileUse::Updated)) continue;
      if (!is_one_file(output.path, other.path)) continue;
      return is_input ? output.option + " would overwrite the file of " + other.option + ", `" + other.path + '`'
                      : output.option + " and " + other.option + " name the same file";
    }
  }
  return {};
}

}  // namespace bip::rt
