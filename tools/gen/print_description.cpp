// The description as a .bip file in BIP2's spelling; types marked `paper` go to print_paper.cpp.
#include "tools/gen/print_description_code.hpp"

namespace bip::gen {
namespace {

std::string code(const Expr& expr) { return text_of(expr, plain_name, Spelling::Bip2); }
std::string code(const Body& body) { return text_of(body, plain_name, Spelling::Bip2); }

std::string typed(const Var& var) {
  return (var.type < Ty::Pair ? "" : "$") + std::string(name_of(var.type)) + " " + var.name;
}
std::string typed(const std::vector<Var>& vars) {
  std::vector<std::string> items;
  for (const Var& var : vars) items.push_back(typed(var));
  return join(items, ", ");
}
std::string data_line(const Var& var) {
  std::string text = std::string("    ") + (var.exported ? "export " : "") + "data " + typed(var);
  if (var.init) text += " = " + code(*var.init);
  return text + "\n";
}

std::string text_of(const std::vector<ClockBound>& when) {
  std::vector<std::string> parts;
  for (const ClockBound& b : when) {
    const std::string left = b.clock + (b.minus.empty() ? "" : " - " + b.minus);
    parts.push_back(left + " " + b.op + " " + (b.limit_name.empty() ? std::to_string(b.limit) : b.limit_name));
  }
  return join(parts, " && ");
}
std::string condition(const std::optional<Expr>& guard, const std::vector<ClockBound>& when) {
  if (!guard && when.empty()) return "";
  std::string text = guard ? code(*guard) : "";
  if (guard && !when.empty()) text = "(" + text + ") && ";
  return " provided (" + text + text_of(when) + ")";
}
// What the action does, then what it sets clocks to.
std::string action(const Transition& t) {
  if (t.action.empty() && t.sets.empty()) return "";
  std::string text = t.action.empty() ? "{ " : code(t.action);
  if (t.sets.empty()) return " do " + text;
  if (!t.action.empty()) text.resize(text.rfind('}'));
  for (const ClockSet& s : t.sets)
    text += s.clock + (s.is_speed ? "' = " : " = ") + std::to_string(s.value) + (s.is_speed ? ".0; " : "; ");
  return " do " + text + "}";
}
// What is written after `do`, and before the transition.
std::string resume(const Transition& t) {
  if (!t.resumes) return "";
  return t.resume.empty() ? " resume" : " resume (" + text_of(t.resume) + ")";
}
std::string async(const Transition& t) {
  if (!t.is_async) return "";
  return t.budget == 0 ? "    @async\n" : "    @async(budget=\"" + std::to_string(t.budget) + "ms\")\n";
}

std::string print(const AtomType& atom) {
  std::string text = "  atom type " + atom.name + "(" + typed(atom.params) + ")\n";
  for (const Var& var : atom.data) text += data_line(var);
  for (std::size_t k = 0; k < atom.ports.size(); ++k) {
    const Port& port = atom.ports[k];
    text += std::string("    ") +
            (port.exported        ? "export "
             : port.event.empty() ? ""
                                  : "extern ") +
            "port $" + port.type + " " + port.name + "(" + join(port.vars, ", ") + ")";
    // Merged ports are neighbours.
    for (; !port.merged.empty() && k + 1 < atom.ports.size() && atom.ports[k + 1].merged == port.merged; ++k) {
      text += ", " + atom.ports[k + 1].name + "(" + join(atom.ports[k + 1].vars, ", ") + ")";
    }
    text += port.event.empty() ? "" : " " + port.event;
    text += port.merged.empty() ? "\n" : " as " + port.merged + "\n";
  }
  for (const Clock& clock : atom.clocks) text += "    clock " + clock.name + " unit " + clock.unit + "\n";
  text += "    place " + join(atom.places, ", ") + "\n    initial to " + join(atom.initial, ", ");
  if (!atom.initial_action.empty()) text += " do " + code(atom.initial_action);
  text += "\n";
  if (!atom.finals.empty()) text += "    final " + join(atom.finals, ", ") + "\n";
  for (const Transition& t : atom.transitions) {
    text += async(t);
    text += t.port.empty() ? "    internal" : "    on " + t.port;
    text += " from " + join(t.from, ", ") + " to " + join(t.to, ", ");
    text += condition(t.guard, t.when) + (t.urgency.empty() ? "" : " " + t.urgency) + action(t) + resume(t) + "\n";
  }
  for (const AtomRule& rule : atom.rules) {
    text += "    priority " + rule.name + " " + rule.low + " < " + rule.high;
    if (rule.guard) text += " provided (" + code(*rule.guard) + ")";
    text += "\n";
  }
  for (const Invariant& i : atom.invariants) {
    text += "    invariant " + i.name + (i.scope.empty() ? "" : " " + i.scope + " " + join(i.places, ", "));
    text += i.when.empty() ? " provided (" + code(i.condition) + ")\n" : condition({}, i.when) + "\n";
  }
  return text + "  end\n";
}

std::string define_text(const ConnectorType& type, const Define& define) {
  std::string text;
  if (define.param >= 0) {
    text = type.params[static_cast<std::size_t>(define.param)].name;
  } else {
    std::vector<std::string> parts;
    for (const Define& child : define.children) parts.push_back(define_text(type, child));
    text = "(" + join(parts, " ") + ")";
  }
  return text + (define.trigger ? "'" : "");
}

std::string print(const ConnectorType& type) {
  std::vector<std::string> params, parts;
  for (const ConnectorParam& p : type.params) params.push_back("$" + p.type + " " + p.name);
  std::string text = "  connector type " + type.name + "(" + join(params, ", ") + ")\n";
  for (const Var& var : type.data) text += data_line(var);
  if (type.exports) {
    text +=
        "    export port $" + type.export_type + " " + type.export_name + "(" + join(type.export_vars, ", ") + ")\n";
  }
  for (const Define& child : type.define.children) parts.push_back(define_text(type, child));
  text += "    define " + join(parts, " ") + "\n";
  for (const Clause& clause : type.clauses) {
    text += "    on";
    for (int p : clause.params) text += " " + type.params[static_cast<std::size_t>(p)].name;
    if (clause.guard) text += " provided (" + code(*clause.guard) + ")";
    if (!clause.up.empty()) text += " up " + code(clause.up);
    if (!clause.down.empty()) text += " down " + code(clause.down);
    text += "\n";
  }
  return text + "  end\n";
}

std::string pattern_text(const CompoundType& compound, const Pattern& pattern) {
  if (pattern.any_connector) return "*:*";
  if (pattern.any_interaction) return pattern.connector + ":*";
  const Connector& connector = *find_named(compound.connectors, pattern.connector);
  std::vector<std::string> ports;
  for (int p : pattern.params) ports.push_back(text_of(connector.ports[static_cast<std::size_t>(p)]));
  return pattern.connector + ":" + join(ports, ", ");
}

std::string print(const CompoundType& compound) {
  std::string text = "  compound type " + compound.name + "(" + typed(compound.params) + ")\n";
  for (const Component& component : compound.components) {
    std::vector<std::string> args;
    for (const Expr& arg : component.args) args.push_back(code(arg));
    text += "    component $" + component.type + " " + component.name;
    if (!component.size.empty()) text += "[" + component.size + "]";
    text += "(" + join(args, ", ") + ")\n";
  }
  for (const Connector& connector : compound.connectors) {
    std::vector<std::string> ports;
    for (const PortPath& path : connector.ports) ports.push_back(text_of(path));
    bool loop = !connector.size.empty();
    text += loop ? "    for i in 0.." + connector.size + " connector $" : "    connector $";
    text += connector.type + " " + connector.name + (loop ? "[i]" : "") + "(" + join(ports, ", ") + ")\n";
  }
  for (const Priority& rule : compound.priorities) {
    text += "    priority " + rule.name + " " + pattern_text(compound, rule.low) + " < " +
            pattern_text(compound, rule.high);
    if (rule.guard) text += " provided (" + code(*rule.guard) + ")";
    text += "\n";
  }
  for (const PortExport& e : compound.port_exports) {
    std::vector<std::string> targets;
    for (const PortPath& path : e.targets) targets.push_back(text_of(path));
    text += "    export port " + join(targets, ", ") + " as " + e.name + "\n";
  }
  for (const DataExport& e : compound.data_exports) {
    text += "    export data " + e.component + "." + e.data + " as " + e.name + "\n";
  }
  return text + "  end\n";
}

}  // namespace

const char* name_of(Ty type) {
  switch (type) {
    case Ty::Int: return "int";
    case Ty::Bool: return "bool";
    case Ty::Float: return "float";
    case Ty::String: return "string";
    case Ty::Pair: return "Pair";
    case Ty::Wide: return "Wide";
  }
  return "?";
}

std::string print_types(const std::vector<PortType>& types) {
  std::string text;
  for (const PortType& type : types) text += "  port type " + type.name + "(" + typed(type.vars) + ")\n";
  return text;
}
std::string print_parts(const Description& model) {
  std::string text;
  for (const AtomType& type : model.atom_types) text += type.paper ? print_paper(type) : print(type);
  for (const ConnectorType& type : model.connector_types) text += print(type);
  return text;
}
std::string print_compounds(const Description& model) {
  std::string text;
  for (const CompoundType& type : model.compound_types) text += type.paper ? print_paper(model, type) : print(type);
  return text;
}

std::string broadcast_text(int receivers) {
  std::string n = std::to_string(receivers), params = "Signal s", define = "s'", ports = "s.go";
  for (int k = 0; k < receivers; ++k) {
    std::string i = std::to_string(k);
    params += ", Signal r" + i;
    define += " r" + i;
    ports += ", r[" + i + "].hear";
  }
  return "package broadcast\n  port type Signal()\n"
         "  atom type Sender()\n    export port Signal go()\n    place S\n    initial to S\n    on go from S to S\n  "
         "end\n"
         "  atom type Receiver()\n    export port Signal hear()\n    export port Signal rearm()\n    place A, B\n"
         "    initial to A\n    on hear from A to B\n    on rearm from B to A\n  end\n"
         "  connector type One(Signal p)\n    define p\n  end\n"
         "  connector type Broadcast(" +
         params + ")\n    define " + define +
         "\n  end\n"
         "  compound type Root()\n    component Sender s()\n    component Receiver r[" +
         n +
         "]()\n"
         "    connector Broadcast all(" +
         ports +
         ")\n"
         "    for i in 0.." +
         n + " connector One again[i](r[i].rearm)\n  end\nend\n";
}

}  // namespace bip::gen
