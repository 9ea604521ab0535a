// Local states of a component as cases of a certificate's rows: "ROOT.a@S&ROOT.a.n=0..3".
#pragma once
#include <compare>
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/system/system.hpp"

namespace bip::verify {

struct ValueRange {
  std::int32_t low = 0, high = 0;
  friend auto operator<=>(const ValueRange&, const ValueRange&) = default;
};
/// By column what is said of a local state: of an automaton the number of its place, else of each place whether it is
/// marked; then of variables.
using ValueBox = std::vector<ValueRange>;
struct CaseColumn {
  enum class About : std::uint8_t { Automaton, Place, Value } about = About::Automaton;
  std::uint32_t row = 0;
  bool is_int = false;
};

/// Returns the columns of places.
[[nodiscard]] std::vector<CaseColumn> place_columns(const AtomType& type);
/// May rows name the variable? Not a parameter, whose value the checker knows, nor what only the compiler names.
[[nodiscard]] bool is_nameable(const DataVariable& variable);
/// Joins boxes that differ in one int only, without a gap. Sorted.
[[nodiscard]] std::vector<ValueBox> joined_boxes(std::vector<ValueBox> boxes, const std::vector<CaseColumn>& columns);
/// Returns the case; an int that may have any value is not mentioned.
[[nodiscard]] std::string case_text(const Atom& atom, const AtomType& type, const std::vector<CaseColumn>& columns,
                                    const ValueBox& box);

}  // namespace bip::verify
