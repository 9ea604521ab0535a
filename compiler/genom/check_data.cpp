// See check_data.hpp.
#include "compiler/genom/check_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/genom/check_scalar.hpp"
#include "compiler/genom/codel_arguments.hpp"

namespace bip::genom {

using idl::Component;
using idl::Direction;
using idl::Kind;
using idl::Value;
using idl::ValueKind;

namespace {

/// Follows an initial value along its type: reports names that the type has not, and values of other types.
class InitialValue {
 public:
  InitialValue(const Component& c, const idl::Parameter& p, Diagnostics& diags)
      : component_(c), range_(p.range), what_(fmt::format("the initial value of `{}`", p.name)), diags_(diags) {}

  void check(std::optional<std::size_t> type, const Value& value) const {
    while (type && component_.plain(*type).kind == Kind::Optional) type = component_.plain(*type).element;
    const idl::Type* const t = type ? &component_.plain(*type) : nullptr;
    if (value.kind == ValueKind::Object) return check_members(t, value);
    if (value.kind == ValueKind::List) {
      const bool has_elements = t != nullptr && (t->kind == Kind::Array || t->kind == Kind::Sequence);
      if (t != nullptr && !has_elements && t->kind != Kind::Struct && t->kind != Kind::Union)
        return mismatch(*t, value);
      // A request brings a value for the whole array, so missing elements would have no value.
      const std::size_t least = has_elements && t->kind == Kind::Array ? static_cast<std::size_t>(t->bound) : 0;
      if (has_elements && t->bound != 0 &&
          (value.parts.size() > static_cast<std::size_t>(t->bound) || value.parts.size() < least))
        diags_.report(Diag::kB6010, value.range, fmt::format("the length of {}", what_), value.parts.size(), least,
                      t->bound);
      for (const Value& part : value.parts) check(has_elements ? std::optional(t->element) : std::nullopt, part);
      return;
    }
    const bool is_name = value.kind == ValueKind::Enumerator || value.kind == ValueKind::Name;
    if (t != nullptr && is_name && t->kind == Kind::Enum) {
      if (std::find(t->enumerators.begin(), t->enumerators.end(), value.text) == t->enumerators.end())
        unknown("enumerator", value.text, *t);
    } else if (t != nullptr && value.kind == ValueKind::Name) {
      diags_.report(Diag::kB6008, value.range, "constant", value.text);
    } else if (t != nullptr) {
      idl::check_scalar(*t, value, what_, value.range, diags_);
    }
  }

 private:
  void check_members(const idl::Type* t, const Value& value) const {
    const bool is_struct = t != nullptr && t->kind == Kind::Struct;
    if (t != nullptr && !is_struct && t->kind != Kind::Union) return mismatch(*t, value);
    for (std::size_t k = 0; k < value.parts.size(); ++k) {
      const idl::Member* const member = is_struct ? find_row(t->members, value.names[k]) : nullptr;
      if (is_struct && member == nullptr) unknown("member", value.names[k], *t);
      check(member != nullptr ? std::optional(member->type) : std::nullopt, value.parts[k]);
    }
  }
  void unknown(const char* kind, const std::string& name, const idl::Type& t) const {
    std::vector<std::string> known = t.enumerators;
    for (const idl::Member& m : t.members) known.push_back(m.name);
    auto d = diags_.report(Diag::kB6008, range_, kind, name);
    d.help(fmt::format("`{}` has {}", t.full_name, fmt::join(known, ", ")));
  }
  void mismatch(const idl::Type& t, const Value& value) const {
    diags_.report(Diag::kB6032, value.range, what_, idl::name_of(value.kind), idl::type_text(t));
  }

  const Component& component_;
  SourceRange range_;
  std::string what_;
  Diagnostics& diags_;
};

// What is read is `in`, what is written `out`; an `out` port may be `inout`: what was written last is changed.
void check_direction(const Component& c, const idl::Codel& codel, const idl::Argument& a,
                     const std::vector<idl::Member>& locals, Diagnostics& diags) {
  if (a.path.size() != 1 || (a.place != idl::Place::Port && a.place != idl::Place::Any)) return;
  const std::string& name = a.path.front();
  if (a.place == idl::Place::Any && (find_row(locals, name) != nullptr || find_row(c.ids, name) != nullptr)) return;
  const idl::Port* const port = find_row(c.ports, name);
  if (port == nullptr || (port->is_out ? a.direction != Direction::In : a.direction == Direction::In)) return;
  diags.report(Diag::kB6028, a.range, codel.name, port->is_out ? "reads" : "writes", name, port->is_out ? "out" : "in");
}

// Functions, and `validate` of attributes, run in the control task, which has no ports in genom3.
void check_no_ports(const Component& c, const idl::Service& s, const std::vector<idl::Member>& locals,
                    Diagnostics& diags) {
  if (s.kind == idl::ServiceKind::Activity) return;
  for (const idl::Codel& codel : s.codels) {
    for (const idl::Argument& a : codel.arguments) {
      if (a.path.empty() || find_row(c.ports, a.path.front()) == nullptr) continue;
      const std::string& name = a.path.front();
      const bool is_other = find_row(locals, name) != nullptr || find_row(c.ids, name) != nullptr;
      if (a.place != idl::Place::Port && (a.place != idl::Place::Any || is_other)) continue;
      auto d = diags.report(Diag::kB6033, a.range, codel.name, name,
                            s.kind == idl::ServiceKind::Function ? "functions" : "attributes");
      d.help("an `activity` whose codels are in a task has ports");
    }
  }
}

}  // namespace

bool check_data(const Component& c, Diagnostics& diags) {
  const std::size_t errors = diags.error_count();
  const CodelArguments names(c);
  const auto text = [](const std::vector<std::string>& steps) {
    std::string path;
    for (const std::string& step : steps) path += (path.empty() || step.starts_with("[") ? "" : ".") + step;
    return path;
  };
  const auto check = [&](const std::vector<idl::Codel>& codels, const std::vector<idl::Member>& locals) {
    for (const idl::Codel& codel : codels) {
      for (const idl::Argument& a : codel.arguments) {
        if (!names.argument(a, locals)) diags.report(Diag::kB6021, a.range, text(a.path), codel.name);
        check_direction(c, codel, a, locals, diags);
      }
    }
  };
  for (const idl::Task& t : c.tasks) check(t.codels, t.locals);
  for (const idl::Service& s : c.services) {
    for (const idl::Parameter& p : s.parameters) {
      const std::optional<std::size_t> type = names.type_of(s, p);
      if (!type) diags.report(Diag::kB6008, p.range, "ids member", text(p.path));
      InitialValue(c, p, diags).check(type, p.initial);
    }
    check(s.codels, names.locals_of(s));
    check_no_ports(c, s, names.locals_of(s), diags);
  }
  return diags.error_count() == errors;
}

}  // namespace bip::genom
