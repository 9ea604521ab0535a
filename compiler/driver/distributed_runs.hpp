// Distributed runs before they begin: placements are read, what cannot be distributed is refused, what it would cost is
// reported. See compiler/docs/distributed.md.
#pragma once
#include <string>

#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "runtime/distributed/distribution.hpp"

namespace bip::driver {

/// Reads a file of `node NAME [host ADDRESS]` and `PATTERN on NODE` lines; the first line that names an atom counts.
/// What `PATTERN anywhere` names is placed where it interacts most, by the counts of a `counts FILE` line if there is
/// one. False: a diagnostic was reported.
[[nodiscard]] bool read_placement(Compilation& c, const std::string& path, rt::Placement& placement);

/// The same with a line for each component.
[[nodiscard]] std::string print_placement(const rt::Image& image, const rt::Placement& placement);

/// Of a run on several nodes: reads its placement, if there is a file, and checks what it was asked for; of other runs
/// nothing. The image needs no code yet. False: a diagnostic was reported.
[[nodiscard]] bool prepare_distributed(Compilation& c, const RunArguments& arguments, rt::Placement& placement);

/// What `bipc deploy` and `bipc node` need of a placement: as prepare_distributed, with the file. `moves_path`: where
/// `bipc deploy` wrote what the prover knows about conflicts; empty: it is asked.
[[nodiscard]] bool prepare_deployed(Compilation& c, const std::string& placement_path, const std::string& moves_path,
                                    rt::Placement& placement);

/// Returns what a run with the placement would be: nodes, interactions over several of them, conflict sets, messages.
/// Empty: a diagnostic was reported.
[[nodiscard]] std::string distribution_text(Compilation& c, const std::string& placement_path);

}  // namespace bip::driver
