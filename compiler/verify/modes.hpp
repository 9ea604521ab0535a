// The modes of an atom: its local states as far as they decide what is enabled. A mode is a marking and the values of
// the data that guards depend on, where they are known; internal transitions are folded in, so a mode is stable.
//
// Every run of the system, looked at through one atom, is a path of modes (a simulation: a mode may stand for more than
// it must, never for less). Data is followed exactly while the modes stay few: first everything observed, then only
// booleans, then nothing. Shared by all atoms of one type with equal arguments.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/system/system.hpp"
#include "compiler/verify/abstract_code.hpp"
#include "compiler/verify/outside.hpp"

namespace bip::verify {

inline constexpr std::size_t kMaxModesWithData = 512;
inline constexpr std::size_t kMaxMarkings = 4096;

struct Mode {
  std::vector<std::uint32_t> places;   // sorted
  std::vector<AbstractValue> values;   // one a slot; parameters too
  friend auto operator<=>(const Mode&, const Mode&) = default;
};
struct Move {
  std::uint32_t from = 0, to = 0;  // modes
  friend auto operator<=>(const Move&, const Move&) = default;
};
struct PortMove {
  std::uint32_t port = 0, other = 0;
};
struct ModeClass {
  AtomTypeId type;
  std::vector<Value> args;
  bool is_too_large = false;                 // then nothing below holds
  std::vector<std::uint8_t> followed;        // by slot
  std::vector<Mode> modes;
  std::vector<std::uint32_t> initial;        // one of these, sorted
  std::vector<std::vector<Move>> moves;      // by port, sorted, each once
  std::vector<std::vector<std::uint8_t>> is_sure;  // by port, by mode: enabled in every state of the mode
  std::vector<std::vector<PortMove>> out, in;      // by mode; other: the mode at the other end
};

[[nodiscard]] ModeClass explore_modes(const System& system, AtomTypeId type, const std::vector<Value>& args,
                                      const TypeAccess& access);

/// "EATS" or "DONE (starts = false)".
[[nodiscard]] std::string mode_text(const System& system, const ModeClass& row, std::uint32_t mode);

}  // namespace bip::verify
