// Slots, the order of candidates: connectors that export no port, then internal ports of atoms.
//
// What the core knows of a slot are 16 bytes. But 64 slots in a row mostly are as 64 others, counted from where their own connectors
// and ports begin: then they stand once, as a pattern, and a slot costs a bit or two. Slots that come in no order cost their 16 bytes.
// A look at a slot is two loads.
#pragma once
#include <cstdint>
#include <set>
#include <vector>

#include "bip/rows.hpp"

namespace bip::rt {

using u32 = std::uint32_t;
using u64 = std::uint64_t;

enum class SlotKind : std::uint8_t {
  Flat,     // rendezvous of atom ports
  Star,     // one level with triggers, atom ports only, no guard
  Planned,  // everything else
  Port      // an internal port
};
/// A slot of the candidate order: a connector that exports no port, or an internal port of an atom.
struct SlotInfo {
  static constexpr u32 kMostPorts = (1u << 28) - 1;
  u32 row = 0;                 // Image::connectors, or the port instance
  u32 first = 0;               // Flat, Star: rows of flat_ports, `count` of them, in parameter order
  u32 ref = kNone;             // see clause, plan
  u32 count : 28 = 0;
  SlotKind kind : 3 = SlotKind::Flat;
  bool searched : 1 = false;   // may have several candidates, or guards: its candidates are listed when something changed
  /// Flat: row in the connector type's clauses. Else kNone.
  [[nodiscard]] u32 clause() const { return kind == SlotKind::Flat ? ref : kNone; }
  /// Planned: row of plans. Else kNone.
  [[nodiscard]] u32 plan() const { return kind == SlotKind::Planned ? ref : kNone; }
};
static_assert(sizeof(SlotInfo) == 16);  // each bit means something

class Slots {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] SlotInfo operator[](std::size_t slot) const {
    const Block& block = blocks_[slot / kBlock];
    SlotInfo info = patterns_[block.pattern + slot % kBlock];
    info.row += block.row;
    info.first += block.first;
    return info;
  }
  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const { return blocks_.size() * sizeof(Block) + patterns_.size() * sizeof(SlotInfo); }

 private:
  friend class SlotPacker;
  static constexpr std::size_t kBlock = 64;
  struct Block {
    u32 pattern = 0;           // rows of patterns_, whose `row` and `first` begin at these:
    u32 row = 0, first = 0;
  };
  std::vector<Block> blocks_;
  std::vector<SlotInfo> patterns_;
  u32 size_ = 0;
};

/// Makes slots, one after the other.
class SlotPacker {
 public:
  explicit SlotPacker(Slots& slots) : slots_(slots), known_(Less{slots}) {}
  void add(SlotInfo info);
  /// After the last one.
  void finish();

 private:
  struct Less {
    const Slots& slots;
    bool operator()(u32 a, u32 b) const;
  };
  Slots& slots_;
  std::set<u32, Less> known_;  // whole patterns
};

}  // namespace bip::rt
