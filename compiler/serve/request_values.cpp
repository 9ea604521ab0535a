// See request_values.hpp. Linear in the input; each parameter of the rules asks the codels' check at most once more.
#include "compiler/serve/request_values.hpp"

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "bip/assert.hpp"

namespace bip::serve {

namespace {

using Json = nlohmann::ordered_json;

// No input is as deep; what is written level by level must not come at the end of the stack.
constexpr int kDeepestInput = 32;
// Of numbers that a double has exactly.
constexpr double kMostWhole = 9007199254740992.0;

// Nothing if it is none, or too deep.
std::optional<Json> read_object(const std::string& text) {
  bool is_too_deep = false;
  const auto keep = [&](int depth, Json::parse_event_t, Json&) {
    is_too_deep = is_too_deep || depth > kDeepestInput;
    return !is_too_deep;
  };
  Json json = Json::parse(text, keep, false);
  if (is_too_deep || !json.is_object()) return std::nullopt;
  return json;
}

std::string printed(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

// Nothing if it has no place in parentheses.
std::optional<std::string> written_value(const Json& value, bool is_word) {
  if (!is_word) return value.is_number() ? std::optional(printed(value)) : std::nullopt;
  if (!value.is_string()) return std::nullopt;
  std::string word = value.get<std::string>();
  if (word.empty() || without_blanks(word) != word || word.find_first_of(",()") != std::string::npos)
    return std::nullopt;
  return word;
}

Json json_value(std::string_view text, bool is_word) {
  double number = 0;
  if (is_word || !read_request_number(text, number)) return std::string(text);
  if (std::abs(number) <= kMostWhole && number == std::trunc(number)) return static_cast<std::int64_t>(number);
  return number;
}

bool is_same(std::string_view text, const std::string& other, bool is_word) {
  double a = 0, b = 0;
  return is_word ? text == other : read_request_number(text, a) && read_request_number(other, b) && a == b;
}

}  // namespace

std::string settle_values(const ServiceText& service, InputProblem input_problem, std::string& text,
                          std::string& input) {
  const RequestText request = read_request(text);
  BIP_ASSERT(request.service == service.name, "a request `{}` for `{}`", text, service.name);
  // Of `Abort` it is the activity.
  if (service.parameters.empty() || service.may_be_bare) return {};
  const bool is_blank = input.find_first_not_of(" \t\r\n") == std::string::npos;
  if (is_blank && input_problem == nullptr) return {};
  std::optional<Json> object = is_blank ? Json::object() : read_object(input);
  if (!object) {
    if (request.values.empty()) return service.problem_of(request);
    if (input_problem != nullptr) return "input of `" + std::string(service.name) + "`: an input is an object of JSON";
    return "input of `" + std::string(service.name) +
           "`: beside values in parentheses it is an object of JSON, or empty: no rule judges its words";
  }
  std::vector<std::string> values(request.values.begin(), request.values.end());
  const bool is_bare = values.empty();
  if (!is_bare && values.size() != service.parameters.size()) return service.problem_of(request);
  std::size_t given = 0;
  for (std::size_t k = 0; k < service.parameters.size(); ++k) {
    const std::string name(service.parameters[k].name);
    const bool is_word = service.parameters[k].is_word;
    if (const auto member = object->find(name); member != object->end()) {
      const std::optional<std::string> value = written_value(*member, is_word);
      if (!value) return "`" + name + "` is a " + (is_word ? "word" : "number") + ", not `" + printed(*member) + "`";
      if (!is_bare && !is_same(values[k], *value, is_word))
        return "`" + name + "` is `" + values[k] + "` in parentheses and `" + *value + "` in the input";
      if (is_bare) values.push_back(*value);
      ++given;
    } else if (!is_bare && input_problem != nullptr) {
      (*object)[name] = json_value(values[k], is_word);
    }
  }
  if (is_bare && given < service.parameters.size()) return service.problem_of(request);
  RequestText settled{request.service, {values.begin(), values.end()}, request.is_sound};
  std::string whole = written_request(settled);
  text = std::move(whole);
  // Written anew: no member is there twice.
  if (!is_blank || !object->empty()) input = printed(*object);
  return {};
}

}  // namespace bip::serve
