// The linker's identification of a program or library: part of the names of what a cache keeps, so that nothing made by
// another build of the same version is taken.
#pragma once
#include <string>

namespace bip {

/// Returns the build id (NT_GNU_BUILD_ID, in hexadecimal digits) of the loaded program or library that contains
/// `address`; empty if the linker wrote none.
[[nodiscard]] std::string build_id_of(const void* address);

}  // namespace bip
