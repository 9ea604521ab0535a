// The core's life outside of steps: construction, the initial state, snapshot and restore, looking at candidates.
#include "runtime/core/core.hpp"

#include <algorithm>
#include <cstring>

namespace bip::rt {

Core::Core(const Image& image, CoreOptions options)
    : tables_(link(image, options.progress)), options_(options), rules_(link_priorities(tables_)) {
  const u32 slot_count = static_cast<u32>(tables_.slots.size());
  atoms_.resize(image.atoms.size);
  for (u32 i = 0; i < image.atoms.size; ++i) {
    const Atom& atom = image.atoms[i];
    atoms_[i] = {kNone, tables_.port_base[i], atom.slot_base, atom.type, tables_.atom_watch[i].size != 0 ? 1u : 0u};
  }
  marks_.assign(tables_.mark_words, 0);
  all_.assign(image.slot_count, Slot{0});
  ports_.resize(tables_.port_atom.size());
  for (u32 i = 0; i < ports_.size(); ++i) {
    const Span<u32> out = tables_.port_out[i];
    ports_[i] = {kNone, tables_.port_atom[i], out.size == 1 ? out[0] : tables_.port_out.first[i], out.size};
  }
  nodes_.resize(tables_.node_start.size());
  for (u32 i = 0; i < nodes_.size(); ++i) {
    const bool is_direct = i < slot_count && !tables_.slots[i].searched && (rules_.count == 0 || rules_.slot_involved[i] == 0);
    nodes_[i] = {tables_.node_start[i], is_direct ? 1u : 0u};
  }
  enabled_.reset(slot_count, tables_.any_searched);

  is_dirty_.assign(slot_count, 0);
  listing_of_.assign(slot_count, kNone);
  for (u32 i = 0; i < slot_count; ++i) {
    if (!tables_.slots[i].searched) continue;
    listing_of_[i] = static_cast<u32>(listings_.size());
    listings_.emplace_back();
  }
  rule_states_.resize(rules_.count);
  is_rule_dirty_.assign(rules_.count, 1);
  for (u32 i = 0; i < rules_.count; ++i) dirty_rules_.push_back(i);
  contributions_.assign(rules_.high_edges.size(), 0);
  is_component_changed_.assign(rules_.cyclic.size(), 0);
  is_reweighed_.assign(rules_.count == 0 ? 0 : slot_count, 0);

  u32 ports = 0, nodes = 0, uses = 0;
  for (const AtomType& type : image.atom_types) ports = std::max(ports, type.ports.size);
  for (const Plan& plan : tables_.plans) {
    nodes = std::max(nodes, plan.node_count);
    uses = std::max(uses, plan.use_count);
  }
  port_scratch_.assign(ports, kNone);
  available_.assign(nodes, 0);
  chosen_.assign(nodes, 0);
  node_scratch_.assign(nodes, 0);
  use_clause_.assign(uses, kNone);
}

bool Core::initialize() {
  const Image& image = *tables_.image;
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const AtomType& type = tables_.atom_type(atom);
    const LinkedType& linked = tables_.types[image.atoms[atom].type];
    AtomState& state = atoms_[atom];
    Slot* slots = all_.data() + state.slot_base;
    u32 args = image.atoms[atom].args;
    for (u32 i = 0; i < type.slots.size; ++i) {
      slots[i] = Slot{0};
      if (type.slots[i].is_param) slots[i] = image.args[args++];
    }
    const u32 before = state.place;
    if (linked.mark_words == 0) {
      state.place = type.initial[0];
    } else {
      state.place = 0;
      u64* marks = marks_.data() + tables_.mark_base[atom];
      std::fill(marks, marks + linked.mark_words, 0);
      for (u32 place : type.initial) marks[place >> 6] |= u64{1} << (place & 63);
    }
    if (linked.initial.fn != nullptr) {
      const std::int32_t status = linked.initial.fn(linked.initial.context, slots, all_.data(), nullptr);
      if (status >= 2) return fail_code(status, atom, kNone, nullptr);
    }
    if (!settle_atom(atom, before)) return false;
    if (state.watched != 0) touch(atom);
  }
  return settle();
}

Candidate Core::candidate(std::uint64_t k) const {
  const EnabledSet::Position at = enabled_.select(k);
  const SlotInfo& info = tables_.slots[at.slot];
  Candidate candidate;
  candidate.slot = at.slot;
  if (info.kind == SlotKind::Port) {
    candidate.atom = tables_.port_atom[info.row];
    candidate.port = info.row - tables_.port_base[candidate.atom];
    return candidate;
  }
  candidate.connector = info.row;
  candidate.config = at.rank;
  if (listing_of_[at.slot] == kNone) return candidate;
  const std::vector<std::uint8_t>& hidden = listings_[listing_of_[at.slot]].hidden;
  if (hidden.empty()) return candidate;
  u32 left = at.rank;
  for (candidate.config = 0; hidden[candidate.config] != 0 || left-- > 0;) ++candidate.config;
  return candidate;
}

std::uint64_t Core::next_after(u32 slot) const {
  const std::uint64_t k = enabled_.rank(slot + 1);
  return k < enabled_.total() ? k : 0;
}

State Core::snapshot() const {
  State state;
  state.places.reserve(atoms_.size());
  for (const AtomState& atom : atoms_) state.places.push_back(atom.place);
  state.marks = marks_;
  state.data.resize(tables_.atom_slots);
  if (!state.data.empty()) std::memcpy(state.data.data(), all_.data(), state.data.size() * sizeof(Slot));
  return state;
}

bool Core::restore(const State& state) {
  const Image& image = *tables_.image;
  // A fault leaves atoms whose ports were not looked at yet: then everything is.
  const bool everything = static_cast<bool>(fault_);
  fault_ = {};
  if (everything) {
    for (u32 slot = 0; slot < is_dirty_.size(); ++slot) {
      if (nodes_[slot].direct == 0) mark_dirty(slot);
    }
    for (u32 rule = 0; rule < rules_.count; ++rule) {
      if (is_rule_dirty_[rule] == 0) dirty_rules_.push_back(rule);
      is_rule_dirty_[rule] = 1;
    }
  }
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    AtomState& now = atoms_[atom];
    const u32 slots = tables_.atom_type(atom).slots.size;
    const u32 words = tables_.types[now.type].mark_words;
    const u32 mark = tables_.mark_base[atom];
    const bool same_data = slots == 0 || std::memcmp(&all_[now.slot_base], &state.data[now.slot_base], slots * sizeof(Slot)) == 0;
    const bool same_marks = words == 0 || std::memcmp(&marks_[mark], &state.marks[mark], words * sizeof(u64)) == 0;
    if (!everything && same_data && same_marks && now.place == state.places[atom]) continue;
    if (slots != 0) std::memcpy(&all_[now.slot_base], &state.data[now.slot_base], slots * sizeof(Slot));
    if (words != 0) std::memcpy(&marks_[mark], &state.marks[mark], words * sizeof(u64));
    const u32 before = everything ? kNone : now.place;
    now.place = state.places[atom];
    if (!update_ports(atom, before)) return false;
    if (now.watched != 0) touch(atom);
  }
  return settle();
}

bool Core::is_marked(u32 atom, u32 place) const {
  if (tables_.types[atoms_[atom].type].mark_words == 0) return atoms_[atom].place == place;
  return (marks_[tables_.mark_base[atom] + (place >> 6)] >> (place & 63) & 1) != 0;
}

u32 Core::enabled_transition(u32 atom, u32 port) const {
  const u32 row = ports_[tables_.port_base[atom] + port].transition;
  return row == kNone ? kNone : row - tables_.types[atoms_[atom].type].first_transition;
}

u32 Core::listed_count(u32 connector) const {
  const u32 slot = tables_.slot_of_connector[connector];
  return slot == kNone ? 0 : base_count(slot);
}

}  // namespace bip::rt
