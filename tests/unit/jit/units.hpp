// Code units by hand: random and chosen pieces of code over a fixed set of variables, and what running them gives.
#pragma once
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "compiler/interp/interp.hpp"
#include "compiler/lower/lower.hpp"
#include "compiler/system/system.hpp"

namespace bip::test {

/// Self and Bind both have the variables 0 1 int, 2 3 bool, 4 5 float, 6 7 string. Self is rows 0–7 of `all`; Bind k is
/// row 15 - k, so that an index taken for an offset is seen.
inline constexpr std::uint32_t kVariables = 8;
inline constexpr std::uint32_t kCells = 2 * kVariables;
Type type_of_variable(std::uint32_t index);

/// A LoweredSystem without front end, instances or image: code and units only.
class Units {
 public:
  Units() { system_.code.strings = {"", "a", "b", "c"}; }

  CodeTable& code() { return system_.code; }
  ExprId constant(Type type, std::int32_t int_value, double float_value = 0);
  ExprId load(Op op, std::uint32_t index);
  ExprId op(Op op, Type type, ExprId a, ExprId b = {});
  StmtId store(StmtOp op, std::uint32_t index, ExprId value, StmtId next = {});
  StmtId branch(ExprId condition, StmtId then_body, StmtId else_body, StmtId next = {});
  void add_guard(ExprId expr);
  void add_action(StmtId body);

  /// Random code, at most `depth` deep.
  ExprId random_expr(std::mt19937& random, Type type, int depth);
  StmtId random_body(std::mt19937& random, int depth);

  [[nodiscard]] std::size_t size() const { return lowered_.units.size(); }
  /// Ready for an executor: sites numbered.
  lower::LoweredSystem& lowered();

 private:
  System system_;
  lower::LoweredSystem lowered_;
};

using Cells = std::vector<rt::Cell>;
/// Random values, often edges: 0, -1, INT_MIN, NaN, infinities, the smallest doubles.
Cells random_cells(std::mt19937& random);
std::int32_t edge_int(std::mt19937& random);
double edge_float(std::mt19937& random);

/// The status of a unit over a copy of `cells`, then every cell, as text (any NaN alike), so that two can be compared.
std::string outcome(const rt::Code& code, Cells cells);

}  // namespace bip::test
