// See core_parts.hpp.
#include "runtime/core/core_parts.hpp"

#include <algorithm>
#include <cstring>

#include "bip/assert.hpp"
#include "bip/draws.hpp"

namespace bip::rt {

CoreParts::CoreParts(const Image& of, const CoreOptions& how)
    : tables(rt::link(of, how.progress)),
      options(how),
      atoms{tables.atoms.data(), of.atoms.size},
      memory(of),
      priorities(*this, tables) {
  for (u32 i = 0; !memory.ffi_data.empty() && i < of.connectors.size; ++i) firing.zero_frame(i);
  ports.link();
  search.link();
  atom_steps.link();
  clocks.link();
  weights.link();
  if (looks_at_binds()) memory.binds.make(of);
  reset();
  steps.link();
}

// To no state at all: no atom is anywhere, no port enabled.
void CoreParts::reset() {
  memory.places.assign(atoms.size, kNone);
  memory.marks.assign(tables.mark_words, 0);
  history.reset();
  ports.reset();
  if (clocks.is_timed()) clocks.reset();
  enabled.reset(static_cast<u32>(tables.interactions.size()), search.is_weighted());
  search.reset();
  priorities.reset();
}

bool CoreParts::initialize() {
  const Image& image = *tables.image;
  fault = {};
  if (has_state) reset();
  has_state = true;
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const AtomType& type = tables.atom_type(atom);
    const LinkedType& linked = tables.types[atoms[atom].type];
    const AtomInfo& state = atoms[atom];
    Cell* cells = memory.cells.from(state.first_cell);
    u32 args = image.atoms[atom].args;
    for (u32 i = 0; i < type.variables.size; ++i) {
      cells[i] = Cell{0};
      if (type.variables[i].is_param) cells[i] = image.args[args++];
    }
    if (type.draws != kNone && has_draw_seed) cells[type.draws].bits = draw_start(draw_seed, atom);
    if (!memory.ffi_data.empty()) memory.ffi_data.reset(type.variables, memory.cells.all(), state.first_cell.value);
    BIP_ASSERT(linked.mark_words != 0 || type.initial.size == 1, "atom {} begins at {} places", atom,
               type.initial.size);
    if (linked.mark_words == 0) {
      memory.places[atom] = type.initial[0];
    } else {
      memory.places[atom] = 0;
      u64* marks = memory.marks.data() + tables.first_mark(atom);
      for (u32 place : type.initial) marks[place >> 6] |= u64{1} << (place & 63);
    }
    if (clocks.is_timed()) clocks.start_clocks(atom);
    if (linked.initial.fn != nullptr) {
      const std::int32_t status = linked.initial.fn(linked.initial.context, cells, memory.cells.all(), nullptr);
      BIP_ASSERT(status >= 1, "`initial` of atom {} returns {}", atom, status);
      if (status >= 2) return faults.fail_code(status, atom, kNone, nullptr);
    }
    if (clocks.is_timed() && !clocks.read_clocks(atom, nullptr)) return false;
    if (linked.has_invariants && !atom_steps.check_invariants(atom, nullptr)) return false;
    if (!atom_steps.settle_atom(atom, kNone, nullptr)) return false;
    if (state.watched != 0) ports.touch(atom);
  }
  return settle_anew();
}

// The list of the uniform policy starts from the order of candidates.
bool CoreParts::settle_anew() {
  enabled.unlist();
  if (!settle()) return false;
  if (keeps_list) enabled.list(static_cast<u32>(tables.interactions.size()));
  BIP_ASSERT(is_settled(), "rows are still to be settled");
  BIP_ASSERT(is_consistent(), "of {} interactions", tables.interactions.size());
  return true;
}

bool CoreParts::is_consistent() const {
  constexpr std::size_t kMostChecked = 64;
  const u32 interactions = static_cast<u32>(tables.interactions.size());
  if (fault || interactions > kMostChecked || atoms.size > kMostChecked) return true;
  if (!ports.is_consistent() || !enabled.is_consistent()) return false;
  if (clocks.is_timed() && !clocks.is_consistent()) return false;
  if (!is_settled()) return true;
  for (const InteractionId i : tables.interactions.ids()) {
    // What is searched or hidden was counted when it was settled.
    if (search.is_searched(i)) continue;
    const bool is_shown = ports.is_available(i) && !priorities.is_hidden(i);
    if (enabled.weight(i) != (is_shown ? 1u : 0u)) return false;
  }
  return priorities.is_consistent();
}

void CoreParts::keep_list() {
  keeps_list = true;
  enabled.list(static_cast<u32>(tables.interactions.size()));
}

void CoreParts::keep_ordered_list() {
  enabled.keep_order();
  keep_list();
}

Candidate CoreParts::candidate(EnabledSet::Position at) const {
  BIP_ASSERT(tables.interactions.contains(at.interaction), "interaction {} of {}", at.interaction,
             tables.interactions.size());
  Candidate candidate;
  candidate.interaction = at.interaction;
  if (!tables.is_of_connector(at.interaction)) {
    const u32 instance = tables.interactions[at.interaction].row;
    candidate.atom = tables.port_atom[instance];
    candidate.port = instance - tables.port_base(candidate.atom);
    return candidate;
  }
  candidate.connector = tables.connector_of(at.interaction);
  candidate.config = config_of(at);
  return candidate;
}

State CoreParts::snapshot() const {
  State state;
  state.places = memory.places;
  state.marks = memory.marks;
  state.data.assign(tables.atom_cells, 0);
  if (!state.data.empty()) std::memcpy(state.data.rows().data(), memory.cells.all(), state.data.size() * sizeof(Cell));
  memory.ffi_data.save(state.data.rows(), state.objects);
  if (clocks.is_timed()) clocks.save(state.time);
  return state;
}

bool CoreParts::restore(const State& state) { return restore_atoms(state) && settle_anew(); }

bool CoreParts::restore_atoms(const State& state) {
  BIP_ASSERT(state.places.size() == memory.places.size() && state.marks.size() == memory.marks.size() &&
                 state.data.size() == tables.atom_cells && state.time.empty() != clocks.is_timed(),
             "a state of another image: {} atoms, {} cells", state.places.size(), state.data.size());
  BIP_ASSERT(!partial.is_on() || partial.state()->busy == 0, "{} atoms are at work", partial.state()->busy);
  const Image& image = *tables.image;
  enabled.unlist();
  // A fault leaves things between two states.
  if (fault) reset();
  fault = {};
  has_state = true;
  if (clocks.is_timed()) clocks.load(state.time);
  // All objects first: what an atom offers may depend on them. An atom that has one counts as changed.
  if (!memory.ffi_data.empty()) memory.ffi_data.load(memory.cells.all(), state.objects);
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const AtomInfo& now = atoms[atom];
    const AtomType& type = image.atom_types[now.type];
    const u32 variables = type.variables.size;
    const u32 words = tables.types[now.type].mark_words;
    const u32 mark = tables.first_mark(atom);
    const bool same_data = variables == 0 || std::memcmp(&memory.cells[now.first_cell], &state.data[now.first_cell],
                                                         variables * sizeof(Cell)) == 0;
    const bool same_marks =
        words == 0 || std::memcmp(&memory.marks[mark], &state.marks[mark], words * sizeof(u64)) == 0;
    // What a timed atom offers depends on the instant.
    const bool is_still = !clocks.is_timed() || type.time == nullptr;
    if (is_still && same_data && same_marks && memory.places[atom] == state.places[atom]) continue;
    for (u32 i = 0; i < variables; ++i) {
      if (!is_ffi(type.variables[i].type)) memory.cells[now.first_cell + i].bits = state.data[now.first_cell + i];
    }
    if (words != 0) std::memcpy(&memory.marks[mark], &state.marks[mark], words * sizeof(u64));
    const u32 before = memory.places[atom];
    memory.places[atom] = state.places[atom];
    if (!atom_steps.update_ports(atom, before)) return false;
    if (now.watched != 0) ports.touch(atom);
  }
  if (actions.any()) actions.restart_jobs();
  return true;
}

bool CoreParts::settle_marked() {
  for (const InteractionId interaction : ports.dirty()) {
    if (!search.is_searched(interaction) || search.list(interaction)) continue;
    fault.is_of_state = true;
    return false;
  }
  if (priorities.tables().count != 0) {
    if (!priorities.settle()) {
      fault.is_of_state = true;
      return false;
    }
  } else {
    for (const InteractionId interaction : ports.dirty()) enabled.set(interaction, search.base_count(interaction));
  }
  ports.dirty().clear();
  return true;
}

bool CoreParts::is_marked(u32 atom, u32 place) const {
  BIP_ASSERT(place < tables.atom_type(atom).places.size, "place {} of {}", place, tables.atom_type(atom).places.size);
  if (tables.types[atoms[atom].type].mark_words == 0) return memory.places[atom] == place;
  return (memory.marks[tables.first_mark(atom) + (place >> 6)] >> (place & 63) & 1) != 0;
}

}  // namespace bip::rt
