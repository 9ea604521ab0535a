// See state_predicate.hpp.
#include "runtime/explore/state_predicate.hpp"

#include "bip/assert.hpp"

namespace bip::rt {

bool PredicateEvaluator::key_of(const u64* state, u64& key) const {
  if (!options_.predicate_connectors.empty()) return false;
  u32 bits = 0;
  key = 0;
  for (const u32 atom : options_.predicate_reads) {
    const u32 width = space_.layout[atom].width;
    if (bits + width > kKeyBits) return false;
    if (width != 0) key |= u64{space_.layout.get(state, atom)} << bits;
    bits += width;
  }
  return true;
}

bool PredicateEvaluator::holds(const u64* state, Expander& expander) {
  BIP_ASSERT(static_cast<bool>(options_.predicate), "no predicate");
  u64 key = 0;
  const bool has_key = key_of(state, key);
  if (has_key) {
    if (const auto found = known_.find(key); found != known_.end()) return found->second;
  }
  Core& core = expander.core();
  const bool answer = !expander.enter(core, state) || options_.predicate(core);
  if (has_key && known_.size() < kKept) known_.emplace(key, answer);
  return answer;
}

}  // namespace bip::rt
