// What a verdict's JSON says, as plain data.
#pragma once
#include "compiler/library/include/bip/compiler.hpp"

namespace bip::library {

/// Sets name, property, method, reason and the counts of `verdict` from its member `json`, which `bipc verify --json`
/// prints.
void read_verdict(compiler::Verdict& verdict);

}  // namespace bip::library
