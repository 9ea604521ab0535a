// Fairness: which infinite runs count.
//
// None: all. Weak: what is possible in every state from some point on happens infinitely often. Strong: what is
// possible infinitely often happens infinitely often (Lehmann, Pnueli, Stavi 1981). `What` is each interaction, that is
// a set of ports of one connector, or each atom: possible if some interaction with it is. Possible means enabled and
// hidden by no priority, so a candidate, and that its step does not end in a run-time error.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/explore/step_labels.hpp"

namespace bip::verify {

enum class FairnessKind : std::uint8_t { None, Weak, Strong };
enum class FairnessUnit : std::uint8_t { Interactions, Atoms };
struct Fairness {
  FairnessKind kind = FairnessKind::None;
  FairnessUnit unit = FairnessUnit::Interactions;
};

/// What read_fairness reads: `none`, `weak`, `strong`, `weak:atoms`, `strong:atoms`.
[[nodiscard]] std::vector<std::string> fairness_names();
[[nodiscard]] std::optional<Fairness> read_fairness(const std::string& text);
/// Returns the text that read_fairness reads.
[[nodiscard]] std::string name_of(const Fairness& fairness);

/// For each label the units that take their turn with it: the label itself, or the atoms that take part.
class FairUnits {
 public:
  FairUnits(const rt::StepLabels& labels, FairnessUnit unit);
  [[nodiscard]] std::uint32_t size() const { return size_; }
  [[nodiscard]] const std::vector<std::uint32_t>& of(std::uint32_t label) const { return units_[label]; }

 private:
  std::uint32_t size_ = 0;
  std::vector<std::vector<std::uint32_t>> units_;  // by label
};

}  // namespace bip::verify
