// The rows of the core's own tables: ports, searched interactions, programs. Nobody else needs them.
#pragma once
#include <cstddef>
#include <new>
#include <utility>
#include <vector>

#include "runtime/core/link/tables.hpp"

namespace bip::rt {

class Profile;

/// Memory from the start of a cache line on: a vector of a loop over it touches one line, not two.
template <class T>
struct InCacheLines {
  using value_type = T;
  static constexpr std::align_val_t kAlign{64};
  InCacheLines() = default;
  template <class U>
  InCacheLines(const InCacheLines<U>&) {}
  T* allocate(std::size_t count) { return static_cast<T*>(::operator new(count * sizeof(T), kAlign)); }
  void deallocate(T* memory, std::size_t) { ::operator delete(memory, kAlign); }
  friend bool operator==(const InCacheLines&, const InCacheLines&) { return true; }
};

struct PortState {
  // Row of Tables::transitions: the enabled one, or kNone. For simple types the only one of the port, and the place
  // from which it is enabled: their ports change with the atom's place, without being written to.
  u32 transition = kNone;
  u32 place = kNone;
};
/// Interactions of which all there is to know is that their value crosses zero: without guards and rules.
struct DirectInteractions {
  u32 below = 0;                        // all interactions below
  std::vector<std::uint8_t> is_direct;  // by interaction; empty: all are
  [[nodiscard]] bool has(u32 node) const { return node < below || (node < is_direct.size() && is_direct[node] != 0); }
};
/// The candidates of a searched interaction.
struct Listing {
  std::vector<u64> configs;  // Planned: count * words
  u32 count = 0;
  std::vector<std::uint8_t> hidden;  // by configuration; empty: none
};

/// By use of the plan that is searched: the sub-choice for which it was evaluated last, and whether its guard held
/// then.
struct EvaluatedUses {
  struct Use {
    bool is_known = false, holds = false;
  };
  std::vector<Use> uses;
  std::vector<u64> bits;  // plan.words a use; of the leaves below it
  void forget(const Plan& plan) {
    uses.assign(plan.use_count, {});
    bits.resize(std::size_t{plan.use_count} * plan.words);
  }
  /// Was it evaluated for the same leaves? Else from now on it is, and holds unless one says otherwise.
  [[nodiscard]] bool knows(const Plan& plan, u32 row, const PlanUse& use, const u64* now) {
    u64* const last = bits.data() + std::size_t{row} * plan.words;
    bool same = uses[row].is_known;
    for (u32 w = use.first_leaf / 64; w * 64 < use.end_leaf; ++w) {
      u64 mask = ~u64{0};
      if (w * 64 < use.first_leaf) mask &= ~u64{0} << (use.first_leaf & 63);
      if (use.end_leaf - w * 64 < 64) mask &= ~(~u64{0} << (use.end_leaf & 63));
      same = same && last[w] == (now[w] & mask);
      last[w] = now[w] & mask;
    }
    if (!same) uses[row] = {true, true};
    return same;
  }
};
/// Bytes of rows: of the image, the tables and the core.
struct MemoryUse {
  u64 atoms = 0;       // atoms and their ports, without data
  u64 connectors = 0;  // connectors and internal ports, what counts them and the enabled ones
  u64 data = 0;        // of atoms and connectors
  u64 rest = 0;        // compounds, and what there is once or once a type; code is not counted
  [[nodiscard]] u64 all() const { return atoms + connectors + data + rest; }
};

/// What searches have cost so far.
struct SearchWork {
  u64 searches = 0, configurations = 0, connectors = 0;  // configurations looked at, connectors evaluated
  u64 range_looks = 0;                                   // sets of configurations looked at as ranges
};

/// The guard of a flat rendezvous, found without a look at the image.
struct FlatGuard {
  u32 code = kNone;  // row of codes_
  u32 own = 0, binds = 0;
};

/// Interactions from `first` on with one compiled step (run_steps.cpp).
struct CompiledRun {
  StepFn fn;
  const StepOperand* operands;
  u32 first;
  u64 inverse;
};

/// A number for each interaction, by 64 interactions if those have the same, or the same as 64 others: small enough to
/// stay at hand.
struct RunRows {
  static constexpr u32 kInteractionsDiffer = 1u << 31;
  std::vector<u32> blocks;  // a number, or kInteractionsDiffer and where theirs are in `rows`
  std::vector<u32> rows;
  [[nodiscard]] u32 operator[](u32 interaction) const { return find(blocks.data(), rows.data(), interaction); }
  static u32 find(const u32* blocks, const u32* rows, u32 interaction) {
    const u32 row = blocks[interaction >> 6];
    if (row < kInteractionsDiffer || row == kNone) return row;
    return rows[row - kInteractionsDiffer + (interaction & 63)];
  }
};

// ---- programs (programs.cpp)
struct ProgramCode {
  Code code;
  u32 zeroed = 0;  // own interactions that are zeroed before it runs
};
struct ProgramCodes {
  std::vector<u32> words;                    // three a code
  std::vector<std::pair<bool, u32>> owners;  // by code: a port instance (true) or a connector
};
struct ProgramParts {
  ProgramCodes before, after;  // the places
  std::vector<u32> places, touched, instances;
  std::vector<std::pair<u32, std::int32_t>> deltas;
};

}  // namespace bip::rt
