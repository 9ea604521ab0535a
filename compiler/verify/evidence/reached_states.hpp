// The states that a search reaches, as rows of a certificate: what was reached is itself an invariant that every step
// keeps.
//
// States are sorted, and a row tells only what differs from the row before. Cost: the states, sorted, once.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/system/system.hpp"
#include "runtime/core/state/state.hpp"

namespace bip::verify {

class StateCollector {
 public:
  /// `system` and `image` are of one compilation and must outlive it.
  StateCollector(const System& system, const rt::Image& image);
  /// False: some of the data has no values that a certificate can name (float, extern), or there is too much of it.
  [[nodiscard]] bool can_tell() const { return can_tell_; }
  void add(const rt::State& state);
  /// "state ROOT.a@S ROOT.a.n=3", a row a state. Empty if that would be too long.
  [[nodiscard]] std::string rows() const;

 private:
  /// What is told of a state: the place of an automaton, whether a place of a Petri net atom is marked, a value.
  enum class About : std::uint8_t { Automaton, Place, Value };
  struct StateColumn {
    About about = About::Automaton;
    std::uint32_t position = 0;                        // row of places or data, bit of the marks
    std::string name;                                  // "ROOT.a@", "ROOT.a@P", "ROOT.a.n="
    const std::vector<std::string>* places = nullptr;  // Automaton
  };

  bool can_tell_ = true;
  std::vector<StateColumn> columns_;
  std::vector<std::int32_t> values_;  // a row of all questions a state
};

}  // namespace bip::verify
