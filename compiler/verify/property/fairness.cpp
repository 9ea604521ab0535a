// See fairness.hpp.
#include "compiler/verify/property/fairness.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

struct FairnessName {
  const char* name;
  Fairness fairness;
};
constexpr FairnessName kFairnessNames[] = {{"none", {}},
                                           {"weak", {FairnessKind::Weak, FairnessUnit::Interactions}},
                                           {"strong", {FairnessKind::Strong, FairnessUnit::Interactions}},
                                           {"weak:atoms", {FairnessKind::Weak, FairnessUnit::Atoms}},
                                           {"strong:atoms", {FairnessKind::Strong, FairnessUnit::Atoms}}};

}  // namespace

std::vector<std::string> fairness_names() {
  std::vector<std::string> names;
  for (const FairnessName& row : kFairnessNames) names.emplace_back(row.name);
  return names;
}

std::optional<Fairness> read_fairness(const std::string& text) {
  for (const FairnessName& row : kFairnessNames) {
    if (text == row.name) return row.fairness;
  }
  return std::nullopt;
}

std::string name_of(const Fairness& fairness) {
  for (const FairnessName& row : kFairnessNames) {
    if (fairness.kind == row.fairness.kind &&
        (fairness.kind == FairnessKind::None || fairness.unit == row.fairness.unit))
      return row.name;
  }
  return {};
}

FairUnits::FairUnits(const rt::StepLabels& labels, FairnessUnit unit) : units_(labels.size()) {
  for (std::uint32_t label = 0; label < labels.size(); ++label) {
    std::vector<std::uint32_t>& own = units_[label];
    if (unit == FairnessUnit::Interactions) {
      own.push_back(label);
    } else {
      for (const rt::PortOfAtom& port : labels.ports(label)) {
        if (std::find(own.begin(), own.end(), port.atom) == own.end()) own.push_back(port.atom);
      }
    }
    BIP_ASSERT(!own.empty(), "step {} is of no unit of fairness", label);
    for (const std::uint32_t row : own) size_ = std::max(size_, row + 1);
  }
}

}  // namespace bip::verify
