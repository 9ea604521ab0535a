// See check_data.hpp.
#include "compiler/genom/check_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/genom/codel_arguments.hpp"

namespace bip::genom {

using idl::Component;
using idl::Direction;
using idl::Kind;

namespace {

/// Follows an initial value (idl::Parameter::initial, JSON) along its type, and reports names that the type has not.
/// What is no JSON, an expression that is not known here, is passed over.
class InitialValue {
 public:
  InitialValue(const Component& c, const idl::Parameter& p, Diagnostics& diags)
      : component_(c), text_(p.initial), range_(p.range), diags_(diags) {}

  void check(std::optional<std::size_t> type) {
    while (type && component_.plain(*type).kind == Kind::Optional) type = component_.plain(*type).element;
    const idl::Type* const t = type ? &component_.plain(*type) : nullptr;
    if (accept('{')) {
      while (at_ < text_.size() && text_[at_] == '"') {
        const std::string name = quoted();
        const bool is_struct = t != nullptr && t->kind == Kind::Struct;
        const idl::Member* const member = is_struct ? find_row(t->members, name) : nullptr;
        if (is_struct && member == nullptr) report("member", name, *t);
        if (!accept(':')) return;
        check(member != nullptr ? std::optional(member->type) : std::nullopt);
        if (!accept(',')) break;
      }
      accept('}');
    } else if (accept('[')) {
      const bool has_elements = t != nullptr && (t->kind == Kind::Array || t->kind == Kind::Sequence);
      while (at_ < text_.size() && text_[at_] != ']') {
        check(has_elements ? std::optional(t->element) : std::nullopt);
        if (!accept(',')) break;
      }
      accept(']');
    } else if (at_ < text_.size() && text_[at_] == '"') {
      const std::string name = quoted();
      if (t != nullptr && t->kind == Kind::Enum &&
          std::find(t->enumerators.begin(), t->enumerators.end(), name) == t->enumerators.end())
        report("enumerator", name, *t);
    } else {
      at_ = std::min(text_.find_first_of(",]}", at_), text_.size());
    }
  }

 private:
  bool accept(char sign) {
    if (at_ >= text_.size() || text_[at_] != sign) return false;
    ++at_;
    return true;
  }
  std::string quoted() {
    const std::size_t begin = ++at_;
    while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
    at_ = std::min(at_, text_.size());
    std::string name(text_.substr(begin, at_ - begin));
    accept('"');
    return name;
  }
  void report(const char* kind, const std::string& name, const idl::Type& t) {
    std::vector<std::string> known = t.enumerators;
    for (const idl::Member& m : t.members) known.push_back(m.name);
    auto d = diags_.report(Diag::kB6008, range_, kind, name);
    d.help(fmt::format("`{}` has {}", t.full_name, fmt::join(known, ", ")));
  }

  const Component& component_;
  std::string_view text_;
  SourceRange range_;
  Diagnostics& diags_;
  std::size_t at_ = 0;
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
      InitialValue(c, p, diags).check(type);
    }
    check(s.codels, names.locals_of(s));
  }
  return diags.error_count() == errors;
}

}  // namespace bip::genom
