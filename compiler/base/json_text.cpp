// See json_text.hpp.
#include "compiler/base/json_text.hpp"

#include <nlohmann/json.hpp>

namespace bip {

using Json = nlohmann::ordered_json;

std::string json_line(const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string indented_json(const Json& value) { return value.dump(2, ' ', false, Json::error_handler_t::replace); }

Json parse_json(std::string_view text) { return Json::parse(text, nullptr, false); }

}  // namespace bip
