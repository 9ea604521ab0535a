// See reached_zones.hpp.
#include "compiler/verify/evidence/reached_zones.hpp"

#include <algorithm>
#include <utility>

#include "compiler/system/inner_priorities.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// No value of a column.
constexpr std::int64_t kUnsaid = INT64_MIN;

}  // namespace

ZoneCollector::ZoneCollector(const System& system, const rt::Image& image,
                             const std::vector<rt::VariableId>& unread_cells, std::size_t bytes, ZoneObserver observer)
    : columns_(state_columns(system, image, unread_cells)), clocks_(1), observer_(observer), bytes_(bytes) {
  if (!system::first_inner_priority(system).empty()) problem_ = "priorities below connectors";
  for (const StateColumn& column : columns_) {
    if (problem_.empty() && !column.is_nameable)
      problem_ =
          "data of a type other than int, bool and string (`" + column.name.substr(0, column.name.size() - 1) + "`)";
  }
  for (std::uint32_t atom = 0; atom < image.atoms.size; ++atom) {
    const Atom& instance = system.atoms[AtomId(std::size_t{atom})];
    const bool is_timed = image.atom_types[image.atoms[atom].type].time != nullptr;
    busy_atoms_.push_back(is_timed ? instance.path : std::string());
    for (const Clock& clock : system.atom_types[instance.type].clocks)
      clocks_.push_back(instance.path + '.' + clock.name);
  }
  if (observer == ZoneObserver::OfResponse) clocks_.emplace_back("observer.since");
  last_.assign(columns_.size() + 2 * busy_atoms_.size() + 1, kUnsaid);
}

void ZoneCollector::append(const rt::Zone& zone, const std::string& rank) {
  BIP_ASSERT(zone.size() == clocks_.size(), "a zone of {} clocks, not {}", zone.size() - 1, clocks_.size() - 1);
  constexpr auto kInf = rt::Zone::kInf;
  rows_ += "zone" + rank;
  for (std::uint32_t i = 1; i < zone.size(); ++i) {
    rows_ += ' ' + clocks_[i] + ">=" + std::to_string(-zone.at(0, i));
    if (zone.at(i, 0) != kInf) rows_ += ' ' + clocks_[i] + "<=" + std::to_string(zone.at(i, 0));
  }
  for (std::uint32_t i = 1; i < zone.size(); ++i) {
    for (std::uint32_t j = 1; j < zone.size(); ++j) {
      const bool follows = zone.at(i, 0) != kInf && zone.at(i, j) == zone.at(i, 0) + zone.at(0, j);
      if (i == j || zone.at(i, j) == kInf || follows) continue;
      rows_ += ' ' + clocks_[i] + '-' + clocks_[j] + "<=" + std::to_string(zone.at(i, j));
    }
  }
  rows_ += '\n';
}

void ZoneCollector::add(const rt::ListedLocation& location) {
  if (!problem_.empty() || is_too_long_) return;
  rows_ += "state";
  std::size_t at = 0;
  for (const StateColumn& column : columns_) {
    const std::int32_t value = column.value_in(*location.state);
    if (std::exchange(last_[at++], value) != value) column.append(value, rows_);
  }
  for (std::size_t atom = 0; atom < busy_atoms_.size(); ++atom, at += 2) {
    if (busy_atoms_[atom].empty()) continue;
    if (std::exchange(last_[at], location.waits[atom]) != location.waits[atom])
      rows_ += ' ' + busy_atoms_[atom] + ".resume=" + std::to_string(location.waits[atom]);
    if (std::exchange(last_[at + 1], location.leaders[atom]) != location.leaders[atom])
      rows_ += ' ' + busy_atoms_[atom] + ".resume-with=" + std::to_string(location.leaders[atom]);
  }
  const int waits = location.is_pending ? 1 : 0;
  if (observer_ == ZoneObserver::OfResponse && std::exchange(last_[at], waits) != waits)
    rows_ += " observer.waits=" + std::to_string(waits);
  rows_ += '\n';
  for (std::size_t k = 0; k < location.zones.size(); ++k)
    append(*location.zones[k], location.ranks.empty() ? "" : " rank=" + std::to_string(location.ranks[k]));
  is_too_long_ = rows_.size() > bytes_;
  if (is_too_long_) rows_ = {};
}

}  // namespace bip::verify
