// The candidates of a state, and their successors. Three ways: masks alone; tables, then rules and reductions; the
// core, if rules have guards or C++ is called.
#include <algorithm>

#include "bip/assert.hpp"
#include "bip/draws.hpp"

#include "runtime/core/final_state.hpp"
#include "runtime/explore/expander.hpp"

namespace bip::rt {

void Expander::put(const u64* state, u32 label, Outbox& out) {
  const u32 words = space_.layout.words();
  if (space_.symmetry != nullptr) {
    std::vector<u64>& copy = canonical_;
    copy.assign(state, state + words);
    space_.symmetry->normalize(copy.data(), space_.layout, symmetry_scratch_);
    state = copy.data();
  }
  if (space_.labels != nullptr) out.labels.push_back(label);
  std::vector<u64>& list = out.words[owners_ == 1 ? 0 : owner_of(state)];
  if (words == 1) list.push_back(*state);
  else list.insert(list.end(), state, state + words);
}

// `multiplicity`: of the step, among those that symmetry identifies.
void Expander::emit(InteractionId interaction, u32 row, u64 multiplicity, const u64* state, Outbox& out,
                    Result& result) {
  BIP_ASSERT(row != kNothing && row < outcomes_.size(), "outcome {} of {}", row, outcomes_.size());
  const Outcome outcome = outcomes_[row];
  BIP_ASSERT(outcome.first + outcome.count <= effects_.size(), "effects from {}", outcome.first);
  for (u32 k = outcome.first; k < outcome.first + outcome.count; ++k) {
    const Effect effect = effects_[k];
    if (effect.is_fault) {
      result.has_error = true;
      continue;
    }
    std::copy(state, state + space_.layout.words(), next_.begin());
    for (u32 piece = effect.first; piece < effect.first + effect.count; ++piece)
      next_[pieces_[piece].word] ^= pieces_[piece].change;
    if (!is_sound(interaction, next_.data())) {
      result.has_error = true;
      continue;
    }
    result.steps += multiplicity;
    put(next_.data(), effect.label, out);
  }
}

// Every interaction is a mask, a value and a change of one word.
Expander::Result Expander::expand_moves(u64 state, Outbox& out) {
  BIP_ASSERT(space_.layout.words() == 1 && moves_.size() == tables_.size(), "{} moves", moves_.size());
  Result result;
  if (owners_ == 1 && space_.labels == nullptr) {
    std::vector<u64>& list = out.words[0];
    const std::size_t before = list.size();
    list.resize(before + moves_.size());
    u64* to = list.data() + before;
    // Written always and kept if enabled: which interactions are is not predictable.
    for (const Move& move : moves_) {
      *to = state ^ move.change;
      to += (state & move.mask) == move.value ? 1 : 0;
    }
    list.resize(static_cast<std::size_t>(to - list.data()));
    result.steps = list.size() - before;
  } else {
    for (const Move& move : moves_) {
      if ((state & move.mask) != move.value) continue;
      const u64 next = state ^ move.change;
      out.words[owners_ == 1 ? 0 : owner_of(&next)].push_back(next);
      if (space_.labels != nullptr) out.labels.push_back(move.label);
      ++result.steps;
    }
  }
  result.is_deadlock = result.steps == 0;
  return result;
}

Expander::Result Expander::expand_by_core(const u64* state, Outbox& out) {
  Result result;
  if (!enter(*core_, state)) {
    result.has_error = true;
    return result;
  }
  const u64 count = core_->candidate_count();
  result.is_deadlock = count == 0;
  const Symmetry* const symmetry = space_.symmetry;
  if (symmetry != nullptr) symmetry->find_equal_members(state, space_.layout, equal_members_);
  // Rules hide what tables tell of; an interaction with one candidate is hidden or not, so its table serves.
  const bool may_look_up =
      !space_.shapes.calls_cpp && space_.shapes.watched.items.empty() && space_.image->sites.size == 0;
  for (u64 k = 0; k < count; ++k) {
    const InteractionId interaction = core_->candidate(k).interaction;
    const u64 multiplicity = symmetry == nullptr ? 1 : symmetry->multiplicity(interaction, equal_members_);
    if (multiplicity == 0) continue;
    if (may_look_up && space_.shapes.interactions[interaction].is_rendezvous) {
      const u32 row = outcome_of(interaction, state);
      if (row == kUnknown) return result;
      // Tables are filled by another core, which has no rules: this one stays where it is.
      emit(interaction, row, multiplicity, state, out, result);
      continue;
    }
    const u32 label = space_.labels == nullptr ? kNone : space_.labels->of(*core_, core_->candidate(k));
    DrawScript script;
    const FollowedScript follow(script);
    bool goes_on = false;
    do {
      if (!core_->fire(k)) {
        result.has_error = true;
      } else {
        std::copy(state, state + space_.layout.words(), next_.begin());
        for (const u32 atom : space_.shapes.atoms_of(interaction)) {
          const u32 number = space_.locals->number(atom, *core_);
          if (!space_.layout.fits(atom, number)) {
            is_too_narrow_ = true;
            return result;
          }
          space_.layout.set(next_.data(), atom, number);
        }
        result.steps += multiplicity;
        put(next_.data(), label, out);
      }
      goes_on = script.advance();
      if ((goes_on || k + 1 < count) && !enter(*core_, state)) return result;
    } while (goes_on);
  }
  return result;
}

bool Expander::is_final(const u64* state) { return enter(*core_, state) && is_final_state(*core_); }

Expander::Result Expander::find_successors(const u64* state, Outbox& out) {
  if (only_moves_) return expand_moves(*state, out);
  if (space_.shapes.needs_core) return expand_by_core(state, out);
  Result result;
  const Shapes& shapes = space_.shapes;
  const std::size_t kept_effects = effects_.size(), kept_pieces = pieces_.size(), kept_outcomes = outcomes_.size();
  if (space_.stubborn == nullptr && shapes.dominators.items.empty()) {
    bool any = false;
    const Symmetry* const symmetry = space_.symmetry;
    if (symmetry != nullptr) symmetry->find_equal_members(state, space_.layout, equal_members_);
    for (const InteractionId interaction : shapes.interactions.ids()) {
      const u64 multiplicity = symmetry == nullptr ? 1 : symmetry->multiplicity(interaction, equal_members_);
      if (multiplicity == 0) continue;
      const u32 row = outcome_of(interaction, state);
      if (row == kNothing) continue;
      if (row == kUnknown) return result;
      any = true;
      emit(interaction, row, multiplicity, state, out, result);
      if (is_too_narrow_) return result;
    }
    result.is_deadlock = !any;
  } else {
    chosen_.clear();
    for (const InteractionId interaction : shapes.interactions.ids()) {
      outcome_row_[interaction] = peek(interaction, state);
      if (outcome_row_[interaction] != kNothing) chosen_.push_back(interaction);
    }
    result.is_deadlock = chosen_.empty();
    if (!shapes.dominators.items.empty()) {
      std::erase_if(chosen_, [&](InteractionId interaction) {
        const Span<InteractionId> high = shapes.dominators[interaction];
        return std::any_of(high.begin(), high.end(),
                           [&](InteractionId other) { return outcome_row_[other] != kNothing; });
      });
    }
    BIP_ASSERT(result.is_deadlock == chosen_.empty(), "priorities hide all candidates of a state");
    if (space_.stubborn != nullptr && chosen_.size() > 1) {
      space_.stubborn->choose(state, space_.layout, *space_.locals, outcome_row_, stubborn_scratch_, chosen_);
    }
    for (const InteractionId interaction : chosen_) {
      const u32 row = outcome_of(interaction, state);
      if (row == kUnknown) return result;
      emit(interaction, row, 1, state, out, result);
    }
  }
  forget_unkept(kept_outcomes, kept_effects, kept_pieces);
  return result;
}

// Outcomes that no table refers to are dropped, so that what has no table costs no memory.
void Expander::forget_unkept(std::size_t outcomes, std::size_t effects, std::size_t pieces) {
  if (kept_ >= outcomes) return;
  outcomes_.resize(outcomes);
  effects_.resize(effects);
  pieces_.resize(pieces);
}

}  // namespace bip::rt
