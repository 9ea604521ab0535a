// See stubborn.hpp. Cost of a state: linear in the pairs of interactions that meet, from the first candidates on until
// a set of one is found.
#include "runtime/explore/stubborn.hpp"

#include <algorithm>

namespace bip::rt {

Stubborn::Stubborn(const Core& core, const Shapes& shapes) : image_(core.image()), shapes_(shapes) {
  std::vector<Csr::Pair> pairs;
  u32 rows = 0;
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
    const u32 type_row = image_.atoms[atom].type;
    is_automaton_.push_back(core.tables().types[type_row].mark_words == 0);
    place_base_.push_back(rows);
    const u32 places = is_automaton_.back() ? image_.atom_types[type_row].places.size : 1;
    for (u32 place = 0; place < places; ++place, ++rows) {
      for (const u32 interaction : shapes.interactions_of_atom[atom]) {
        // Who reads an atom, or asks whether it is ready, depends on it wherever it stands.
        bool uses = !is_automaton_.back() || !shapes.interactions[interaction].is_rendezvous;
        bool is_leaf = false;
        for (const InteractionLeaf& leaf : shapes.leaves_of(interaction)) {
          if (leaf.atom != atom) continue;
          is_leaf = true;
          uses = uses || offers(atom, leaf.port, place);
        }
        if (uses || !is_leaf) pairs.push_back({rows, interaction});
      }
    }
  }
  by_place_ = Csr::build(rows, pairs);
  list_enabling();
}

// By two ports: may a transition of the first bring the automaton to where the second is offered? Internal transitions
// run at the end of a step, so it leads to every place that they may lead on to.
std::vector<std::vector<bool>> Stubborn::ports_that_lead(const AtomType& type) {
  std::vector<std::vector<bool>> leads(type.ports.size, std::vector<bool>(type.ports.size, false));
  std::vector<bool> seen(type.places.size);
  for (const Transition& step : type.transitions) {
    if (step.port == kNone) continue;
    std::fill(seen.begin(), seen.end(), false);
    std::vector<u32> todo{step.to[0]};
    while (!todo.empty()) {
      const u32 here = todo.back();
      todo.pop_back();
      if (seen[here]) continue;
      seen[here] = true;
      for (const Transition& t : type.transitions) {
        if (t.from[0] != here) continue;
        if (t.port == kNone) todo.push_back(t.to[0]);
        else leads[step.port][t.port] = true;
      }
    }
  }
  return leads;
}

void Stubborn::list_enabling() {
  std::vector<std::vector<std::vector<bool>>> leads(image_.atom_types.size);
  std::vector<Csr::Pair> pairs;
  u32 rows = 0;
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
    const u32 row = image_.atoms[atom].type;
    const u32 ports = image_.atom_types[row].ports.size;
    port_base_.push_back(rows);
    if (is_automaton_[atom] && leads[row].empty()) leads[row] = ports_that_lead(image_.atom_types[row]);
    for (u32 port = 0; port < ports; ++port, ++rows) {
      if (!is_automaton_[atom]) continue;
      for (const u32 interaction : shapes_.interactions_of_atom[atom]) {
        const Span<InteractionLeaf> leaves = shapes_.leaves_of(interaction);
        const bool brings = std::any_of(leaves.begin(), leaves.end(), [&](const InteractionLeaf& leaf) {
          return leaf.atom == atom && leads[row][leaf.port][port];
        });
        if (brings) pairs.push_back({rows, interaction});
      }
    }
  }
  enabling_ = Csr::build(rows, pairs);
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

// What an interaction needs. Of an interaction without candidate: of the atoms whose port is not offered where they
// stand, and the two sets that each gives, one that adds few interactions with a candidate; those of the component at
// hand are in the set anyway.
StubbornScratch::Frame Stubborn::frame_of(u32 interaction, const u64* state, const Layout& layout, const Locals& locals,
                                          const std::vector<u32>& has_candidate, const StubbornScratch& scratch) const {
  StubbornScratch::Frame frame{interaction, false, {}};
  if (has_candidate[interaction] != 0 || !shapes_.interactions[interaction].is_rendezvous) return frame;
  std::pair<u32, u32> fewest;
  const auto offer = [&](Span<u32> interactions) {
    std::pair<u32, u32> cost{0, 0};
    for (const u32 other : interactions) {
      const StubbornScratch::Visit& visit = scratch.visits[other];
      if (visit.round == scratch.round && visit.is_open) continue;
      const bool is_complete = visit.round == scratch.round;
      cost.first += has_candidate[other] != 0 || (is_complete && visit.has_candidate) ? 1 : 0;
      cost.second += is_complete ? 0 : 1;
    }
    if (frame.is_blocked && cost >= fewest) return;
    fewest = cost;
    frame.is_blocked = true;
    frame.needed = interactions;
  };
  for (const InteractionLeaf& leaf : shapes_.leaves_of(interaction)) {
    if (!is_automaton_[leaf.atom] ||
        offers(leaf.atom, leaf.port, locals.place(leaf.atom, layout.get(state, leaf.atom))))
      continue;
    offer(enabling_[port_base_[leaf.atom] + leaf.port]);
    offer(near(state, layout, locals, leaf.atom));
  }
  return frame;
}

// The next interaction that the frame's interaction needs, or kNone.
u32 Stubborn::next_needed(StubbornScratch::Frame& frame, const u64* state, const Layout& layout,
                          const Locals& locals) const {
  if (frame.is_blocked) return frame.at < frame.needed.size ? frame.needed[frame.at++] : kNone;
  const Span<u32> own = shapes_.atoms_of(frame.interaction);
  for (; frame.atom < own.size; ++frame.atom, frame.at = 0) {
    const Span<u32> interactions = near(state, layout, locals, own[frame.atom]);
    if (frame.at < interactions.size) return interactions[frame.at++];
  }
  return kNone;
}

void Stubborn::choose(const u64* state, const Layout& layout, const Locals& locals,
                      const std::vector<u32>& has_candidate, StubbornScratch& scratch, std::vector<u32>& chosen) const {
  using Visit = StubbornScratch::Visit;
  std::vector<Visit>& visits = scratch.visits;
  visits.resize(shapes_.interactions.size());
  const std::uint32_t round = ++scratch.round;
  u32 order = 0;
  std::size_t best = ~std::size_t{0};
  const auto begin = [&](u32 interaction) {
    visits[interaction] = {round, order, order, true, false};
    ++order;
    scratch.open.push_back(interaction);
    scratch.frames.push_back(frame_of(interaction, state, layout, locals, has_candidate, scratch));
  };
  // The component of `root` is complete: everything from it to the top of `open`. Those it needs were complete before.
  const auto finish = [&](u32 root) {
    const bool is_candidate_below = visits[root].has_candidate;
    scratch.set.clear();
    u32 interaction = kNone;
    std::size_t first = scratch.open.size();
    do {
      interaction = scratch.open[--first];
      if (has_candidate[interaction] != 0) scratch.set.push_back(interaction);
    } while (interaction != root);
    for (std::size_t k = first; k < scratch.open.size(); ++k) {
      visits[scratch.open[k]].is_open = false;
      visits[scratch.open[k]].has_candidate = is_candidate_below || !scratch.set.empty();
    }
    scratch.open.resize(first);
    if (is_candidate_below || scratch.set.empty() || scratch.set.size() >= best) return;
    best = scratch.set.size();
    chosen = scratch.set;
  };
  const u32 interactions = static_cast<u32>(has_candidate.size());
  scratch.frames.clear();
  scratch.open.clear();
  for (u32 start = 0; start < interactions && best > 1; ++start) {
    if (has_candidate[start] == 0 || visits[start].round == round) continue;
    begin(start);
    while (!scratch.frames.empty()) {
      const u32 next = next_needed(scratch.frames.back(), state, layout, locals);
      const u32 interaction = scratch.frames.back().interaction;
      if (next != kNone && visits[next].round != round) {
        begin(next);
      } else if (next != kNone) {
        if (visits[next].is_open) visits[interaction].low = std::min(visits[interaction].low, visits[next].order);
        else visits[interaction].has_candidate |= visits[next].has_candidate;
      } else {
        scratch.frames.pop_back();
        if (visits[interaction].low == visits[interaction].order) finish(interaction);
        if (scratch.frames.empty()) break;
        Visit& above = visits[scratch.frames.back().interaction];
        above.has_candidate |= visits[interaction].has_candidate;
        if (visits[interaction].is_open) above.low = std::min(above.low, visits[interaction].low);
      }
    }
  }
  std::sort(chosen.begin(), chosen.end());
}

}  // namespace bip::rt
