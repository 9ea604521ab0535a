// Connectors: which ports are triggers, and data transfer. `up` of a connector without exported port, which BIP2 does
// not have, is the beginning of its `down`.
#include <algorithm>
#include <set>

#include "runtime/include/bip/assert.hpp"
#include "compiler/migrate/bip2_writer.hpp"

namespace bip::migrate {

using namespace syntax::bip1;

namespace {

void make_triggers(PortTerm& term, const std::set<std::string>& triggers) {
  if (term.children.empty()) term.is_trigger |= triggers.contains(joined(term.port));
}

// A group that only wraps the whole: `define [p q]`.
std::vector<PortTerm> without_brackets(std::vector<PortTerm> terms) {
  while (terms.size() == 1 && !terms[0].children.empty() && !terms[0].is_trigger) {
    std::vector<PortTerm> inner = std::move(terms[0].children);
    terms = std::move(inner);
  }
  return terms;
}

}  // namespace

void Bip2Writer::add_port_variables(const std::string& prefix, std::string_view type, Variables& to) {
  const auto found = decls_.find(type);
  if (found == decls_.end() || found->second->kind != DeclKind::PortType) return;
  for (const Param& param : found->second->params) {
    to[prefix + "." + std::string(param.name.text)] = {cpp_.type(param.type.text)};
  }
}

void Bip2Writer::connector_type(const Decl& d) {
  if (d.params.empty()) return no_counterpart(d.range, "a connector without ports", "it has no interaction");
  Variables variables;
  std::string params;
  std::vector<Path> ports;
  for (const Param& param : d.params) {
    params += (params.empty() ? "" : ", ") + port_type_of(param) + " " + names_.name(param.name.text);
    ports.push_back({param.name});
    add_port_variables(std::string(param.name.text), param.type.text, variables);
  }
  open("connector type " + names_.name(d.name.text) + "(" + params + ")",
       {d.range.file, d.range.begin, d.name.range.end});
  connector_body(d.connector, ports, variables, std::string(d.name.text));
  close(d.range);
}

void Bip2Writer::connector_body(const ConnectorBody& body, const std::vector<Path>& ports, Variables& variables,
                                const std::string& owner) {
  for (const Data& data_decl : body.data) (void)data(data_decl, variables, nullptr);
  const std::string defined = define(body, ports);
  if (!defined.empty()) line("define " + defined, body.define_range);
  for (const Clause& clause_decl : body.clauses) clause(clause_decl, variables, !body.exports.empty(), owner);
  for (const Port& port_decl : body.exports) {
    if (&port_decl != &body.exports.front()) {
      no_counterpart(port_decl.range, "a second exported port", "a connector exports one");
      continue;
    }
    // The name behind `is` is the port's only name outside.
    Port exported = port_decl;
    exported.is_exported = true;
    if (!exported.exported_as.text.empty() && exported.items.size() == 1) exported.items[0].name = exported.exported_as;
    exported.exported_as = {};
    port(exported, variables);
  }
}

std::string Bip2Writer::define(const ConnectorBody& body, const std::vector<Path>& ports) {
  std::vector<PortTerm> terms = body.define;
  if (terms.empty()) {
    for (const Path& port : ports) {
      PortTerm term;
      term.port = port;
      terms.push_back(term);
    }
  }
  terms = without_brackets(std::move(terms));
  std::set<std::string> triggers;
  for (const Completeness& completeness : body.completeness) {
    for (const std::vector<Path>& interaction : completeness.interactions) {
      if (!completeness.is_complete) continue;
      if (interaction.size() == 1) {
        triggers.insert(joined(interaction[0]));
        continue;
      }
      // `complete p|q`: a group that is a trigger, if the ports stand in no other one.
      PortTerm group{.is_trigger = true};
      std::vector<PortTerm> rest;
      for (PortTerm& term : terms) {
        const bool is_in = std::any_of(interaction.begin(), interaction.end(), [&](const Path& p) {
          return term.children.empty() && !term.is_trigger && joined(p) == joined(term.port);
        });
        (is_in ? group.children : rest).push_back(std::move(term));
      }
      if (group.children.size() != interaction.size()) {
        no_counterpart(completeness.range, "this set of complete interactions",
                       "a port stands in one group of `define`");
        for (PortTerm& term : group.children) rest.push_back(std::move(term));
      } else {
        rest.insert(rest.begin(), std::move(group));
      }
      terms = std::move(rest);
    }
  }
  BIP_ASSERT(!terms.empty(), "a connector of {} ports binds none", ports.size());
  std::string out;
  for (PortTerm& port_term : terms) {
    make_triggers(port_term, triggers);
    out += (out.empty() ? "" : " ") + term(port_term);
  }
  return out;
}

std::string Bip2Writer::term(const PortTerm& term) const {
  std::string out;
  if (term.children.empty()) {
    out = names_.path(term.port);
  } else {
    for (const PortTerm& child : term.children) out += (out.empty() ? "(" : " ") + this->term(child);
    out += ")";
  }
  return out + (term.is_trigger ? "'" : "");
}

void Bip2Writer::clause(const Clause& c, const Variables& variables, bool has_export, const std::string& owner) {
  std::string text = "on";
  for (const Path& port : c.ports) text += " " + names_.path(port);
  const std::string guard = guards(c.guards, variables, owner);
  if (!guard.empty()) text += " provided (" + guard + ")";
  // `up` computes values of the connector: ports are read.
  Variables in_up = variables;
  for (auto& [name, variable] : in_up) variable.is_writable = !has_export || name.find('.') == std::string::npos;
  const std::string up = action(c.up, in_up, owner), down = action(c.down, variables, owner);
  if (has_export && !up.empty()) text += " up { " + up + "}";
  const std::string transfer = has_export ? down : up + down;
  if (!transfer.empty()) text += " down { " + transfer + "}";
  line(std::move(text), c.range);
}

}  // namespace bip::migrate
