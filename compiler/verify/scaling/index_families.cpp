// See index_families.hpp.
#include "compiler/verify/scaling/index_families.hpp"

#include <algorithm>
#include <charconv>
#include <map>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// "ROOT.row[1].cell[12]": "ROOT.row[1].cell[]" and 12.
std::pair<std::string, u32> split_last_index(const std::string& path) {
  const std::size_t open = path.rfind('[');
  if (open == std::string::npos) return {path, 0};
  const std::size_t close = path.find(']', open);
  u32 index = 0;
  std::from_chars(path.data() + open + 1, path.data() + close, index);
  return {path.substr(0, open + 1) + path.substr(close), index};
}

// The family of the other instance that each one corresponds to: by name and by the type's name.
std::optional<std::vector<u32>> match(const IndexFamilies& from, const System& from_system, const IndexFamilies& to,
                                      const System& to_system) {
  if (from.rows.size() != to.rows.size()) return std::nullopt;
  std::map<std::string, u32> rows;
  for (u32 row = 0; row < to.rows.size(); ++row) rows[to.rows[row].name] = row;
  std::vector<u32> result;
  for (const Family& family : from.rows) {
    const auto found = rows.find(family.name);
    if (found == rows.end()) return std::nullopt;
    const AtomType& type = from_system.atom_types[AtomTypeId(std::size_t{family.type})];
    const AtomType& other = to_system.atom_types[AtomTypeId(std::size_t{to.rows[found->second].type})];
    if (type.name != other.name || type.places != other.places || type.variables.size() != other.variables.size())
      return std::nullopt;
    result.push_back(found->second);
  }
  return result;
}

}  // namespace

std::optional<IndexFamilies> find_families(const System& system) {
  IndexFamilies result;
  std::map<std::string, u32> rows;
  for (std::size_t atom = 0; atom < system.atoms.size(); ++atom) {
    const Atom& row = system.atoms[AtomId(atom)];
    const auto [name, index] = split_last_index(row.path);
    const auto [found, is_new] = rows.try_emplace(name, static_cast<u32>(result.rows.size()));
    if (is_new) result.rows.push_back({name, row.type.value, {}});
    Family& family = result.rows[found->second];
    if (family.type != row.type.value || index != family.atoms.size()) return std::nullopt;
    family.atoms.push_back(static_cast<u32>(atom));
    result.of_atom.push_back({found->second, index});
  }
  return result;
}

std::optional<Dimensions> find_dimensions(const IndexFamilies& large, const System& large_system,
                                          const IndexFamilies& small, const System& small_system) {
  const std::optional<std::vector<u32>> small_of = match(large, large_system, small, small_system);
  if (!small_of) return std::nullopt;
  Dimensions result;
  std::map<std::size_t, u32> dimension_of_growth;
  for (std::size_t row = 0; row < large.rows.size(); ++row) {
    const std::size_t length = large.rows[row].atoms.size(), before = small.rows[(*small_of)[row]].atoms.size();
    BIP_ASSERT(length > 0 && before > 0, "an array of {} components, and one of {}", length, before);
    if (length < before) return std::nullopt;
    u32 dimension = Dimensions::kFixed;
    if (length != before) {
      const auto [found, is_new] = dimension_of_growth.try_emplace(length - before, result.count);
      result.count += is_new ? 1 : 0;
      dimension = found->second;
    }
    result.of_family.push_back(dimension);
  }
  return result;
}

std::optional<InstanceView> view_instance(const System& system, const IndexFamilies& large, const System& large_system,
                                          const Dimensions& dimensions) {
  std::optional<IndexFamilies> families = find_families(system);
  if (!families) return std::nullopt;
  InstanceView view;
  std::optional<std::vector<u32>> family_of_large = match(large, large_system, *families, system);
  if (!family_of_large) return std::nullopt;
  view.family_of_large = std::move(*family_of_large);
  view.large_family_of.resize(families->rows.size());
  view.lengths.resize(dimensions.count, 0);
  std::vector<std::optional<std::size_t>> growth(dimensions.count);
  for (u32 row = 0; row < large.rows.size(); ++row) {
    view.large_family_of[view.family_of_large[row]] = row;
    const std::size_t length = families->rows[view.family_of_large[row]].atoms.size(),
                      of_large = large.rows[row].atoms.size();
    const u32 dimension = dimensions.of_family[row];
    if (dimension == Dimensions::kFixed ? length != of_large : length > of_large) return std::nullopt;
    if (dimension == Dimensions::kFixed) continue;
    std::optional<std::size_t>& known = growth[dimension];
    if (known && *known != of_large - length) return std::nullopt;
    known = of_large - length;
    view.lengths[dimension] = std::max(view.lengths[dimension], static_cast<u32>(length));
  }
  BIP_ASSERT(view.family_of_large.size() == large.rows.size() && view.large_family_of.size() == large.rows.size(),
             "{} arrays, {} and {} are known", large.rows.size(), view.family_of_large.size(),
             view.large_family_of.size());
  view.families = std::move(*families);
  return view;
}

}  // namespace bip::verify
