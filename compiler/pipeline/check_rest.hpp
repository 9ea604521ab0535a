// After errors of syntax, or without a package that is not there: checks names and types of the declarations that do
// not depend on an erroneous one.
#pragma once
#include "compiler/pipeline/pipeline.hpp"

namespace bip::pipeline {

/// Adds the errors of sound declarations to c.diags. Nothing is said about a declaration that names, directly or
/// through others, one that was not understood. Needs c.syntax and its errors; leaves no other product.
void check_rest(Compilation& c);

/// After load_packages() has failed because packages that the compiled one uses are not there: says which names are not
/// known without them, and adds the errors of declarations that do not depend on such a name.
void check_without_missing(Compilation& c);

}  // namespace bip::pipeline
