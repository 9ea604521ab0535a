// After syntax errors: checks names and types of the declarations that do not depend on an erroneous one.
#pragma once
#include "compiler/pipeline/pipeline.hpp"

namespace bip::pipeline {

/// Adds the errors of sound declarations to c.diags. Nothing is said about a declaration that names, directly or
/// through others, one that was not understood. Needs c.syntax and its errors; leaves no other product.
void check_rest(Compilation& c);

}  // namespace bip::pipeline
