// SHA-256 (FIPS 180-4), for the type hashes of ROS 2. Short texts, so it is written to be read.
#pragma once
#include <string>
#include <string_view>

namespace bip::ros2 {

/// Returns 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view bytes);

}  // namespace bip::ros2
