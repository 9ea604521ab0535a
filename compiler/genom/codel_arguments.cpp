// See codel_arguments.hpp.
#include "compiler/genom/codel_arguments.hpp"

#include <fmt/format.h>

#include "compiler/genom/c_mapping.hpp"
#include "compiler/genom/cxx_mapping.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {

using idl::Direction;
using idl::Kind;

std::string CodelArgument::value_of(std::size_t owner) const {
  BIP_ASSERT(value.find('@') == value.rfind('@'), "`{}` names its owner twice", value);
  std::string text = value;
  if (const std::size_t at = text.find('@'); at != std::string::npos) text.replace(at, 1, std::to_string(owner));
  return text;
}

std::optional<std::size_t> CodelArguments::follow(const std::vector<idl::Member>& members,
                                                  const std::vector<std::string>& path, std::string& text) const {
  const std::vector<idl::Member>* fields = &members;
  std::optional<std::size_t> type;
  for (const std::string& step : path) {
    if (step.starts_with("[")) {
      if (!type || component_.plain(*type).kind != Kind::Array) return std::nullopt;
      type = component_.plain(*type).element;
      text += step;
    } else {
      if (type) {
        if (component_.plain(*type).kind != Kind::Struct) return std::nullopt;
        fields = &component_.plain(*type).members;
      }
      const auto found = std::find_if(fields->begin(), fields->end(), [&](const auto& m) { return m.name == step; });
      if (found == fields->end()) return std::nullopt;
      type = found->type;
      text += "." + step;
    }
  }
  return type;
}

std::vector<idl::Member> CodelArguments::locals_of(const idl::Service& s) const {
  std::vector<idl::Member> all;
  for (const idl::Parameter& p : s.parameters) all.push_back({p.name, type_of(s, p).value_or(0), {}});
  all.insert(all.end(), s.locals.begin(), s.locals.end());
  return all;
}
std::optional<std::size_t> CodelArguments::type_of(const idl::Service& s, const idl::Parameter& p) const {
  std::string ignored;
  return s.kind == idl::ServiceKind::Attribute ? follow(component_.ids, p.path, ignored) : std::optional(p.type);
}

std::optional<CodelArgument> CodelArguments::argument(const idl::Argument& a,
                                                      const std::vector<idl::Member>& locals) const {
  const std::string ids = "ids_" + component_.name;
  if (a.place == idl::Place::Remote) {
    if (a.path.size() != 1 || find_row(component_.remotes, a.path.front()) == nullptr)
      return component_.knows_remotes ? std::nullopt : std::optional(CodelArgument{});
    const std::string type = fmt::format("const {}_{}", component_.name, a.path.front()),
                      object = fmt::format("remote_{}_{}", component_.name, a.path.front());
    return CodelArgument{type + (component_.is_cxx ? "&" : " *"), (component_.is_cxx ? "" : "&") + object};
  }
  if (a.path.empty() && component_.is_cxx)
    return CodelArgument{(a.direction == Direction::In ? "const " : "") + component_.name + "_ids&", ids};
  if (a.path.empty())
    return CodelArgument{(a.direction == Direction::In ? "const " : "") + component_.name + "_ids *", "&" + ids};
  const auto data = [&](const std::vector<idl::Member>& members,
                        const std::string& base) -> std::optional<CodelArgument> {
    std::string value = base;
    const std::optional<std::size_t> type = follow(members, a.path, value);
    if (!type) return std::nullopt;
    if (component_.is_cxx) return CodelArgument{cxx_parameter_type(component_, *type, a.direction), value};
    const idl::Type& t = component_.plain(*type);
    const bool is_plain =
        decays(t) || (a.direction == Direction::In && (is_passed_by_value(t) || t.kind == Kind::String));
    return CodelArgument{c_parameter(component_, *type, a.direction, ""), is_plain ? value : "&" + value};
  };
  using enum idl::Place;
  if (a.place == Any || a.place == Local) {
    if (auto found = data(locals, "data_@")) return found;
  }
  if (a.place == Any || a.place == Ids) {
    if (auto found = data(component_.ids, ids)) return found;
  }
  if (a.place == Any || a.place == Port) {
    for (const idl::Port& p : component_.ports) {
      if (p.name != a.path.front() || a.path.size() != 1) continue;
      if (component_.is_cxx)
        return CodelArgument{fmt::format("const {}_{}&", component_.name, p.name),
                             fmt::format("port_{}_{}", component_.name, p.name)};
      return CodelArgument{fmt::format("const {}_{} *", component_.name, p.name),
                           fmt::format("&port_{}_{}", component_.name, p.name)};
    }
  }
  return std::nullopt;
}

}  // namespace bip::genom
