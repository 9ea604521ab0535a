// See suggest.hpp. Only messages depend on this file.
#include "compiler/model/suggest.hpp"

#include <algorithm>
#include <utility>

#include "compiler/base/ascii.hpp"

namespace bip::model {
namespace {

const char* default_of(Type type) {
  switch (type) {
    case Type::Bool: return "false";
    case Type::Float: return "0.0";
    case Type::String: return "\"\"";
    case Type::Int: return "0";
  }
  return "0";
}

const syntax::Decl* atom_around(const Model& model, SourceRange at) {
  for (const syntax::Decl* decl : model.decls) {
    if (decl->kind == syntax::DeclKind::AtomType && decl->range.file == at.file && decl->range.begin <= at.begin &&
        at.end <= decl->range.end)
      return decl;
  }
  return nullptr;
}

std::string indent_of(std::string_view text, std::uint32_t offset) {
  const std::size_t begin = text.rfind('\n', offset) + 1;  // the first line: npos + 1 = 0
  const std::size_t end = std::min(text.find_first_not_of(" \t", begin), text.size());
  return std::string(text.substr(begin, end - begin));
}

bool is_number(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return is_digit(c); });
}

}  // namespace

std::string_view shown_name(std::string_view param) {
  for (const std::string_view hidden : {"initial ", "given "}) {
    if (param.starts_with(hidden)) return param.substr(hidden.size());
  }
  return param;
}

std::optional<Type> meant_type(std::string_view word) {
  constexpr std::pair<std::string_view, Type> kWords[] = {
      {"integer", Type::Int}, {"Integer", Type::Int},  {"Int", Type::Int},       {"INT", Type::Int},
      {"long", Type::Int},    {"short", Type::Int},    {"unsigned", Type::Int},  {"uint", Type::Int},
      {"int32_t", Type::Int}, {"nat", Type::Int},      {"boolean", Type::Bool},  {"Boolean", Type::Bool},
      {"Bool", Type::Bool},   {"BOOL", Type::Bool},    {"real", Type::Float},    {"Real", Type::Float},
      {"Float", Type::Float}, {"number", Type::Float}, {"String", Type::String}, {"str", Type::String},
      {"text", Type::String}};
  for (const auto& [other, type] : kWords) {
    if (word == other) return type;
  }
  return std::nullopt;
}

void help_unknown_name(DiagnosticBuilder d, const Model& model, const syntax::Path& path, std::string_view key,
                       const std::vector<std::string>& names) {
  if (key == "True" || key == "TRUE" || key == "False" || key == "FALSE") {
    const std::string word = key.starts_with('T') ? "true" : "false";
    d.help("write `" + word + "`", path.range, word);
    return;
  }
  if (key == "None" || key == "null" || key == "NULL" || key == "nil") {
    d.note("data always have a value; without one in the declaration it is 0, `false` or the empty string");
    return;
  }
  const std::string port(path.parts[0].name.text);
  std::vector<std::string> variables;
  for (const std::string& name : names) {
    if (name.starts_with(port + ".")) variables.push_back(name);
  }
  if (path.parts.size() <= 2 && !variables.empty()) {
    std::string list;
    for (const std::string& name : variables) list += (list.empty() ? "`" : ", `") + name + "`";
    if (variables.size() == 1) d.help("port `" + port + "` shows " + list, path.range, variables[0]);
    else d.note("port `" + port + "` shows " + list);
    return;
  }
  const syntax::Decl* atom = atom_around(model, path.range);
  if (atom == nullptr) {
    if (path.parts.size() == 2)
      d.note("port `" + port + "` shows no data: its port type has no parameters, or it is no port here");
    return;
  }
  if (path.parts.size() > 1) {
    d.note("an atom sees its own data only; values of others come through connectors");
    return;
  }
  // A name that is too long to be read is not repeated.
  constexpr std::size_t kLongestName = 80;
  if (key.size() > kLongestName) return;
  const std::string_view text = model.sources->text(path.range.file);
  const std::string line = "data int " + std::string(key) + " = 0";
  std::uint32_t at = atom->name.range.end;
  std::string indent = indent_of(text, atom->range.begin) + "  ";
  if (!atom->data.empty()) {
    at = atom->data.back().range.end;
    indent = indent_of(text, atom->data.back().range.begin);
  } else if (const std::size_t open = text.find_first_not_of(" \t\n", at); open < text.size() && text[open] == '(') {
    at = static_cast<std::uint32_t>(std::min(text.find(')', open), text.size() - 1) + 1);
  }
  d.help("declare it: `" + line + "`", {path.range.file, at, at}, "\n" + indent + line);
}

void help_wrong_type(DiagnosticBuilder d, const SourceMap& sources, const syntax::Expr& e, Type wanted, Type got) {
  const auto write = [&](const std::string& text) { d.help("write `" + text + "`", e.range, text); };
  if (e.kind == syntax::ExprKind::Bool && wanted == Type::Int) return write(e.truth ? "1" : "0");
  if (e.kind == syntax::ExprKind::Int && wanted == Type::Bool && (e.text == "0" || e.text == "1"))
    return write(e.text == "1" ? "true" : "false");
  if (e.kind == syntax::ExprKind::String && wanted == Type::Int && is_number(e.text)) return write(std::string(e.text));
  if (wanted == Type::Bool && (got == Type::Int || got == Type::Float)) {
    const bool is_simple = e.kind == syntax::ExprKind::Path && !e.parenthesised;
    const std::string text(sources.text(e.range));
    return write((is_simple || e.parenthesised ? text : "(" + text + ")") + " != 0");
  }
  if (wanted == Type::Int && got == Type::Float)
    d.note("nothing converts to `int` by itself: declare the data `float`, or use whole numbers");
}

void help_arguments(DiagnosticBuilder d, const Model& model, const std::vector<const DataVariable*>& params,
                    SourceRange name, const std::vector<SourceRange>& given) {
  std::string missing, defaults;
  for (std::size_t k = given.size(); k < params.size(); ++k) {
    missing += (missing.empty() ? "`" : ", `") + std::string(shown_name(params[k]->name)) + "`";
    defaults += (k == 0 ? "" : ", ") + std::string(default_of(params[k]->type));
  }
  const std::string_view text = model.sources->text(name.file);
  if (!missing.empty()) {
    d.note(missing + (given.size() + 1 == params.size() ? " has no value" : " have no values"));
    std::uint32_t at = name.end;
    if (!given.empty()) {
      at = given.back().end;
    } else if (at < text.size() && text[at] == '(') {
      ++at;
    } else {
      defaults = "(" + defaults + ")";
    }
    d.help("give one, such as `" + defaults + "`", {name.file, at, at}, defaults);
    return;
  }
  const std::uint32_t from = params.empty() ? given.front().begin : given[params.size() - 1].end;
  const SourceRange surplus{name.file, from, given.back().end};
  d.help(fmt::format("leave `{}` out", model.sources->text(surplus)), surplus, "");
}

SourceRange port_declaration(const Model& model, std::string_view atom, std::string_view port) {
  for (const syntax::Decl* decl : model.decls) {
    if (decl->kind != syntax::DeclKind::AtomType || decl->name.text != atom) continue;
    for (const syntax::PortDecl& p : decl->ports) {
      for (const syntax::PortItem& item : p.items) {
        if (item.name.text == port) return p.range;
      }
    }
  }
  return {};
}

}  // namespace bip::model
