// See joint_explorer.hpp.
#include "compiler/verify/regions/joint_explorer.hpp"

#include <algorithm>
#include <set>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::size_t kTuplesBetweenLooks = 1024;
constexpr u32 kByteStates = JointExplorer::kMostLocalStates;
static_assert(kByteStates == 256, "a local state is a byte of a tuple");

std::size_t index_of_tuple(const JointExplorer::Tuple& tuple) {
  return (std::size_t{tuple[0]} * kByteStates + tuple[1]) * kByteStates + tuple[2];
}

// The region that a range lies in, or those that it begins and ends in, as a whole.
Range widened_to_regions(const Range& range, const std::vector<std::int64_t>& constants) {
  // Truth values, too.
  if (range.low >= 0 && range.high <= 1) return range;
  Range wide = range;
  const auto low = std::lower_bound(constants.begin(), constants.end(), range.low);
  if (low == constants.end() || *low != range.low)
    wide.low = low == constants.begin() ? kAnyInt.low : *std::prev(low) + 1;
  const auto high = std::lower_bound(constants.begin(), constants.end(), range.high);
  if (high == constants.end() || *high != range.high) wide.high = high == constants.end() ? kAnyInt.high : *high - 1;
  return wide;
}

}  // namespace

JointExplorer::JointExplorer(const RegionNet& net, const std::vector<std::vector<std::uint8_t>>& follows)
    : net_(net), follows_(follows), is_reached_(std::size_t{kByteStates} * kByteStates * kByteStates / 64, 0) {}

// Steps that are equal but for data within the same regions are one.
void JointExplorer::collect_steps(const std::vector<u32>& atoms) {
  const RegionConstants constants = constants_of(net_, atoms);
  spaces_.clear();
  for (const u32 atom : atoms)
    spaces_.emplace_back(net_, atom, constants, follows_[net_.system->atoms[AtomId(std::size_t{atom})].type.value]);
  alone_.assign(atoms.size(), {});
  moves_.assign(atoms.size(), {});
  of_three_.clear();
  for (Together& together : together_) {
    for (const u32 at : together.touched) together.list_of[at] = 0;
    together.touched.clear();
    together.steps.clear();
    together.lists.assign(1, {});
  }
  std::size_t pairs = 0;
  for (u32 a = 0; a < atoms.size(); ++a) {
    for (u32 b = a + 1; b < atoms.size(); ++b, ++pairs) {
      if (together_.size() <= pairs) {
        together_.emplace_back().list_of.assign(std::size_t{kByteStates} * kByteStates, 0);
        together_.back().lists.assign(1, {});
      }
      together_[pairs].first = a;
      together_[pairs].second = b;
    }
  }
  std::set<std::vector<std::int64_t>> seen;
  std::vector<std::int64_t> key;
  for (u32 k = 0; k < atoms.size(); ++k) {
    for (const u32 connector : net_.connectors[atoms[k]]) {
      RegionStep step = step_of(net_, connector, atoms);
      // The first of its members brings it.
      if (step.members.front().space != k) continue;
      const ConnectorTypeId type = net_.connector(connector).type;
      key.assign(
          {type.value, net_.type_of(net_.connector(connector)).variables.empty() ? -1 : std::int64_t{connector}});
      for (const RegionStep::Member& member : step.members) {
        key.insert(key.end(), {member.space, member.port, member.first_bind});
        const std::size_t count = net_.type_of(atoms[member.space]).ports[member.port].variables.size();
        for (std::size_t v = 0; v < count; ++v) step.binds[member.first_bind + v] = {0, 0};
      }
      for (std::size_t bind = 0; bind < step.binds.size(); ++bind) {
        bool is_own = false;
        for (const RegionStep::Member& member : step.members) {
          const std::size_t count = net_.type_of(atoms[member.space]).ports[member.port].variables.size();
          is_own |= bind >= member.first_bind && bind < member.first_bind + count;
        }
        if (!is_own)
          step.binds[bind] =
              widened_to_regions(step.binds[bind], constants[net_.values.class_of_bind[type.value][bind]]);
        key.insert(key.end(), {step.binds[bind].low, step.binds[bind].high});
      }
      if (!seen.insert(key).second) continue;
      if (step.members.size() == 1) {
        alone_[k].push_back(std::move(step));
      } else if (step.members.size() == 2) {
        const auto together = std::find_if(together_.begin(), together_.end(), [&](const Together& each) {
          return each.first == step.members[0].space && each.second == step.members[1].space;
        });
        BIP_ASSERT(together != together_.end(), "no pair of {} and {}", step.members[0].space, step.members[1].space);
        together->steps.push_back(std::move(step));
      } else {
        of_three_.push_back(std::move(step));
      }
    }
  }
}

bool JointExplorer::reach(const Tuple& tuple) {
  const std::size_t index = index_of_tuple(tuple);
  std::uint64_t& word = is_reached_[index / 64];
  const std::uint64_t bit = std::uint64_t{1} << (index % 64);
  if ((word & bit) != 0) return false;
  word |= bit;
  reached_.push_back(tuple);
  return true;
}

// All combinations of what the members do.
void JointExplorer::fire(const RegionStep& step, const Tuple& from, const std::function<void(const Tuple&)>& reach) {
  std::vector<Range> binds = step.binds;
  for (const RegionStep::Member& member : step.members) {
    const LocalSpace& space = spaces_[member.space];
    if (!space.may_offer(from[member.space], member.port)) return;
    const std::vector<u32>& variables = net_.type_of(space.atom()).ports[member.port].variables;
    for (u32 k = 0; k < variables.size(); ++k)
      binds[member.first_bind + k] = space.range(from[member.space], variables[k]);
  }
  if (!transfer(net_, step.connector, binds)) return;
  std::vector<Tuple> to{from};
  for (const RegionStep::Member& member : step.members) {
    LocalSpace& space = spaces_[member.space];
    const LocalSpace::Writes writes = writes_to(net_, step, member, space.atom(), binds);
    const std::vector<u32> states = space.after(from[member.space], member.port, writes);
    // The caller gives up; the numbers of the states are no bytes.
    if (space.size() > kMostLocalStates) return;
    std::vector<Tuple> next;
    for (const Tuple& tuple : to) {
      for (const u32 state : states) {
        next.push_back(tuple);
        next.back()[member.space] = static_cast<std::uint8_t>(state);
      }
    }
    to = std::move(next);
  }
  for (const Tuple& tuple : to) reach(tuple);
}

const std::vector<u32>& JointExplorer::moves_alone(u32 space, u32 state) {
  if (moves_[space].size() <= state) moves_[space].resize(state + 1);
  std::optional<std::vector<u32>>& moves = moves_[space][state];
  if (moves) return *moves;
  std::set<u32> states;
  Tuple from{};
  from[space] = static_cast<std::uint8_t>(state);
  for (const RegionStep& step : alone_[space]) fire(step, from, [&](const Tuple& to) { states.insert(to[space]); });
  const AtomType& type = net_.type_of(spaces_[space].atom());
  for (u32 port = 0; port < type.ports.size(); ++port) {
    if (type.ports[port].exported) continue;
    for (const u32 to : spaces_[space].after(state, port, {})) states.insert(to);
  }
  states.erase(state);
  // Steps have added states, but no rows.
  moves_[space][state].emplace(states.begin(), states.end());
  return *moves_[space][state];
}

const std::vector<JointExplorer::Pair>& JointExplorer::moves_together(Together& together, u32 first, u32 second) {
  const std::size_t at = std::size_t{first} * kByteStates + second;
  if (together.list_of[at] != 0) return together.lists[together.list_of[at]];
  std::set<Pair> pairs;
  Tuple from{};
  from[together.first] = static_cast<std::uint8_t>(first);
  from[together.second] = static_cast<std::uint8_t>(second);
  for (const RegionStep& step : together.steps)
    fire(step, from, [&](const Tuple& to) { pairs.insert({to[together.first], to[together.second]}); });
  together.list_of[at] = static_cast<u32>(together.lists.size());
  together.touched.push_back(static_cast<u32>(at));
  together.lists.emplace_back(pairs.begin(), pairs.end());
  return together.lists.back();
}

bool JointExplorer::explore(const std::vector<u32>& atoms, std::size_t most, const CancellationToken& cancellation) {
  BIP_ASSERT(atoms.size() >= 2 && atoms.size() <= kMostFollowed, "{} components", atoms.size());
  for (const Tuple& tuple : reached_) is_reached_[index_of_tuple(tuple) / 64] = 0;
  reached_.clear();
  collect_steps(atoms);
  const auto is_too_large = [&] {
    return std::any_of(spaces_.begin(), spaces_.end(),
                       [](const LocalSpace& space) { return space.is_too_large() || space.size() > kMostLocalStates; });
  };
  std::vector<Tuple> initial{Tuple{}};
  for (u32 k = 0; k < spaces_.size(); ++k) {
    std::vector<Tuple> next;
    for (const u32 state : spaces_[k].initial()) {
      if (state >= kMostLocalStates) return false;
      for (Tuple tuple : initial) {
        tuple[k] = static_cast<std::uint8_t>(state);
        next.push_back(tuple);
      }
    }
    initial = std::move(next);
  }
  for (const Tuple& tuple : initial) reach(tuple);
  for (std::size_t at = 0; at < reached_.size(); ++at) {
    if (reached_.size() > most || is_too_large() || (at % kTuplesBetweenLooks == 0 && cancellation.is_over()))
      return false;
    const Tuple from = reached_[at];
    for (u32 k = 0; k < spaces_.size(); ++k) {
      for (const u32 state : moves_alone(k, from[k])) {
        if (state >= kMostLocalStates) return false;
        Tuple to = from;
        to[k] = static_cast<std::uint8_t>(state);
        reach(to);
      }
    }
    for (Together& together : together_) {
      if (together.steps.empty()) continue;
      for (const Pair& pair : moves_together(together, from[together.first], from[together.second])) {
        Tuple to = from;
        to[together.first] = pair[0];
        to[together.second] = pair[1];
        reach(to);
      }
    }
    for (const RegionStep& step : of_three_) fire(step, from, [&](const Tuple& to) { reach(to); });
  }
  return !is_too_large();
}

}  // namespace bip::verify
