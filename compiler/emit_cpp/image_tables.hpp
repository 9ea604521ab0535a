// The image's tables as C++ constants.
#pragma once
#include <string>
#include <vector>

#include "compiler/emit_cpp/writer.hpp"
#include "compiler/lower/lower.hpp"
#include "compiler/lower/unit_names.hpp"
#include "runtime/include/bip/image_time.hpp"

namespace bip::emit_cpp {

/// Writes tables with names that are unique in the file. Arrays come before the rows that name them.
class TableWriter {
 public:
  TableWriter(const lower::LoweredSystem& lowered, CppWriter& out);

  void types();
  void instances();
  /// The Image itself; after all tables.
  void image();

 private:
  void port_types();
  void atom_type(const rt::AtomType& type);
  void connector_type(const rt::ConnectorType& type);
  // tables_time.cpp
  std::string atom_time(const std::string& name, const rt::AtomTime* time);
  std::string time_guard(const std::string& name, const rt::TimeGuard& when);
  std::string resume(const std::string& name, const rt::Resume& resume);
  void priorities();
  void choices();
  void shown_ports();
  void steps();
  void inner_steps();

  /// `constexpr <type> <name>[] = { rows };` and the expression for its span; nothing and "{}" if there are no rows.
  std::string table(const std::string& type, const std::string& name, const std::vector<std::string>& rows);
  /// The expression for a table of instances, of which `rows` are those that stand.
  template <class T, class SlopeText>
  std::string folded(const std::string& type, const std::string& name, const std::vector<std::string>& rows,
                     const rt::Rows<T>& table_rows, SlopeText slope_text);
  // The array's name; rows there must be.
  std::string array(const std::string& type, const std::string& name, const std::vector<std::string>& rows);
  /// The expression for a list of rows: in place if it is short.
  std::string list(const std::string& name, const rt::Span<std::uint32_t>& items);
  std::string ranges(const std::string& name, const rt::Span<rt::RangeOp>& code);
  std::string cell_operands();
  std::string vars(const std::string& name, const rt::Span<rt::Var>& items);
  std::string pattern(const std::string& name, const rt::Pattern& pattern);

  const lower::LoweredSystem& lowered_;
  const rt::Image& image_;
  CppWriter& out_;
  lower::UniqueNames names_;
  std::vector<std::string> atom_rows_, connector_rows_;
  // Spans of the finished tables, for image().
  std::string port_types_, atom_types_, connector_types_, compounds_, atoms_, args_, connectors_, port_refs_, binds_,
      priorities_, choices_, shown_ports_, step_fns_, step_runs_, step_operands_, step_entries_, step_columns_,
      steps_fn_, inner_steps_;
};

}  // namespace bip::emit_cpp
