// See collect_strings.hpp.
#include "runtime/engine/collect_strings.hpp"

#include <algorithm>
#include <vector>

#include "bip/ffi.hpp"

namespace bip::rt {

void collect_strings(Core& core) {
  FfiContext* const ffi = core.image().ffi;
  if (ffi == nullptr || !ffi->wants_collection()) return;
  // Actions that run beside the others have copies of their atoms' cells.
  if (!core.actions().working().empty()) return;
  std::vector<std::int32_t> live;
  for (u32 cell = 0; cell < core.image().cell_count; ++cell) live.push_back(core.cell(cell).i);
  std::vector<i64> queued;
  core.events().save(queued);
  for (const i64 word : queued) live.push_back(static_cast<std::int32_t>(word));
  std::sort(live.begin(), live.end());
  ffi->keep_only(live);
}

}  // namespace bip::rt
