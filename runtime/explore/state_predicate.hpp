// Does a predicate (ExploreOptions::predicate) hold in a state? It is evaluated once for each combination of the local
// states that it reads, and the result is stored; a predicate that reads what connectors offer, so all atoms, is
// evaluated each time.
//
// An evaluator belongs to one thread. In a state that no core can enter the predicate counts as true: no path to it
// will be found, so nothing is claimed.
#pragma once
#include <unordered_map>

#include "runtime/explore/expander.hpp"
#include "runtime/explore/explore.hpp"

namespace bip::rt {

class PredicateEvaluator {
 public:
  /// `options` must outlive the evaluator and have a predicate.
  PredicateEvaluator(const StateSpace& space, const ExploreOptions& options) : space_(space), options_(options) {}

  [[nodiscard]] bool holds(const u64* state, Expander& expander);
  /// Forgets all results: a new layout has other numbers.
  void relayout() { known_.clear(); }
  [[nodiscard]] std::size_t bytes() const { return known_.size() * kEntryBytes; }

 private:
  static constexpr u32 kKeyBits = 64;
  static constexpr std::size_t kKept = 1u << 20, kEntryBytes = 40;  // entries; about what one takes

  // False: the atoms' numbers are too long for one.
  [[nodiscard]] bool key_of(const u64* state, u64& key) const;

  const StateSpace& space_;
  const ExploreOptions& options_;
  std::unordered_map<u64, bool> known_;
};

}  // namespace bip::rt
