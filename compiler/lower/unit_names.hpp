// Readable, unique C identifiers for code units.
//
// Names come from the model ("Fork_on_take_from_free_guard"); each sequence of other characters than letters, digits
// and `_` becomes one `_`. Long names are truncated, equal names are numbered from _2 on. Linear in the text: counters
// are kept per stem.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "compiler/system/system_ids.hpp"

namespace bip::lower {

class UniqueNames {
 public:
  /// `text` as a C identifier that was not given before and is no reserved one (no leading or double underscore).
  [[nodiscard]] std::string make(std::string_view text);
  /// Words that `make` shall not return.
  void reserve(std::string_view word) { used_.emplace(word); }

 private:
  std::unordered_set<std::string> used_;
  std::unordered_map<std::string, std::uint32_t> next_;
};

/// "Fork_on_take_from_free" or "Fork_internal_from_free".
[[nodiscard]] std::string transition_name(const AtomType& type, const Transition& transition);
/// "Broadcast_on_p_q".
[[nodiscard]] std::string clause_name(const ConnectorType& type, const Clause& clause);

}  // namespace bip::lower
