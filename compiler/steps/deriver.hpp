// One derivation: what interactions do, slot by slot. Private to steps/.
#pragma once
#include <map>
#include <vector>

#include "compiler/lower/code_facts.hpp"
#include "compiler/lower/lower.hpp"
#include "runtime/core/priorities.hpp"
#include "runtime/core/tables.hpp"

namespace bip::steps {

using lower::SlotChange;
using lower::StepOp;
using lower::StepOpKind;
using rt::kNone;
using rt::u32;

/// The operations of one slot's interaction with the values of their operands.
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
};

/// Operations that repeat with equal strides, `least` or more in a row, become one. strides: by operand.
void fold(const Instance& in, std::size_t least, Instance& out, std::vector<std::int32_t>& strides);

class Deriver {
 public:
  explicit Deriver(const lower::LoweredSystem& lowered);

  /// False: priorities that only the core knows how to follow.
  [[nodiscard]] bool link_priorities();
  [[nodiscard]] const std::vector<lower::CodeFacts>& facts() const { return facts_; }
  [[nodiscard]] u32 slots() const { return static_cast<u32>(tables_.slots.size()); }
  /// Must every slot have a shape, if any is to have one? Compiled steps do not keep the core's books of priority rules.
  [[nodiscard]] bool needs_all() const { return rules_.count != 0; }
  enum class Found { Yes, Never, No };  // Never: it cannot fire
  /// The interaction of a slot, not folded.
  Found describe(u32 slot, Instance& out);

 private:
  struct Effect {
    u32 slot;
    std::int32_t delta;
  };
  bool add_code(u32 unit, u32 zeroed, u32 self, u32 binds, Instance& out);
  bool add_connector_codes(const rt::SlotInfo& info, Instance& out);
  bool add_plan_codes(const rt::Plan& plan, Instance& out);
  bool add_actions(Instance& out);
  bool add_effects(u32 fired, Instance& out);
  bool add_slot(Effect effect, u32 fired, Instance& out);
  bool add_star(Instance& out);
  [[nodiscard]] u32 transition_of(u32 instance) const;
  [[nodiscard]] bool have_distinct_atoms();

  const lower::LoweredSystem& lowered_;
  const rt::Image& image_;
  rt::Tables tables_;
  rt::PriorityTables rules_;
  std::vector<lower::CodeFacts> facts_;             // by unit
  std::vector<u32> first_port_;                     // by atom type: its rows of transitions_
  std::vector<u32> transitions_;                    // by atom type and port: the only transition, or none
  std::map<u32, std::vector<u32>> hiders_, hidden_;  // by slot
  // scratch
  std::vector<u32> ports_, atoms_, touched_;
  std::vector<Effect> effects_;
};

}  // namespace bip::steps
