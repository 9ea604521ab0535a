// The folders of `bipc deploy`, one a node: what is in them, written and read.
//
//   model.bsys      the model
//   ffi/            its C++, if it has some
//   model.place     the placement
//   model.moves     what the prover knows about conflicts
//   node            which node this is, and the keys of all by which they know each other
//   key             its secret key, which only its owner can read; `launcher.key` beside it on the first node
//   start, bipc-NAME.service, README
#pragma once
#include <string>

#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "runtime/distributed/deployment.hpp"
#include "runtime/distributed/distribution.hpp"

namespace bip::driver {

inline constexpr const char* kModelFile = "model.bsys";
inline constexpr const char* kPlacementFile = "model.place";
inline constexpr const char* kMovesFile = "model.moves";
inline constexpr const char* kCppFolder = "ffi";

/// Can such a placement be deployed? False: a diagnostic was reported.
[[nodiscard]] bool is_deployable(Compilation& c, const rt::Placement& placement);

/// Writes the folders. A failure says why; false: a diagnostic was reported, that a file cannot be written (B5004) or
/// is an input of this command (B5013).
[[nodiscard]] Result<bool> write_deployment(Compilation& c, const rt::Placement& placement,
                                            const DeployArguments& arguments, const rt::FabricFactory& fabrics);

/// Reads the nodes' keys and addresses from a node's folder. `placement`: as read from its file. A failure says what is
/// wrong.
[[nodiscard]] Result<rt::Deployment> read_deployment(const std::string& folder, const rt::Placement& placement);

}  // namespace bip::driver
