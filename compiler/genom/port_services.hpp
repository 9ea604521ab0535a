// The service `connect_port` that genom3 gives each component: requests choose which out port an in port reads.
// For components whose codels are called in C or C++ (c_codels.hpp), if they have in ports.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/module.hpp"

namespace bip::genom {

inline constexpr const char* kConnectPort = "connect_port";

/// Adds it to the module and its component, unless that has a service of the name or no in port.
void add_port_services(Module& module);
/// Has add_port_services() added it?
[[nodiscard]] bool has_port_services(const idl::Component& component);
/// The name of its function: "demo_connect_port".
[[nodiscard]] std::string connect_function(const idl::Component& component);

}  // namespace bip::genom
