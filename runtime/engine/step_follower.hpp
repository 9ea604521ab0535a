// What is written about the steps of several nodes, made where it is written: a core that takes each step again. Nodes
// then send interactions in place of texts, which costs them next to nothing, and the texts are made once.
//
// The same values as at the node that began the step: the order in which steps are written is one of the sequential
// semantics. One more core of the model, and one step of it for each step.
#pragma once
#include "runtime/core/core.hpp"
#include "runtime/engine/output.hpp"

namespace bip::rt {

/// Do the interactions of steps tell all that is written about them? Not those of models with time, nor of models that
/// call C++: it runs once for each step, at home. All processes of a run have the same answer.
[[nodiscard]] bool can_follow_steps(const Core& core, const Output& output);

class StepFollower {
 public:
  /// At the state before the first step. `core` must outlive it.
  StepFollower(const Core& core, const State& initial);
  /// Makes the text of step `number` and takes it. False: it is no step of the model here, or comes after a fault;
  /// nothing follows.
  [[nodiscard]] bool take(EnabledSet::Position at, u64 number, Output& output, StepText& text);
  /// The last step ended in a run-time error.
  [[nodiscard]] bool has_met_fault() const { return has_met_fault_; }

 private:
  Core core_;
  bool has_met_fault_ = false;
};

}  // namespace bip::rt
