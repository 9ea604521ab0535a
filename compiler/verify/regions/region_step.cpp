// See region_step.hpp.
#include "compiler/verify/regions/region_step.hpp"

#include <algorithm>

namespace bip::verify {

RegionStep step_of(const RegionNet& net, u32 connector, const std::vector<u32>& atoms) {
  const Connector& row = net.connector(connector);
  const ConnectorType& type = net.type_of(row);
  RegionStep step;
  step.connector = connector;
  for (std::size_t param = 0; param < row.ports.size(); ++param) {
    const PortRef& ref = row.ports[param];
    const u32 first_bind = type.params[param].first_bind;
    const auto found = std::find(atoms.begin(), atoms.end(), ref.atom.value);
    if (found != atoms.end()) step.members.push_back({static_cast<u32>(found - atoms.begin()), ref.port, first_bind});
    for (const u32 variable : net.type_of(ref.atom.value).ports[ref.port].variables)
      step.binds.push_back(net.range(ref.atom.value, variable));
  }
  for (const DataRef& ref : row.data) step.binds.push_back(net.range(ref.atom.value, ref.variable));
  std::sort(step.members.begin(), step.members.end(),
            [](const RegionStep::Member& a, const RegionStep::Member& b) { return a.space < b.space; });
  return step;
}

bool transfer(const RegionNet& net, u32 connector, std::vector<Range>& binds) {
  const Connector& row = net.connector(connector);
  const ConnectorType& type = net.type_of(row);
  if (type.clauses.empty()) return true;
  const Clause& clause = type.clauses.front();
  IntervalPoint point;
  const auto own = net.ranges.begin() + static_cast<std::ptrdiff_t>(net.first_own[connector]);
  point.self.assign(own, own + static_cast<std::ptrdiff_t>(type.variables.size()));
  point.bind = std::move(binds);
  IntervalDomain domain(net.system->code);
  const bool may_be = !clause.guard.is_valid() || domain.assume(clause.guard, true, point);
  if (may_be) {
    domain.execute(clause.up, point);
    domain.execute(clause.down, point);
  }
  binds = std::move(point.bind);
  return may_be;
}

LocalSpace::Writes writes_to(const RegionNet& net, const RegionStep& step, const RegionStep::Member& member, u32 atom,
                             const std::vector<Range>& binds) {
  LocalSpace::Writes writes;
  const std::vector<std::uint8_t>& assigned = net.assigned[net.connector(step.connector).type.value];
  const std::vector<u32>& variables = net.type_of(atom).ports[member.port].variables;
  for (u32 k = 0; k < variables.size(); ++k) {
    if (assigned[member.first_bind + k] != 0) writes.emplace_back(variables[k], binds[member.first_bind + k]);
  }
  return writes;
}

}  // namespace bip::verify
