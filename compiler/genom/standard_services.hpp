// Services that genom3 gives each component: `connect_port` chooses which out port an in port reads, `connect_service`
// which service a remote is, `kill` ends the component. For components whose codels are called in C or C++
// (c_codels.hpp). `abort_activity` needs the numbers of requests, so it is in compiler/serve.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/module.hpp"

namespace bip::genom {

inline constexpr const char* kConnectPort = "connect_port";
inline constexpr const char* kConnectService = "connect_service";
inline constexpr const char* kKill = "kill";

/// Adds them to the module and its component, unless that has a service of the name; `connect_port` only if it has in
/// ports, `connect_service` only if its codels call others. `kill` interrupts all activities and stops the tasks; after
/// it every service is refused (`disallowed`).
void add_standard_services(Module& module);
/// Has add_standard_services() added `connect_port`, or `connect_service`?
[[nodiscard]] bool connects_ports(const idl::Component& component);
[[nodiscard]] bool connects_services(const idl::Component& component);
/// Is the service one of these two?
[[nodiscard]] bool is_connection(const idl::Component& component, const std::string& service);
/// The name of its function: "demo_connect_port".
[[nodiscard]] std::string connect_function(const idl::Component& component, const char* service);

}  // namespace bip::genom
