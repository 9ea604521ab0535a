// See names.hpp. The reserved words are those of grammar/BipLexer.g4; contextual words are names wherever they are
// generated.
#include "compiler/genom/names.hpp"

#include <algorithm>
#include <cctype>
#include <set>

#include "runtime/include/bip/assert.hpp"

namespace bip::genom {

std::string bip_name(std::string_view name) {
  static const std::set<std::string_view> kReserved{
      "package",  "use",      "end",       "as",       "atom",     "compound", "component", "connector", "port",
      "type",     "extern",   "export",    "function", "operator", "refine",   "data",      "const",     "define",
      "on",       "internal", "provided",  "do",       "up",       "down",     "place",     "initial",   "from",
      "to",       "priority", "if",        "then",     "else",     "fi",       "true",      "false",     "int",
      "bool",     "float",    "string",    "clock",    "unit",     "lazy",     "delayable", "eager",     "resume",
      "sync",     "async",    "invariant", "at",       "remember", "ignore",   "error",     "behavior",  "state",
      "contains", "for",      "in",        "and",      "or",       "not"};
  std::string result(name);
  for (char& c : result) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  if (result.empty() || std::isdigit(static_cast<unsigned char>(result[0])) != 0) result.insert(0, "_");
  return kReserved.contains(result) ? result + "_" : result;
}

std::string type_name(std::string_view name) {
  std::string result;
  bool starts_word = true;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) {
      starts_word = true;
      continue;
    }
    result += starts_word ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    starts_word = false;
  }
  return bip_name(result);
}

std::string codel_function(std::string_view codel) { return "codel_" + bip_name(codel); }

std::string upper(std::string_view name) {
  std::string result = bip_name(name);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return result;
}

std::string Scope::claim(const std::string& name, const std::string& kind) {
  BIP_ASSERT(name.empty() || !kind.empty() || !taken_.contains(name),
             "`{}` is taken, and there is no other name for it", name);
  std::string result = name;
  if (taken_.contains(result)) result = name + "_" + kind;
  for (int n = 2; taken_.contains(result); ++n) result = name + "_" + kind + std::to_string(n);
  taken_.insert(result);
  return result;
}

}  // namespace bip::genom
