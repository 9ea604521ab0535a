// Prints properties of states and of runs as Promela's `ltl`.
#pragma once
#include <functional>
#include <string>

#include "compiler/base/result.hpp"
#include "compiler/exchange/exchange.hpp"
#include "compiler/exchange/promela_runs.hpp"
#include "compiler/verify/property/formula.hpp"

namespace bip::exchange {

/// Promela text of what conditions read.
struct ConditionNames {
  std::function<std::string(AtomId atom, u32 place)> marked;
  std::function<std::string(AtomId atom, u32 variable)> variable;
  std::function<std::string(AtomId atom, u32 port)> can_port;
  std::function<std::string(ConnectorId connector)> can_connector;
};

/// Returns the formula over macros `c0`, `c1`, …, whose definitions are added to `macros`. Failure: what looks back,
/// and data that Promela lacks.
[[nodiscard]] Result<std::string> ltl_text(const verify::Formula& formula, const ConditionNames& names,
                                           const PromelaRuns& runs, std::string& macros);

}  // namespace bip::exchange
