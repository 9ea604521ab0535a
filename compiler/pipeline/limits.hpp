// Limits and units of answers, shared by everything that searches.
#pragma once
#include <cstddef>
#include <cstdint>

namespace bip::pipeline {

/// Longest run that a story prints step by step.
inline constexpr std::size_t kStepsShown = 100;
/// Bytes of a megabyte in options and output.
inline constexpr std::uint64_t kMega = 1000000;

}  // namespace bip::pipeline
