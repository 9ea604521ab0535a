// JSON as text. The reader and the writer are templates that take a second to compile: they are compiled here, once.
#pragma once
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace bip {

/// `value` on one line, without the line's end. Bytes that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string json_line(const nlohmann::ordered_json& value);
/// `value` over several lines, each level indented by two columns; the rest as of json_line.
[[nodiscard]] std::string indented_json(const nlohmann::ordered_json& value);
/// The value that `text` says; `is_discarded()` holds of it if the text is not JSON.
[[nodiscard]] nlohmann::ordered_json parse_json(std::string_view text);

}  // namespace bip
