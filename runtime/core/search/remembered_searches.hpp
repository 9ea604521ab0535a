// What searches found for the inputs that they had: a search that would read the same again is not made.
//
// A search reads which ports of its plan are enabled and those of their variables that guards and `up`s read (none of
// them where there are merged ports, but no guards); all else that it computes with (the connectors' own variables) it
// sets itself. So equal inputs have equal candidates. Each searched interaction keeps the last few.
#pragma once
#include <vector>

#include "runtime/core/link/tables.hpp"

namespace bip::rt {

struct CoreParts;

class RememberedSearches {
 public:
  /// Looks up what the search of each plan reads. A plan whose code calls C++ functions, or reads data
  /// that no port exports, is never remembered.
  void link(const CoreParts& core);

  /// Reads the inputs of the plan's search. Its candidates if they are known, else null. Cost: a word per variable.
  [[nodiscard]] const std::vector<u64>* recall(const CoreParts& core, u32 plan);
  /// Keeps the configurations that the search found for the inputs that `recall` read last, for the same plan.
  void keep(u32 plan, const std::vector<u64>& configs);

  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Entry {
    u64 hash = 0;
    std::vector<u64> inputs, configs;
  };
  struct PlanMemory {
    u32 first_leaf = 0, end_leaf = 0;  // rows of leaves_
    u32 next = 0;                      // the entry that goes next
    u32 hits = 0, misses = 0;
    bool is_used = false;
    std::vector<Entry> entries;
  };
  struct Leaf {
    u32 port = 0;          // instance
    u32 end_variable = 0;  // of its variables in variables_; they begin where those of the leaf before end
  };
  void read_inputs(const CoreParts& core, const PlanMemory& memory);

  std::vector<PlanMemory> plans_;
  std::vector<Leaf> leaves_;  // a first one without variables
  std::vector<VariableId> variables_;
  std::vector<u64> inputs_;  // that were read last
  u64 hash_ = 0;             // of inputs_
};

}  // namespace bip::rt
