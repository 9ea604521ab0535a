// How much of what the nodes of a distributed run say about their steps is not written yet: a bound for the memory of
// the launcher, which holds each step until no earlier one can come. A node that is silent, or an output that blocks,
// lets all of them wait.
//
// A node counts what it has said, and begins no step while that is too much; the launcher says up to which step all is
// written. Who waits so still takes messages, runs actions and tells its clock, so what is written first never waits
// for it, and each node goes on in the end.
#pragma once
#include <algorithm>
#include <deque>

#include "runtime/core/link/tables.hpp"
#include "runtime/engine/output.hpp"

namespace bip::rt {

/// Bytes of steps that the launcher may hold.
inline constexpr u64 kMostUnwritten = u64{64} << 20;
/// Those of each node.
[[nodiscard]] constexpr u64 most_unwritten(std::size_t nodes) { return kMostUnwritten / std::max<u64>(nodes, 1); }
/// The launcher says what is written after so many bytes: often enough that no node waits for that alone.
[[nodiscard]] constexpr u64 written_to_tell(std::size_t nodes) { return most_unwritten(nodes) / 8; }

/// Of its tables, for all steps that share one number.
inline constexpr u64 kRecordTables = 216;
/// Bytes that the launcher holds for `steps` steps that share one number and this text, its tables included.
[[nodiscard]] inline u64 record_bytes(const StepText& text, u64 steps = 1) {
  constexpr u64 kStep = 64;
  return kRecordTables + kStep * steps + text.out.size() + text.trace.size();
}
/// The same for steps of which only the interactions are written.
[[nodiscard]] constexpr u64 fired_bytes(u64 steps) { return kRecordTables + sizeof(InteractionId) * steps; }

/// Of one node. O(1) a step, and a row for many of them.
class UnwrittenSteps {
 public:
  /// Of step `step`, or more of what shares its number. Requires that steps do not decrease.
  void add(u64 step, u64 bytes) {
    constexpr u64 kPiece = u64{1} << 12;
    if (pieces_.empty() || pieces_.back().bytes >= kPiece) pieces_.push_back({step, 0});
    pieces_.back().last = step;
    pieces_.back().bytes += bytes;
    bytes_ += bytes;
  }
  /// All steps up to this one are written.
  void remove_up_to(u64 step) {
    for (; !pieces_.empty() && pieces_.front().last <= step; pieces_.pop_front()) bytes_ -= pieces_.front().bytes;
  }
  [[nodiscard]] u64 bytes() const { return bytes_; }

 private:
  struct Piece {
    u64 last;  // of its steps
    u64 bytes;
  };
  std::deque<Piece> pieces_;
  u64 bytes_ = 0;
};

}  // namespace bip::rt
