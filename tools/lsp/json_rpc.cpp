// See json_rpc.hpp.
#include "tools/lsp/json_rpc.hpp"

namespace bip::lsp {

std::optional<std::int64_t> int_member(const Json& object, const char* key) {
  const Json* found = member(object, key);
  if (found == nullptr || !found->is_number_integer()) return std::nullopt;
  if (found->is_number_unsigned() && found->get<std::uint64_t>() > INT64_MAX) return std::nullopt;
  return found->get<std::int64_t>();
}

std::optional<std::uint32_t> uint_member(const Json& object, const char* key) {
  const std::optional<std::int64_t> value = int_member(object, key);
  if (!value || *value < 0 || *value > INT32_MAX) return std::nullopt;
  return static_cast<std::uint32_t>(*value);
}

std::optional<Position> position_of(const Json* value) {
  if (value == nullptr) return std::nullopt;
  const auto line = uint_member(*value, "line");
  const auto character = uint_member(*value, "character");
  if (!line || !character) return std::nullopt;
  return Position{*line, *character};
}

Json json_of(Position at) { return {{"line", at.line}, {"character", at.character}}; }

}  // namespace bip::lsp
