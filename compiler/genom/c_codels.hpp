// The C side of GenoM 3 components, for codels as people wrote them for genom3: headers with the names that genom3's
// mappings give, and the C++ between those codels and BIP (runtime/include/bip/genom3_codels.hpp).
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/genom/generate_package.hpp"

namespace bip::genom {

/// The type of a service's parameter; of an attribute, that of the IDS. Nothing: there is no such member.
[[nodiscard]] std::optional<std::size_t> type_of_parameter(const idl::Component& component, const idl::Service& service,
                                                           const idl::Parameter& parameter);
/// Are all modules components whose types and data are known?
[[nodiscard]] bool check_c_codels(const std::vector<Module>& modules, Diagnostics& diags);
/// Name and text of each file beside the package: `acdemo.h`, `demo_c_types.h`, …, `PACKAGE_codels.hpp` and `.cpp`.
/// Modules are of GenoM 3 and have passed check_c_codels.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> c_codel_files(const std::vector<Module>& modules,
                                                                             const GenerateOptions& options);

}  // namespace bip::genom
