// See port_services.hpp. It is a function like others of the description, with a codel that `bipc genom --codels`
// writes.
#include "compiler/genom/port_services.hpp"

#include <algorithm>

namespace bip::genom {

std::string connect_function(const idl::Component& c) { return c.name + "_" + kConnectPort; }

bool has_port_services(const idl::Component& c) {
  return std::any_of(c.services.begin(), c.services.end(), [&](const idl::Service& s) {
    return s.name == kConnectPort && s.codels.size() == 1 && s.codels[0].name == connect_function(c);
  });
}

void add_port_services(Module& m) {
  idl::Component& c = *m.component;
  if (std::none_of(c.ports.begin(), c.ports.end(), [](const idl::Port& p) { return !p.is_out; }) ||
      std::any_of(m.services.begin(), m.services.end(), [](const Service& s) { return s.name.text == kConnectPort; }))
    return;
  const auto is_text = [](const idl::Type& t) { return t.kind == idl::Kind::String && t.bound == 0; };
  auto text = std::find_if(c.types.begin(), c.types.end(), is_text);
  if (text == c.types.end()) text = c.types.insert(text, {.kind = idl::Kind::String, .c_name = "string"});
  const auto type = static_cast<std::size_t>(text - c.types.begin());
  idl::Service row{.name = kConnectPort, .parameters = {}, .locals = {}, .codels = {}};
  idl::Codel codel{connect_function(c), {}};
  for (const char* const name : {"local", "remote"}) {
    row.parameters.push_back({.name = name, .type = type, .initial = {}, .path = {}});
    codel.arguments.push_back({.path = {name}, .range = m.name.range});
  }
  row.codels.push_back(codel);
  c.services.push_back(std::move(row));
  Service service;
  service.name = {kConnectPort, m.name.range};
  service.doc = "Connects an in port to an out port.";
  service.body.push_back({.name = {codel.name, m.name.range}, .uses = {}});
  for (const char* const report : {"no_such_inport", "no_such_outport"})
    service.reports.push_back({report, m.name.range});
  m.services.push_back(std::move(service));
}

}  // namespace bip::genom
