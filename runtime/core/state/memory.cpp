// What a core takes, by count of rows: the instances of the image, the tables, the books of the core. Not counted: what
// the image says of types, code, objects of C++ types, what vectors keep in reserve, what runs beside the core
// (engines, traces). Cost: linear in names and listings.
#include <cstring>

#include "runtime/core/core.hpp"

namespace bip::rt {

namespace {

template <class T, class Allocator>
u64 bytes(const std::vector<T, Allocator>& rows) {
  return u64{rows.size()} * sizeof(T);
}
u64 bytes(const Csr& rows) { return bytes(rows.first) + bytes(rows.items); }
template <class T>
u64 bytes(const Span<T>& rows) {
  return u64{rows.size} * sizeof(T);
}
template <class T>
u64 bytes(const Rows<T>& rows) {
  return bytes(rows.rows) + bytes(rows.repeats) + bytes(rows.slopes);
}
template <class T>
u64 bytes_of_names(const Rows<T>& rows) {
  u64 sum = 0;
  for (const T& row : rows.rows) sum += std::strlen(row.name) + 1;
  return sum;
}
template <class... Lists>
u64 all_of(const Lists&... lists) {
  return (bytes(lists) + ...);
}

u64 bytes_of_time(const TimeState& t) {
  u64 sum = all_of(t.clock_base, t.clocks, t.busy_until, t.may_resume_until, t.ports, t.coming, t.event_ports,
                   t.event_row, t.queues, t.at_work) +
            t.changes.bytes() + t.ends.bytes();
  for (const EventQueue& queue : t.queues) sum += bytes(queue.values);
  return sum;
}

}  // namespace

MemoryUse Core::memory() const {
  const Image& image = *tables_.image;
  const Tables& t = tables_;
  MemoryUse use;
  use.atoms = bytes(image.atoms) + bytes_of_names(image.atoms) + bytes(image.args) +
              all_of(t.atoms, t.port_atom, t.mark_base, t.port_out.first, t.atom_watch) +
              all_of(places_, marks_, ports_);
  if (time_ != nullptr) use.atoms += bytes_of_time(*time_);

  use.connectors = bytes(image.connectors) + bytes_of_names(image.connectors) +
                   all_of(image.port_refs, image.binds, image.choices, image.step_runs, image.step_operands);
  for (const Choice& choice : image.choices) use.connectors += bytes(choice.ports);
  use.connectors += t.interactions.bytes() + all_of(t.interaction_of_connector, t.flat_ports, t.inner_start, t.node_out,
                                                    t.port_out.items, t.port_watch, t.plans, t.plan_nodes, t.plan_uses,
                                                    t.plan_params);
  use.connectors += enabled_.bytes() + all_of(binds_.own, values_, direct_.is_direct, is_dirty_, rows_, programs_,
                                              runs_, run_of_.blocks, run_of_.rows);
  use.connectors += all_of(listing_of_, listings_, flat_guards_);
  for (const Listing& listing : listings_) use.connectors += all_of(listing.configs, listing.hidden);
  // Rules hide and show interactions: theirs is what they keep.
  use.connectors +=
      all_of(rules_.is_involved, rules_.high_edges, rules_.high_of_interaction, rules_.low_of_interaction,
             rules_.interactions_of_low, rules_.next, rules_.previous, rules_.component, rules_.members, rules_.cyclic);
  use.connectors +=
      all_of(image.priorities, is_rule_dirty_, rule_states_, contributions_, is_component_changed_, is_reweighed_);

  use.data = bytes(all_) + u64{image.step_cells} * sizeof(ColumnCell);
  for (const Compound& compound : image.compounds) use.rest += sizeof compound + std::strlen(compound.path) + 1;
  use.rest += all_of(t.types, t.transitions, t.deltas, t.place_transitions, t.place_internals, codes_, history_);
  return use;
}

}  // namespace bip::rt
