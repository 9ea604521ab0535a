// PNG from SVG, by a program of others.
#pragma once
#include <string>

#include "compiler/base/result.hpp"

namespace bip::driver {

/// Returns the contents of a PNG file with twice the picture's size, made by `rsvg-convert`. A Failure says what is
/// missing and what helps.
[[nodiscard]] Result<std::string> svg_to_png(const std::string& svg);

}  // namespace bip::driver
