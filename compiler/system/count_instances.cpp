// How many atoms and compounds a root has at least, counted before any is made: compounds of compounds of compounds
// double fast, and to make as many as memory holds takes minutes.
#include <algorithm>

#include "compiler/model/evaluate.hpp"
#include "compiler/system/instantiator.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::system {

namespace {

/// Counts stop here, so that their sums and products fit.
constexpr std::uint64_t kMany = std::uint64_t{1} << 40;

std::uint64_t sum(std::uint64_t so_far, std::uint64_t elements, std::uint64_t of_each) {
  if (elements == 0) return so_far;
  return of_each <= (kMany - so_far) / elements ? so_far + elements * of_each : kMany;
}

/// Elements of a component that is declared outside of loops; of an array whose size needs parameters none.
std::uint64_t least_elements(const Model& model, const CompoundType& type, const CompoundItem& item) {
  if (!item.index.is_valid()) return 1;
  if (!type.params.empty()) return 0;
  const model::Evaluated size = model::evaluate(model.code, item.index, {});
  return size.fault == model::Fault::None ? static_cast<std::uint64_t>(std::max(size.value.int_value, 0)) : 0;
}

}  // namespace

InstanceCount LeastCounts::of(CompoundTypeId type) {
  BIP_ASSERT(type.value < known_.size(), "compound type {} of {}", type, known_.size());
  if (known_[type.value]) return *known_[type.value];
  InstanceCount count{.atoms = 0, .compounds = 1};
  // Types do not contain themselves and are not nested deep: the model was refused otherwise.
  for (const CompoundItem& item : model_.compound_types[type].items) count = with(count, type, item);
  known_[type.value] = count;
  return count;
}

InstanceCount LeastCounts::with(InstanceCount count, CompoundTypeId type, const CompoundItem& item) {
  if (item.kind != ItemKind::Component) return count;
  const CompoundType& owner = model_.compound_types[type];
  const ComponentFamily& family = owner.components[item.family];
  const std::uint64_t elements = least_elements(model_, owner, item);
  if (!family.is_compound) return {.atoms = sum(count.atoms, elements, 1), .compounds = count.compounds};
  const InstanceCount each = of(family.compound);
  return {.atoms = sum(count.atoms, elements, each.atoms), .compounds = sum(count.compounds, elements, each.compounds)};
}

bool Instantiator::is_too_large(CompoundTypeId root) {
  LeastCounts least(model);
  InstanceCount count{.atoms = 0, .compounds = 1};
  for (const CompoundItem& item : model.compound_types[root].items) {
    count = least.with(count, root, item);
    const SourceRange at = item.index.is_valid() ? item.syntax->index->range : item.range;
    // too_many asks whether there is room for one more.
    if (too_many(count.compounds - 1, "compounds", at)) return true;
    if (count.atoms > 0 && too_many(count.atoms - 1, "atoms", at)) return true;
  }
  return false;
}

}  // namespace bip::system
