// See framed_output.hpp.
#include "compiler/base/framed_output.hpp"

#include <unistd.h>

#include <cerrno>
#include <string>

#include "compiler/base/framing.hpp"

namespace bip {

void FramedOutput::write(std::string_view body) {
  if (error_ != 0) return;
  const std::string message = framed(body);
  std::string_view rest = message;
  while (!rest.empty()) {
    const ssize_t done = ::write(file_, rest.data(), rest.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) {
      error_ = done < 0 ? errno : EIO;
      return;
    }
    rest.remove_prefix(static_cast<std::size_t>(done));
  }
}

}  // namespace bip
