// Interactions, the order of candidates: connectors that export no port, then internal ports of atoms.
//
// What the core knows of an interaction are 16 bytes. But 64 interactions in a row mostly are as 64 others, counted
// from where their own connectors and ports begin: then they stand once, as a pattern, and an interaction costs a bit
// or two. Interactions that come in no order cost their 16 bytes. A look at an interaction is two loads.
#pragma once
#include <cstdint>
#include <set>
#include <vector>

#include "bip/assert.hpp"
#include "bip/ids.hpp"
#include "bip/rows.hpp"

namespace bip::rt {

using u32 = std::uint32_t;
using u64 = std::uint64_t;

enum class InteractionKind : std::uint8_t {
  Flat,     // rendezvous of atom ports
  Star,     // one level with triggers, atom ports only, no guard
  Planned,  // everything else
  Port      // an internal port
};
/// An interaction of the candidate order: a connector that exports no port, or an internal port of an atom.
struct InteractionInfo {
  static constexpr u32 kMostPorts = (1u << 28) - 1;
  u32 row = 0;      // Image::connectors, or the port instance
  u32 first = 0;    // Flat, Star: rows of flat_ports, `count` of them, in parameter order
  u32 ref = kNone;  // see clause, plan
  u32 count : 28 = 0;
  InteractionKind kind : 3 = InteractionKind::Flat;
  bool searched : 1 =
      false;  // may have several candidates, or guards: its candidates are listed when something changed
  /// Flat: row in the connector type's clauses. Else kNone.
  [[nodiscard]] u32 clause() const { return kind == InteractionKind::Flat ? ref : kNone; }
  /// Planned: row of plans. Else kNone.
  [[nodiscard]] u32 plan() const { return kind == InteractionKind::Planned ? ref : kNone; }
};
static_assert(sizeof(InteractionInfo) == 16);  // each bit means something

class Interactions {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] IdRange<InteractionId> ids() const { return IdRange<InteractionId>(size_); }
  [[nodiscard]] bool contains(InteractionId interaction) const { return interaction.value < size_; }
  [[nodiscard]] InteractionInfo operator[](InteractionId interaction) const {
    BIP_ASSERT(contains(interaction), "interaction {} of {}", interaction, size_);
    const Block& block = blocks_[interaction.value / kBlock];
    InteractionInfo info = patterns_[block.pattern + interaction.value % kBlock];
    info.row += block.row;
    info.first += block.first;
    return info;
  }
  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const {
    return blocks_.size() * sizeof(Block) + patterns_.size() * sizeof(InteractionInfo);
  }

 private:
  friend class InteractionPacker;
  static constexpr std::size_t kBlock = 64;
  struct Block {
    u32 pattern = 0;  // rows of patterns_, whose `row` and `first` begin at these:
    u32 row = 0, first = 0;
  };
  std::vector<Block> blocks_;
  std::vector<InteractionInfo> patterns_;
  u32 size_ = 0;
};

/// Makes interactions, one after the other.
class InteractionPacker {
 public:
  explicit InteractionPacker(Interactions& interactions) : interactions_(interactions), known_(Less{interactions}) {}
  void add(InteractionInfo info);
  /// After the last one.
  void finish();

 private:
  struct Less {
    const Interactions& interactions;
    bool operator()(u32 a, u32 b) const;
  };
  Interactions& interactions_;
  std::set<u32, Less> known_;  // whole patterns
};

}  // namespace bip::rt
