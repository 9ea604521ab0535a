// What a verdict's JSON says, as plain data.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "compiler/library/include/bip/compiler.hpp"

namespace bip::library {

/// Sets name, property, method, reason and the counts of `verdict` from what `bipc verify --json` prints.
void read_verdict(const nlohmann::ordered_json& json, compiler::Verdict& verdict);

}  // namespace bip::library
