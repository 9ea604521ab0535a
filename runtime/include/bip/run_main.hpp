// main() of emitted programs. Apart from run.hpp, whose options need headers that take long to read.
#pragma once

namespace bip::rt {

struct Image;

/// main() of an emitted program: the options of `run`, see --help; exit code as bipc run's.
int run_main(const Image& image, int argc, char** argv);

}  // namespace bip::rt
