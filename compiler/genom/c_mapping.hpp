// Types, parameters and ports of a GenoM 3 component as genom3's C mapping has them. Names are those of genom3:
// `demo_state` for `demo::state`, `demo_ids`, `demo_ids_body_s` for a struct inside of the IDS, `demo_e_far(&detail,
// self)`, a port is a struct of functions. Internal to compiler/genom; cxx_mapping.hpp is its twin.
#pragma once
#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "compiler/genom/idl.hpp"

namespace bip::genom {

/// Members of a struct, a line each.
[[nodiscard]] std::string c_members(const idl::Component& c, const std::vector<idl::Member>& members,
                                    const std::string& indent);
/// "const demo_state *name"; without a name the type of the parameter.
[[nodiscard]] std::string c_parameter(const idl::Component& c, std::size_t type, idl::Direction direction,
                                      const std::string& name);
/// An argument of such a type is a copy.
[[nodiscard]] bool is_passed_by_value(const idl::Type& t);
/// In C the name of it is a pointer already.
[[nodiscard]] bool decays(const idl::Type& t);
/// demo_c_types.h: types, constants, exceptions.
[[nodiscard]] std::string c_types_header(const idl::Component& c);
/// `typedef struct demo_place { … } demo_place;`
[[nodiscard]] std::string c_port_struct(const idl::Component& c, const idl::Port& p);
/// `genom_members` and `genom_enumerators` (bip/genom3_values.hpp) of its types. `done`: those that are there already.
[[nodiscard]] std::string c_members_functions(const idl::Component& c, std::set<std::string>& done);

}  // namespace bip::genom
