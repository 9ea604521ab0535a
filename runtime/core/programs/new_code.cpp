// The same model with other code: what was made in the meantime takes the place of what the run began with.
//
// Every copy that linking made of a row of code is looked up among the rows as they were; programs, places, books and
// the list stay as they are, since code of the same meaning changes none of them. Cost: the code of types, plus the
// interactions if there are compiled steps now.
#include <map>
#include <utility>

#include "runtime/core/core.hpp"

namespace bip::rt {

void Core::take_new_code(const std::vector<Code>& before) {
  const Image& image = *tables_.image;
  std::map<std::pair<CodeFn, const void*>, u32> rows;
  for (u32 row = 0; row < before.size(); ++row) rows.try_emplace({before[row].fn, before[row].context}, row);
  const auto renew = [&](Code& code) {
    const auto at = rows.find({code.fn, code.context});
    if (code.fn != nullptr && at != rows.end()) code = image.codes[at->second];
  };
  for (LinkedType& type : tables_.types) renew(type.initial);
  for (LinkedTransition& transition : tables_.transitions) {
    renew(transition.guard);
    renew(transition.action);
  }
  code_rows_.clear();
  for (u32 row = 0; row < codes_.size(); ++row) {
    renew(codes_[row].code);
    code_rows_.try_emplace({codes_[row].code.fn, codes_[row].code.context, codes_[row].zeroed}, row);
  }
  link_steps();
}

}  // namespace bip::rt
