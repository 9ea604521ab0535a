// See stubborn.hpp. Cost of a state: linear in the pairs of interactions that meet, from the first candidates on until
// a set of one is found.
#include "runtime/explore/stubborn.hpp"

#include <algorithm>

#include "bip/assert.hpp"

namespace bip::rt {

Stubborn::Stubborn(const Core& core, const Shapes& shapes) : image_(core.image()), shapes_(shapes) {
  std::vector<InteractionsBy::Pair> pairs;
  u32 rows = 0;
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
    const u32 type_row = image_.atoms[atom].type;
    is_automaton_.push_back(core.tables().types[type_row].mark_words == 0);
    place_base_.push_back(rows);
    const u32 places = is_automaton_.back() ? image_.atom_types[type_row].places.size : 1;
    for (u32 place = 0; place < places; ++place, ++rows) {
      for (const InteractionId interaction : shapes.interactions_of_atom[atom]) {
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
  by_place_ = InteractionsBy::build(rows, pairs);
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
      const u32 place = todo.back();
      todo.pop_back();
      if (seen[place]) continue;
      seen[place] = true;
      for (const Transition& t : type.transitions) {
        if (t.from[0] != place) continue;
        if (t.port == kNone) todo.push_back(t.to[0]);
        else leads[step.port][t.port] = true;
      }
    }
  }
  return leads;
}

void Stubborn::list_enabling() {
  std::vector<std::vector<std::vector<bool>>> leads(image_.atom_types.size);
  std::vector<InteractionsBy::Pair> pairs;
  u32 rows = 0;
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
    const u32 row = image_.atoms[atom].type;
    const u32 ports = image_.atom_types[row].ports.size;
    port_base_.push_back(rows);
    if (is_automaton_[atom] && leads[row].empty()) leads[row] = ports_that_lead(image_.atom_types[row]);
    for (u32 port = 0; port < ports; ++port, ++rows) {
      if (!is_automaton_[atom]) continue;
      for (const InteractionId interaction : shapes_.interactions_of_atom[atom]) {
        const Span<InteractionLeaf> leaves = shapes_.leaves_of(interaction);
        const bool brings = std::any_of(leaves.begin(), leaves.end(), [&](const InteractionLeaf& leaf) {
          return leaf.atom == atom && leads[row][leaf.port][port];
        });
        if (brings) pairs.push_back({rows, interaction});
      }
    }
  }
  enabling_ = InteractionsBy::build(rows, pairs);
}

// May the port of an automaton be enabled at the place? Guards are not looked at.
bool Stubborn::offers(u32 atom, u32 port, u32 place) const {
  for (const Transition& t : image_.atom_types[image_.atoms[atom].type].transitions) {
    if (t.port == port && t.from[0] == place) return true;
  }
  return false;
}

Span<InteractionId> Stubborn::near(const u64* state, const Layout& layout, const Locals& locals, u32 atom) const {
  return by_place_[place_base_[atom] + (is_automaton_[atom] ? locals.place(atom, layout.get(state, atom)) : 0)];
}

// What an interaction needs. Of an interaction without candidate: of the atoms whose port is not offered where they
// stand, and the two sets that each gives, one that adds few interactions with a candidate; those of the component at
// hand are in the set anyway.
StubbornScratch::Needed Stubborn::needed_by(InteractionId interaction, const u64* state, const Layout& layout,
                                            const Locals& locals, const IndexVector<InteractionId, u32>& has_candidate,
                                            const StubbornScratch& scratch) const {
  StubbornScratch::Needed needed;
  if (has_candidate[interaction] != 0 || !shapes_.interactions[interaction].is_rendezvous) return needed;
  std::pair<u32, u32> fewest;
  const auto offer = [&](Span<InteractionId> interactions) {
    std::pair<u32, u32> cost{0, 0};
    for (const InteractionId other : interactions) {
      const bool is_visited = scratch.search.is_visited(other.value);
      if (is_visited && scratch.search.is_open(other.value)) continue;
      cost.first += has_candidate[other] != 0 || (is_visited && scratch.has_candidate[other] != 0) ? 1 : 0;
      cost.second += is_visited ? 0 : 1;
    }
    if (needed.is_blocked && cost >= fewest) return;
    fewest = cost;
    needed.is_blocked = true;
    needed.interactions = interactions;
  };
  for (const InteractionLeaf& leaf : shapes_.leaves_of(interaction)) {
    if (!is_automaton_[leaf.atom] ||
        offers(leaf.atom, leaf.port, locals.place(leaf.atom, layout.get(state, leaf.atom))))
      continue;
    offer(enabling_[port_base_[leaf.atom] + leaf.port]);
    offer(near(state, layout, locals, leaf.atom));
  }
  return needed;
}

// The next interaction that the interaction needs, or none.
InteractionId Stubborn::next_needed(InteractionId interaction, StubbornScratch::Needed& needed, const u64* state,
                                    const Layout& layout, const Locals& locals) const {
  if (needed.is_blocked)
    return needed.at < needed.interactions.size ? needed.interactions[needed.at++] : InteractionId();
  const Span<u32> own = shapes_.atoms_of(interaction);
  for (; needed.atom < own.size; ++needed.atom, needed.at = 0) {
    const Span<InteractionId> interactions = near(state, layout, locals, own[needed.atom]);
    if (needed.at < interactions.size) return interactions[needed.at++];
  }
  return {};
}

// The graph "t needs u", in the form that StrongComponents visits. Keeps the smallest set of candidates of a component
// that needs no other with a candidate.
struct Stubborn::NeedGraph {
  const Stubborn& stubborn;
  const u64* state;
  const Layout& layout;
  const Locals& locals;
  const IndexVector<InteractionId, u32>& has_candidate;
  StubbornScratch& scratch;
  std::vector<InteractionId>& chosen;
  std::size_t best = ~std::size_t{0};

  // Vertices are the numbers of interactions.
  static_assert(kNoSuccessor == InteractionId::kNone);
  StubbornScratch::Needed enter(u32 vertex) {
    const InteractionId interaction(vertex);
    scratch.has_candidate[interaction] = 0;
    return stubborn.needed_by(interaction, state, layout, locals, has_candidate, scratch);
  }
  u32 next(u32 vertex, StubbornScratch::Needed& needed) {
    return stubborn.next_needed(InteractionId(vertex), needed, state, layout, locals).value;
  }
  void reach(u32 from, u32 to) {
    scratch.has_candidate[InteractionId(from)] |= scratch.has_candidate[InteractionId(to)];
  }
  // All that the component needs was complete before.
  void close(const u32* members, std::size_t count) {
    const bool is_candidate_below = scratch.has_candidate[InteractionId(members[0])] != 0;
    scratch.set.clear();
    for (std::size_t k = 0; k < count; ++k) {
      const InteractionId member(members[k]);
      if (has_candidate[member] != 0) scratch.set.push_back(member);
    }
    for (std::size_t k = 0; k < count; ++k)
      scratch.has_candidate[InteractionId(members[k])] = is_candidate_below || !scratch.set.empty() ? 1 : 0;
    if (is_candidate_below || scratch.set.empty() || scratch.set.size() >= best) return;
    best = scratch.set.size();
    chosen = scratch.set;
  }
};

void Stubborn::choose(const u64* state, const Layout& layout, const Locals& locals,
                      const IndexVector<InteractionId, u32>& has_candidate, StubbornScratch& scratch,
                      std::vector<InteractionId>& chosen) const {
  BIP_ASSERT(has_candidate.size() == shapes_.interactions.size(), "{} interactions of {}", has_candidate.size(),
             shapes_.interactions.size());
  BIP_ASSERT(!chosen.empty(), "no interaction to choose among");
  if (scratch.has_candidate.size() != shapes_.interactions.size())
    scratch.has_candidate.assign(shapes_.interactions.size(), 0);
  scratch.search.begin(shapes_.interactions.size());
  NeedGraph graph{*this, state, layout, locals, has_candidate, scratch, chosen};
  for (const InteractionId start : has_candidate.ids()) {
    if (graph.best <= 1) break;
    if (has_candidate[start] != 0) scratch.search.visit(start.value, graph);
  }
  std::sort(chosen.begin(), chosen.end());
  BIP_ASSERT(!chosen.empty() && std::all_of(chosen.begin(), chosen.end(),
                                            [&](InteractionId interaction) { return has_candidate[interaction] != 0; }),
             "an interaction without candidate is among {} chosen ones", chosen.size());
}

}  // namespace bip::rt
