// --emit=KIND: prints the product of one stage to standard output, instead of executing the command.
#pragma once
#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::driver {

/// Compiles as far as options.emit needs and prints it. Problems are in c.diags afterwards; nothing is printed then.
void emit_stage(Compilation& c, const std::string& path, Optimisation optimisation);

}  // namespace bip::driver
