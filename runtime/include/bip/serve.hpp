// main() of a program that serves a model (`bipc build --serve`, compiler/docs/serve.md). It is in libbip_serve.a, not
// in the runtime.
#pragma once
#include "bip/image_tables.hpp"

namespace bip {

/// Serves the model with the options of `bipc serve`, but for those that compile, see --help. The functions of the
/// model's C++ are found in the program itself, which is linked with -rdynamic. Returns the exit code of `bipc serve`.
[[nodiscard]] int serve_main(const rt::Image& image, int argc, char** argv);

}  // namespace bip
