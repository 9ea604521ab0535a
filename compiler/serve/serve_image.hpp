// Serves an image with these settings: what `bipc serve` and programs of `bipc build --serve` do once there is one.
#pragma once
#include "bip/image.hpp"
#include "compiler/serve/serve_options.hpp"

namespace bip::serve {

/// The exit code of settings that cannot be used.
inline constexpr int kUsage = 2;

/// Until serve() ends (model_server.hpp). `library`: a handle of dlopen in which the functions of the model's C++ are
/// found; null: it has none. Reports errors and warnings on standard error. Returns the exit code: 0, kUsage if the
/// settings do not fit or something cannot be opened, kOutputLost.
[[nodiscard]] int serve_image(const rt::Image& image, void* library, const ServeSettings& settings);

}  // namespace bip::serve
