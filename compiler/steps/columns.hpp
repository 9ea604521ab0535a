// Data in columns for the loop over steps.
//
// In the core's array an atom's variables lie side by side, eight bytes each. An interaction of a thousand atoms that
// looks at one variable of each reads four or eight times what it needs. While the loop over steps runs nobody else
// looks at data, so they may lie otherwise: four bytes each, and those of one variable in a row.
#pragma once
#include "compiler/steps/derive_steps.hpp"

namespace bip::steps {

/// Makes steps.cells and points steps.loop to it, if that is possible (all variables have 32 bits, every operand moves
/// as regularly among cells as among cells) and of use: the loop knows all runs, and some interaction goes over data of
/// many atoms. atom_cells: cells below belong to atoms. Linear in what interactions do.
void lay_out_columns(const lower::LoweredSystem& lowered, std::uint32_t atom_cells, Columns columns,
                     lower::Steps& steps);

}  // namespace bip::steps
