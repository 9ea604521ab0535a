// Linking priorities of compounds whose connectors export ports: see InnerRules in tables.hpp. Linear in the connectors
// and the rules.
#include <algorithm>

#include "runtime/core/link/tables.hpp"

namespace bip::rt {

namespace {

u32 depth_of(const Image& image, u32 compound) {
  u32 depth = 0;
  for (; image.compounds[compound].parent != kNone; compound = image.compounds[compound].parent) ++depth;
  return depth;
}

// Connectors that a sibling binds: their interactions are parts of the sibling's.
std::vector<bool> bound_by_siblings(const Image& image) {
  std::vector<bool> bound(image.connectors.size, false);
  const auto note = [&](const Connector& above, const PortRef& ref) {
    if (ref.connector != kNone && !ref.maximal_only && image.connectors[ref.connector].parent == above.parent)
      bound[ref.connector] = true;
  };
  for (const Connector& above : image.connectors) {
    for (u32 param = 0; param < image.connector_types[above.type].params.size; ++param) {
      const PortRef ref = image.port_refs[above.ports + param];
      note(above, ref);
      if (ref.choice == kNone) continue;
      for (const PortRef& port : image.choices[ref.choice].ports) note(above, port);
    }
  }
  return bound;
}

}  // namespace

void link_inner_rules(Tables& tables) {
  const Image& image = *tables.image;
  const auto is_bound = [&](u32 connector) {
    return tables.connector_type(connector).exports && image.connectors[connector].bound;
  };
  // Most systems have no such rule, and need not look at what each connector binds.
  const auto may_decide = [&](const Pattern& side) { return side.any_connector || is_bound(side.connector); };
  if (std::none_of(image.priorities.begin(), image.priorities.end(),
                   [&](const Priority& rule) { return may_decide(rule.low) || may_decide(rule.high); }))
    return;
  const std::vector<bool> has_sibling = bound_by_siblings(image);
  // Exported by the compound and bound outside of it.
  const auto is_inner = [&](u32 connector) { return is_bound(connector) && !has_sibling[connector]; };
  std::vector<bool> has_inner(image.compounds.size, false), has_group(image.compounds.size, false);
  for (u32 connector = 0; connector < image.connectors.size; ++connector) {
    if (is_inner(connector)) has_inner[image.connectors[connector].parent] = true;
  }
  for (const Priority& rule : image.priorities) {
    const bool names_inner = (!rule.low.any_connector && is_inner(rule.low.connector)) ||
                             (!rule.high.any_connector && is_inner(rule.high.connector));
    const bool names_all = rule.low.any_connector || rule.high.any_connector;
    if (names_inner || (names_all && has_inner[rule.parent])) has_group[rule.parent] = true;
  }
  if (std::none_of(has_group.begin(), has_group.end(), [](bool has) { return has; })) return;
  InnerRules& inner = tables.inner_rules;
  std::vector<u32> group_of(image.compounds.size, kNone);
  for (u32 compound = 0; compound < image.compounds.size; ++compound) {
    if (!has_group[compound]) continue;
    group_of[compound] = static_cast<u32>(inner.groups.size());
    inner.groups.push_back({compound, depth_of(image, compound), {}, {}});
  }
  inner.group_of_connector.assign(image.connectors.size, kNone);
  for (u32 connector = 0; connector < image.connectors.size; ++connector) {
    const u32 group = group_of[image.connectors[connector].parent];
    if (group == kNone || (tables.connector_type(connector).exports && !is_inner(connector))) continue;
    inner.group_of_connector[connector] = group;
    inner.groups[group].members.push_back(connector);
  }
  for (u32 rule = 0; rule < image.priorities.size; ++rule) {
    const u32 group = group_of[image.priorities[rule].parent];
    inner.group_of_rule.push_back(group);
    if (group != kNone) inner.groups[group].rules.push_back(rule);
  }
}

}  // namespace bip::rt
