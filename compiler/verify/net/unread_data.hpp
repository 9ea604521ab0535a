// Data that are never read: by no guard, no limit of a clock, no connector, and no assignment to data that is read.
// Without it a system has the same behaviour in time, only fewer states: counters that are there for people would make
// local state spaces infinite.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/system/system_ids.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::verify {

/// Which assignments count as readers although their results are never read: those that may end in a run-time error,
/// those that divide, none.
enum class FaultyAssignments : std::uint8_t { Read, DivisionsRead, Ignored };
/// By atom type, by variable: is it read? Hidden variables of time are, and those that are `asked` for. Linear in the
/// code, times the longest chain of assignments.
[[nodiscard]] std::vector<std::vector<std::uint8_t>> find_read_data(
    const System& system, const std::vector<DataRef>& asked = {},
    FaultyAssignments faulty = FaultyAssignments::Ignored);
/// Rows of the cells of numbers that are never read, ascending: whatever they hold, the same steps are possible, now
/// and later, and the same run-time errors. Strings and C++ objects are not among them.
[[nodiscard]] std::vector<rt::VariableId> find_unread_cells(const System& system, const rt::Image& image,
                                                            const std::vector<DataRef>& asked = {});
/// The same system without assignments to data that is not read. Faults that they would have ended in do not occur.
[[nodiscard]] System without_unread_data(const System& system, const std::vector<std::vector<std::uint8_t>>& is_read);

}  // namespace bip::verify
