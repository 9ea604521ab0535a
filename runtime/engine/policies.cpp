// The table of policies: see policies.hpp.
#include "runtime/engine/policies.hpp"

#include <algorithm>

#include "bip/assert.hpp"

namespace bip::rt {

namespace {

// The first candidate in canonical order.
class FirstPolicy final : public EnginePolicy {
 public:
  EnabledSet::Position choose(const Core& core, Prng&) override { return core.position(0); }
  StepOrder* order() override { return &order_; }
  [[nodiscard]] std::unique_ptr<EnginePolicy> clone() const override { return std::make_unique<FirstPolicy>(*this); }

 private:
  StepOrder order_{0, false};
};

// The first candidate after the interaction that was fired last, cyclically.
class FairPolicy final : public EnginePolicy {
 public:
  EnabledSet::Position choose(const Core& core, Prng&) override {
    BIP_ASSERT(core.candidate_count() != 0, "a choice among no candidates, from interaction {} on", order_.from);
    if (order_.from == 0 || core.candidate_count() == 1) return core.position(0);
    return core.enabled().first_after(InteractionId(order_.from - 1));
  }
  void fired(InteractionId interaction) override { order_.from = interaction.value + 1; }
  StepOrder* order() override { return &order_; }
  [[nodiscard]] std::unique_ptr<EnginePolicy> clone() const override { return std::make_unique<FairPolicy>(*this); }

 private:
  StepOrder order_{0, true};
};

template <class Chosen>
std::unique_ptr<EnginePolicy> make_policy() {
  return std::make_unique<Chosen>();
}

constexpr PolicyRow kPolicyRows[] = {
    {Policy::Uniform, "uniform", "draws each candidate with the same probability", nullptr},
    {Policy::First, "first", "takes the first candidate in canonical order", make_policy<FirstPolicy>},
    {Policy::Fair, "fair", "takes the next candidate after the one taken last, cyclically", make_policy<FairPolicy>},
};

constexpr bool are_policies_in_order() {
  for (std::size_t k = 0; k < std::size(kPolicyRows); ++k) {
    if (static_cast<std::size_t>(kPolicyRows[k].policy) != k) return false;
  }
  return true;
}
static_assert(are_policies_in_order(), "rows are found by the number of their policy");

}  // namespace

std::span<const PolicyRow> policies() { return kPolicyRows; }

const PolicyRow& row_of(Policy policy) {
  BIP_ASSERT(static_cast<std::size_t>(policy) < std::size(kPolicyRows), "policy {}", policy);
  return kPolicyRows[static_cast<std::size_t>(policy)];
}

const PolicyRow* find_policy(std::string_view name) {
  const auto* const row = std::find_if(std::begin(kPolicyRows), std::end(kPolicyRows),
                                       [&](const PolicyRow& candidate) { return candidate.name == name; });
  return row == std::end(kPolicyRows) ? nullptr : row;
}

}  // namespace bip::rt
