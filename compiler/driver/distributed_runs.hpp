// Distributed runs before they begin: placements are read, what cannot be distributed is refused, what it would cost is
// reported. See compiler/docs/distributed.md.
#pragma once
#include <string>

#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/core/link/priorities.hpp"
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

/// The same as one line of JSON (placement_report.hpp), also if something was refused or `file` has errors.
[[nodiscard]] std::string distribution_json(Compilation& c, const std::string& file, const std::string& placement_path);

/// What is linked without code.
struct LinkedModel {
  explicit LinkedModel(const rt::Image& image, rt::MaximalProgress progress = rt::MaximalProgress::On)
      : tables(rt::link(image, progress)), rules(rt::link_priorities(tables)) {}
  rt::Tables tables;
  rt::PriorityTables rules;
};

/// False: several nodes do not run such models with time, which was reported.
[[nodiscard]] bool is_distributable(Compilation& c);
/// False: a C++ object would have to be sent to another node, which was reported.
[[nodiscard]] bool crosses_nothing(Compilation& c, const LinkedModel& linked, const rt::Distribution& distribution);

/// " (FILE:LINE:COLUMN)"; empty if the place is unknown.
[[nodiscard]] std::string image_place_text(const rt::Image& image, const rt::SourceLine& loc);

}  // namespace bip::driver
