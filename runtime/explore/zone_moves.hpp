// How a zone search notes what happens at points of its nodes. Internal to runtime/explore.
#pragma once
#include "runtime/explore/zone_search.hpp"

namespace bip::rt {

class ZoneSearch::NotedMove {
 public:
  NotedMove(ZoneSearch& search, u32 from, ZoneEdge edge, const Zone& part) : search_(search) {
    if (!search_.notes_moves_) return;
    search_.move_ = static_cast<u32>(search_.moves_.size());
    search_.moves_.push_back({.from = from, .edge = edge, .part = part, .sets = {}, .atoms = {}, .to = {}});
    search_.node_bytes_ += sizeof(ZoneMove) + part.bytes();
  }
  ~NotedMove() { search_.move_ = kNone; }
  NotedMove(const NotedMove&) = delete;
  NotedMove& operator=(const NotedMove&) = delete;

  void add_atoms(const std::vector<Participant>& participants) {
    if (search_.move_ == kNone) return;
    for (const Participant& participant : participants) search_.moves_.back().atoms.push_back(participant.atom);
  }
  /// Those that the core has just set.
  void add_set_clocks() {
    if (search_.move_ == kNone) return;
    for (const u32 clock : search_.core_.time().set_clocks())
      search_.moves_.back().sets.emplace_back(clock + 1, search_.core_.time().clock_state(clock).value);
  }

 private:
  ZoneSearch& search_;
};

}  // namespace bip::rt
