// See memory_use.hpp.
#include "runtime/core/memory_use.hpp"

#include <cstring>

#include "runtime/core/core_parts.hpp"

namespace bip::rt {

namespace {

template <class T, class Allocator>
u64 bytes(const std::vector<T, Allocator>& rows) {
  return u64{rows.size()} * sizeof(T);
}
template <class Row, class T>
u64 bytes(const IndexVector<Row, T>& rows) {
  return bytes(rows.rows());
}
template <class From, class To>
u64 bytes(const CsrOf<From, To>& rows) {
  return bytes(rows.first) + bytes(rows.items);
}
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

}  // namespace

MemoryUse memory_use(const CoreParts& core) {
  const Image& image = core.image();
  const Tables& t = core.tables;
  const PriorityTables& rules = core.priorities.tables();
  MemoryUse use;
  use.atoms = bytes(image.atoms) + bytes_of_names(image.atoms) + bytes(image.args) +
              all_of(t.atoms, t.port_atom, t.idle_ports, t.mark_base, t.port_out.first, t.atom_watch, t.atom_rules) +
              all_of(core.memory.places, core.memory.marks) + core.ports.port_bytes();
  if (core.clocks.is_timed()) use.atoms += core.clocks.bytes() + core.events.bytes() + core.actions.bytes();

  use.connectors = bytes(image.connectors) + bytes_of_names(image.connectors) +
                   all_of(image.port_refs, image.binds, image.choices, image.step_runs, image.step_operands,
                          image.inner_steps.interactions, image.inner_steps.run_of, image.inner_steps.runs,
                          image.inner_steps.atoms, image.inner_steps.cells);
  for (const Choice& choice : image.choices) use.connectors += bytes(choice.ports);
  use.connectors +=
      t.interactions.bytes() + all_of(t.interaction_of_connector, t.flat_ports, t.inner_start, t.interaction_start,
                                      t.node_out, t.port_out.items, t.port_watch, t.plans, t.plan_nodes, t.plan_uses,
                                      t.plan_params, t.plan_ports, t.plan_transfers, t.plan_choices);
  use.connectors += core.enabled.bytes() + bytes(core.memory.binds.own) + core.ports.network_bytes() +
                    core.programs.bytes() + core.steps.bytes() + core.search.bytes();
  // Rules hide and show interactions: theirs is what they keep.
  use.connectors += all_of(rules.is_involved, rules.has_one_candidate, rules.is_followed, rules.high_edges,
                           rules.high_of_interaction, rules.low_of_interaction, rules.interactions_of_low, rules.next,
                           rules.previous, rules.component, rules.members, rules.cyclic);
  use.connectors += bytes(image.priorities) + core.priorities.bytes();

  use.data = u64{core.memory.cells.size()} * sizeof(Cell) + u64{image.step_cells} * sizeof(ColumnCell);
  for (const Compound& compound : image.compounds) use.rest += sizeof compound + std::strlen(compound.path) + 1;
  use.rest += all_of(t.types, t.transitions, t.deltas, t.guarded_ports, t.place_transitions, t.place_internals) +
              core.programs.code_bytes() + core.history.bytes();
  return use;
}

}  // namespace bip::rt
