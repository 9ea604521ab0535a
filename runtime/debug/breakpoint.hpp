// Where a debugging session stops. A breakpoint is looked at after each move, with the state before and after it: a
// step of an interaction, a port, or a line of the source was taken; an atom has entered a place; a variable has
// changed; a condition has become true; an instant was reached.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "runtime/core/core.hpp"

namespace bip::rt {

enum class BreakKind : std::uint8_t { Interaction, Port, Place, Data, Line, Condition, Time };

struct Breakpoint {
  BreakKind kind = BreakKind::Condition;
  u32 owner = 0;  // connector; atom; Line: row of Image::files
  u32 row = 0;    // port, place or variable of the atom; Line: the line
  i64 instant = 0;
  std::string text;  // as the person wrote it
  /// Condition: stops where it has become true. Other kinds: stops only where it holds; may be empty.
  std::function<bool(const Core&)> condition;
  /// Not empty: the session goes on and reports the breakpoint to on_log.
  std::string message;
  std::uint64_t number = 0;       // by which the face names it
  std::uint64_t hits_before = 0;  // stops from the hit after so many
  std::uint64_t hits = 0;
  bool is_temporary = false;  // of one movement

  std::uint64_t was = 0;  // Place, Condition: whether it held before the move; Data: the value
};

}  // namespace bip::rt
