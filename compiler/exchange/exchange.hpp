// Writes the System in the languages of other tools: Promela for SPIN, PNML for Petri net tools.
//
// The purpose is a second opinion: the reachable stable states and deadlocks are those of the System, and a run-time
// error ends a run without being a deadlock. A model that a format cannot express is refused with the reason; nothing
// is omitted silently.
#pragma once
#include <cstdint>
#include <string>

#include "compiler/base/result.hpp"
#include "compiler/system/system_ids.hpp"
#include "compiler/verify/property/fairness.hpp"
#include "compiler/verify/property/formula.hpp"

namespace bip::exchange {

using u32 = std::uint32_t;
/// A connector with more interactions is refused: each is text of its own.
inline constexpr std::size_t kMaxInteractions = 2048;

inline constexpr std::size_t kMaxTransitions = 1'000'000;

struct Options {
  bool maximal_progress = true;
  std::string root_name;                          // for the comment at the top
  std::size_t max_transitions = kMaxTransitions;  // of PNML
  /// Of Promela: what SPIN is asked instead of deadlocks; null: nothing.
  const verify::Formula* formula = nullptr;
  verify::Fairness fairness = {};  // of the runs that it is asked of
};

/// Writes int, bool and string data, guards, transfers, internal transitions and priorities as one Promela process.
/// Failure: what the format cannot express, with its place. Cost: interactions times their size, squared per connector.
[[nodiscard]] Result<std::string> promela(const System& system, const Options& options);
/// Writes a place/transition net (ISO/IEC 15909-2) of a model whose guards are decided by parameters. Failure: what a
/// net cannot express, or more transitions than `max_transitions`.
[[nodiscard]] Result<std::string> pnml(const System& system, const Options& options);

}  // namespace bip::exchange
