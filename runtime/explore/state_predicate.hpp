// Is a state one that is looked for (ExploreOptions::is_broken)? The core is asked once for each combination of the
// local states that the answer depends on, and remembered is what it said; where it depends on what connectors offer,
// so on all atoms, the core is asked each time.
//
// A judge belongs to one thread. A state that cannot be entered counts as broken: no way to it will be found, so
// nothing is claimed.
#pragma once
#include <unordered_map>

#include "runtime/explore/expander.hpp"
#include "runtime/explore/explore.hpp"

namespace bip::rt {

class StateJudge {
 public:
  /// `options` must outlive it and have an `is_broken`.
  StateJudge(const StateSpace& space, const ExploreOptions& options) : space_(space), options_(options) {}

  [[nodiscard]] bool is_broken(const u64* state, Expander& expander);
  /// The layout is a new one: what was remembered has other numbers.
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
