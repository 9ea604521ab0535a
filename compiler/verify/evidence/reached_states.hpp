// Lists the states that a search reaches as rows of a certificate: the set of them is an inductive invariant.
//
// States are sorted, and a row has only what differs from the row before. Cost: 4 bytes per value of a state, a sort.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/system/system_ids.hpp"
#include "runtime/core/state/state.hpp"

namespace bip::verify {

/// What certificates say of a state, column by column: the place of an automaton, whether a place of a Petri net atom
/// is marked, a value.
struct StateColumn {
  enum class About : std::uint8_t { Automaton, Place, Value };

  About about = About::Automaton;
  std::uint32_t position = 0;                        // row of places or data, bit of the marks
  std::string name;                                  // "ROOT.a@", "ROOT.a@P", "ROOT.a.n="
  const std::vector<std::string>* places = nullptr;  // Automaton
  bool is_nameable = true;                           // Value: ints, bools, strings are; floats and FFI objects are not

  [[nodiscard]] std::int32_t value_in(const rt::State& state) const;
  /// Appends " ROOT.a@S", " !ROOT.a@P", " ROOT.a.n=3".
  void append(std::int32_t value, std::string& out) const;
};
/// Parameters, hidden variables of time and these cells have no column. Refers to `system`.
[[nodiscard]] std::vector<StateColumn> state_columns(const System& system, const rt::Image& image,
                                                     const std::vector<rt::VariableId>& left_out_cells = {});

class StateCollector {
 public:
  /// Refers to `system` and `image`, of one compilation, which must outlive it. `bytes`: of the values, and of the
  /// text.
  StateCollector(const System& system, const rt::Image& image, std::size_t bytes);
  /// Does all data have values that a certificate can name? Floats and FFI objects have none.
  [[nodiscard]] bool is_listable() const { return is_listable_; }
  void add(const rt::State& state);
  /// Returns "state ROOT.a@S ROOT.a.n=3", one row per state; an empty text if that would be too long.
  [[nodiscard]] std::string rows() const;

 private:
  bool is_listable_ = true;
  std::size_t bytes_;
  std::vector<StateColumn> columns_;
  std::vector<std::int32_t> values_;  // a row of all questions a state
};

}  // namespace bip::verify
