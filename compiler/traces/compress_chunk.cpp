// See compress_chunk.hpp.
#include "compiler/traces/compress_chunk.hpp"

#include "bip/assert.hpp"

#ifdef BIPC_ZSTD
#include <zstd.h>

namespace bip::traces {

bool has_zstd() { return true; }

std::string zstd(std::string_view bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3);
  BIP_ENSURE(ZSTD_isError(size) == 0, "libzstd: {}", ZSTD_getErrorName(size));
  out.resize(size);
  return out;
}

std::optional<std::string> unzstd(std::string_view bytes, std::size_t size) {
  if (ZSTD_getFrameContentSize(bytes.data(), bytes.size()) != size) return std::nullopt;
  std::string out(size, '\0');
  if (ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size()) != size) return std::nullopt;
  return out;
}

}  // namespace bip::traces
#else
namespace bip::traces {

bool has_zstd() { return false; }

std::string zstd(std::string_view) {
  BIP_ENSURE(has_zstd(), "libzstd is not built in");
  return {};
}

std::optional<std::string> unzstd(std::string_view, std::size_t) { return std::nullopt; }

}  // namespace bip::traces
#endif
