// What takes its turn with each label of a graph of states, as fairness has it.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/verify/property/fairness.hpp"
#include "runtime/explore/step_labels.hpp"

namespace bip::verify {

/// The units that take their turn with each label, and how: of a term about interactions the label itself, of one about
/// atoms those that take part, of a name that name.
class FairUnits {
 public:
  FairUnits(const rt::StepLabels& labels, const Fairness& fairness);
  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(is_strong_.size()); }
  /// In ascending order.
  [[nodiscard]] const std::vector<std::uint32_t>& of(std::uint32_t label) const { return units_[label]; }
  [[nodiscard]] bool is_strong(std::uint32_t unit) const { return is_strong_[unit] != 0; }
  /// The unit of a term with a name.
  [[nodiscard]] std::uint32_t of_term(std::size_t term) const { return first_[term]; }

 private:
  std::vector<std::vector<std::uint32_t>> units_;  // by label
  std::vector<std::uint8_t> is_strong_;            // by unit
  std::vector<std::uint32_t> first_;               // by term: its first unit
};

}  // namespace bip::verify
