// The effect of code on cells, as expressions over the values that the cells had before.
//
// Code of connectors mostly compares, adds and passes values on. A value that is the old value of a cell, or many old
// values joined by an operation whose order cannot be observed in the result's bits, need not pass through the
// connectors' variables: the receiver can be given it directly. Any other value is opaque.
#pragma once
#include <utility>
#include <vector>

#include "compiler/lower/step_shapes.hpp"
#include "compiler/model/code.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::steps {

using rt::u32;

class Values {
 public:
  enum class Kind : std::uint8_t { Old, Zero, Opaque, Joined };
  struct Value {
    Kind kind;
    lower::ReductionOp by;  // Joined
    u32 a, b;               // Old: a is the cell; Joined: two values
  };

  Values(const CodeTable& code, u32 cells) : code_(code), now_(cells, rt::kNone) {}

  /// Interactions hold what they held.
  void begin();
  /// Sets cells [first, first + count) to zero.
  void zero(u32 first, u32 count);
  /// Runs statements that cannot fault. Linear in them but for variables that branches assign.
  void run(StmtId body, u32 self, const u32* bind);

  /// False: there were too many branches within one another, so nothing is known.
  [[nodiscard]] bool is_known() const { return is_known_; }
  /// Was a cell read that was set to zero and not assigned since, or might it have been?
  [[nodiscard]] bool has_read_zero() const { return has_read_zero_; }
  /// What the cell holds now: a row of values.
  [[nodiscard]] u32 in(u32 cell);
  [[nodiscard]] const Value& operator[](u32 value) const { return values_[value]; }
  [[nodiscard]] u32 count() const { return static_cast<u32>(values_.size()); }
  /// Interactions that were asked for or assigned since `begin`, each once.
  [[nodiscard]] const std::vector<u32>& cells() const { return cells_; }
  /// The cells whose old values are joined to this one, ascending, each as often as it counts. False: it is no such
  /// value.
  [[nodiscard]] bool elements(u32 value, std::vector<u32>& out) const;

 private:
  using Assigned = std::vector<std::pair<u32, u32>>;  // cell, value

  u32 add(Value value);
  u32 opaque() { return add({Kind::Opaque, {}, 0, 0}); }
  u32 read(u32 cell);
  u32 joined(lower::ReductionOp by, u32 a, u32 b);
  u32 expr(ExprId id);
  void set(u32 cell, u32 value);
  void branch(const Stmt& s);
  Assigned take_back(std::size_t mark);
  u32 either(ExprId condition, u32 yes, u32 no);

  const CodeTable& code_;
  std::vector<u32> now_;  // by cell; kNone: not read yet
  std::vector<u32> cells_;
  std::vector<Value> values_;
  Assigned before_;  // what assignments within branches replaced
  u32 depth_ = 0, self_ = 0;
  const u32* bind_ = nullptr;
  bool is_known_ = true, has_read_zero_ = false;
};

}  // namespace bip::steps
