// See bad_places.hpp.
#include "compiler/verify/counting/bad_places.hpp"

#include <algorithm>
#include <map>

#include "compiler/verify/counting/class_combinations.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::size_t kMostCombinations = 20'000;
constexpr std::size_t kMostBad = 200;

// What the property sees of a component in the state that the core is in.
std::vector<rt::u64> view_of(const rt::Core& core, u32 atom, const Property& property) {
  std::vector<rt::u64> view;
  for (const PropertyNode& node : property.nodes) {
    if (!names_atom(node.kind) || node.owner != atom) continue;
    if (node.kind == PropertyKind::At) view.push_back(core.is_marked(atom, node.row) ? 1 : 0);
    else if (node.kind == PropertyKind::CanPort) view.push_back(core.enabled_transition(atom, node.row) != rt::kNone);
    else view.push_back(core.cell(core.image().atoms[atom].variable(node.row)).bits);
  }
  return view;
}

}  // namespace

std::optional<std::vector<BadPlaces>> find_bad_places(CountedNetBuilder& builder, const Property& property,
                                                      const std::function<bool(const rt::Core&)>& is_bad) {
  const CountedNet& net = builder.net();
  const std::vector<u32> atoms = atoms_of(property);
  if (atoms.empty() || !connectors_of(property).empty()) return std::nullopt;
  std::vector<std::vector<std::vector<u32>>> classes;  // by component and class: the places
  std::size_t combinations = 1;
  for (const u32 atom : atoms) {
    BIP_ASSERT(net.atom_of_kind[net.kind_of_atom[atom]] == atom, "atom {} is one of several of its kind", atom);
    std::map<std::vector<rt::u64>, std::vector<u32>> by_view;
    for (const u32 place : net.places_of_kind[net.kind_of_atom[atom]]) {
      if (!builder.enter_atoms({atom}, {place})) return std::nullopt;
      by_view[view_of(builder.core(), atom, property)].push_back(place);
    }
    classes.emplace_back();
    for (auto& [view, places] : by_view) classes.back().push_back(std::move(places));
    combinations *= classes.back().size();
    if (combinations > kMostCombinations) return std::nullopt;
  }
  std::vector<ClassCombination> bad;
  std::vector<u32> chosen(atoms.size(), 0), places(atoms.size(), 0);
  for (std::size_t number = 0; number < combinations; ++number) {
    std::size_t rest = number;
    for (std::size_t k = 0; k < atoms.size(); ++k) {
      chosen[k] = static_cast<u32>(rest % classes[k].size());
      rest /= classes[k].size();
      places[k] = classes[k][chosen[k]].front();
    }
    if (!builder.enter_atoms(atoms, places)) return std::nullopt;
    if (!is_bad(builder.core())) continue;
    ClassCombination combination;
    for (const u32 row : chosen) combination.push_back({row});
    bad.push_back(std::move(combination));
  }
  for (std::size_t k = 0; k < atoms.size(); ++k) join_combinations(bad, k);
  if (bad.size() > kMostBad) return std::nullopt;
  std::vector<BadPlaces> result;
  for (const ClassCombination& combination : bad) {
    BadPlaces of_this;
    for (std::size_t k = 0; k < atoms.size(); ++k) {
      std::vector<u32> all;
      for (const u32 row : combination[k]) all.insert(all.end(), classes[k][row].begin(), classes[k][row].end());
      std::sort(all.begin(), all.end());
      of_this.sets.push_back(std::move(all));
    }
    result.push_back(std::move(of_this));
  }
  return result;
}

}  // namespace bip::verify
