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
  /// What a column is about: the place of an automaton, whether a place of a Petri net atom is marked, a value.
  enum class About : std::uint8_t { Automaton, Place, Value };
  struct StateColumn {
    About about = About::Automaton;
    std::uint32_t position = 0;                        // row of places or data, bit of the marks
    std::string name;                                  // "ROOT.a@", "ROOT.a@P", "ROOT.a.n="
    const std::vector<std::string>* places = nullptr;  // Automaton
  };

  bool is_listable_ = true;
  std::size_t bytes_;
  std::vector<StateColumn> columns_;
  std::vector<std::int32_t> values_;  // a row of all questions a state
};

}  // namespace bip::verify
