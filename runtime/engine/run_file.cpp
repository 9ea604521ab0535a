// See run_file.hpp.
#include "runtime/engine/run_file.hpp"

#include <cerrno>
#include <cstring>

#include "bip/assert.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

bool RunFile::open() {
  if (path_.empty()) return true;
  file_ = std::fopen(path_.c_str(), "wbe");
  if (file_ == nullptr) {
    std::fprintf(err_, "error: cannot write `%s`: %s\n", printable(path_).c_str(), std::strerror(errno));
    return false;
  }
  // Writers have their own, larger buffers.
  std::setvbuf(file_, nullptr, _IONBF, 0);
  return true;
}

void RunFile::write(std::string_view text) {
  BIP_ASSERT(is_open(), "`{}` is not open", path_);
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size() && error_ == 0) error_ = errno;
}

bool RunFile::close() {
  if (file_ == nullptr) return true;
  if (std::fclose(std::exchange(file_, nullptr)) != 0 && error_ == 0) error_ = errno;
  if (error_ == 0) return true;
  std::fprintf(err_, "error: cannot write `%s`: %s\n", printable(path_).c_str(), std::strerror(error_));
  return false;
}

}  // namespace bip::rt
