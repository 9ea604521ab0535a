// The ports for events of a system, by their paths, and what an event for one must carry.
//
// Constant after construction, so any thread may ask. Cost: O(log ports) a path.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "bip/events.hpp"
#include "runtime/core/core.hpp"

namespace bip::rt {

class EventPorts {
 public:
  explicit EventPorts(const Core& core);
  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  /// `ROOT.panel.press`, with or without `ROOT.`; kNone: there is no such port for events.
  [[nodiscard]] u32 find(std::string_view path) const;
  [[nodiscard]] std::string path(u32 row) const;
  /// `ROOT.planner`, of those with actions that run beside the others; kNone: there is none. O(atoms).
  [[nodiscard]] u32 find_atom(std::string_view path) const;
  [[nodiscard]] std::string atom_path(u32 atom) const { return image_.atoms[atom].path(); }
  /// Its variables.
  [[nodiscard]] const Span<Var>& vars(u32 row) const;
  /// Empty, or what is wrong with these values for the port; ints become floats where those are wanted.
  [[nodiscard]] std::string check(u32 row, std::vector<EventValue>& values) const;
  /// As the core wants them. Only where the model runs: strings are made rows.
  void to_cells(u32 row, const std::vector<EventValue>& values, std::vector<Cell>& out) const;
  [[nodiscard]] EventValue from_cell(CellType type, Cell cell) const;

 private:
  const Image& image_;
  const std::vector<EventPortRow>& rows_;  // the core's
  std::vector<u32> by_path_;
};

}  // namespace bip::rt
