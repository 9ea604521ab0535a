// The candidates of an interaction that is searched: one or none if it is flat and has a guard, else what search.cpp
// finds. Cost: a guard, or a search.
#include "runtime/core/core.hpp"

namespace bip::rt {

// Lists the interaction's candidates anew.
bool Core::list(u32 interaction) {
  Listing& listing = listings_[listing_of(interaction)];
  listing.count = 0;
  listing.configs.clear();
  if (values_[interaction] < 0) return true;
  if (const FlatGuard& guard = flat_guards_[listing_of(interaction)]; guard.code != kNone) {
    const ProgramCode& code = codes_[guard.code];
    Cell* own = all_.data() + guard.own;
    for (u32 i = 0; i < code.zeroed; ++i) own[i] = Cell{0};
    const std::int32_t status = code.code.fn(code.code.context, own, all_.data(), binds_.rows + guard.binds);
    if (status >= 2) return fail_code(status, kNone, tables_.connector_of(interaction), nullptr);
    listing.count = status != 0 ? 1 : 0;
    return true;
  }
  const InteractionInfo info = tables_.interactions[interaction];
  if (info.kind == InteractionKind::Flat) {
    listing.count = 1;
    if (info.clause() == kNone) return true;
    const Connector& row = tables_.image->connectors[info.row];
    const Clause& clause = tables_.connector_type(info.row).clauses[info.clause()];
    const Code guard = tables_.code(clause.guard);
    zero_frame(info.row);
    const std::int32_t status = guard.fn == nullptr ? 1
                                                    : guard.fn(guard.context, all_.data() + row.first_cell, all_.data(),
                                                               binds_.rows + row.binds);
    if (status >= 2) return fail_code(status, kNone, info.row, nullptr);
    listing.count = status != 0 ? 1 : 0;
    return status == 0 || !clause.may_fault || run_code(tables_.code(clause.up), info.row);
  }
  const Plan& plan = tables_.plans[info.plan()];
  std::vector<Bits> found;
  ++search_work_.searches;
  // Data have changed since.
  evaluated_.forget(plan);
  if (!search_links(plan)) return false;
  const bool listed = options_.progress == MaximalProgress::Off ? enumerate(plan, found) : search(plan, 0, found);
  link_alternatives_.clear();
  if (!listed) return false;
  for (const Bits& bits : found) listing.configs.insert(listing.configs.end(), bits.begin(), bits.end());
  listing.count = static_cast<u32>(found.size());
  return true;
}

}  // namespace bip::rt
