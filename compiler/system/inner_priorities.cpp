// See inner_priorities.hpp. Linear in the connectors and the rules.
#include "compiler/system/inner_priorities.hpp"

#include <fmt/format.h>

#include "compiler/system/system.hpp"

namespace bip::system {

namespace {

// By connector: a sibling binds it, so that its interactions are parts of the sibling's.
std::vector<bool> bound_by_siblings(const System& system) {
  std::vector<bool> bound(system.connectors.size());
  const auto note = [&](const Connector& above, const PortRef& ref) {
    if (ref.kind == PortRef::Kind::Connector && !ref.maximal_only &&
        system.connectors[ref.connector].parent == above.parent)
      bound[ref.connector.value] = true;
  };
  for (const Connector& above : system.connectors) {
    for (const PortRef& ref : above.ports) {
      note(above, ref);
      if (ref.kind != PortRef::Kind::Choice) continue;
      for (const PortRef& port : system.choices[ref.choice].ports) note(above, port);
    }
  }
  return bound;
}

}  // namespace

std::string first_inner_priority(const System& system) {
  if (system.priorities.size() == 0) return {};
  const std::vector<bool> has_sibling = bound_by_siblings(system);
  std::vector<bool> has_inner(system.compounds.size());
  const auto is_inner = [&](ConnectorId id) {
    return !system.is_top(id) && system.connectors[id].bound && !has_sibling[id.value];
  };
  for (std::size_t row = 0; row < system.connectors.size(); ++row) {
    const ConnectorId id(row);
    if (is_inner(id)) has_inner[system.connectors[id].parent.value] = true;
  }
  for (const Priority& rule : system.priorities) {
    for (const Pattern* side : {&rule.low, &rule.high}) {
      if (side->any_connector ? has_inner[rule.parent.value] : is_inner(side->connector))
        return fmt::format("priority `{}` orders connectors that export a port", rule.name);
    }
  }
  return {};
}

}  // namespace bip::system
