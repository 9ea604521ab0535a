// See collect_strings.hpp.
#include "runtime/engine/collect_strings.hpp"

#include <algorithm>
#include <vector>

#include "bip/ffi.hpp"

namespace bip::rt {

void LiveStrings::add(const Core& core) {
  for (const VariableId variable : IdRange<VariableId>(core.image().cell_count)) rows_.push_back(core.cell(variable).i);
  std::vector<i64> queued;
  core.events().save(queued);
  for (const i64 word : queued) rows_.push_back(static_cast<std::int32_t>(word));
}

void LiveStrings::add(const std::vector<u64>& cells) {
  for (const u64 bits : cells) rows_.push_back(Cell{.bits = bits}.i);
}

void LiveStrings::keep_only(FfiContext& ffi) {
  std::sort(rows_.begin(), rows_.end());
  ffi.keep_only({rows_.data(), static_cast<u32>(rows_.size())});
}

void LiveStrings::pin(FfiContext& ffi) const { ffi.pin({rows_.data(), static_cast<u32>(rows_.size())}); }

bool wants_collection(const Image& image) { return image.ffi != nullptr && image.ffi->wants_collection(); }

void collect_strings(Core& core) {
  // Actions that run beside the others have copies of their atoms' cells.
  if (!wants_collection(core.image()) || !core.actions().working().empty()) return;
  LiveStrings live;
  live.add(core);
  live.keep_only(*core.image().ffi);
}

void pin_strings(const Core& core) {
  if (core.image().ffi == nullptr) return;
  LiveStrings live;
  live.add(core);
  live.pin(*core.image().ffi);
}

}  // namespace bip::rt
