// Writes the System in the languages of other tools: Promela for SPIN, PNML for Petri net tools.
//
// The purpose is a second opinion: the reachable stable states and deadlocks are those of the System, and a run-time
// error ends a run without being a deadlock. A model that a format cannot express is refused with the reason; nothing
// is omitted silently.
#pragma once
#include <string>

#include "compiler/base/result.hpp"
#include "compiler/system/system.hpp"

namespace bip::exchange {

struct Options {
  bool maximal_progress = true;
  std::string root_name;  // for the comment at the top
};

/// int, bool and string data, guards, transfers, internal transitions, priorities. Failure: what there is no form for.
[[nodiscard]] Result<std::string> promela(const System& system, const Options& options);
/// A place/transition net of a model whose guards are decided by parameters. Failure: what there is no form for.
[[nodiscard]] Result<std::string> pnml(const System& system, const Options& options);

}  // namespace bip::exchange
