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

#include "compiler/system/system_ids.hpp"
#include "compiler/verify/net/abstract_code.hpp"
#include "compiler/analysis/data_access.hpp"
#include "compiler/verify/net/port_uses.hpp"

namespace bip::verify {

inline constexpr std::size_t kMaxModesWithData = 512;
inline constexpr std::size_t kMaxMarkings = 4096;
// Where uses of ports are distinguished: modes, and tries of a move.
inline constexpr std::size_t kMaxModesWithUses = 20000, kMaxTries = 20'000'000;

struct Mode {
  std::vector<std::uint32_t> places;  // sorted
  std::vector<AbstractValue> values;  // one a variable; parameters too
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
  bool is_too_large = false;           // then nothing below holds
  const AtomUses* uses = nullptr;      // told apart: ports of their own after the type's
  std::vector<std::uint8_t> followed;  // by variable
  std::vector<Mode> modes;
  std::vector<std::uint32_t> initial;              // one of these, sorted
  std::vector<std::vector<Move>> moves;            // by port, then by use; sorted, each once
  std::vector<std::vector<std::uint8_t>> is_sure;  // by port of the type, by mode: enabled in every state of the mode
  std::vector<std::vector<PortMove>> out, in;      // by mode; other: the mode at the other end

  /// The type's port of a row of `moves`.
  [[nodiscard]] std::uint32_t port_of(std::uint32_t row) const {
    return row < is_sure.size() ? row : uses->uses[row - is_sure.size()].port;
  }
};

[[nodiscard]] ModeClass explore_modes(const System& system, AtomTypeId type, const std::vector<Value>& args,
                                      const analysis::DataAccess& access);

/// What an atom's uses of ports are for: to be told apart, with the values that they write; or to be seen as one again,
/// without those values (what a certificate can speak of as modes).
enum class UsesAs : std::uint8_t { Ports, Hidden };
/// `plain`: the class without; the uses speak of the data that it follows, and must stay where they are. Too large: not
/// within the limits.
[[nodiscard]] ModeClass explore_modes(const System& system, const ModeClass& plain, const analysis::DataAccess& access,
                                      const AtomUses& uses, UsesAs as);

/// By variable: what it always is, if it never changes.
[[nodiscard]] std::vector<AbstractValue> constants_of(const ModeClass& row);
/// "EATS" or "DONE (starts = false)".
[[nodiscard]] std::string mode_text(const System& system, const ModeClass& row, std::uint32_t mode);

}  // namespace bip::verify
