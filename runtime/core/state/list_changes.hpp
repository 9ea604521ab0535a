// What comes into the list of the enabled set and what goes out of it before the list is settled. There and back is
// nothing. Cost: O(1) a change; to take them, the order of the changes: a handful a step mostly.
#pragma once
#include <algorithm>
#include <cstdint>

#include "bip/ids.hpp"
#include "runtime/core/state/row_list.hpp"

namespace bip::rt {

class ListChanges {
 public:
  /// No changes among so many interactions.
  void reset(std::uint32_t interactions) {
    is_changed_.assign(interactions, 0);
    rows_.clear();
  }
  void clear() {
    for (const InteractionId interaction : rows_) is_changed_[interaction] = 0;
    rows_.clear();
  }
  /// The interaction comes or goes; if it did before, nothing is left of that.
  void toggle(InteractionId interaction) {
    is_changed_[interaction] ^= 1;
    rows_.push(interaction);
  }
  [[nodiscard]] bool has(InteractionId interaction) const { return is_changed_[interaction] != 0; }
  /// Was anything toggled since the last time? It may have been toggled back.
  [[nodiscard]] bool any() const { return !rows_.empty(); }
  /// Calls visit(interaction) for each change, in interaction order, and forgets them.
  template <class Visit>
  [[gnu::always_inline]] void take(const Visit& visit) {
    sort();
    // Locals: a byte that is written might be anything, for all that the compiler knows.
    const InteractionId* const end = rows_.end();
    std::uint8_t* const is_changed = is_changed_.rows().data();
    for (const InteractionId* at = rows_.begin(); at != end; ++at) {
      const InteractionId interaction = *at;
      // One that came back stands more than once.
      if (is_changed[interaction.value] == 0) continue;
      is_changed[interaction.value] = 0;
      visit(interaction);
    }
    rows_.clear();
  }
  /// Calls visit(interaction) for each change, in interaction order. O(interactions).
  template <class Visit>
  void visit(const Visit& visit) const {
    for (const InteractionId interaction : is_changed_.ids()) {
      if (has(interaction)) visit(interaction);
    }
  }
  [[nodiscard]] std::size_t bytes() const { return is_changed_.size(); }

 private:
  void sort() {
    constexpr std::size_t kFew = 16;
    if (rows_.size() > kFew) return sort_many();
    InteractionId* const begin = rows_.begin();
    InteractionId* const end = rows_.end();
    for (InteractionId* next = begin + 1; next < end; ++next) {
      const InteractionId interaction = *next;
      InteractionId* at = next;
      for (; at != begin && interaction < at[-1]; --at) *at = at[-1];
      *at = interaction;
    }
  }
  [[gnu::noinline]] void sort_many() { std::sort(rows_.begin(), rows_.end()); }

  IndexVector<InteractionId, std::uint8_t> is_changed_;
  RowList<InteractionId> rows_;  // those, and others
};

}  // namespace bip::rt
