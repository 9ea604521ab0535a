// Emits one C++ function per shape of interaction; compiler/lower/step_shapes.hpp defines the operations.
//
// Operands are local constants v0, v1, …. The functions of units are called by name, so that the compiler inlines them.
// In loops, positions are pointers that advance by constants, which lets compilers vectorise them.
#include "compiler/emit_cpp/emit_steps.hpp"

#include <algorithm>

#include "compiler/emit_cpp/functions.hpp"
#include "compiler/model/code_uses.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::emit_cpp {

using lower::StepOp;
using lower::StepOpKind;

namespace {

const char* name_of(lower::ReductionOp reduction) {
  switch (reduction) {
    case lower::ReductionOp::Add: return "Sum";
    case lower::ReductionOp::Mul: return "Product";
    case lower::ReductionOp::And: return "BitAnd";
    case lower::ReductionOp::Or: return "BitOr";
    case lower::ReductionOp::Xor: return "BitXor";
    case lower::ReductionOp::Min: return "Least";
    case lower::ReductionOp::Max: return "Largest";
  }
  return "";
}

class ShapeWriter {
 public:
  /// Cells one by one, or those of the columnar layout.
  enum class Cells : std::uint8_t { Single, Column };
  ShapeWriter(const lower::LoweredSystem& lowered, const lower::StepShape& shape, Cells cells, CppWriter& out)
      : lowered_(lowered),
        shape_(shape),
        out_(out),
        all_(cells == Cells::Column ? "s.cells" : "s.all"),
        cell_(cells == Cells::Column ? "ColumnCell" : "Cell") {}

  void write(const std::string& specifiers, const std::string& name) {
    out_.line();
    out_.line(specifiers + "void " + name +
              "(StepState& state, [[maybe_unused]] const StepOperand* operands, [[maybe_unused]] std::uint32_t i) {");
    out_.line("  StepState s = state;");
    for (std::size_t k = 0; k < shape_.strides.size(); ++k) {
      const std::string cell = "operands[" + std::to_string(k) + "]";
      std::string text = cell + ".at(i)";
      if (!shape_.run_strides.empty()) {
        const std::uint32_t stride = shape_.run_strides[k];
        text = cell + ".base" + (stride == 0 ? "" : stride == 1 ? " + i" : " + " + std::to_string(stride) + "u * i");
      }
      out_.line("  const std::uint32_t v" + std::to_string(k) + " = " + text + ";");
    }
    for (const StepOp& op : shape_.ops) {
      guard(op);
      if (op.kind == StepOpKind::At || op.kind == StepOpKind::Away) test(op);
      if (op.kind == StepOpKind::Reduce) reduce(op);
      if (op.kind == StepOpKind::Copy) copy(op);
      if (op.kind == StepOpKind::Code) code(op);
      if (op.kind == StepOpKind::Place) loop(op, "s.places[" + at(op, 0) + "] = " + value(op, 1) + ";");
      if (op.kind == StepOpKind::Ready) ready(op);
      if ((op.kind == StepOpKind::Interaction || op.kind == StepOpKind::Count) && op.delta != 0) loop(op, grow(op, 0));
    }
    guard({});
    for (const StepOp& op : shape_.ops) {
      if (op.kind == StepOpKind::Interaction) list(op);
      if (op.kind == StepOpKind::SettleInOrder) settle_in_order(op);
      if (op.kind == StepOpKind::Settle) loop(op, "settle_interaction(s, " + value(op, 0) + ");");
    }
    BIP_ASSERT(inlined_.empty(), "copies were not written: {}", inlined_);
    out_.line("  state.count = s.count;");
    out_.line("}");
  }

 private:
  [[nodiscard]] static std::uint32_t operand(const StepOp& op, std::uint32_t k) {
    return op.first_ref + (op.repeats ? 1 : 0) + k;
  }
  [[nodiscard]] std::int32_t stride(const StepOp& op, std::uint32_t k) const { return shape_.strides[operand(op, k)]; }
  /// How many refs the operation has without the count.
  [[nodiscard]] static std::uint32_t refs(const StepOp& op) { return op.refs - (op.repeats ? 1 : 0); }

  // Ref k as a number, and as an index that moves with t.
  [[nodiscard]] std::string value(const StepOp& op, std::uint32_t k) const {
    BIP_ASSERT(operand(op, k) < shape_.strides.size() && k < refs(op), "operand {} of an operation with {}", k,
               refs(op));
    const std::string base = "v" + std::to_string(operand(op, k));
    if (stride(op, k) == 0) return base;
    return base + " + " + std::to_string(static_cast<std::uint32_t>(stride(op, k))) +
           "u * static_cast<std::uint32_t>(t)";
  }
  [[nodiscard]] std::string at(const StepOp& op, std::uint32_t k) const {
    const std::string base = "v" + std::to_string(operand(op, k));
    if (stride(op, k) == 0) return base;
    return "std::ptrdiff_t{" + base + "} + " + std::to_string(stride(op, k)) + " * t";
  }
  [[nodiscard]] std::string grow(const StepOp& op, std::uint32_t k) const {
    return "s.values[" + at(op, k) + "] += " + std::to_string(op.delta) + ";";
  }

  void loop(const StepOp& op, const std::string& statement) {
    out_.line((op.repeats
                   ? "  for (std::ptrdiff_t t = 0; t < std::ptrdiff_t{v" + std::to_string(op.first_ref) + "}; ++t) "
                   : "  ") +
              statement);
  }

  // What is executed only if atoms are where it says. Each group of tests has a variable of its own.
  void test(const StepOp& op) {
    if (holds_.empty()) {
      holds_ = "holds" + std::to_string(op.first_ref);
      out_.line("  bool " + holds_ + " = true;");
    }
    loop(op, holds_ + " &= s.places[" + at(op, 0) + "] " + (op.kind == StepOpKind::At ? "==" : "!=") + " " +
                 std::to_string(op.from) + "u;");
  }
  void guard(const StepOp& op) {
    if (op.guarded == is_guarded_) return;
    is_guarded_ = op.guarded;
    BIP_ASSERT(!holds_.empty(), "guarded operations without a test");
    out_.line(op.guarded ? "  if (" + holds_ + ") {" : "  }");
    if (!op.guarded) holds_.clear();
  }

  // The call of a unit whose self is ref k and whose bound variables follow. Their rows come in an array; if all move
  // alike, `all` moves instead.
  [[nodiscard]] std::string call(const StepOp& op, std::uint32_t k, std::string& before) const {
    BIP_ASSERT(op.unit < lowered_.units.size() && lowered_.steps.binds.size() == lowered_.units.size(), "unit {} of {}",
               op.unit, lowered_.units.size());
    const lower::CodeUnit& unit = lowered_.units[op.unit];
    const std::vector<std::uint32_t>& binds = lowered_.steps.binds[op.unit];
    std::string bind = "nullptr", all = all_;
    if (!binds.empty()) {
      bool together = true;
      for (std::uint32_t b = 0; b < binds.size(); ++b)
        together = together && stride(op, k + 1 + b) == stride(op, k + 1);
      bind = "bind" + std::to_string(op.first_ref);
      std::string cells;
      std::uint32_t next = 0;
      for (std::uint32_t b = 0; b < binds.size(); ++b, ++next) {
        for (; next < binds[b]; ++next) cells += "0, ";
        cells += (together ? "v" + std::to_string(operand(op, k + 1 + b)) : value(op, k + 1 + b)) + ", ";
      }
      before = "const std::uint32_t " + bind + "[] = {" + cells.substr(0, cells.size() - 2) + "};";
      if (together && stride(op, k + 1) != 0) all += " + " + std::to_string(stride(op, k + 1)) + " * t";
    }
    return unit.name + "(nullptr, " + all_ + " + (" + at(op, k) + "), " + all + ", " + bind + ")";
  }

  void reduce(const StepOp& op) {
    const std::string by = std::string("bip::rt::reduce<bip::rt::") + name_of(op.reduction) + ">(" + all_ + "[" +
                           at(op, 0) + "], " + all_ + " + ";
    const std::string from = "v" + std::to_string(operand(op, 1));
    if (op.repeats && stride(op, 0) == 0) {
      out_.line("  " + by + from + ", " + std::to_string(stride(op, 1)) + ", v" + std::to_string(op.first_ref) + ");");
    } else {
      loop(op, by + "(" + at(op, 1) + "), 0, 1);");
    }
  }

  // Of a short body the jump would be a good part; g++ unrolls nothing by itself.
  void unroll(const StepOp& op) {
    constexpr std::size_t kShort = 4;
    std::size_t statements = 0;
    model::for_each_stmt(lowered_.system->code, lowered_.units[op.unit].body, [&](const Stmt&) { ++statements; });
    if (op.repeats && statements <= kShort) out_.line("  BIP_UNROLL");
  }

  // What stays where it is, is read once; with a code, in its loop.
  void copy(const StepOp& op) {
    if (stride(op, 1) != 0 || !op.repeats)
      return loop(op, all_ + "[" + at(op, 0) + "] = " + all_ + "[" + at(op, 1) + "];");
    const std::string name = "moved" + std::to_string(op.first_ref);
    out_.line("  const " + cell_ + " " + name + " = " + all_ + "[" + at(op, 1) + "];");
    if (!op.inlined) return loop(op, all_ + "[" + at(op, 0) + "] = " + name + ";");
    inlined_ += "self[" + std::to_string(op.offset) + "] = " + name + "; ";
  }
  void code_with_copies(const StepOp& op) {
    unroll(op);
    loop(op, "{ " + cell_ + "* const self = " + all_ + " + (" + at(op, 0) + "); " + inlined_ +
                 lowered_.units[op.unit].name + "(nullptr, self, " + all_ + ", nullptr); }");
    inlined_.clear();
  }

  void code(const StepOp& op) {
    if (!inlined_.empty()) return code_with_copies(op);
    std::string body, before;
    for (std::uint32_t k = 0; k < op.zeroed; ++k)
      body += all_ + "[" + at(op, 0) + " + " + std::to_string(k) + "] = " + cell_ + "{0}; ";
    if (op.unit != rt::kNone) {
      const std::string text = call(op, 0, before);
      body += text + ";";
      unroll(op);
    }
    loop(op, "{ " + (before.empty() ? "" : before + " ") + body + " }");
  }

  void settle_in_order(const StepOp& op) {
    const std::string number = std::to_string(op.first_ref);
    std::string changed;
    for (std::uint32_t k = 1; k < op.refs; ++k) changed += (k == 1 ? "" : ", ") + value(op, k);
    out_.line("  const std::uint32_t order" + number + " = s.scratch[" + at(op, 0) + "], changed" + number + "[] = {" +
              changed + "};");
    for (std::uint32_t k = 1; k < op.refs; ++k) {
      out_.line("  settle_interaction(s, changed" + number + "[order" + number + " >> " + std::to_string(4 * (k - 1)) +
                " & 15]);");
    }
  }

  // Which are ready is noted first, without branches: a branch would not be predicted.
  void ready(const StepOp& op) {
    out_.line("  {");
    out_.line("    std::uint32_t ready = 0;");
    out_.line("    for (std::ptrdiff_t t = 0; t < std::ptrdiff_t{v" + std::to_string(op.first_ref) + "}; ++t) {");
    out_.line("      s.scratch[ready] = static_cast<std::uint32_t>(t);");
    out_.line("      ready += s.places[" + at(op, 0) + "] == " + std::to_string(op.from) + "u ? 1u : 0u;");
    out_.line("    }");
    out_.line("    for (std::uint32_t k = 0; k < ready; ++k) {");
    out_.line("      [[maybe_unused]] const std::ptrdiff_t t = s.scratch[k];");
    std::string before;
    if (op.unit != rt::kNone) out_.line("      " + call(op, 1, before) + ";");
    if (op.from != op.to) out_.line("      s.places[" + at(op, 0) + "] = " + std::to_string(op.to) + "u;");
    if (op.delta != 0) {
      const std::uint32_t interaction = refs(op) - 1;
      out_.line("      " + grow(op, interaction));
      out_.line(std::string("      ") + (op.delta > 0 ? "interaction_enters" : "interaction_leaves") + "(s, " +
                value(op, interaction) + ");");
    }
    out_.line("    }");
    out_.line("  }");
  }

  void list(const StepOp& op) {
    const std::string interaction = value(op, 0);
    if (op.change == lower::InteractionChange::Enters) return loop(op, "interaction_enters(s, " + interaction + ");");
    if (op.change == lower::InteractionChange::Leaves) return loop(op, "interaction_leaves(s, " + interaction + ");");
    std::string before, zeroes;
    std::string is_on = "s.values[" + at(op, 0) + "] >= 0";
    for (std::uint32_t k = refs(op) - op.hiders; k < refs(op); ++k) is_on += " && s.values[" + at(op, k) + "] < 0";
    if (op.unit != rt::kNone) {
      for (std::uint32_t k = 0; k < op.zeroed; ++k)
        zeroes += all_ + "[" + at(op, 1) + " + " + std::to_string(k) + "] = " + cell_ + "{0}; ";
      is_on += " && " + call(op, 1, before) + " != 0";
    }
    loop(op, "{ " + before + (before.empty() ? "" : " ") + zeroes + "set_interaction(s, " + interaction + ", " + is_on +
                 "); }");
  }

  const lower::LoweredSystem& lowered_;
  const lower::StepShape& shape_;
  CppWriter& out_;
  std::string all_, cell_;
  std::string holds_;        // the variable of the tests before
  bool is_guarded_ = false;  // among guarded operations
  std::string inlined_;      // copies, for the next code
};

// The units that shapes on cells call, each at its own distance.
void emit_units_on_cells(const lower::LoweredSystem& lowered, CppWriter& out) {
  const lower::StepCells& cells = lowered.steps.cells;
  std::vector<bool> is_called(lowered.units.size(), false);
  for (const lower::StepShape& shape : cells.shapes) {
    for (const StepOp& op : shape.ops) {
      if (op.unit != rt::kNone) is_called[op.unit] = true;
    }
  }
  out.line();
  out.line("// The same on cells: data in columns while a loop over steps runs (bip/steps.hpp).");
  for (const char* name : {"BoolCell", "ColumnCell", "IntCell", "StringCell"})
    out.line(std::string("using bip::rt::") + name + ";");
  for (std::uint32_t unit = 0; unit < is_called.size(); ++unit) {
    if (is_called[unit]) emit_on_cells(lowered, unit, cells.self_distance[unit], out);
  }
  out.at_emitted();
}

bool is_in_loop(const lower::Steps& steps, std::size_t shape) {
  return steps.shapes[shape].is_inlined() &&
         std::any_of(steps.loop.begin(), steps.loop.end(), [&](const rt::StepRun& run) { return run.shape == shape; });
}

}  // namespace

std::string step_name(std::size_t shape) { return "steps::shape_" + std::to_string(shape); }

void emit_steps(const lower::LoweredSystem& lowered, CppWriter& out) {
  const lower::Steps& steps = lowered.steps;
  if (steps.shapes.empty()) return;
  const lower::StepCells& cells = steps.cells;
  if (!cells.empty()) emit_units_on_cells(lowered, out);
  out.line();
  out.line("// Whole steps, one function a shape of interaction; bip/steps.hpp says what they work on.");
  out.line("namespace steps {");
  for (const char* name :
       {"ColumnCell", "StepState", "StepOperand", "interaction_enters", "interaction_leaves", "set_interaction"}) {
    out.line(std::string("using bip::rt::") + name + ";");
  }
  if (!steps.inner.runs.empty()) out.line("using bip::rt::settle_interaction;");
  for (std::size_t k = 0; k < steps.shapes.size(); ++k) {
    const lower::StepShape& shape = steps.shapes[k];
    const std::string name = "shape_" + std::to_string(k);
    ShapeWriter writer(lowered, shape, ShapeWriter::Cells::Single, out);
    if (!shape.has_loops()) {
      writer.write(shape.is_inlined() ? "BIP_INLINE " : "", name);
    } else if (cells.empty() && is_in_loop(steps, k)) {
      writer.write("BIP_INLINE ", name + "_inlined");
      out.line();
      out.line("BIP_FOR_PROCESSORS void " + name +
               "(StepState& state, const StepOperand* operands, std::uint32_t i) { " + name +
               "_inlined(state, operands, i); }");
    } else {
      writer.write("BIP_FOR_PROCESSORS ", name);
    }
  }
  for (std::size_t k = 0; k < cells.shapes.size(); ++k)
    ShapeWriter(lowered, cells.shapes[k], ShapeWriter::Cells::Column, out)
        .write("BIP_INLINE ", "cells_" + std::to_string(k));
  out.line();
  out.line("}  // namespace steps");
}

// One comparison after the other.
bool emit_step_loop(const lower::LoweredSystem& lowered, const std::string& name, const std::string& operands,
                    CppWriter& out) {
  const lower::Steps& steps = lowered.steps;
  if (steps.loop.empty()) return false;
  const std::vector<lower::StepShape>& shapes = steps.cells.empty() ? steps.shapes : steps.cells.shapes;
  const bool has_loops = std::any_of(steps.loop.begin(), steps.loop.end(), [&](const rt::StepRun& run) {
    return shapes[run.shape].is_inlined() && shapes[run.shape].has_loops();
  });
  out.line();
  if (has_loops) out.line("BIP_FOR_PROCESSORS");
  out.line("bip::rt::StepsTaken " + name +
           "(bip::rt::StepState& state, bip::rt::Prng& prng, bip::rt::StepHistory& history, std::uint64_t limit) {");
  out.line(
      "  return bip::rt::take_steps(state, prng, history, limit, [](bip::rt::StepState& s, std::uint32_t cell) "
      "BIP_INLINED {");
  out.line("    std::uint32_t i = 0;");
  for (const rt::StepRun& run : steps.loop) {
    const auto number = [](std::uint32_t value) { return std::to_string(value) + "u"; };
    const lower::StepShape& shape = shapes[run.shape];
    std::string function = step_name(run.shape);
    if (!steps.cells.empty()) function = "steps::cells_" + std::to_string(run.shape);
    else if (shape.is_inlined() && shape.has_loops()) function += "_inlined";
    BIP_ASSERT(run.shape < shapes.size(), "shape {} of {}", run.shape, shapes.size());
    const std::string row = operands + " + " + std::to_string(run.operands);
    out.line("    if (bip::rt::is_in_run(cell, " + number(run.first) + ", " + number(run.count) + ", " +
             number(run.distance) + ", i)) {");
    if (shape.is_inlined()) out.line("      " + function + "(s, " + row + ", i);");
    else out.line("      bip::rt::call_step(&" + function + ", s, " + row + ", i);");
    out.line("      return true;");
    out.line("    }");
  }
  out.line("    return false;");
  out.line("  });");
  out.line("}");
  return true;
}

}  // namespace bip::emit_cpp
