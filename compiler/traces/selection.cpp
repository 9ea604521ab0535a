// See selection.hpp.
#include "compiler/traces/selection.hpp"

#include <algorithm>
#include <string_view>

#include "bip/assert.hpp"

namespace bip::traces {

namespace {

// Does the path begin with the name, up to the end of a word of it?
bool is_in(std::string_view path, std::string_view name) {
  if (path.starts_with("ROOT.")) path.remove_prefix(5);
  if (name.starts_with("ROOT.")) name.remove_prefix(5);
  return path.starts_with(name) && (path.size() == name.size() || path[name.size()] == '.' || path[name.size()] == '[');
}

bool is_in_any(std::string_view path, const std::vector<std::string>& names) {
  return names.empty() || std::any_of(names.begin(), names.end(), [&](const std::string& n) { return is_in(path, n); });
}

}  // namespace

bool Selection::is_all() const {
  const Selection all;
  return components.empty() && interactions.empty() && first == all.first && last == all.last && begin == all.begin &&
         end == all.end;
}

std::string Selection::unknown(const rt::Image& image) const {
  const auto has = [](const auto& rows, const std::string& name) {
    for (const auto& row : rows)
      if (is_in(row.path(), name)) return true;
    return false;
  };
  for (const std::string& name : components)
    if (!has(image.atoms, name)) return "component `" + name + "`";
  // The interaction of an internal port is called by its component.
  const auto has_port = [&](const std::string& name) {
    const std::size_t dot = std::min(name.rfind('.'), name.size());
    for (const auto& atom : image.atoms) {
      if (!is_in(atom.path(), name.substr(0, dot))) continue;
      for (const auto& port : image.atom_types[atom.type].ports)
        if (dot < name.size() && name.substr(dot + 1) == port.name) return true;
    }
    return false;
  };
  for (const std::string& name : interactions)
    if (!has(image.connectors, name) && !has_port(name)) return "interaction `" + name + "`";
  return {};
}

bool Selection::takes_component(const std::string& path) const { return is_in_any(path, components); }

bool Selection::takes(const rt::Image& image, const TracedStep& step) const {
  BIP_ASSERT(step.parts != nullptr, "step {} has no parts", step.number);
  if (step.number < first || step.number > last || step.instant < begin || step.instant > end) return false;
  if (!is_in_any(step.interaction, interactions)) return false;
  return components.empty() || std::any_of(step.parts->begin(), step.parts->end(), [&](const rt::MovePart& part) {
           return takes_component(image.atoms[part.atom].path());
         });
}

}  // namespace bip::traces
