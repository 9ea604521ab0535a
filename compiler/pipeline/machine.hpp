// Free resources of this machine, for the defaults of long computations.
#pragma once
#include <cstdint>

namespace bip::pipeline {

/// Processors this process may use, at least 1.
[[nodiscard]] std::uint32_t processors();
/// Bytes that can be taken without driving others out: what the kernel calls available, within the control group's
/// limit. A guess of 2 GB where nothing is known.
[[nodiscard]] std::uint64_t available_memory();

}  // namespace bip::pipeline
