// See local_space.hpp.
#include "compiler/verify/regions/local_space.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {
// A key is a marking and a region for each variable that is followed, in one number.
constexpr std::uint64_t kMostMarkings = 1u << 12, kMostKeys = std::uint64_t{1} << 62;
}  // namespace

std::vector<Range> divide(const Range& range, const std::vector<std::int64_t>& constants) {
  std::vector<Range> parts;
  std::int64_t low = range.low;
  for (auto at = std::lower_bound(constants.begin(), constants.end(), range.low);
       at != constants.end() && *at <= range.high; ++at) {
    if (low < *at) parts.push_back({low, *at - 1});
    parts.push_back({*at, *at});
    low = *at + 1;
  }
  if (low <= range.high) parts.push_back({low, range.high});
  return parts;
}

LocalSpace::LocalSpace(const RegionNet& net, u32 atom, const RegionConstants& constants,
                       const std::vector<std::uint8_t>& follows)
    : net_(net), atom_(atom), type_(net.type_of(atom)), domain_(net.system->code) {
  static const std::vector<std::int64_t> kTruthValues{0, 1};
  const std::vector<u32>& classes = net.values.class_of[net.system->atoms[AtomId(std::size_t{atom})].type.value];
  std::uint64_t keys = kMostMarkings;
  for (u32 k = 0; k < type_.variables.size(); ++k) {
    whole_.push_back(net.range(atom, k));
    column_.push_back(kNone);
    const Type type = type_.variables[k].type;
    if (follows[k] == 0 || net.is_fixed(atom, k) || (type != Type::Int && type != Type::Bool)) continue;
    column_[k] = static_cast<u32>(followed_.size());
    followed_.push_back(k);
    regions_.push_back(divide(whole_[k], type == Type::Bool ? kTruthValues : constants[classes[k]]));
    if (keys > kMostKeys / std::max<std::uint64_t>(1, regions_.back().size())) is_too_large_ = true;
    else keys *= regions_.back().size();
  }
}

IntervalPoint LocalSpace::point_of(Key key) const {
  IntervalPoint point{whole_, {}};
  for (std::size_t k = followed_.size(); k-- > 0;) {
    point.self[followed_[k]] = regions_[k][key % regions_[k].size()];
    key /= regions_[k].size();
  }
  return point;
}

bool LocalSpace::leaves(const std::vector<u32>& marking, const Transition& t) const {
  return std::all_of(t.from.begin(), t.from.end(),
                     [&](u32 place) { return std::binary_search(marking.begin(), marking.end(), place); });
}

// False: a token lands on a marked place, which ends the run.
bool LocalSpace::move_tokens(const std::vector<u32>& marking, const Transition& t, std::vector<u32>& next) const {
  next = marking;
  for (const u32 place : t.from) std::erase(next, place);
  for (const u32 place : t.to) {
    const auto at = std::lower_bound(next.begin(), next.end(), place);
    if (at != next.end() && *at == place) return false;
    next.insert(at, place);
  }
  return true;
}

u32 LocalSpace::number_of_marking(const std::vector<u32>& marking) {
  const auto found = std::find(markings_.begin(), markings_.end(), marking);
  if (found != markings_.end()) return static_cast<u32>(found - markings_.begin());
  if (markings_.size() >= kMostMarkings) {
    is_too_large_ = true;
    return 0;
  }
  markings_.push_back(marking);
  return static_cast<u32>(markings_.size() - 1);
}

// One key for each combination of regions that the ranges meet. Variables that are not followed are forgotten; a value
// outside of what a variable ever is does not occur.
void LocalSpace::add_boxes(u32 marking, const IntervalPoint& point, std::vector<Key>& keys) const {
  const std::size_t first = keys.size();
  keys.push_back(marking);
  for (std::size_t k = 0; k < followed_.size(); ++k) {
    const std::vector<Range>& regions = regions_[k];
    const Range& range = point.self[followed_[k]];
    const auto from = std::lower_bound(regions.begin(), regions.end(), range.low,
                                       [](const Range& region, std::int64_t low) { return region.high < low; });
    const auto to = std::find_if(from, regions.end(), [&](const Range& region) { return region.low > range.high; });
    const std::size_t end = keys.size();
    if (from == to) {
      keys.resize(first);
      return;
    }
    for (std::size_t row = first; row < end; ++row) {
      const Key base = keys[row] * regions.size();
      keys[row] = base + static_cast<Key>(from - regions.begin());
      for (auto at = from + 1; at != to; ++at) keys.push_back(base + static_cast<Key>(at - regions.begin()));
    }
  }
}

u32 LocalSpace::number_of(Key key) {
  const auto [found, is_new] = number_.try_emplace(key, size());
  if (!is_new) return found->second;
  key_of_.push_back(key);
  const std::size_t first = region_of_.size();
  region_of_.resize(first + followed_.size());
  for (std::size_t k = followed_.size(); k-- > 0;) {
    region_of_[first + k] = static_cast<u32>(key % regions_[k].size());
    key /= regions_[k].size();
  }
  marking_of_.push_back(static_cast<u32>(key));
  return found->second;
}

void LocalSpace::settle(u32 marking, const IntervalPoint& point, std::vector<u32>& stable) {
  std::vector<Key> keys;
  add_boxes(marking, point, keys);
  std::vector<u32> next;
  for (std::size_t at = 0; at < keys.size() && !is_too_large_; ++at) {
    const Key key = keys[at];
    if (std::find(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(at), key) !=
        keys.begin() + static_cast<std::ptrdiff_t>(at))
      continue;
    Key rest = key;
    for (std::size_t k = followed_.size(); k-- > 0;) rest /= regions_[k].size();
    const std::vector<u32> places = markings_[static_cast<std::size_t>(rest)];
    bool surely_goes_on = false;
    for (const Transition& t : type_.transitions) {
      if (t.port != Transition::kInternal || !leaves(places, t)) continue;
      IntervalPoint local = point_of(key);
      if (t.guard.is_valid()) {
        const Range truth = domain_.evaluate(t.guard, local);
        local = point_of(key);
        if (!domain_.assume(t.guard, true, local)) continue;
        surely_goes_on |= truth.low >= 1;
      } else {
        surely_goes_on = true;
      }
      domain_.execute(t.action, local);
      if (move_tokens(places, t, next)) add_boxes(number_of_marking(next), local, keys);
    }
    if (!surely_goes_on) stable.push_back(number_of(key));
  }
}

std::vector<u32> LocalSpace::initial() {
  std::vector<u32> stable;
  if (is_too_large_) return stable;
  IntervalPoint point{whole_, {}};
  // Data are zero before the initial action; strings, floats and what is random are any.
  for (u32 k = 0; k < type_.variables.size(); ++k) {
    const DataVariable& variable = type_.variables[k];
    if (!variable.is_param && (variable.type == Type::Int || variable.type == Type::Bool)) point.self[k] = {0, 0};
  }
  domain_.execute(type_.initial_action, point);
  std::vector<u32> marking = type_.initial;
  std::sort(marking.begin(), marking.end());
  settle(number_of_marking(marking), point, stable);
  return stable;
}

std::vector<u32> LocalSpace::after(u32 state, u32 port, const Writes& writes) {
  std::vector<u32> stable, next;
  const std::vector<u32> places = marking(state);
  for (const Transition& t : type_.transitions) {
    if (t.port != port || !leaves(places, t)) continue;
    IntervalPoint local = point_of(key_of_[state]);
    if (t.guard.is_valid() && !domain_.assume(t.guard, true, local)) continue;
    for (const auto& [variable, range] : writes) local.self[variable] = range;
    domain_.execute(t.action, local);
    if (move_tokens(places, t, next)) settle(number_of_marking(next), local, stable);
  }
  std::sort(stable.begin(), stable.end());
  stable.erase(std::unique(stable.begin(), stable.end()), stable.end());
  return stable;
}

const Range& LocalSpace::range(u32 state, u32 variable) const {
  const u32 column = column_[variable];
  return column == kNone ? whole_[variable] : regions_[column][region_of_[state * followed_.size() + column]];
}

bool LocalSpace::is_marked(u32 state, u32 place) const {
  return std::binary_search(marking(state).begin(), marking(state).end(), place);
}

bool LocalSpace::may_offer(u32 state, u32 port) const {
  return std::any_of(type_.transitions.begin(), type_.transitions.end(), [&](const Transition& t) {
    if (t.port != port || !leaves(marking(state), t)) return false;
    IntervalPoint local = point_of(key_of_[state]);
    return !t.guard.is_valid() || domain_.assume(t.guard, true, local);
  });
}

bool LocalSpace::surely_offers(u32 state, u32 port) const {
  // A rule inside of the atom may hide the port; an event from outside may not come.
  const auto hides = [&](const AtomPriority& rule) { return rule.low == AtomPriority::kAnyPort || rule.low == port; };
  if (type_.ports[port].external || std::any_of(type_.priorities.begin(), type_.priorities.end(), hides)) return false;
  return std::any_of(type_.transitions.begin(), type_.transitions.end(), [&](const Transition& t) {
    if (t.port != port || !leaves(marking(state), t)) return false;
    IntervalPoint local = point_of(key_of_[state]);
    return !t.guard.is_valid() || domain_.evaluate(t.guard, local).low >= 1;
  });
}

bool LocalSpace::overlaps(u32 state, const LocalSpace& other, u32 other_state) const {
  BIP_ASSERT(atom_ == other.atom_, "states of atoms {} and {}", atom_, other.atom_);
  if (marking(state) != other.marking(other_state)) return false;
  for (u32 k = 0; k < whole_.size(); ++k) {
    if ((column_[k] != kNone || other.column_[k] != kNone) &&
        common(range(state, k), other.range(other_state, k)).is_empty())
      return false;
  }
  return true;
}

}  // namespace bip::verify
