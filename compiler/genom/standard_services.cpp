// See standard_services.hpp. They are services like others of the description: those that connect are functions
// with a codel that `bipc genom --codels` writes, `kill` one without a codel that all others are `before`.
#include "compiler/genom/standard_services.hpp"

#include <algorithm>

#include "compiler/genom/remote_services.hpp"

namespace bip::genom {
namespace {

bool has_service(const Module& m, const char* name) {
  return std::any_of(m.services.begin(), m.services.end(), [&](const Service& s) { return s.name.text == name; });
}

void add_connection(Module& m, const char* name, const char* doc, const std::vector<const char*>& reports) {
  idl::Component& c = *m.component;
  const auto is_text = [](const idl::Type& t) { return t.kind == idl::Kind::String && t.bound == 0; };
  auto text = std::find_if(c.types.begin(), c.types.end(), is_text);
  if (text == c.types.end()) text = c.types.insert(text, {.kind = idl::Kind::String, .c_name = "string"});
  const auto type = static_cast<std::size_t>(text - c.types.begin());
  idl::Service row{.name = name, .parameters = {}, .locals = {}, .codels = {}};
  idl::Codel codel{connect_function(c, name), {}};
  for (const char* const end : {"local", "remote"}) {
    row.parameters.push_back({.name = end, .type = type, .initial = {}, .path = {}});
    codel.arguments.push_back({.path = {end}, .range = m.name.range});
  }
  row.codels.push_back(codel);
  c.services.push_back(std::move(row));
  Service service;
  service.name = {name, m.name.range};
  service.doc = doc;
  service.body.push_back({.name = {codel.name, m.name.range}, .uses = {}});
  for (const char* const report : reports) service.reports.push_back({report, m.name.range});
  m.services.push_back(std::move(service));
}

void add_kill(Module& m) {
  m.component->services.push_back({.name = kKill, .parameters = {}, .locals = {}, .codels = {}});
  Service service;
  service.name = {kKill, m.name.range};
  service.doc = "Ends the component.";
  service.interrupts_all = true;
  service.overtakes = true;
  m.services.push_back(std::move(service));
  for (Service& s : m.services) s.before.push_back({kKill, m.name.range});
  m.is_killed = true;
}

}  // namespace

std::string connect_function(const idl::Component& c, const char* service) { return c.name + "_" + service; }

bool is_connection(const idl::Component& c, const std::string& service) {
  if (service != kConnectPort && service != kConnectService) return false;
  return std::any_of(c.services.begin(), c.services.end(), [&](const idl::Service& s) {
    return s.name == service && s.codels.size() == 1 && s.codels[0].name == connect_function(c, service.c_str());
  });
}
bool connects_ports(const idl::Component& c) { return is_connection(c, kConnectPort); }
bool connects_services(const idl::Component& c) { return is_connection(c, kConnectService); }

void add_standard_services(Module& m) {
  const std::vector<idl::Port>& ports = m.component->ports;
  const bool reads = std::any_of(ports.begin(), ports.end(), [](const idl::Port& p) { return !p.is_out; });
  if (reads && !has_service(m, kConnectPort))
    add_connection(m, kConnectPort, "Connects an in port to an out port.", {"no_such_inport", "no_such_outport"});
  if (!called_remotes(*m.component).empty() && !has_service(m, kConnectService))
    add_connection(m, kConnectService, "Connects a remote to a service of another component.", {"no_such_service"});
  if (!has_service(m, kKill)) add_kill(m);
}

}  // namespace bip::genom
