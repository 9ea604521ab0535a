// Broken promises of a System with the row each belongs to, so that the reader of .bsys can say at which line.
// Internal to system/.
#pragma once
#include <string>
#include <vector>

#include "compiler/system/system.hpp"

namespace bip::system {

enum class Table : std::uint8_t {
  Whole,
  PortTypes,
  AtomTypes,
  ConnectorTypes,
  Compounds,
  Atoms,
  Choices,
  Connectors,
  Priorities
};
inline constexpr std::size_t kTables = 9;

struct Problem {
  Table table = Table::Whole;
  std::uint32_t row = 0;
  std::string message;
};

/// Collects up to kMax problems; the rest is dropped, for one fault can break every row.
class Problems {
 public:
  static constexpr std::size_t kMax = 100;

  void at(Table table, std::size_t row) {
    table_ = table;
    row_ = static_cast<std::uint32_t>(row);
  }
  void add(std::string message) {
    if (list_.size() < kMax) list_.push_back({table_, row_, std::move(message)});
  }
  /// Adds `message` unless `holds`; returns `holds`.
  bool expect(bool holds, const char* message) {
    if (!holds) add(message);
    return holds;
  }
  [[nodiscard]] bool empty() const { return list_.empty(); }
  [[nodiscard]] const std::vector<Problem>& list() const { return list_; }

 private:
  std::vector<Problem> list_;
  Table table_ = Table::Whole;
  std::uint32_t row_ = 0;
};

/// All problems, types before instances. Problems of ids come alone: what hangs on them is not looked at.
[[nodiscard]] std::vector<Problem> find_problems(const System& system);

/// The parts of it, each in a file of its own.
void check_code(const System& system, Problems& problems);
void check_port_and_atom_types(const System& system, Problems& problems);
void check_connector_types(const System& system, Problems& problems);
void check_instances(const System& system, Problems& problems);
void check_priorities(const System& system, Problems& problems);

/// A place names a file of the table.
inline void check_loc(const System& system, const Loc& loc, Problems& problems) {
  problems.expect(loc.line == 0 || loc.file < system.files.size(), "a place names no file of the table");
}
/// Port types whose variables agree: as many, of the same types. Both must be rows.
[[nodiscard]] bool same_variables(const System& system, PortTypeId a, PortTypeId b);
inline bool is_type(const System& system, Type type) {
  return !is_ffi(type) || ffi_row(type) < system.code.ffi_types.size();
}

}  // namespace bip::system
