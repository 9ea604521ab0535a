// Linear searches: a functional level has hundreds of names, a file tens of rules.
#include "compiler/rules/scope.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace bip::rules {
namespace {

using genom::Condition;
using genom::ConditionKind;

// The index of what is called so in a module, or its size.
template <class Rows>
std::size_t find(const Rows& rows, const std::string& name) {
  return static_cast<std::size_t>(std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.name.text == name; }) - rows.begin());
}

struct Found {
  std::size_t module = 0, row = 0;
};

// Of services or posters, with or without their module.
template <class Rows>
std::optional<Found> look_up(const std::vector<genom::Module>& modules, Rows genom::Module::*rows, const Path& path, const char* what, Diagnostics& diags) {
  std::vector<std::string> known;
  std::optional<Found> found;
  for (std::size_t m = 0; m < modules.size(); ++m) {
    const bool is_named = path.module.is_set();
    if (is_named && modules[m].name.text != path.module.text) continue;
    const std::size_t row = find(modules[m].*rows, path.name.text);
    for (const auto& r : modules[m].*rows) known.push_back(is_named ? modules[m].name.text + "." + r.name.text : r.name.text);
    if (row == (modules[m].*rows).size()) continue;
    if (found) {
      diags.report(Diag::kB6100, path.range(), path.name.text, what, modules[found->module].name.text, modules[m].name.text)
          .help("name the module", path.range(), modules[m].name.text + "." + path.name.text);
      return std::nullopt;
    }
    found = {m, row};
  }
  if (found) return found;
  auto d = diags.report(Diag::kB6008, path.range(), what, path.text());
  for (const std::string& similar : similar_names(path.text(), known)) d.help(fmt::format("there is `{}`", similar), path.range(), similar);
  return std::nullopt;
}

const char* name_of(Type t) {
  switch (t) {
    case Type::Bool: return "a truth value";
    case Type::Int: return "a number";
    case Type::Text: return "a text";
    case Type::None: break;
  }
  return "nothing";
}

}  // namespace

std::optional<genom::ServiceRef> NameScope::service(const Path& path) {
  const auto found = look_up(modules_, &genom::Module::services, path, "service", diags_);
  if (!found) return std::nullopt;
  return genom::ServiceRef{found->module, found->row};
}

std::optional<genom::PosterRef> NameScope::poster(const Path& path) {
  const auto found = look_up(modules_, &genom::Module::posters, path, "poster", diags_);
  if (!found) return std::nullopt;
  return genom::PosterRef{found->module, found->row};
}

void NameScope::parameter(const ParameterDecl& decl) {
  for (const Path& path : decl.services) {
    const auto s = service(path);
    if (!s) continue;
    for (const genom::ParameterRow& p : constraints_.parameters) {
      if (p.service == *s && p.name == decl.name.text) diags_.report(Diag::kB6013, decl.name.range, "parameter", decl.name.text);
    }
    genom::ParameterRow row{decl.name.text, *s, decl.is_text, {}};
    for (const std::string& v : decl.values) row.values.push_back(decl.is_text ? "\"" + v + "\"" : v);
    constraints_.parameters.push_back(std::move(row));
  }
}

bool NameScope::condition(const Expr& e, genom::ServiceRef subject, bool is_kept, Condition& into) {
  const Type type = convert(e, subject, is_kept, into);
  if (type == Type::Bool || type == Type::None) return type == Type::Bool;
  diags_.report(Diag::kB6106, e.range, "a rule", name_of(Type::Bool), name_of(type));
  return false;
}

// An instance of a service can't be rejected or told to stop and be asked how it is in one interaction.
bool NameScope::sees_itself(const Expr& e, genom::ServiceRef seen, genom::ServiceRef subject) {
  if (seen != subject) return false;
  diags_.report(Diag::kB6101, e.range, text(subject)).help("while it runs it is active, and a module refuses one activity too many by itself");
  return true;
}

Type NameScope::parameter_of(const Expr& e, std::optional<genom::ServiceRef> s, bool is_asked, Condition& into) {
  if (!s) return Type::None;
  for (std::size_t i = 0; i < constraints_.parameters.size(); ++i) {
    const genom::ParameterRow& p = constraints_.parameters[i];
    if (p.service != *s || p.name != e.name.text) continue;
    into.kind = is_asked ? ConditionKind::Asked : ConditionKind::Value;
    into.row = i;
    return p.is_text ? Type::Text : Type::Int;
  }
  diags_.report(Diag::kB6105, e.name.range, e.name.text, text(*s)).help(fmt::format("declare it: `parameter {} of {}: VALUES;`", e.name.text, text(*s)));
  return Type::None;
}

Type NameScope::convert(const Expr& e, genom::ServiceRef subject, bool is_kept, Condition& into) {
  switch (e.kind) {
    case ExprKind::Number:
      into.number = e.number;
      return Type::Int;
    case ExprKind::Text:
      into.kind = ConditionKind::Text;
      into.text = e.text;
      return Type::Text;
    case ExprKind::Active:
    case ExprKind::Done: {
      const auto s = service(e.path);
      if (!s || sees_itself(e, *s, subject)) return Type::None;
      into.kind = e.kind == ExprKind::Active ? ConditionKind::Active : ConditionKind::Done;
      into.service = *s;
      return Type::Bool;
    }
    case ExprKind::Of: return parameter_of(e, service(e.path), false, into);
    case ExprKind::Request: return parameter_of(e, subject, !is_kept, into);
    case ExprKind::Total: {
      into.kind = ConditionKind::Total;
      for (std::size_t i = 0; i < constraints_.parameters.size(); ++i) {
        const genom::ParameterRow& p = constraints_.parameters[i];
        // Of the others: what the request would add is `request.p`.
        if (p.name == e.name.text && !p.is_text && p.service != subject) into.rows.push_back(i);
      }
      if (!into.rows.empty()) return Type::Int;
      diags_.report(Diag::kB6105, e.name.range, e.name.text, "any other service");
      return Type::None;
    }
    case ExprKind::Fresh:
    case ExprKind::Age: {
      const auto p = poster(e.path);
      if (!p) return Type::None;
      into.kind = e.kind == ExprKind::Fresh ? ConditionKind::Fresh : ConditionKind::Age;
      into.poster = *p;
      into.span = e.span;
      return e.kind == ExprKind::Fresh ? Type::Bool : Type::Int;
    }
    case ExprKind::Ordered: {
      const auto first = service(e.path);
      const auto second = service(e.second);
      if (!first || !second) return Type::None;
      into.kind = ConditionKind::Ordered;
      into.row = constraints_.pairs.size();
      constraints_.pairs.push_back({*first, *second});
      return Type::Bool;
    }
    case ExprKind::Not:
    case ExprKind::Operator: break;
  }
  return combine(e, subject, is_kept, into);
}

Type NameScope::combine(const Expr& e, genom::ServiceRef subject, bool is_kept, Condition& into) {
  into.kind = e.kind == ExprKind::Not ? ConditionKind::Not : ConditionKind::Operator;
  into.text = e.text;
  Type types[2] = {Type::None, Type::None};
  for (std::size_t i = 0; i < e.operands.size(); ++i) {
    types[i] = convert(e.operands[i], subject, is_kept, into.operands.emplace_back());
    if (types[i] == Type::None) return Type::None;
  }
  const bool is_logic = e.kind == ExprKind::Not || e.text == "&&" || e.text == "||";
  const bool is_equality = e.text == "==" || e.text == "!=";
  const bool is_sum = e.text == "+" || e.text == "-" || e.text == "*";
  const std::string sign = e.kind == ExprKind::Not ? "!" : e.text;
  for (std::size_t i = 0; i < e.operands.size(); ++i) {
    const Type wanted = is_logic ? Type::Bool : is_equality ? types[0] : Type::Int;
    if (types[i] == wanted) continue;
    diags_.report(Diag::kB6106, e.operands[i].range, "`" + sign + "`", name_of(wanted), name_of(types[i]));
    return Type::None;
  }
  return is_sum ? Type::Int : Type::Bool;
}

}  // namespace bip::rules
