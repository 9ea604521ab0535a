// See neighbourhood_steps.hpp.
#include "compiler/verify/liveness/neighbourhood_steps.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "compiler/verify/regions/explore_alone.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// A variable with more values is divided at constants.
constexpr std::int64_t kMostValues = 128;
constexpr u32 kMostStatesAlone = 8192;

bool has_few_values(const Range& range) { return range.high - range.low < kMostValues; }

}  // namespace

std::size_t NeighbourhoodSteps::KeyHash::operator()(const Key& key) const {
  std::uint64_t hash = 0x9e3779b97f4a7c15u;
  for (const u32 part : key) hash = (hash ^ part) * 0xff51afd7ed558ccdu, hash ^= hash >> 32;
  return static_cast<std::size_t>(hash);
}

NeighbourhoodSteps::NeighbourhoodSteps(const System& system, const rt::Image& image)
    : net_(build_region_net(system, image)), faultless_(find_faultless_code(net_)) {
  const std::size_t atoms = system.atoms.size();
  steps_of_.resize(atoms);
  spaces_.resize(atoms);
  is_explored_.resize(atoms, 0);
  offers_.resize(atoms);
  for (std::size_t row = 0; row < system.connectors.size(); ++row) {
    std::vector<std::pair<u32, u32>> members;  // atom and port
    // What exports its port and is bound nowhere never runs; a plain rendezvous exports none.
    for (const PortRef& ref : system.connectors[ConnectorId(row)].ports) members.emplace_back(ref.atom.value, ref.port);
    std::sort(members.begin(), members.end());
    atoms_of_.emplace_back();
    ports_.emplace_back();
    for (const auto& [atom, port] : members) {
      atoms_of_.back().push_back(atom);
      ports_.back().push_back(port);
      steps_of_[atom].push_back(static_cast<u32>(row));
    }
  }
  for (u32 atom = 0; atom < atoms; ++atom) {
    const AtomType& type = net_.type_of(atom);
    for (u32 port = 0; port < type.ports.size(); ++port) {
      if (type.ports[port].exported) continue;
      steps_of_[atom].push_back(size());
      atoms_of_.push_back({atom});
      ports_.push_back({port});
    }
  }
  for (const std::vector<u32>& members : atoms_of_) exclusions_.emplace_back(members.size());
}

std::size_t NeighbourhoodSteps::row_in(u32 step, u32 atom) const {
  const std::vector<u32>& members = atoms_of_[step];
  const auto at = std::lower_bound(members.begin(), members.end(), atom);
  BIP_ASSERT(at != members.end() && *at == atom, "component {} takes no part in step {}", atom, step);
  return static_cast<std::size_t>(at - members.begin());
}

u32 NeighbourhoodSteps::port_of(u32 step, u32 atom) const { return ports_[step][row_in(step, atom)]; }

const LocalSpace* NeighbourhoodSteps::space(u32 atom, const CancellationToken& cancellation) {
  if (is_explored_[atom] == 0 && !cancellation.is_over()) {
    is_explored_[atom] = 1;
    spaces_[atom] = explore(atom, cancellation);
  }
  return spaces_[atom].get();
}

// With all variables that have few values; or with places and bools alone.
std::unique_ptr<LocalSpace> NeighbourhoodSteps::explore(u32 atom, const CancellationToken& cancellation) const {
  std::vector<u32> around{atom};
  for (const u32 step : steps_of_[atom]) around.insert(around.end(), atoms_of_[step].begin(), atoms_of_[step].end());
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  RegionConstants constants = constants_of(net_, around);
  const AtomType& type = net_.type_of(atom);
  const std::vector<u32>& classes = net_.values.class_of[net_.system->atoms[AtomId(std::size_t{atom})].type.value];
  for (u32 k = 0; k < type.variables.size(); ++k) {
    const Range& range = net_.range(atom, k);
    if (type.variables[k].type != Type::Int || !has_few_values(range)) continue;
    std::vector<std::int64_t>& all = constants[classes[k]];
    for (std::int64_t value = range.low; value <= range.high; ++value) all.push_back(value);
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
  }
  for (const bool has_ints : {true, false}) {
    std::vector<std::uint8_t> follows;
    for (const DataVariable& variable : type.variables)
      follows.push_back(variable.type == Type::Bool || (has_ints && variable.type == Type::Int) ? 1 : 0);
    std::optional<LocalSpace> found = explore_alone(net_, atom, constants, follows, kMostStatesAlone, cancellation);
    if (found) return std::make_unique<LocalSpace>(std::move(*found));
  }
  return nullptr;
}

NeighbourhoodSteps::Key NeighbourhoodSteps::key_of(u32 step, const Members& members) {
  Key key;
  key.fill(RegionStep::kNone);
  key[0] = step;
  for (std::size_t k = 0; k < members.size(); ++k) {
    key[2 * k + 1] = members[k].atom;
    key[2 * k + 2] = members[k].state;
  }
  return key;
}

const std::vector<NeighbourhoodSteps::Move>& NeighbourhoodSteps::moves(u32 step, const Members& members) {
  // Mostly a state of one of them excludes it, and that is known for fewer states.
  if (is_excluded_by_one(step, members)) return no_moves_;
  const auto [at, is_new] = moves_.try_emplace(key_of(step, members));
  if (is_new) at->second = find_moves(step, members);
  return at->second;
}

bool NeighbourhoodSteps::is_excluded_by_one(u32 step, const Members& members) {
  for (const Member& member : members) {
    const std::size_t row = row_in(step, member.atom);
    if (offer(member, ports_[step][row]) == kNo) return true;
    if (members.size() > 1 && excludes(step, row, member)) return true;
  }
  return false;
}

bool NeighbourhoodSteps::excludes(u32 step, std::size_t row, const Member& member) {
  std::vector<Exclusion>& known = exclusions_[step][row];
  if (known.size() <= member.state) known.resize(spaces_[member.atom]->size(), kUnknown);
  if (known[member.state] == kUnknown) {
    Members one;
    one.add(member);
    known[member.state] = moves(step, one).empty() ? kExcluded : kPossible;
  }
  return known[member.state] == kExcluded;
}

bool NeighbourhoodSteps::is_sure(u32 step, const Members& members) {
  BIP_ASSERT(members.size() == atoms_of_[step].size(), "{} of {} members", members.size(), atoms_of_[step].size());
  for (const Member& member : members) {
    if (faultless_.is_atom[member.atom] == 0 || offer(member, port_of(step, member.atom)) != kSurely) return false;
  }
  if (!is_connector(step)) return true;
  if (faultless_.is_connector[step] == 0) return false;
  const ConnectorType& type = net_.type_of(net_.connector(step));
  if (type.clauses.empty() || !type.clauses.front().guard.is_valid()) return true;
  if (is_excluded_by_one(step, members)) return false;
  const auto [at, is_new] = sure_.try_emplace(key_of(step, members));
  if (is_new) at->second = is_guard_sure(step, members);
  return at->second;
}

NeighbourhoodSteps::Offer NeighbourhoodSteps::offer(const Member& member, u32 port) {
  const LocalSpace& space = *spaces_[member.atom];
  const auto ports = static_cast<u32>(net_.type_of(member.atom).ports.size());
  std::vector<Offer>& offers = offers_[member.atom];
  for (auto at = static_cast<u32>(offers.size()); at < space.size() * ports; ++at) {
    const u32 state = at / ports, row = at % ports;
    offers.push_back(space.surely_offers(state, row) ? kSurely : space.may_offer(state, row) ? kMaybe : kNo);
  }
  return offers[member.state * ports + port];
}

// Of the followed ones the values of their states.
void NeighbourhoodSteps::bind(RegionStep& step, const Members& members) const {
  for (const RegionStep::Member& member : step.members) {
    const Member& at = members[member.space];
    const std::vector<u32>& variables = net_.type_of(at.atom).ports[member.port].variables;
    for (u32 k = 0; k < variables.size(); ++k)
      step.binds[member.first_bind + k] = spaces_[at.atom]->range(at.state, variables[k]);
  }
}

std::vector<NeighbourhoodSteps::Move> NeighbourhoodSteps::find_moves(u32 step, const Members& members) {
  std::vector<Move> result;
  std::vector<LocalSpace::Writes> writes(members.size());
  if (is_connector(step)) {
    std::vector<u32> atoms;
    for (const Member& member : members) atoms.push_back(member.atom);
    RegionStep seen = step_of(net_, step, atoms);
    bind(seen, members);
    std::vector<Range> binds = seen.binds;
    if (!transfer(net_, step, binds)) return result;
    for (const RegionStep::Member& member : seen.members)
      writes[member.space] = writes_to(net_, seen, member, atoms[member.space], binds);
  }
  result.emplace_back();
  result.back().fill(0);
  for (std::size_t k = 0; k < members.size(); ++k) {
    const Member& member = members[k];
    const std::vector<u32> states = spaces_[member.atom]->after(member.state, port_of(step, member.atom), writes[k]);
    std::vector<Move> more;
    for (const Move& move : result) {
      for (const u32 state : states) {
        more.push_back(move);
        more.back()[k] = state;
      }
    }
    result = std::move(more);
  }
  return result;
}

bool NeighbourhoodSteps::is_guard_sure(u32 step, const Members& members) const {
  const ConnectorType& type = net_.type_of(net_.connector(step));
  std::vector<u32> atoms;
  for (const Member& member : members) atoms.push_back(member.atom);
  RegionStep seen = step_of(net_, step, atoms);
  bind(seen, members);
  IntervalPoint point;
  const auto own = net_.ranges.begin() + static_cast<std::ptrdiff_t>(net_.first_own[step]);
  point.self.assign(own, own + static_cast<std::ptrdiff_t>(type.variables.size()));
  point.bind = std::move(seen.binds);
  return IntervalDomain(net_.system->code).evaluate(type.clauses.front().guard, point).low >= 1;
}

}  // namespace bip::verify
