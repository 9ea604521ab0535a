// The System in the languages of other tools: Promela for SPIN, PNML for Petri net tools.
//
// What they are for is a second opinion: reachable stable states and deadlocks are the System's own, run-time errors
// end a run without being deadlocks. A model that a format has no form for is refused with the reason; nothing is left
// out silently.
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
