// See take_new_code.hpp.
#include "runtime/core/programs/take_new_code.hpp"

#include <map>
#include <utility>

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"

namespace bip::rt {

void take_new_code(CoreParts& core, const std::vector<Code>& before) {
  const Image& image = core.image();
  std::map<std::pair<CodeFn, const void*>, u32> rows;
  for (u32 row = 0; row < before.size(); ++row) rows.try_emplace({before[row].fn, before[row].context}, row);
  const auto renew = [&](Code& code) {
    const auto at = rows.find({code.fn, code.context});
    if (code.fn != nullptr && at != rows.end()) code = image.codes[at->second];
  };
  BIP_ASSERT(before.size() == image.codes.size, "{} codes take the place of {}", image.codes.size, before.size());
  for (LinkedType& type : core.tables.types) renew(type.initial);
  for (LinkedTransition& transition : core.tables.transitions) {
    renew(transition.guard);
    renew(transition.action);
  }
  for (GuardedPort& port : core.tables.guarded_ports) renew(port.guard);
  core.programs.renew_codes(renew);
  core.steps.link();
}

}  // namespace bip::rt
