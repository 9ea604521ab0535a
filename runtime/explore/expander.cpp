// See expander.hpp: the tables, how they are filled, how they are read. Which candidates a state has: expand.cpp.
#include "runtime/explore/expander.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "bip/draws.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/explore/word_set.hpp"

namespace bip::rt {

Expander::Expander(StateSpace& space, u32 owners)
    : space_(space),
      has_final_states_(has_final_states(*space.image)),
      owners_(owners),
      plain_image_(*space.image),
      scratch_(space.initial) {
  const CoreOptions options{.progress = space.progress};
  core_ = std::make_unique<Core>(*space.image, options);
  plain_ = core_.get();
  if (space.image->priorities.size != 0) {
    // Tables hold what interactions offer before rules hide some of it.
    plain_image_.priorities = {};
    plain_own_ = std::make_unique<Core>(plain_image_, options);
    plain_ = plain_own_.get();
  }
  relayout();
}

void Expander::relayout() {
  const Shapes& shapes = space_.shapes;
  is_too_narrow_ = false;
  entered_.clear();
  tables_.assign(shapes.interactions.size(), {});
  parts_.clear();
  dense_.clear();
  entries_.assign(1u << 10, {});
  entry_count_ = 0;
  outcomes_.assign(1, {});
  effects_.clear();
  pieces_.clear();
  moves_.clear();
  kept_ = 0;
  next_.resize(space_.layout.words());
  outcome_row_.assign(shapes.interactions.size(), kNothing);
  only_moves_ = space_.layout.words() == 1 && !shapes.needs_core && shapes.dominators.items.empty() &&
                space_.stubborn == nullptr && space_.symmetry == nullptr;
  for (const InteractionId interaction : shapes.interactions.ids()) {
    InteractionTable& table = tables_[interaction];
    table.first_part = static_cast<u32>(parts_.size());
    if (shapes.interactions[interaction].form == InteractionForm::Moves) {
      add_moves(interaction, table);
      continue;
    }
    only_moves_ = false;
    for (const u32 atom : shapes.atoms_of(interaction)) {
      const Field& field = space_.layout[atom];
      if (table.key_bits <= 64)
        parts_.push_back({field.word, field.mask, 0, field.shift, static_cast<std::uint8_t>(table.key_bits)});
      table.key_bits += field.width;
    }
    table.part_count = static_cast<u32>(parts_.size()) - table.first_part;
    if (table.key_bits > kDenseBits) continue;
    table.dense = static_cast<u32>(dense_.size());
    BIP_ASSERT(table.part_count == shapes.atoms_of(interaction).size, "{} parts, {} atoms", table.part_count,
               shapes.atoms_of(interaction).size);
    dense_.resize(dense_.size() + (std::size_t{1} << table.key_bits), kUnknown);
  }
}

// One mask and value a word that the interaction's atoms lie in, and the change.
void Expander::add_moves(InteractionId interaction, InteractionTable& table) {
  const u32 first_piece = static_cast<u32>(pieces_.size());
  for (const InteractionLeaf& leaf : space_.shapes.leaves_of(interaction)) {
    const Field& field = space_.layout[leaf.atom];
    auto part = parts_.begin() + table.first_part;
    while (part != parts_.end() && part->word != field.word) ++part;
    if (part == parts_.end()) {
      parts_.push_back({field.word, 0, 0, 0, 0});
      part = parts_.end() - 1;
      pieces_.push_back({field.word, 0});
    }
    Piece& piece = pieces_[first_piece + static_cast<u32>(part - parts_.begin()) - table.first_part];
    part->mask |= field.mask << field.shift;
    part->value |= u64{leaf.from} << field.shift;
    piece.change |= u64{leaf.from ^ leaf.to} << field.shift;
  }
  table.part_count = static_cast<u32>(parts_.size()) - table.first_part;
  table.outcome = static_cast<u32>(outcomes_.size());
  outcomes_.push_back({static_cast<u32>(effects_.size()), 1});
  u32 label = kNone;
  if (space_.labels != nullptr) {
    const Tables& tables = core_->tables();
    const u32 connector = tables.is_of_connector(interaction) ? tables.connector_of(interaction) : kNone;
    label = space_.labels->of(interaction, connector, space_.shapes.leaves_of(interaction));
  }
  effects_.push_back({first_piece, table.part_count, label, false});
  kept_ = table.outcome;
  BIP_ASSERT(table.part_count == pieces_.size() - first_piece, "{} parts", table.part_count);
  BIP_ASSERT(pieces_.size() == first_piece + table.part_count, "{} pieces of {} parts", pieces_.size() - first_piece,
             table.part_count);
  if (only_moves_) moves_.push_back({parts_.back().mask, parts_.back().value, pieces_.back().change, label});
}

std::size_t Expander::bytes() const {
  return dense_.size() * sizeof(u32) + entries_.size() * sizeof(Entry) + outcomes_.size() * sizeof(Outcome) +
         effects_.size() * sizeof(Effect) + pieces_.size() * sizeof(Piece);
}

u32 Expander::owner_of(const u64* state) const {
  u64 hash = 0;
  for (u32 word = 0; word < space_.layout.words(); ++word) hash = WordSet::hash_of(hash ^ state[word]);
  // Neither the bits that choose a bucket nor those of the tag.
  return static_cast<u32>((hash >> 16 & 0xffff) * owners_ >> 16);
}

u64 Expander::key_of(const InteractionTable& table, const u64* state) const {
  u64 key = 0;
  const Part* part = parts_.data() + table.first_part;
  for (u32 k = 0; k < table.part_count; ++k, ++part)
    key |= (state[part->word] >> part->shift & part->mask) << (part->offset & 63);
  return key;
}

// What is known of the interaction in the state: a row of outcomes_, or kUnknown.
u32 Expander::known(InteractionId interaction, const u64* state) const {
  const InteractionTable& table = tables_[interaction];
  if (table.outcome != kUnknown) {
    const Part* part = parts_.data() + table.first_part;
    for (u32 k = 0; k < table.part_count; ++k, ++part) {
      if ((state[part->word] & part->mask) != part->value) return kNothing;
    }
    return table.outcome;
  }
  if (table.key_bits <= kDenseBits) return dense_[table.dense + key_of(table, state)];
  if (table.key_bits > 64) return kUnknown;
  const u64 key = key_of(table, state);
  const std::size_t mask = entries_.size() - 1;
  for (std::size_t at = WordSet::hash_of(key + interaction.value * 0x9e3779b97f4a7c15ull) & mask;
       entries_[at].interaction.is_valid(); at = (at + 1) & mask) {
    if (entries_[at].key == key && entries_[at].interaction == interaction) return entries_[at].outcome;
  }
  return kUnknown;
}

void Expander::remember(InteractionId interaction, const u64* state, u32 outcome) {
  BIP_ASSERT(outcome < outcomes_.size() && known(interaction, state) == kUnknown, "outcome {}", outcome);
  const InteractionTable& table = tables_[interaction];
  const u64 key = key_of(table, state);
  if (table.key_bits <= kDenseBits) {
    dense_[table.dense + key] = outcome;
    return;
  }
  const auto insert = [](std::vector<Entry>& entries, const Entry& entry) {
    const std::size_t mask = entries.size() - 1;
    std::size_t at = WordSet::hash_of(entry.key + entry.interaction.value * 0x9e3779b97f4a7c15ull) & mask;
    while (entries[at].interaction.is_valid()) at = (at + 1) & mask;
    entries[at] = entry;
  };
  insert(entries_, {key, interaction, outcome});
  BIP_ASSERT(known(interaction, state) == outcome, "interaction {} was not found again", interaction);
  if (++entry_count_ * 2 <= entries_.size()) return;
  std::vector<Entry> wider(entries_.size() * 2);
  for (const Entry& entry : entries_) {
    if (entry.interaction.is_valid()) insert(wider, entry);
  }
  entries_ = std::move(wider);
}

bool Expander::enter(Core& core, const u64* state) {
  // Without rules both are one.
  if (&core == plain_) entered_.clear();
  scratch_numbers_.resize(space_.locals->atoms(), kNone);
  for (u32 atom = 0; atom < space_.locals->atoms(); ++atom) {
    const u32 number = space_.layout.get(state, atom);
    if (scratch_numbers_[atom] == number) continue;
    space_.locals->write(atom, number, scratch_);
    scratch_numbers_[atom] = number;
  }
  return core.restore(scratch_);
}

// plain_ to the state; after a step of one of its interactions only a few atoms differ, which restore sees.
bool Expander::enter_plain(const u64* state) {
  if (!entered_.empty() && std::equal(entered_.begin(), entered_.end(), state)) return true;
  entered_.clear();
  if (!enter(*plain_, state)) return false;
  entered_.assign(state, state + space_.layout.words());
  return true;
}

bool Expander::pack(const Core& core, u64* out) {
  std::fill(out, out + space_.layout.words(), u64{0});
  for (u32 atom = 0; atom < space_.locals->atoms(); ++atom) {
    const u32 number = space_.locals->number(atom, core);
    if (!space_.layout.fits(atom, number)) return false;
    space_.layout.set(out, atom, number);
    BIP_ASSERT(space_.layout.get(out, atom) == number, "atom {} as {}", atom, number);
  }
  return true;
}

// After a step of the interaction: how its atoms differ from the state's, as an effect.
bool Expander::read_effect(Core& core, InteractionId interaction, u32 label, const u64* state) {
  Effect effect{static_cast<u32>(pieces_.size()), 0, label, false};
  for (const u32 atom : space_.shapes.atoms_of(interaction)) {
    const u32 number = space_.locals->number(atom, core);
    if (!space_.layout.fits(atom, number)) {
      is_too_narrow_ = true;
      return false;
    }
    const u32 before = space_.layout.get(state, atom);
    if (before == number) continue;
    const Field& field = space_.layout[atom];
    const u64 change = u64{before ^ number} << field.shift;
    if (effect.count != 0 && pieces_.back().word == field.word) {
      pieces_.back().change |= change;
    } else {
      pieces_.push_back({field.word, change});
      ++effect.count;
    }
  }
  effects_.push_back(effect);
  return true;
}

// The interaction's candidates in the state that plain_ is in: numbers [first, end).
std::pair<u64, u64> Expander::candidates_of(InteractionId interaction) const {
  const u64 first = interaction.value == 0 ? 0 : plain_->enabled().next_after(InteractionId(interaction.value - 1));
  u64 end = first;
  while (end < plain_->candidate_count() && plain_->candidate(end).interaction == interaction) ++end;
  BIP_ASSERT(first <= end && end <= plain_->candidate_count(), "candidates {} to {}", first, end);
  return {first, end};
}

// Has the interaction a candidate in the state? What it does is not asked: rules may hide it. kNothing: no.
u32 Expander::peek(InteractionId interaction, const u64* state) {
  const u32 row = known(interaction, state);
  if (row != kUnknown || !enter_plain(state)) return row;
  const auto [first, end] = candidates_of(interaction);
  if (first != end) return kUnknown;
  keep(interaction, state, kNothing);
  return kNothing;
}

void Expander::keep(InteractionId interaction, const u64* state, u32 row) {
  if (tables_[interaction].key_bits > 64 || outcomes_.size() >= kKept || entry_count_ >= kKept) return;
  remember(interaction, state, row);
  kept_ = std::max(kept_, row);
}

// Asks the core what the interaction does in the state. kUnknown: a number that does not fit.
u32 Expander::learn(InteractionId interaction, const u64* state) {
  const Outcome before{static_cast<u32>(effects_.size()), 0};
  Outcome outcome = before;
  bool is_kept = true;
  if (!enter_plain(state)) {
    effects_.push_back({0, 0, kNone, true});
    outcome.count = 1;
    is_kept = false;
  } else {
    const auto [first, end] = candidates_of(interaction);
    for (u64 k = first; k < end; ++k) {
      DrawScript script;
      const FollowedScript follow(script);
      do {
        if (outcome.count != 0 && !enter_plain(state)) break;
        entered_.clear();
        const u32 label = space_.labels == nullptr ? kNone : space_.labels->of(*plain_, plain_->candidate(k));
        if (!plain_->fire(k)) {
          effects_.push_back({0, 0, kNone, true});
          // Whether the fault is the interaction's own or that of a neighbour that looks at the new state is not known.
          is_kept = false;
        } else if (!read_effect(*plain_, interaction, label, state)) {
          return kUnknown;
        }
        ++outcome.count;
      } while (script.advance());
    }
  }
  u32 row = kNothing;
  if (outcome.count != 0) {
    row = static_cast<u32>(outcomes_.size());
    outcomes_.push_back(outcome);
  }
  if (is_kept) keep(interaction, state, row);
  return row;
}

u32 Expander::outcome_of(InteractionId interaction, const u64* state) {
  const u32 row = known(interaction, state);
  return row != kUnknown ? row : learn(interaction, state);
}

// Does nothing fault in the state that a step of the interaction leads to? What has a table entry there was evaluated
// before.
bool Expander::is_sound(InteractionId interaction, const u64* state) {
  const CsrOf<InteractionId, InteractionId>& watched = space_.shapes.watched;
  if (watched.items.empty()) return true;
  const auto is_unknown = [&](InteractionId other) { return known(other, state) == kUnknown; };
  if (std::none_of(watched[interaction].begin(), watched[interaction].end(), is_unknown)) return true;
  if (!enter_plain(state)) return false;
  // Everything has been evaluated. The tables are told, so that it need not be done again.
  for (const InteractionId other : watched[interaction]) {
    if (is_unknown(other)) (void)peek(other, state);
  }
  return true;
}

}  // namespace bip::rt
