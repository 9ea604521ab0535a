// A run as data beside a verdict.
#pragma once
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace bip::library {

/// Adds the members of `run` (rt::counterexample_json) to an object. A run whose strings are no UTF-8, which JSON
/// cannot have, is left out.
void add_run(nlohmann::ordered_json& json, const std::string& run);

}  // namespace bip::library
