// Words of .bsys and scopes of code: see bsys_text.hpp.
#include "compiler/system/bsys_text.hpp"

#include <array>
#include <utility>

namespace bip::system::text {
namespace {

constexpr std::array<std::pair<Type, const char*>, 4> kTypes{
    {{Type::Int, "int"}, {Type::Bool, "bool"}, {Type::Float, "float"}, {Type::String, "string"}}};

}  // namespace

const char* word_of(Type type) {
  for (const auto& [value, word] : kTypes)
    if (value == type) return word;
  return "?";
}
std::optional<Type> type_of(std::string_view text) {
  for (const auto& [value, word] : kTypes)
    if (text == word) return value;
  return std::nullopt;
}
const char* word_of(InvariantScope scope) {
  switch (scope) {
    case InvariantScope::Always: return "always";
    case InvariantScope::At: return "at";
    case InvariantScope::From: return "from";
  }
  return "?";
}
std::optional<InvariantScope> invariant_scope_of(std::string_view word) {
  for (const InvariantScope scope : {InvariantScope::Always, InvariantScope::At, InvariantScope::From})
    if (word == word_of(scope)) return scope;
  return std::nullopt;
}
std::optional<Op> op_of(std::string_view text) {
  for (std::size_t row = 0; row < kOperators.size(); ++row)
    if (kOperators[row].word != nullptr && text == kOperators[row].word) return static_cast<Op>(row);
  return std::nullopt;
}

bool is_bare(std::string_view name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  if (name.empty() || !is_letter(name[0])) return false;
  for (const char c : name)
    if (!is_letter(c) && !(c >= '0' && c <= '9') && c != '.' && c != '[' && c != ']') return false;
  return true;
}

CodeScope scope_of(const AtomType& type) {
  CodeScope scope;
  for (const DataVariable& variable : type.variables)
    scope.self.push_back({variable.name, variable.type, !variable.is_param});
  scope.draws = type.draws;
  return scope;
}

CodeScope scope_of(const System& system, const ConnectorType& type) {
  CodeScope scope;
  for (const DataVariable& variable : type.variables)
    scope.self.push_back({variable.name, variable.type, !variable.is_param});
  for (const ConnectorParam& param : type.params) {
    if (!system.port_types.contains(param.type)) continue;
    for (const Variable& variable : system.port_types[param.type].variables)
      scope.bind.push_back({param.name + "." + variable.name, variable.type, true});
  }
  for (const DataRead& read : type.data_reads) scope.bind.push_back({read.path, read.type, false});
  return scope;
}

CodeScope scope_of(const System& system, const Priority& priority) {
  CodeScope scope;
  for (const DataRef& data : priority.data) {
    if (!system.atoms.contains(data.atom)) continue;
    const Atom& atom = system.atoms[data.atom];
    if (!system.atom_types.contains(atom.type)) continue;
    const std::vector<DataVariable>& variables = system.atom_types[atom.type].variables;
    if (data.variable >= variables.size()) continue;
    scope.bind.push_back({atom.path + "." + variables[data.variable].name, variables[data.variable].type, false});
  }
  return scope;
}

}  // namespace bip::system::text
