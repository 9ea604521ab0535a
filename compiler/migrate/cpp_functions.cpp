// See cpp_functions.hpp. The code is not parsed: words outside of strings and comments that name variables are their
// uses, and a variable behind which an assignment stands, or before which `&`, `++` or `--` does, may be changed. A
// variable that only seems to be changed costs nothing but a `const`.
#include "compiler/migrate/cpp_functions.hpp"

#include <algorithm>
#include <array>

#include "runtime/include/bip/assert.hpp"
#include "compiler/base/ascii.hpp"

namespace bip::migrate {
namespace {

bool begins_word(char c) { return is_letter(c) || c == '_'; }
bool is_in_word(char c) { return begins_word(c) || is_digit(c); }
constexpr std::string_view kCodeBlanks = " \t\r\n";

/// The end of the string, character or comment that begins at `at`, or `at`.
std::size_t skip_quoted(std::string_view code, std::size_t at) {
  const char c = code[at];
  if (c == '"' || c == '\'') {
    std::size_t end = at + 1;
    while (end < code.size() && code[end] != c && code[end] != '\n') end += code[end] == '\\' ? 2 : 1;
    return std::min(end + 1, code.size());
  }
  if (code.substr(at).starts_with("//")) return std::min(code.find('\n', at), code.size());
  if (code.substr(at).starts_with("/*")) {
    const std::size_t end = code.find("*/", at + 2);
    return end == std::string_view::npos ? code.size() : end + 2;
  }
  return at;
}

/// Whether what stands behind a variable changes it.
bool is_assigned(std::string_view behind) {
  const std::size_t first = behind.find_first_not_of(kCodeBlanks);
  if (first == std::string_view::npos) return false;
  behind.remove_prefix(first);
  if (behind.starts_with("==")) return false;
  if (behind.starts_with("=") || behind.starts_with("++") || behind.starts_with("--")) return true;
  if (behind.starts_with("<<=") || behind.starts_with(">>=")) return true;
  return behind.size() > 1 && behind[1] == '=' &&
         std::string_view("+-*/%&|^").find(behind[0]) != std::string_view::npos;
}

/// Whether what stands before a variable changes it, or takes its address.
bool is_handed_out(std::string_view before) {
  const std::size_t last = before.find_last_not_of(kCodeBlanks);
  if (last == std::string_view::npos) return false;
  before = before.substr(0, last + 1);
  if (before.ends_with("++") || before.ends_with("--") || before.ends_with(">>")) return true;
  return before.ends_with("&") && !before.ends_with("&&");
}

std::string parameter_name(std::string name) {
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
}

bool is_by_value(ValueKind kind) { return kind == ValueKind::Bool || kind == ValueKind::String; }

}  // namespace

VariableType CppFunctions::type(std::string_view bip1) {
  using Row = std::pair<std::string_view, VariableType>;
  static const std::array<Row, 11> kTypes = {Row{"int", {ValueKind::Int, "int", "int"}},
                                             Row{"signed", {ValueKind::Int, "int", "int"}},
                                             Row{"signed int", {ValueKind::Int, "int", "int"}},
                                             Row{"int32_t", {ValueKind::Int, "int", "int"}},
                                             Row{"bool", {ValueKind::Bool, "bool", "bool"}},
                                             Row{"boolean", {ValueKind::Bool, "bool", "bool"}},
                                             Row{"_Bool", {ValueKind::Bool, "bool", "bool"}},
                                             Row{"float", {ValueKind::Float, "float", "double"}},
                                             Row{"double", {ValueKind::Float, "float", "double"}},
                                             Row{"string", {ValueKind::String, "string", "std::string"}},
                                             Row{"std::string", {ValueKind::String, "string", "std::string"}}};
  for (const Row& row : kTypes) {
    if (row.first == bip1) return row.second;
  }
  const std::string cpp(bip1);
  auto found = types_.find(cpp);
  if (found == types_.end()) {
    std::string wish;
    bool is_built_in = true;
    for (std::size_t at = 0; at < cpp.size();) {
      const std::size_t begin = at;
      while (at < cpp.size() && is_in_word(cpp[at])) ++at;
      const std::string word = cpp.substr(begin, at - begin);
      if (!word.empty() || cpp[at] == '*') wish += (wish.empty() ? "" : "_") + (word.empty() ? "pointer" : word);
      constexpr std::string_view kBuiltIn = " unsigned signed char short int long float double ";
      is_built_in &= word.empty() || kBuiltIn.find(" " + word + " ") != std::string_view::npos;
      at += word.empty() ? 1 : 0;
    }
    has_own_types_ |= !is_built_in;
    if (wish.empty() || is_digit(wish[0])) wish = "object_" + wish;
    found = types_.emplace(cpp, names_.fresh(wish + "_type")).first;
    type_order_.push_back(cpp);
    BIP_ASSERT(type_order_.size() == types_.size(), "{} of {} types are in an order", type_order_.size(),
               types_.size());
  }
  return {ValueKind::Object, found->second, cpp};
}

CppFunctions::Body CppFunctions::find_variables(std::string_view code, const Variables& variables) {
  Body body;
  for (std::size_t at = 0; at < code.size();) {
    if (const std::size_t end = skip_quoted(code, at); end != at) {
      body.text += code.substr(at, end - at);
      at = end;
      continue;
    }
    if (code.substr(at).starts_with("{#") || code.substr(at).starts_with("#}")) {
      body.text += code[at] == '#' ? '}' : '{';
      at += 2;
      continue;
    }
    if (!begins_word(code[at])) {
      // A number with its suffix is no word.
      const std::size_t begin = at++;
      while (is_digit(code[begin]) && at < code.size() && (is_in_word(code[at]) || code[at] == '.')) ++at;
      body.text += code.substr(begin, at - begin);
      continue;
    }
    // The longest path that is a variable: `p.x`, and of `x.member` the `x`.
    const bool is_member = body.text.ends_with(".") || body.text.ends_with("->");
    std::size_t end = at, found_end = at;
    auto found = variables.end();
    std::string path;
    for (;;) {
      const std::size_t begin = end;
      while (end < code.size() && is_in_word(code[end])) ++end;
      path += code.substr(begin, end - begin);
      if (const auto prefix = variables.find(path); prefix != variables.end() && !is_member) {
        found = prefix;
        found_end = end;
      }
      if (found_end == at && begin == at) found_end = end;
      if (end + 1 >= code.size() || code[end] != '.' || !begins_word(code[end + 1])) break;
      path += '.';
      ++end;
    }
    if (found == variables.end()) {
      body.text += code.substr(at, found_end - at);
      at = found_end;
      continue;
    }
    auto used = std::find_if(body.used.begin(), body.used.end(), [&](const Used& u) { return u.name == found->first; });
    if (used == body.used.end()) used = body.used.insert(used, Used{found->first, &found->second});
    used->is_written |= is_assigned(code.substr(found_end)) || is_handed_out(code.substr(0, at));
    body.text += parameter_name(found->first);
    at = found_end;
  }
  return body;
}

std::optional<std::string> CppFunctions::action(const std::string& owner, std::string_view code,
                                                const Variables& variables, const std::string& place) {
  Body body = find_variables(code, variables);
  const Used* returned = nullptr;
  for (Used& used : body.used) {
    const bool is_value = is_by_value(used.variable->type.kind);
    // What C++ does with an object is not for words to tell.
    used.is_written |= used.variable->type.kind == ValueKind::Object;
    if (!used.variable->is_writable) used.is_written = false;
    if (!used.is_written || !is_value) continue;
    if (returned != nullptr) {
      reason_ = "it changes `" + returned->name + "` and `" + used.name +
                "`, and a function of C++ gives one `bool` or `string`";
      return std::nullopt;
    }
    returned = &used;
  }
  std::string text = "\n" + body.text + "\n";
  if (returned != nullptr) text += "  return " + parameter_name(returned->name) + ";\n";
  const std::optional<std::string> call =
      add(owner, body, text, returned == nullptr ? nullptr : &returned->variable->type, false, place);
  if (!call) return std::nullopt;
  std::string target;
  if (returned != nullptr) {
    std::string_view rest = returned->name;
    for (std::size_t dot = 0; dot != std::string_view::npos; rest.remove_prefix(dot == rest.npos ? 0 : dot + 1)) {
      dot = rest.find('.');
      target += (target.empty() ? "" : ".") + names_.name(rest.substr(0, dot));
    }
    target += " = ";
  }
  return target + *call + "; ";
}

std::optional<std::string> CppFunctions::value(const std::string& owner, std::string_view code,
                                               const Variables& variables, const VariableType& result,
                                               const std::string& place) {
  const Body body = find_variables(code, variables);
  std::string_view text = trimmed(body.text);
  while (text.ends_with(';')) text = trimmed(text.substr(0, text.size() - 1));
  return add(owner, body, "\n  return " + std::string(text) + ";\n", &result, true, place);
}

std::optional<std::string> CppFunctions::add(const std::string& owner, const Body& body, const std::string& cpp_body,
                                             const VariableType* result, bool is_constant, const std::string& place) {
  std::string bip_params, cpp_params, args;
  for (const Used& used : body.used) {
    const VariableType& type = used.variable->type;
    if (type.kind == ValueKind::Unknown || type.kind == ValueKind::Clock) {
      reason_ = type.kind == ValueKind::Clock ? "C++ reads clock `" + used.name + "`"
                                              : "the type of `" + used.name + "` is not to be seen here";
      return std::nullopt;
    }
    const bool is_reference = !is_constant && used.is_written && !is_by_value(type.kind);
    const std::string comma = args.empty() ? "" : ", ";
    bip_params += comma + (is_reference ? "" : "const ") + type.bip;
    cpp_params += comma + (type.kind == ValueKind::Object && !is_reference ? "const " : "") + type.cpp +
                  (is_reference || type.kind == ValueKind::Object ? "& " : " ") + parameter_name(used.name);
    args += comma;
    std::string_view rest = used.name;
    for (bool is_first = true;; is_first = false) {
      const std::size_t dot = rest.find('.');
      args += (is_first ? "" : ".") + names_.name(rest.substr(0, dot));
      if (dot == std::string_view::npos) break;
      rest.remove_prefix(dot + 1);
    }
  }
  BIP_ASSERT(prototypes_.size() == definitions_.size() && cpp_declarations_.size() == definitions_.size(),
             "{} prototypes of {} functions", prototypes_.size(), definitions_.size());
  const std::string name = names_.fresh(owner + "_code");
  prototypes_.push_back("extern function " + (result == nullptr ? "" : result->bip + " ") + name + "(" + bip_params +
                        ")");
  const std::string head = (result == nullptr ? "void" : result->cpp) + " " + name + "(" + cpp_params + ")";
  cpp_declarations_.push_back(head + ";\n");
  definitions_.push_back("\n// " + place + "\n" + head + " {" + cpp_body + "}\n");
  return name + "(" + args + ")";
}

void CppFunctions::add_header(std::string_view code, const std::string& place) {
  headers_.push_back("// " + place + "\n" + std::string(code) + "\n");
}

std::vector<std::string> CppFunctions::declarations() const {
  std::vector<std::string> lines;
  for (const std::string& cpp : type_order_) {
    std::string quoted;
    for (const char c : cpp) quoted += (c == '"' || c == '\\' ? "\\" : "") + std::string(1, c);
    lines.push_back("extern data type " + types_.at(cpp) + " as \"" + quoted + "\"");
  }
  lines.insert(lines.end(), prototypes_.begin(), prototypes_.end());
  return lines;
}

std::string CppFunctions::header(const std::string& model) const {
  std::string out =
      "// C code of the BIP1 model `" + model + "`, written by `bipc migrate`.\n#pragma once\n#include <string>\n";
  if (has_own_types_) {
    for (const std::string& text : headers_) out += "\n" + text;
  }
  if (!cpp_declarations_.empty()) out += "\n";
  for (const std::string& line : cpp_declarations_) out += line;
  return out;
}

std::string CppFunctions::source(const std::string& model, const std::string& header_name) const {
  std::string out =
      "// C code of the BIP1 model `" + model + "`, written by `bipc migrate`.\n#include \"" + header_name + "\"\n";
  if (!has_own_types_) {
    for (const std::string& text : headers_) out += "\n" + text;
  }
  for (const std::string& text : definitions_) out += text;
  return out;
}

}  // namespace bip::migrate
