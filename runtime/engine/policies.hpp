// The policies: how a run chooses among the candidates of a state. This table is the only one: the command line,
// emitted programs, the C ABI, records and traces find policies here.
//
// A new policy is a value of Policy (bip/run.hpp), a class and a row in policies.cpp. `uniform` has no class: Scheduler
// draws by itself, so that the default run makes no virtual call per step.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "bip/prng.hpp"
#include "bip/run.hpp"
#include "runtime/core/core.hpp"

namespace bip::rt {

/// Chooses the candidates of one run; has what it remembers of the steps before.
class EnginePolicy {
 public:
  virtual ~EnginePolicy() = default;
  /// Returns the candidate to take. Requires that there is one. `prng` is the run's: the same seed gives the same run.
  [[nodiscard]] virtual EnabledSet::Position choose(const Core& core, Prng& prng) = 0;
  /// Notes that a step of the interaction was taken: the chosen one, or another if a person or a C++ program chose.
  virtual void fired(InteractionId interaction) { (void)interaction; }
  /// If the choice is the first candidate from some interaction on: how compiled steps make it by themselves, changing
  /// what the policy remembers. Null: all steps of a run are chosen one by one.
  [[nodiscard]] virtual StepOrder* order() { return nullptr; }
  /// Returns a copy with the same memory, for snapshots.
  [[nodiscard]] virtual std::unique_ptr<EnginePolicy> clone() const = 0;
};

struct PolicyRow {
  Policy policy;
  const char* name;                         // on the command line, in records and in traces
  const char* help;                         // what it chooses, a phrase
  std::unique_ptr<EnginePolicy> (*make)();  // null: uniform draws, which Scheduler makes
  [[nodiscard]] bool is_uniform() const { return make == nullptr; }
};

/// Returns all policies, in the order of the enum; the first is the default.
[[nodiscard]] std::span<const PolicyRow> policies();
[[nodiscard]] const PolicyRow& row_of(Policy policy);
/// Returns the policy of this name, or null.
[[nodiscard]] const PolicyRow* find_policy(std::string_view name);
[[nodiscard]] inline const char* name_of(Policy policy) { return row_of(policy).name; }

}  // namespace bip::rt
