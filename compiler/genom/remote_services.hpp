// Services of other components that codels of GenoM 3 call (`remote` arguments, services of an interface that the
// component `uses`): what the codels see of them, and the C++ behind it, which asks for them as clients do
// (bip/genom3_remotes.hpp). Internal to compiler/genom.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/module.hpp"

namespace bip::genom {

/// Those that its codels name.
[[nodiscard]] std::vector<const idl::Service*> called_remotes(const idl::Component& c);
/// `typedef struct guide_watch { … } guide_watch;`, in C or C++.
[[nodiscard]] std::string remote_struct(const idl::Component& c, const idl::Service& s);
/// The functions behind these structs, and the objects that codels get. `modules`: whose services may be called.
[[nodiscard]] std::string remote_functions(const std::vector<Module>& modules, const idl::Component& c);
/// The codel of `connect_service`.
[[nodiscard]] std::string connect_service_function(const idl::Component& c);
/// Reports codels that call services and do not run beside their task. After resolve().
void check_remotes(const std::vector<Module>& modules, Diagnostics& diags);

}  // namespace bip::genom
