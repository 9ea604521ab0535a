// A run as data beside a verdict.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace bip::library {

/// Adds the members of `run` (rt::counterexample_json) to an object. A run whose strings are no UTF-8, which JSON
/// cannot have, is left out.
inline void add_run(nlohmann::ordered_json& json, const std::string& run) {
  const nlohmann::ordered_json members = nlohmann::ordered_json::parse(run, nullptr, false);
  if (members.is_object()) json.update(members);
}

}  // namespace bip::library
