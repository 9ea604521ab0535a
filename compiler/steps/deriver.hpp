// The state of one derivation: the operations of each interaction in turn. Internal to steps/.
#pragma once
#include <map>
#include <vector>

#include "compiler/lower/code_facts.hpp"
#include "compiler/lower/lower.hpp"
#include "compiler/steps/values.hpp"
#include "runtime/core/link/priorities.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::steps {

using lower::InteractionChange;
using lower::StepOp;
using lower::StepOpKind;
using rt::kNone;
using rt::u32;

inline constexpr std::size_t kLeastRepeats = 4;  // in a row, to become a loop
inline constexpr std::size_t kMostOps = 48;

/// The operations of one interaction's interaction with the values of their operands.
struct Instance {
  std::vector<StepOp> ops;
  std::vector<u32> refs;
  void clear() {
    ops.clear();
    refs.clear();
  }
  StepOp& add(StepOpKind kind) {
    ops.push_back({});
    ops.back().kind = kind;
    ops.back().first_ref = static_cast<u32>(refs.size());
    return ops.back();
  }
  void ref(u32 value) {
    refs.push_back(value);
    ++ops.back().refs;
  }
  void ref(rt::InteractionId interaction) { ref(interaction.value); }
  void append(const Instance& more) {
    const u32 before = static_cast<u32>(refs.size());
    for (const StepOp& op : more.ops) {
      ops.push_back(op);
      ops.back().first_ref += before;
    }
    refs.insert(refs.end(), more.refs.begin(), more.refs.end());
  }
};

/// Operations that repeat with equal strides, `least` or more in a row, become one. strides: by operand.
void fold(const Instance& in, std::size_t least, Instance& out, std::vector<std::int32_t>& strides);
/// Of folded operations: equal iff they differ in operands alone.
[[nodiscard]] std::vector<u32> shape_key(const Instance& folded, const std::vector<std::int32_t>& strides);
/// Returns the runs with the most interactions, for a loop over steps; none if the loop would know too few of the
/// interactions.
[[nodiscard]] std::vector<rt::StepRun> choose_loop(std::vector<rt::StepRun> runs, std::uint64_t interactions);
/// Copies to variables of atoms go into the loop of the code that follows and works on these atoms.
void inline_copies(Instance& folded, const std::vector<std::int32_t>& strides, u32 atom_cells);

class Deriver {
 public:
  explicit Deriver(const lower::LoweredSystem& lowered);

  /// False: priorities that only the core knows how to follow.
  [[nodiscard]] bool link_priorities();
  [[nodiscard]] const std::vector<lower::CodeFacts>& facts() const { return facts_; }
  [[nodiscard]] const rt::Tables& tables() const { return tables_; }
  [[nodiscard]] u32 interactions() const { return static_cast<u32>(tables_.interactions.size()); }
  /// Must every interaction have a shape, if any is to have one? Compiled steps do not keep the core's books of
  /// priority rules.
  [[nodiscard]] bool needs_all() const { return rules_.count != 0; }
  /// Cells below belong to atoms.
  [[nodiscard]] u32 atom_cells() const { return tables_.atom_cells; }
  enum class Found { Yes, Never, No };  // Never: it cannot fire
  /// The operations of an interaction, not folded.
  Found describe(rt::InteractionId interaction, Instance& out);

 private:
  struct Effect {
    rt::InteractionId interaction;
    std::int32_t delta = 0;
  };
  bool add_code(u32 unit, u32 zeroed, u32 self, u32 binds, Instance& out);
  bool add_connector_codes(const rt::InteractionInfo& info, Instance& out);
  bool add_plan_codes(const rt::Plan& plan, Instance& out);
  bool add_transfers(const rt::PlanUse* uses, u32 count, const rt::PlanNode* nodes, Instance& out);
  bool order_uses(u32 count, const rt::PlanNode* nodes);
  enum class Transfer : std::uint8_t { Up, Down };
  [[nodiscard]] u32 unit_of(u32 use, Transfer transfer) const;
  void evaluate_uses();
  bool list_assigned();
  [[nodiscard]] u32 home_of(u32 value) const;
  bool add_joined(Instance& out);
  bool add_moved(Instance& out);
  bool add_ups(Instance& out);
  void add_copies(Instance& out);
  bool add_actions(Instance& out);
  bool add_effects(rt::InteractionId fired, Instance& out);
  bool add_interaction(Effect effect, rt::InteractionId fired, Instance& out);
  bool add_star(rt::InteractionId fired, const rt::InteractionInfo& info, Instance& out);
  bool add_star_transfers(const rt::InteractionInfo& info, const std::vector<bool>& is_sure, Instance& out);
  bool add_ready(const std::vector<u32>& ports, Instance& out, u32& last_changed);
  [[nodiscard]] std::vector<bool> find_sure(rt::InteractionId fired) const;
  [[nodiscard]] bool is_sure(const rt::InteractionInfo& info) const;
  [[nodiscard]] u32 trigger_count(rt::InteractionId interaction, const rt::InteractionInfo& info) const;
  [[nodiscard]] u32 transition_of(u32 instance) const;
  [[nodiscard]] bool have_distinct_atoms();

  const lower::LoweredSystem& lowered_;
  const rt::Image& image_;
  rt::Tables tables_;
  rt::Binds binds_;
  rt::PriorityTables rules_;
  std::vector<lower::CodeFacts> facts_;  // by unit
  std::vector<u32> first_port_;          // by atom type: its rows of transitions_
  std::vector<u32> transitions_;         // by atom type and port: the only transition, or none
  std::map<rt::InteractionId, std::vector<rt::InteractionId>> hiders_, hidden_;
  // scratch
  std::vector<u32> ports_, atoms_;
  std::vector<rt::InteractionId> touched_;
  std::vector<Effect> effects_;
  // of one plan: see transfers.cpp
  Values values_;
  const rt::PlanUse* uses_ = nullptr;
  std::vector<u32> ups_, downs_;               // uses, in the order in which their code runs
  std::vector<u32> homes_;                     // by value that an `up` gave: the cell, or none
  std::vector<std::pair<u32, u32>> assigned_;  // cells of atoms that get a value from connectors, and which
  std::vector<std::pair<u32, u32>> copies_;    // to, from
};

}  // namespace bip::steps
