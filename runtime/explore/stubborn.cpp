// See stubborn.hpp. Cost of a state: the closure from a few of its slots, each linear in the slots that meet.
#include "runtime/explore/stubborn.hpp"

#include <algorithm>

namespace bip::rt {

namespace {

constexpr u32 kTries = 24;  // slots with which a set is begun; the smallest set is taken

}  // namespace

Stubborn::Stubborn(const Core& core, const Shapes& shapes) : image_(core.image()), shapes_(shapes) {
  std::vector<Csr::Pair> pairs;
  u32 rows = 0;
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
    const u32 type_row = image_.atoms[atom].type;
    is_automaton_.push_back(core.tables().types[type_row].mark_words == 0);
    place_base_.push_back(rows);
    const u32 places = is_automaton_.back() ? image_.atom_types[type_row].places.size : 1;
    for (u32 place = 0; place < places; ++place, ++rows) {
      for (const u32 slot : shapes.slots_of_atom[atom]) {
        // Who reads an atom, or asks whether it is ready, depends on it wherever it stands.
        bool uses = !is_automaton_.back() || !shapes.slots[slot].is_rendezvous;
        bool is_leaf = false;
        for (const SlotLeaf& leaf : shapes.leaves_of(slot)) {
          if (leaf.atom != atom) continue;
          is_leaf = true;
          uses = uses || offers(atom, leaf.port, place);
        }
        if (uses || !is_leaf) pairs.push_back({rows, slot});
      }
    }
  }
  by_place_ = Csr::build(rows, pairs);
}

// May the port of an automaton be enabled at the place? Guards are not looked at.
bool Stubborn::offers(u32 atom, u32 port, u32 place) const {
  for (const Transition& t : image_.atom_types[image_.atoms[atom].type].transitions) {
    if (t.port == port && t.from[0] == place) return true;
  }
  return false;
}

Span<u32> Stubborn::near(const u64* state, const Layout& layout, const Locals& locals, u32 atom) const {
  return by_place_[place_base_[atom] + (is_automaton_[atom] ? locals.place(atom, layout.get(state, atom)) : 0)];
}

void Stubborn::choose(const u64* state, const Layout& layout, const Locals& locals, const std::vector<u32>& has_candidate,
                      StubbornScratch& scratch, std::vector<u32>& chosen) const {
  scratch.in_set.resize(shapes_.slots.size(), 0);
  std::vector<u32>& set = scratch.set;
  std::size_t best = ~std::size_t{0};
  u32 tries = 0;
  for (u32 start = 0; start < has_candidate.size() && tries < kTries && best > 1; ++start) {
    if (has_candidate[start] == 0) continue;
    ++tries;
    const std::uint32_t round = ++scratch.round;
    set.assign(1, start);
    scratch.in_set[start] = round;
    const auto add_near = [&](u32 atom) {
      for (const u32 slot : near(state, layout, locals, atom)) {
        if (scratch.in_set[slot] == round) continue;
        scratch.in_set[slot] = round;
        set.push_back(slot);
      }
    };
    std::size_t taken = 0;
    for (std::size_t at = 0; at < set.size() && taken < best; ++at) {
      const u32 slot = set[at];
      u32 blocking = kNone;
      if (has_candidate[slot] != 0) {
        ++taken;
      } else if (shapes_.slots[slot].is_rendezvous) {
        u32 fewest = kNone;
        for (const SlotLeaf& leaf : shapes_.leaves_of(slot)) {
          if (!is_automaton_[leaf.atom] || offers(leaf.atom, leaf.port, locals.place(leaf.atom, layout.get(state, leaf.atom)))) continue;
          u32 fresh = 0;
          for (const u32 other : near(state, layout, locals, leaf.atom)) fresh += scratch.in_set[other] == round ? 0u : 1u;
          if (fewest == kNone || fresh < fewest) {
            fewest = fresh;
            blocking = leaf.atom;
          }
        }
      }
      if (blocking != kNone) {
        add_near(blocking);
      } else {
        for (const u32 atom : shapes_.atoms_of(slot)) add_near(atom);
      }
    }
    if (taken >= best) continue;
    best = taken;
    chosen.clear();
    for (const u32 slot : set) {
      if (has_candidate[slot] != 0) chosen.push_back(slot);
    }
  }
  std::sort(chosen.begin(), chosen.end());
}

}  // namespace bip::rt
