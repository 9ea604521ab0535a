// The reachable stable states of an image and all steps between them, as tables: what questions about runs are decided
// on.
//
// States are numbered in the order of a breadth-first search, the initial one is 0. Successors are the explorer's
// (expander.hpp), the same states as `explore_states` visits; here a step keeps its target and its label. The graph
// grows on demand, so that a violation in its first part is found without the rest. Without time; one thread. Memory:
// 8 bytes a step and 24 bytes a state besides the state itself.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "runtime/explore/expander.hpp"
#include "runtime/explore/explore.hpp"
#include "runtime/explore/state_predicate.hpp"
#include "runtime/explore/state_store.hpp"

namespace bip::rt {

/// A condition on states, and what it reads (ExploreOptions has the same fields for one predicate).
struct GraphPredicate {
  std::function<bool(const Core&)> holds;
  std::vector<u32> connectors;  // whose candidates it reads
  std::vector<u32> atoms;       // without connectors: all atoms that it reads
};
struct GraphOptions {
  MaximalProgress progress = MaximalProgress::On;
  std::size_t bytes = 0;                   // of everything that is stored; 0: no limit
  std::function<bool()> is_stopped;        // called now and then
  std::vector<VariableId> unread_cells;    // as in ExploreOptions
  std::vector<GraphPredicate> predicates;  // at most 64
};

class StateGraph {
 public:
  StateGraph(const Image& image, GraphOptions options);

  /// To the initial state. False: the initialization ends in a fault.
  [[nodiscard]] bool initialize();
  /// Expands states until `wanted` are expanded, all are, or a limit is reached.
  ExploreEnd grow(u32 wanted);

  /// Are all reachable states expanded?
  [[nodiscard]] bool is_complete() const { return expanded() == states(); }
  [[nodiscard]] u32 states() const { return store_->size(); }
  /// States below this one have their steps.
  [[nodiscard]] u32 expanded() const { return static_cast<u32>(values_.size()); }
  [[nodiscard]] u64 steps() const { return targets_.size(); }
  [[nodiscard]] std::size_t bytes() const;

  /// Steps [first, end) of an expanded state: rows of target() and label().
  [[nodiscard]] u64 first_step(u32 state) const { return first_[state]; }
  [[nodiscard]] u64 end_of_steps(u32 state) const { return first_[state + 1]; }
  [[nodiscard]] u32 target(u64 step) const { return targets_[step]; }
  [[nodiscard]] u32 label(u64 step) const { return labels_of_steps_[step]; }
  /// No candidate in the state: a deadlock or a final state. The last state of a run is taken to repeat for ever.
  [[nodiscard]] bool is_end(u32 state) const { return is_end_[state] != 0; }
  /// Which predicates hold in an expanded state: a row of valuation().
  [[nodiscard]] u32 value(u32 state) const { return values_[state]; }
  /// Bit k: predicate k holds.
  [[nodiscard]] u64 valuation(u32 value) const { return valuations_[value]; }
  [[nodiscard]] u32 valuations() const { return static_cast<u32>(valuations_.size()); }
  [[nodiscard]] const StepLabels& labels() const { return labels_; }

  [[nodiscard]] u64 deadlocks() const { return deadlocks_; }
  /// States with a step that ends in a run-time error. Such a step is none of the graph.
  [[nodiscard]] u64 errors() const { return errors_; }
  /// The state's number of the stable state that a core of the same image is in; kNone: it is not in the graph.
  [[nodiscard]] u32 find(const Core& core);
  /// Enters each state in the order of their numbers. The core stays as it is until `visit` returns.
  void each_state(const std::function<void(const Core&)>& visit);
  /// The label of a candidate of the state that a core of the same image is in.
  [[nodiscard]] u32 label_of(Core& core, const Candidate& candidate) { return labels_.of(core, candidate); }

 private:
  ExploreEnd expand_batch(u32 end);
  bool widen();
  u32 value_in(const u64* state);

  const Image& image_;
  GraphOptions options_;
  StateSpace space_;
  StepLabels labels_;
  std::unique_ptr<Expander> expander_;
  std::unique_ptr<StateStore> store_;
  std::vector<ExploreOptions> predicate_options_;  // each with one predicate; evaluators refer to them
  std::vector<PredicateEvaluator> evaluators_;
  std::vector<u64> first_;  // by expanded state, and one more
  std::vector<u32> targets_, labels_of_steps_;
  std::vector<std::uint8_t> is_end_;  // by expanded state
  std::vector<u32> values_;           // by expanded state
  std::vector<u64> valuations_;
  std::unordered_map<u64, u32> row_of_valuation_;
  u64 deadlocks_ = 0, errors_ = 0;
  // Scratch of a batch.
  Outbox out_;
  std::vector<u32> counts_, rows_, batch_values_;
  std::vector<std::uint8_t> batch_ends_;
  std::vector<u64> state_, read_scratch_;
};

}  // namespace bip::rt
