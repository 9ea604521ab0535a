// See scope.hpp. Linear searches: a functional level has hundreds of names, a file tens of rules.
#include "compiler/rules/scope.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::rules {
namespace {

using genom::Condition;
using genom::ConditionKind;

// The index of what is called so in a module, or its size.
template <class Rows>
std::size_t find(const Rows& rows, const std::string& name) {
  return static_cast<std::size_t>(
      std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.name.text == name; }) - rows.begin());
}

// What a poster may hold, all its values together.
constexpr std::size_t kMostChoices = 256;
// Of a number beside fractions: so many ten-thousandths can still be added up.
constexpr std::int64_t kMostWhole = 9999;

struct Found {
  std::size_t module = 0, row = 0;
};

// Of services or posters, with or without their module.
template <class Rows>
std::optional<Found> look_up(const std::vector<genom::Module>& modules, Rows genom::Module::*rows, const Path& path,
                             const char* what, Diagnostics& diags) {
  std::vector<std::string> known;
  std::optional<Found> found;
  for (std::size_t m = 0; m < modules.size(); ++m) {
    const bool is_named = path.module.is_set();
    if (is_named && modules[m].name.text != path.module.text) continue;
    const std::size_t row = find(modules[m].*rows, path.name.text);
    for (const auto& r : modules[m].*rows)
      known.push_back(is_named ? modules[m].name.text + "." + r.name.text : r.name.text);
    if (row == (modules[m].*rows).size()) continue;
    if (found) {
      diags
          .report(Diag::kB6100, path.range(), path.name.text, what, modules[found->module].name.text,
                  modules[m].name.text)
          .help("name the module", path.range(), modules[m].name.text + "." + path.name.text);
      return std::nullopt;
    }
    found = {m, row};
  }
  if (found) return found;
  auto d = diags.report(Diag::kB6008, path.range(), what, path.text());
  for (const std::string& similar : similar_names(path.text(), known))
    d.help(fmt::format("there is `{}`", similar), path.range(), similar);
  return std::nullopt;
}

Type type_of(genom::ValueType type) {
  return type == genom::ValueType::Int ? Type::Int : type == genom::ValueType::Float ? Type::Float : Type::Text;
}

const char* name_of(Type t) {
  switch (t) {
    case Type::Bool: return "a truth value";
    case Type::Int: return "a whole number";
    case Type::Float: return "a number with a fraction";
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

std::optional<genom::TaskRef> NameScope::task(const Path& path) {
  const auto found = look_up(modules_, &genom::Module::tasks, path, "task", diags_);
  if (!found) return std::nullopt;
  return genom::TaskRef{found->module, found->row};
}

std::optional<std::size_t> NameScope::module(const Name& name) {
  const std::size_t found = find(modules_, name.text);
  if (found < modules_.size()) return found;
  std::vector<std::string> known;
  for (const genom::Module& m : modules_) known.push_back(m.name.text);
  auto d = diags_.report(Diag::kB6008, name.range, "module", name.text);
  for (const std::string& similar : similar_names(name.text, known))
    d.help(fmt::format("there is `{}`", similar), name.range, similar);
  return std::nullopt;
}

// As BIP writes them.
std::vector<std::string> NameScope::written(const Name& name, genom::ValueType type,
                                            const std::vector<std::string>& values) {
  std::vector<std::string> out;
  for (const std::string& v : values) {
    const bool is_whole = v.find('.') == std::string::npos;
    if (type == genom::ValueType::Float && is_whole && v.size() > (v.starts_with('-') ? 5U : 4U))
      diags_.report(Diag::kB6010, name.range, "a number beside a fraction", v, -kMostWhole, kMostWhole);
    out.push_back(type == genom::ValueType::Text                ? "\"" + v + "\""
                  : type == genom::ValueType::Float && is_whole ? v + ".0"
                                                                : v);
  }
  return out;
}

void NameScope::parameter(const ParameterDecl& decl) {
  for (const Path& path : decl.services) {
    const auto s = service(path);
    if (!s) continue;
    // GenoM 2 does not name parameters, GenoM 3 does: the codels would never get the value of another one.
    const std::vector<std::string>& inputs = at(*s).inputs;
    if (modules_[s->module].generation == 3 &&
        std::find(inputs.begin(), inputs.end(), decl.name.text) == inputs.end()) {
      auto d = diags_.report(Diag::kB6105, decl.name.range, "`" + text(*s) + "`", decl.name.text);
      for (const std::string& similar : similar_names(decl.name.text, inputs))
        d.help(fmt::format("there is `{}`", similar), decl.name.range, similar);
      d.label(path.range(), inputs.empty() ? "a request for it brings no parameter"
                                           : fmt::format("a request for it brings {}", fmt::join(inputs, ", ")));
    }
    for (const genom::ParameterRow& p : constraints_.parameters) {
      if (p.service == *s && p.name == decl.name.text)
        diags_.report(Diag::kB6013, decl.name.range, "parameter", decl.name.text);
    }
    constraints_.parameters.push_back({decl.name.text, *s, decl.type, written(decl.name, decl.type, decl.values)});
  }
}

void NameScope::value(const ValueDecl& decl) {
  const auto p = poster(decl.poster);
  if (!p) return;
  std::size_t choices = decl.values.size();
  for (const genom::ValueRow& v : constraints_.values) {
    if (v.poster != *p) continue;
    BIP_ASSERT(!v.values.empty() && choices > 0, "value `{}` has {} values", v.name, v.values.size());
    if (v.name == decl.name.text) {
      diags_.report(Diag::kB6013, decl.name.range, "value", decl.name.text);
      return;
    }
    choices *= v.values.size();
  }
  // A write is a choice among all of them.
  if (choices > kMostChoices)
    diags_.report(Diag::kB6010, decl.name.range,
                  fmt::format("the number of values that poster `{}` may hold", decl.poster.text()), choices, 1,
                  kMostChoices);
  constraints_.values.push_back({*p, decl.name.text, decl.type, written(decl.name, decl.type, decl.values)});
}

Type NameScope::value_of(const Expr& e, Condition& into) {
  std::size_t found = constraints_.values.size();
  for (std::size_t i = 0; i < constraints_.values.size(); ++i) {
    const genom::ValueRow& v = constraints_.values[i];
    const genom::Module& m = modules_[v.poster.module];
    const std::string& first = e.path.name.text;
    const bool is_module = !e.path.module.is_set() && first == m.name.text;
    const bool is_poster =
        first == m.posters[v.poster.poster].name.text && (!e.path.module.is_set() || e.path.module.text == m.name.text);
    if (v.name != e.name.text || !(first.empty() || is_module || is_poster)) continue;
    if (found < i) {
      const auto owner = [&](std::size_t k) {
        return modules_[constraints_.values[k].poster.module].name.text + "." +
               modules_[constraints_.values[k].poster.module].posters[constraints_.values[k].poster.poster].name.text;
      };
      diags_.report(Diag::kB6100, e.range, e.name.text, "value", owner(found), owner(i));
      return Type::None;
    }
    found = i;
  }
  if (found == constraints_.values.size()) return Type::None;
  BIP_ASSERT(constraints_.values[found].poster.module < modules_.size(), "value {} is of module {}", found,
             constraints_.values[found].poster.module);
  into.kind = ConditionKind::Held;
  into.row = found;
  return type_of(constraints_.values[found].type);
}

bool NameScope::condition(const Expr& e, Subject subject, Moment moment, Condition& into) {
  const Type type = convert(e, subject, moment, into);
  if (type == Type::Bool || type == Type::None) return type == Type::Bool;
  diags_.report(Diag::kB6106, e.range, "a rule", name_of(Type::Bool), name_of(type));
  return false;
}

// An instance of a service can't be rejected or told to stop and be asked how it is in one interaction.
bool NameScope::sees_itself(const Expr& e, genom::ServiceRef seen, Subject subject) {
  if (seen != subject) return false;
  diags_.report(Diag::kB6101, e.range, text(seen))
      .help("while it runs it is active, and a module refuses one activity too many by itself");
  return true;
}

// A poster that has no such value.
bool NameScope::is_poster(const Expr& e) {
  for (const genom::Module& m : modules_) {
    if ((e.path.module.is_set() && e.path.module.text != m.name.text) ||
        find(m.posters, e.path.name.text) == m.posters.size())
      continue;
    diags_.report(Diag::kB6008, e.range, "value", e.path.text() + "." + e.name.text)
        .help(fmt::format("declare it: `value {} of {}: VALUES;`", e.name.text, e.path.text()));
    return true;
  }
  return false;
}

Type NameScope::parameter_of(const Expr& e, std::optional<genom::ServiceRef> s, Moment moment, Condition& into) {
  if (!s) return Type::None;
  for (std::size_t i = 0; i < constraints_.parameters.size(); ++i) {
    const genom::ParameterRow& p = constraints_.parameters[i];
    if (p.service != *s || p.name != e.name.text) continue;
    BIP_ASSERT(!p.values.empty(), "parameter `{}` has no values", p.name);
    into.kind = moment == Moment::Request ? ConditionKind::Asked : ConditionKind::Value;
    into.row = i;
    return type_of(p.type);
  }
  diags_.report(Diag::kB6105, e.name.range, "`" + text(*s) + "`", e.name.text)
      .help(fmt::format("declare it: `parameter {} of {}: VALUES;`", e.name.text, text(*s)));
  return Type::None;
}

Type NameScope::convert(const Expr& e, Subject subject, Moment moment, Condition& into) {
  switch (e.kind) {
    case ExprKind::Number:
      into.number = e.number;
      into.text = e.text;
      return e.text.empty() ? Type::Int : Type::Float;
    case ExprKind::Word: {
      const std::size_t errors = diags_.error_count();
      if (const Type held = value_of(e, into); held != Type::None || diags_.error_count() > errors) return held;
      into.kind = ConditionKind::Text;
      into.text = e.text;
      return Type::Text;
    }
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
    case ExprKind::Of: {
      const std::size_t errors = diags_.error_count();
      if (const Type held = value_of(e, into); held != Type::None || diags_.error_count() > errors) return held;
      if (is_poster(e)) return Type::None;
      return parameter_of(e, service(e.path), Moment::Run, into);
    }
    case ExprKind::Request:
      if (!subject)
        diags_.report(Diag::kB6105, e.range, "a rule with `when`", e.name.text)
            .help(fmt::format("`SERVICE.{}` is that of the last request that was accepted", e.name.text));
      return parameter_of(e, subject, moment, into);
    case ExprKind::Total: return total(e, subject, into);
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
    case ExprKind::Silent: return silence(e, into);
    case ExprKind::Failed:
    case ExprKind::Lost:
    case ExprKind::Late:
    case ExprKind::Missed: {
      // A declared value may have that name.
      const std::size_t errors = diags_.error_count();
      if (const Type held = value_of(e, into); held != Type::None || diags_.error_count() > errors) return held;
      return e.kind == ExprKind::Missed ? missed(e, into) : failure(e, into);
    }
    case ExprKind::Not:
    case ExprKind::Operator: break;
  }
  return combine(e, subject, moment, into);
}

Type NameScope::total(const Expr& e, Subject subject, Condition& into) {
  into.kind = ConditionKind::Total;
  bool has_fractions = false;
  for (std::size_t i = 0; i < constraints_.parameters.size(); ++i) {
    const genom::ParameterRow& p = constraints_.parameters[i];
    // Of the others: what the request would add is `request.p`.
    if (p.name != e.name.text || p.type == genom::ValueType::Text || p.service == subject) continue;
    const bool is_fraction = p.type == genom::ValueType::Float;
    if (!into.rows.empty() && is_fraction != has_fractions) {
      diags_.report(Diag::kB6106, e.name.range, "`total`", name_of(has_fractions ? Type::Float : Type::Int),
                    name_of(is_fraction ? Type::Float : Type::Int));
      return Type::None;
    }
    has_fractions = is_fraction;
    into.rows.push_back(i);
  }
  if (!into.rows.empty()) return has_fractions ? Type::Float : Type::Int;
  diags_.report(Diag::kB6105, e.name.range, "any other service", e.name.text);
  return Type::None;
}

namespace {
// The index of a row that is equal, or of a new one: what is the same is remembered once.
template <class Row>
std::size_t row_of(std::vector<Row>& rows, const Row& row) {
  const auto known = std::find(rows.begin(), rows.end(), row);
  const auto index = static_cast<std::size_t>(known - rows.begin());
  if (known == rows.end()) rows.push_back(row);
  return index;
}

// Has a codel of its activity a budget, which runs beside its task if `is_async`?
bool has_budget(const genom::Service& s, bool is_async) {
  return std::any_of(s.activity.states.begin(), s.activity.states.end(), [&](const genom::State& state) {
    return (state.codel.is_async || !is_async) && state.codel.budget_us > 0;
  });
}
}  // namespace

Type NameScope::silence(const Expr& e, Condition& into) {
  into.kind = ConditionKind::Silent;
  genom::SilenceRow row{.module = {}, .limit = e.span};
  if (e.path.name.is_set()) {
    row.module = module(e.path.name);
    if (!row.module) return Type::None;
  }
  into.row = row_of(constraints_.silences, row);
  return Type::Bool;
}

Type NameScope::failure(const Expr& e, Condition& into) {
  const auto s = service(e.path);
  if (!s) return Type::None;
  const bool is_lost = e.kind == ExprKind::Lost, is_late = e.kind == ExprKind::Late;
  if ((is_lost || is_late) && !has_budget(at(*s), is_lost)) {
    const bool is_activity = at(*s).kind == genom::ServiceKind::Execution;
    auto d = diags_.report(
        Diag::kB6115, e.range, e.path.text() + (is_lost ? ".lost" : ".late"), "never",
        is_activity ? fmt::format("no codel of `{}` has a budget", text(*s))
                    : fmt::format("`{}` is no activity, and only codels of activities are asked about", text(*s)));
    if (is_activity)
      d.help(is_lost ? "say `codel NAME async 20 ms` in the side file, or `async codel` with `wcet` in the description"
                     : "say `codel NAME takes 20 ms` in the side file, or `wcet` in the description");
    return Type::None;
  }
  into.kind = ConditionKind::Failed;
  into.row = row_of(constraints_.failures, {*s, is_lost   ? genom::FailureKind::Lost
                                                : is_late ? genom::FailureKind::Late
                                                          : genom::FailureKind::Failed});
  return Type::Bool;
}

Type NameScope::missed(const Expr& e, Condition& into) {
  const auto t = task(e.path);
  if (!t) return Type::None;
  if (modules_[t->module].tasks[t->task].period_us == 0) {
    diags_.report(Diag::kB6115, e.range, e.path.text() + ".missed", "never",
                  fmt::format("task `{}` has no period", modules_[t->module].tasks[t->task].name.text));
    return Type::None;
  }
  into.kind = ConditionKind::Missed;
  into.row = row_of(constraints_.watched_tasks, *t);
  return Type::Bool;
}

namespace {
// A number, a text, sums and comparisons of them.
bool is_constant(const Condition& c) {
  if (c.kind == ConditionKind::Number || c.kind == ConditionKind::Text) return true;
  return c.kind == ConditionKind::Operator && std::all_of(c.operands.begin(), c.operands.end(), is_constant);
}
}  // namespace

Type NameScope::combine(const Expr& e, Subject subject, Moment moment, Condition& into) {
  into.kind = e.kind == ExprKind::Not ? ConditionKind::Not : ConditionKind::Operator;
  into.text = e.text;
  Type types[2] = {Type::None, Type::None};
  for (std::size_t i = 0; i < e.operands.size(); ++i) {
    types[i] = convert(e.operands[i], subject, moment, into.operands.emplace_back());
    if (types[i] == Type::None) return Type::None;
  }
  BIP_ASSERT(e.operands.size() == (e.kind == ExprKind::Not ? 1 : 2) && into.operands.size() == e.operands.size(),
             "`{}` has {} operands", e.text, e.operands.size());
  const bool is_logic = e.kind == ExprKind::Not || e.text == "&&" || e.text == "||";
  const bool is_equality = e.text == "==" || e.text == "!=";
  const bool is_sum = e.text == "+" || e.text == "-" || e.text == "*";
  const std::string sign = e.kind == ExprKind::Not ? "!" : e.text;
  // A whole number that stands there is a fraction where the other side is one.
  for (std::size_t i = 0; i < 2 && e.operands.size() == 2 && !is_logic; ++i) {
    Condition& of = into.operands[i];
    if (types[i] != Type::Int || types[1 - i] != Type::Float || of.kind != ConditionKind::Number) continue;
    if (of.number > kMostWhole || of.number < -kMostWhole)
      diags_.report(Diag::kB6010, e.operands[i].range, "a number beside a fraction", of.number, -kMostWhole,
                    kMostWhole);
    of.text = std::to_string(std::clamp(of.number, -kMostWhole, kMostWhole)) + ".0";
    types[i] = Type::Float;
  }
  const bool is_fraction = types[0] == Type::Float;
  for (std::size_t i = 0; i < e.operands.size(); ++i) {
    const Type wanted = is_logic                       ? Type::Bool
                        : is_equality                  ? types[0]
                        : is_fraction && e.text != "*" ? Type::Float
                                                       : Type::Int;
    if (types[i] == wanted) continue;
    diags_.report(Diag::kB6106, e.operands[i].range, "`" + sign + "`", name_of(wanted), name_of(types[i]));
    return Type::None;
  }
  if (!is_logic && !is_sum && is_constant(into)) {
    auto d = diags_.report(Diag::kB6106, e.range, "`" + sign + "`", "something that may change",
                           "a comparison of constants");
    if (is_equality && types[0] == Type::Text)
      d.help(
          "a word that is no value is a text: `request.PARAMETER`, `SERVICE.PARAMETER`, or declare `value NAME "
          "of POSTER: VALUES;`");
    return Type::None;
  }
  return !is_sum ? Type::Bool : is_fraction ? Type::Float : Type::Int;
}

}  // namespace bip::rules
