// The text of a property that a compound states, in terms of the whole system.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/model/code.hpp"

namespace bip::system {

struct ExpandedProperty {
  std::string text;
  std::vector<std::uint32_t> source;  // by byte of the text, and one for its end: offset in what was expanded
};

/// Returns the property with each path prefixed by `scope` ("" or "table."), parameters and variables of loops replaced
/// by their values, indices computed, comments left out. `a.x`, `a@P`, `a[0]` and what follows `can` and `happens` are
/// paths; those that begin with `ROOT.` stay, and so do variables of quantifiers
/// (`forall i in a: …`) with the indices that name them, but for their parameters. Grammar and names are checked by the
/// parser of the result. The error says which index has no value. Linear in the text.
[[nodiscard]] Result<ExpandedProperty> expand_property(std::string_view text, const std::string& scope,
                                                       const std::map<std::string, Value, std::less<>>& constants,
                                                       const std::vector<std::string>& strings);

}  // namespace bip::system
