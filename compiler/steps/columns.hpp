// Columnar layout of data for the loop over compiled steps.
//
// In the core's array the variables of an atom lie side by side, eight bytes each. An interaction of a thousand atoms
// that reads one variable of each reads four or eight times the bytes that it needs. During the loop over steps nothing
// else reads data, so the layout may differ there: four bytes per value, and all values of one variable in sequence.
#pragma once
#include "compiler/steps/derive_steps.hpp"

namespace bip::steps {

/// Makes steps.cells and points steps.loop to it, if that is possible (all variables have 32 bits, every operand moves
/// as regularly among cells as among cells) and of use: the loop knows all runs, and some interaction goes over data of
/// many atoms. atom_cells: cells below belong to atoms. Linear in what interactions do.
void lay_out_columns(const lower::LoweredSystem& lowered, std::uint32_t atom_cells, Columns columns,
                     lower::Steps& steps);

}  // namespace bip::steps
