// What verdicts about models with time share. Internal to compiler/library.
#pragma once
#include <string>

#include <nlohmann/json.hpp>

#include "compiler/library/decide.hpp"
#include "runtime/explore/zones.hpp"

namespace bip::library {

/// Why a search of zones has no answer.
[[nodiscard]] std::string limit_text(const rt::ZoneReport& found, const verify::CancellationToken& cancellation);
[[nodiscard]] Verdict verdict_of(const nlohmann::ordered_json& json, std::string text, int exit_code);
/// Of a model with C++ or random numbers, which zones cannot follow.
[[nodiscard]] Verdict unknown_because_of_values(const System& system);

}  // namespace bip::library
