// The text of a request to a robot module, "NDD.GoTo(3, 0.5, fast)": the service, and the values of its parameters.
// Used by what `bipc genom` writes and by `bipc serve`. Header only; nothing throws but for memory.
//
// Rules judge the values in the text; codels get the input that comes with it as well. `bipc serve` writes both from
// one value (compiler/serve/request_values.hpp). Other events for a mailbox (`--events`) come as they are: what
// disagrees is no known request.
#pragma once
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include "bip/json_value.hpp"

namespace bip {

struct RequestText {
  std::string_view service;
  std::vector<std::string_view> values;
  bool is_sound = false;  // the parentheses are closed, no value is empty
};

inline std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

inline RequestText read_request(std::string_view text) {
  text = without_blanks(text);
  RequestText request;
  const std::size_t open = text.find('(');
  request.service = without_blanks(text.substr(0, open));
  request.is_sound = !request.service.empty();
  if (open == std::string_view::npos) return request;
  request.is_sound = request.is_sound && text.back() == ')';
  std::string_view rest = text.substr(open + 1, text.size() - open - (text.back() == ')' ? 2 : 1));
  if (without_blanks(rest).empty()) return request;
  while (true) {
    const std::size_t comma = rest.find(',');
    request.values.push_back(without_blanks(rest.substr(0, comma)));
    request.is_sound = request.is_sound && !request.values.back().empty();
    if (comma == std::string_view::npos) return request;
    rest.remove_prefix(comma + 1);
  }
}

/// The one form that codels, rules and replies see: "NDD.GoTo(3, 0.5)", "NDD.Stop".
inline std::string written_request(const RequestText& request) {
  std::string text(request.service);
  for (std::size_t k = 0; k < request.values.size(); ++k)
    text.append(k == 0 ? "(" : ", ").append(request.values[k]).append(k + 1 == request.values.size() ? ")" : "");
  return text;
}

/// What is wrong with an input that has a member `name`, if codels have no parameter of this name.
inline std::string no_parameter(std::string_view name) { return "there is no parameter `" + std::string(name) + "`"; }

/// A finite number, whole or a fraction. False: it is none.
inline bool read_request_number(std::string_view text, double& number) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const char* const end = text.data() + text.size();
  const std::from_chars_result read = std::from_chars(text.data(), end, number);
  return !text.empty() && read.ec == std::errc() && read.ptr == end && std::isfinite(number);
}

struct ParameterText {
  std::string_view name;
  bool is_word = false;  // else it is a number
  // Which words there are, separated by `|`, with `~` for a blank: "Left|Far~right". Empty: any.
  std::string_view words{};

  [[nodiscard]] bool has_word(std::string_view word) const {
    if (words.empty()) return true;
    for (std::string_view rest = words; true;) {
      const std::size_t end = std::min(rest.find('|'), rest.size());
      const std::string_view known = rest.substr(0, end);
      if (known.size() == word.size() && std::equal(known.begin(), known.end(), word.begin(), [](char a, char b) {
            return a == b ? a != '~' : a == '~' && b == ' ';
          }))
        return true;
      if (end == rest.size()) return false;
      rest.remove_prefix(end + 1);
    }
  }
  /// For a reader: "Left, Far right".
  [[nodiscard]] std::string words_told() const {
    std::string told;
    for (const char c : words) {
      if (c == '|') told += ", ";
      else told += c == '~' ? ' ' : c;
    }
    return told;
  }
};
/// A service, as a mailbox describes it: "NDD.Stop control overtakes stops=NDD.GoTo", "Battery.Use activity
/// power:number", "VIAM.Acquire activity camera:word=Left|Right".
struct ServiceText {
  std::string_view name;
  bool is_control = false;   // over at once
  bool overtakes = false;    // waits for no other request of its module
  bool may_be_bare = false;  // also without values
  std::vector<std::string_view> stops;
  std::vector<ParameterText> parameters;

  /// What is wrong with the values of a request for it; empty if nothing is.
  [[nodiscard]] std::string problem_of(const RequestText& request) const {
    std::string form(name);
    for (std::size_t k = 0; k < parameters.size(); ++k)
      form.append(k == 0 ? "(" : ", ").append(parameters[k].name).append(k + 1 == parameters.size() ? ")" : "");
    if (!request.is_sound) return "a request has the form `" + form + "`";
    if (request.values.empty() && may_be_bare) return {};
    if (request.values.size() != parameters.size()) return "the request has the form `" + form + "`";
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      double number = 0;
      if (!parameters[k].is_word && !read_request_number(request.values[k], number))
        return std::string("`").append(parameters[k].name).append("` is a number, not `").append(request.values[k]) +
               "`";
      // No rule was written for another word: none would refuse it.
      if (parameters[k].is_word && !parameters[k].has_word(request.values[k]))
        return std::string("`").append(parameters[k].name).append("` is one of ") + parameters[k].words_told() +
               ", not `" + std::string(request.values[k]) + "`";
    }
    return {};
  }
};

/// One service; without a name, if the text has none. The texts are those of `row`.
inline ServiceText read_service(std::string_view row) {
  ServiceText service;
  while (!row.empty()) {
    const std::size_t blank = std::min(row.find(' '), row.size());
    const std::string_view word = row.substr(0, blank);
    row.remove_prefix(std::min(blank + 1, row.size()));
    const std::size_t colon = word.find(':');
    if (service.name.empty()) service.name = word;
    else if (word == "control") service.is_control = true;
    else if (word == "overtakes") service.overtakes = true;
    else if (word == "bare") service.may_be_bare = true;
    else if (word.starts_with("stops=")) service.stops.push_back(word.substr(6));
    else if (colon != std::string_view::npos) {
      const std::string_view type = word.substr(colon + 1);
      const std::size_t equals = std::min(type.find('='), type.size());
      const std::string_view words = type.substr(std::min(equals + 1, type.size()));
      service.parameters.push_back({word.substr(0, colon), type.substr(0, equals) == "word", words});
    }
  }
  return service;
}

/// Takes the first one of `services`, which are separated by `;`.
inline std::string_view take_service(std::string_view& services) {
  const std::size_t end = std::min(services.find(';'), services.size());
  const std::string_view row = services.substr(0, end);
  services.remove_prefix(std::min(end + 1, services.size()));
  return row;
}

/// Separated by `;`. The texts are those of `services`.
inline std::vector<ServiceText> read_services(std::string_view services) {
  std::vector<ServiceText> all;
  while (!services.empty()) {
    ServiceText service = read_service(take_service(services));
    if (!service.name.empty()) all.push_back(std::move(service));
  }
  return all;
}

/// The first one of this name; without a name, if there is none.
inline ServiceText find_service(std::string_view services, std::string_view name) {
  while (!services.empty()) {
    const std::string_view row = take_service(services);
    // Most have another name: these are not read.
    if (row.find(name) != std::string_view::npos) {
      ServiceText service = read_service(row);
      if (service.name == name) return service;
    }
  }
  return {};
}

// ---- called by generated BIP

inline std::string request_service(const char* text) { return std::string(read_request(text).service); }

/// "NDD" of "NDD.GoTo(3, 0.5)".
inline std::string request_module(const char* text) {
  const std::string_view service = read_request(text).service;
  return std::string(service.substr(0, service.find('.')));
}

/// Value k as a number; 0 if there is none.
inline double request_number(const char* text, int k) {
  const RequestText request = read_request(text);
  double number = 0;
  if (k < 0 || static_cast<std::size_t>(k) >= request.values.size() ||
      !read_request_number(request.values[static_cast<std::size_t>(k)], number))
    return 0;
  return number;
}

/// Value k as it was written; empty if there is none.
inline std::string request_word(const char* text, int k) {
  const RequestText request = read_request(text);
  if (k < 0 || static_cast<std::size_t>(k) >= request.values.size()) return {};
  return std::string(request.values[static_cast<std::size_t>(k)]);
}

/// Is it a request for one of `services` (read_services()), with a value for each parameter?
inline bool request_known(const char* text, const char* services) {
  const RequestText request = read_request(text);
  // What an executive says that wants nothing, in each tick.
  if (request.service.empty()) return false;
  const ServiceText service = find_service(services, request.service);
  return !service.name.empty() && service.problem_of(request).empty();
}

/// How codels get the values of an input: those of GenoM 2 as words, those of genom3 by the names of parameters.
enum class InputForm { Words, Names };

/// Does an input have the value that rules judge for each parameter? Without names it may have none.
inline bool input_agrees(const ServiceText& service, const RequestText& request, std::string_view input,
                         InputForm form) {
  // Of `Abort` it is the activity.
  if (service.parameters.empty() || service.may_be_bare) return true;
  if (input.find_first_not_of(" \t\r\n") == std::string_view::npos) return form == InputForm::Words;
  JsonValue object;
  try {
    object = JsonReader::read(input);
  } catch (const std::exception&) {
    return false;
  }
  // No rule judges its words.
  if (object.kind != JsonValue::Kind::Object) return false;
  for (std::size_t k = 0; k < service.parameters.size(); ++k) {
    const ParameterText& parameter = service.parameters[k];
    bool is_given = false;
    for (const JsonMember& member : object.members) {
      if (member.name != parameter.name) continue;
      is_given = true;
      double judged = 0, given = 0;
      const bool is_same = parameter.is_word
                               ? member.value.kind == JsonValue::Kind::Text && member.value.text == request.values[k]
                               : member.value.kind == JsonValue::Kind::Number &&
                                     read_request_number(request.values[k], judged) &&
                                     read_request_number(member.value.text, given) && judged == given;
      if (!is_same) return false;
    }
    if (!is_given && form == InputForm::Names) return false;
  }
  return true;
}

/// request_known(), of a request whose input agrees.
inline bool request_agrees(const char* text, const char* input, const char* services, InputForm form) {
  const RequestText request = read_request(text);
  if (request.service.empty()) return false;
  const ServiceText service = find_service(services, request.service);
  return !service.name.empty() && service.problem_of(request).empty() && input_agrees(service, request, input, form);
}

}  // namespace bip
