// Chunks of MCAP files in the frame format of Zstandard (RFC 8878). The only folder that includes libzstd.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace bip::traces {

/// Whether libzstd is built in.
[[nodiscard]] bool has_zstd();
/// Requires has_zstd(). Level 3, which is the library's own.
[[nodiscard]] std::string zstd(std::string_view bytes);
/// Requires has_zstd(). Nothing if the bytes are no frame of `size` bytes.
[[nodiscard]] std::optional<std::string> unzstd(std::string_view bytes, std::size_t size);

}  // namespace bip::traces
