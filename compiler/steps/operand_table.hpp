// Operands of irregular models in a table, for the loop over steps.
//
// On a random graph the numbers of an interaction's neighbours follow no rule, so each interaction is a run of its own,
// and a step reads its run and two numbers for each operand. The loop knows such interactions by their shape instead:
// what is affine becomes a constant of the code, what follows from another operand is computed (the cell of an atom
// from another cell of it), and the rest is a row of numbers, usually one cache line.
#pragma once
#include "compiler/lower/step_shapes.hpp"

namespace bip::steps {

/// Returns the table of the shapes with the most interactions; an empty one if most runs are longer than a few
/// interactions, or if those shapes are not nearly all interactions. Linear in the operands of all interactions.
[[nodiscard]] lower::OperandTable make_operand_table(const std::vector<lower::StepShape>& shapes,
                                                     const std::vector<rt::StepRun>& runs,
                                                     const std::vector<rt::StepOperand>& operands);

}  // namespace bip::steps
