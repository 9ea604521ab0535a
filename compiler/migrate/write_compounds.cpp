// Compounds: components, connectors, priorities, exports; and the root.
#include <algorithm>
#include <set>

#include "compiler/migrate/bip2_writer.hpp"

namespace bip::migrate {

using namespace syntax::bip1;

void Bip2Writer::compound_type(const Decl& d) {
  if (d.instances.empty()) return no_counterpart(d.range, "a compound without components", "it does nothing");
  Variables variables;
  const std::string head = params(d.params, variables);
  open("compound type " + names_.name(d.name.text) + "(" + head + ")", {d.range.file, d.range.begin, d.name.range.end});
  Elements elements;
  for (const Instances& list : d.instances) {
    for (const Instance& instance : list.items) elements.emplace(instance.name.text, list.type.text);
    instances(list, variables);
  }
  for (const Connector& connector_decl : d.connectors) connector(connector_decl, elements);
  for (const Priority& priority_decl : d.priorities) priority(priority_decl, d);
  for (const Export& export_decl : d.exports) compound_export(export_decl);
  close(d.range);
}

void Bip2Writer::instances(const Instances& list, const Variables& variables) {
  const auto type = decls_.find(list.type.text);
  std::string items;
  for (const Instance& instance : list.items) {
    std::string args;
    for (std::size_t i = 0; i < instance.args.size(); ++i) {
      VariableType wanted;
      if (type != decls_.end() && i < type->second->params.size())
        wanted = cpp_.type(type->second->params[i].type.text);
      const std::string arg = constant(instance.args[i], wanted, variables);
      args += (i == 0 ? "" : ", ") + (arg.empty() ? "0" : arg);
    }
    items += (items.empty() ? "" : ", ") + names_.name(instance.name.text) + "(" + args + ")";
  }
  line("component " + names_.name(list.type.text) + " " + items, list.range);
}

void Bip2Writer::add_bound_variables(const Path& port, const Elements& elements, Variables& to) {
  if (port.size() != 2) return;
  const auto element = elements.find(port[0].text);
  const auto type = element == elements.end() ? decls_.end() : decls_.find(element->second);
  if (type == decls_.end()) return;
  for (const Port& port_decl : type->second->ports) {
    for (const PortItem& item : port_decl.items) {
      const syntax::Name& outer = port_decl.exported_as.text.empty() ? item.name : port_decl.exported_as;
      if (outer.text != port[1].text) continue;
      if (!port_decl.type.text.empty()) return add_port_variables(joined(port), port_decl.type.text, to);
      for (const syntax::Name& name : item.vars) {
        for (const Data& data : type->second->data) {
          for (const Var& var : data.vars) {
            if (var.name.text == name.text)
              to[joined(port) + "." + std::string(name.text)] = {cpp_.type(var.type.text)};
          }
        }
      }
    }
  }
}

void Bip2Writer::connector(const Connector& c, const Elements& elements) {
  std::string ports;
  for (const Path& port : c.ports) ports += (ports.empty() ? "" : ", ") + names_.path(port);
  const std::string bound = names_.name(c.name.text) + "(" + ports + ")";
  if (!c.type.text.empty()) return line("connector " + names_.name(c.type.text) + " " + bound, c.range);
  Variables variables;
  for (const Path& port : c.ports) add_bound_variables(port, elements, variables);
  line("connector " + bound, {c.range.file, c.range.begin, c.name.range.end});
  ++indent_;
  connector_body(c.body, c.ports, variables, std::string(c.name.text));
  --indent_;
}

void Bip2Writer::priority(const Priority& p, const Decl& owner) {
  const bool is_atom = owner.kind == DeclKind::AtomType;
  const std::string low = side(p.low, owner, p.range);
  const std::string high = low.empty() ? "" : side(p.high, owner, p.range);
  if (high.empty()) return;
  std::string guard;
  Variables variables;
  if (is_atom) {
    for (const Data& data : owner.data) {
      for (const Var& var : data.vars) variables[std::string(var.name.text)] = {cpp_.type(var.type.text)};
    }
  }
  for (const Param& param : owner.params) variables[std::string(param.name.text)] = {cpp_.type(param.type.text)};
  for (const Instances& list : owner.instances) {
    const auto type = decls_.find(list.type.text);
    if (type == decls_.end()) continue;
    for (const Instance& instance : list.items) {
      for (const Data& data : type->second->data) {
        for (const Var& var : data.vars)
          variables[std::string(instance.name.text) + "." + std::string(var.name.text)] = {cpp_.type(var.type.text)};
      }
    }
  }
  for (const Condition& condition : p.conditions) {
    const std::string text = value(condition.guard, known(ValueKind::Bool), variables, std::string(owner.name.text));
    if (!text.empty()) guard += (guard.empty() ? "" : " && ") + ("(" + text + ")");
  }
  const std::string name = p.name.text.empty() ? names_.fresh("priority_1") : names_.name(p.name.text);
  line("priority " + name + " " + low + " < " + high + (guard.empty() ? "" : " provided (" + guard + ")"), p.range);
}

std::string Bip2Writer::side(const PrioritySide& s, const Decl& owner, SourceRange at) {
  if (owner.kind == DeclKind::AtomType) return s.is_any ? "*" : names_.path(s.connector);
  if (s.is_any) return "*:*";
  const std::string connector = joined(s.connector);
  const auto found = std::find_if(owner.connectors.begin(), owner.connectors.end(),
                                  [&](const Connector& c) { return c.name.text == connector; });
  if (found == owner.connectors.end()) {
    no_counterpart(at, "`" + connector + "` in a priority",
                   "BIP2 orders interactions of connectors, and this names none");
    return {};
  }
  std::string out = names_.path(s.connector) + ":";
  if (s.interaction.empty()) return out + "*";
  const auto type = decls_.find(found->type.text);
  for (const Path& port : s.interaction) {
    // The connector's own name of a port stands for what it binds.
    const Path* bound = &port;
    if (port.size() == 1 && type != decls_.end()) {
      const std::vector<Param>& params = type->second->params;
      for (std::size_t i = 0; i < params.size() && i < found->ports.size(); ++i) {
        if (params[i].name.text == port[0].text) bound = &found->ports[i];
      }
    }
    out += (&port == &s.interaction.front() ? "" : ",") + names_.path(*bound);
  }
  return out;
}

void Bip2Writer::compound_export(const Export& e) {
  if (e.name.text.empty()) return no_counterpart(e.range, "this `export`", "it gives no name to a port of a component");
  const std::string what = e.is_data ? "data" : "port";
  line("export " + what + " " + names_.path(e.target) + " as " + names_.name(e.name.text), e.range);
}

// `component Root r` of a model: BIP2 runs the one compound that nothing contains, or what `--root` names.
void Bip2Writer::roots() {
  std::set<std::string_view> contained;
  for (const Decl& d : model_.decls) {
    for (const Instances& list : d.instances) contained.insert(list.type.text);
  }
  std::size_t candidates = 0, instances_of_model = 0;
  for (const Decl& d : model_.decls) {
    candidates += d.kind == DeclKind::CompoundType && d.params.empty() && !contained.contains(d.name.text) ? 1 : 0;
  }
  bool is_plain = true;
  for (const Instances& list : model_.roots) {
    const auto type = decls_.find(list.type.text);
    is_plain &= type != decls_.end() && type->second->kind == DeclKind::CompoundType;
    for (const Instance& instance : list.items) is_plain &= instance.args.empty();
    instances_of_model += list.items.size();
  }
  if (instances_of_model == 0) return;
  if (is_plain && instances_of_model == 1) {
    const Instances& root = model_.roots.front();
    const std::string text =
        candidates == 1 ? " is the root" : " is the root: bipc run --root " + names_.name(root.type.text);
    return line("// `" + in_one_line(root.range) + "`: `" + names_.name(root.type.text) + "`" + text, root.range);
  }
  line("compound type " + names_.fresh("Root") + "()", {});
  ++indent_;
  for (const Instances& list : model_.roots) instances(list, {});
  --indent_;
  line("end", {});
}

}  // namespace bip::migrate
