// The successors of a state, as words: from tables that the core has filled, or by the core if there is no table.
//
// An expander belongs to one thread. The effect of an interaction on the numbers of its atoms is computed by a core
// once: restore that state, fire, read the atoms' local states. So the expander caches the meaning of a step and does
// not define one. Tables are valid as long as the layout. A number that no longer fits sets `is_too_narrow`; the caller
// then makes a wider layout and repeats the batch.
#pragma once
#include <memory>
#include <vector>

#include "runtime/explore/locals.hpp"
#include "runtime/explore/shapes.hpp"
#include "runtime/explore/step_labels.hpp"
#include "runtime/explore/stubborn.hpp"
#include "runtime/explore/symmetry.hpp"

namespace bip::rt {

/// What all threads share while a batch is expanded.
struct StateSpace {
  const Image* image = nullptr;
  MaximalProgress progress = MaximalProgress::On;
  Shapes shapes;
  std::unique_ptr<Locals> locals;
  Layout layout;
  State initial;                       // with the parameters of all atoms
  const Stubborn* stubborn = nullptr;  // null: no partial-order reduction
  const Symmetry* symmetry = nullptr;  // null: none
  StepLabels* labels = nullptr;        // null: steps have no labels; else one thread expands
};

/// Successors by the owner of their state: a word list each.
struct Outbox {
  std::vector<std::vector<u64>> words;
  std::vector<u32> labels;  // of the successors, if the space has labels
  void clear() {
    for (auto& list : words) list.clear();
    labels.clear();
  }
  [[nodiscard]] std::size_t size() const {
    std::size_t sum = 0;
    for (const auto& list : words) sum += list.size();
    return sum;
  }
};

class Expander {
 public:
  Expander(StateSpace& space, u32 owners);

  /// The layout is a new one: tables are forgotten.
  void relayout();

  struct Result {
    u64 steps = 0;             // that lead to a state
    bool is_deadlock = false;  // no step at all
    bool is_final = false;     // none either, but as the model declares
    bool has_error = false;
  };
  /// Adds the state's successors to `out`, in the order of the candidates.
  Result expand(const u64* state, Outbox& out) {
    Result result = find_successors(state, out);
    if (result.is_deadlock && has_final_states_ && is_final(state)) result.is_deadlock = false, result.is_final = true;
    return result;
  }
  [[nodiscard]] bool is_too_narrow() const { return is_too_narrow_; }

  /// The words of the state that a core is in; false: a number does not fit.
  [[nodiscard]] bool pack(const Core& core, u64* out);
  /// A core with the image's rules, at the state. False: a fault.
  [[nodiscard]] bool enter(Core& core, const u64* state);
  [[nodiscard]] Core& core() { return *core_; }
  [[nodiscard]] std::size_t bytes() const;
  /// The owner of a state; any function of its words.
  [[nodiscard]] u32 owner_of(const u64* state) const;

 private:
  static constexpr u32 kUnknown = 0xffffffffu, kNothing = 0;  // rows of outcomes_
  static constexpr u32 kDenseBits = 12;
  static constexpr u32 kKept = 1u << 22;  // outcomes that are remembered
  struct Piece {
    u32 word;
    u64 change;  // exclusive or
  };
  /// One candidate of an interaction: pieces [first, first + count).
  struct Effect {
    u32 first = 0, count = 0;
    u32 label = kNone;  // if the space has labels
    bool is_fault = false;
  };
  /// Effects [first, first + count).
  struct Outcome {
    u32 first = 0, count = 0;
  };
  struct Part {  // of a key, or of a mask
    u32 word;
    u64 mask, value;  // Moves: of the word. Table: mask of the number
    std::uint8_t shift, offset;
  };
  struct InteractionTable {
    u32 first_part = 0, part_count = 0;
    u32 key_bits = 0;
    u32 dense = 0;           // first row of dense_, if key_bits <= kDenseBits
    u32 outcome = kUnknown;  // Moves: the only one
  };
  struct Entry {
    u64 key = 0;
    InteractionId interaction;
    u32 outcome = 0;
  };
  struct Move {  // Moves in a state of one word
    u64 mask, value, change;
    u32 label;
  };

  void add_moves(InteractionId interaction, InteractionTable& table);
  [[nodiscard]] u64 key_of(const InteractionTable& table, const u64* state) const;
  [[nodiscard]] u32 known(InteractionId interaction, const u64* state) const;
  u32 outcome_of(InteractionId interaction, const u64* state);
  [[nodiscard]] std::pair<u64, u64> candidates_of(InteractionId interaction) const;
  u32 peek(InteractionId interaction, const u64* state);
  u32 learn(InteractionId interaction, const u64* state);
  void keep(InteractionId interaction, const u64* state, u32 row);
  void remember(InteractionId interaction, const u64* state, u32 outcome);
  bool enter_plain(const u64* state);
  bool read_effect(Core& core, InteractionId interaction, u32 label, const u64* state);
  bool is_sound(InteractionId interaction, const u64* state);
  void put(const u64* state, u32 label, Outbox& out);
  void emit(InteractionId interaction, u32 outcome, u64 multiplicity, const u64* state, Outbox& out, Result& result);
  Result find_successors(const u64* state, Outbox& out);
  [[nodiscard]] bool is_final(const u64* state);
  Result expand_moves(u64 state, Outbox& out);
  Result expand_by_core(const u64* state, Outbox& out);
  void forget_unkept(std::size_t outcomes, std::size_t effects, std::size_t pieces);

  StateSpace& space_;
  const bool has_final_states_;
  u32 owners_;
  std::unique_ptr<Core> core_;        // of the image
  Image plain_image_;                 // without rules
  std::unique_ptr<Core> plain_own_;   // of it; null: there are no rules
  Core* plain_ = nullptr;             // fills tables
  State scratch_;                     // the state that was entered last
  std::vector<u32> scratch_numbers_;  // its atoms' numbers
  std::vector<u64> entered_;          // the state that plain_ is in; empty: none
  bool is_too_narrow_ = false;
  bool only_moves_ = false;  // every interaction is one, in one word, without rules

  IndexVector<InteractionId, InteractionTable> tables_;
  std::vector<Part> parts_;
  std::vector<u32> dense_;
  std::vector<Entry> entries_;  // open addressing
  u32 entry_count_ = 0;
  std::vector<Outcome> outcomes_;
  std::vector<Effect> effects_;
  std::vector<Piece> pieces_;
  std::vector<Move> moves_;

  u32 kept_ = 0;  // the last outcome that a table refers to

  std::vector<u64> next_, canonical_, symmetry_scratch_;
  IndexVector<InteractionId, u32> outcome_row_;  // of the state at hand
  std::vector<InteractionId> chosen_;
  std::vector<u32> equal_members_;  // Symmetry: of the state at hand
  StubbornScratch stubborn_scratch_;
};

}  // namespace bip::rt
