// Types, headers and signatures of GenoM 3 components in C++, for codels that include `acNAME.hpp`;
// compiler/docs/genom.md lists what becomes what. c_codels.cpp has the C side, and the C++ between BIP and codels of
// both.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "compiler/genom/idl.hpp"

namespace bip::genom {

/// "::demo::state", "std::vector<double>".
[[nodiscard]] std::string cxx_type(const idl::Component& component, std::size_t type);
/// Members of a struct, one per line, each with an initial value.
[[nodiscard]] std::string cxx_members(const idl::Component& component, const std::vector<idl::Member>& members,
                                      const std::string& indent);
/// "const ::demo::state &": the type of a codel's parameter, without its name.
[[nodiscard]] std::string cxx_parameter_type(const idl::Component& component, std::size_t type,
                                             idl::Direction direction);
/// `NAME_cxx_types.hpp`: types, constants, exceptions.
[[nodiscard]] std::string cxx_types_header(const idl::Component& component);
/// `acNAME.hpp`: IDS, ports, then `events` and `prototypes`, which have C linkage.
[[nodiscard]] std::string cxx_component_header(const idl::Component& component, const std::string& events,
                                               const std::string& prototypes);
/// How values are copied and written (bip/genom3_values.hpp). `done`: names of types that have been written.
[[nodiscard]] std::string cxx_members_functions(const idl::Component& component, std::set<std::string>& done);

}  // namespace bip::genom
