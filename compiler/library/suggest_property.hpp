// Properties as other tools write them, and with slips in names: the same as bipc writes it.
#pragma once
#include <optional>
#include <string>

#include "compiler/system/system_ids.hpp"

namespace bip::library {

struct PropertySuggestion {
  std::string note;      // may be empty
  std::string property;  // it can be read; empty: there is only a note
};

/// What a person may have meant by a text that is no property of the system. Cost: linear in the system for each name.
[[nodiscard]] std::optional<PropertySuggestion> suggest_property(const std::string& text, const System& system);

/// The same of a text that says which runs are fair.
[[nodiscard]] std::optional<PropertySuggestion> suggest_fairness(const std::string& text, const System& system);

}  // namespace bip::library
