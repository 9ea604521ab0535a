// The file of `bipc verify --certificate`.
#pragma once
#include <string>

#include "compiler/driver/options.hpp"
#include "compiler/library/decide.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::driver {

/// Writes the verdict's certificate to PATH, if it has one. A violation removes a file of an earlier run, which says
/// what this one refutes. Reports B5004. An empty path: does nothing.
void write_certificate(pipeline::Compilation& c, const std::string& path, const library::Verdict& verdict);

}  // namespace bip::driver
