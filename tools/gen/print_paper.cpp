// The paper's notation: `component … behavior … end` for atoms that fit it, and compounds whose connectors are written
// inline, their ports named by what they connect.
#include <map>

#include "tools/gen/print_description_code.hpp"

namespace bip::gen {
namespace {

std::string paper_code(const Expr& expr) { return text_of(expr, plain_name, Spelling::Paper); }

std::string inline_define(const std::vector<std::string>& paths, const Define& define) {
  std::string text;
  if (define.param >= 0) {
    text = paths[static_cast<std::size_t>(define.param)];
  } else {
    std::vector<std::string> parts;
    for (const Define& child : define.children) parts.push_back(inline_define(paths, child));
    text = "[" + join(parts, ", ") + "]";
  }
  return text + (define.trigger ? "'" : "");
}

std::string inline_connector(const ConnectorType& type, const Connector& connector) {
  std::vector<std::string> paths;
  std::map<std::string, std::string> path_of;
  for (std::size_t k = 0; k < connector.ports.size(); ++k) {
    paths.push_back(text_of(connector.ports[k]));
    path_of[type.params[k].name] = paths.back();
  }
  NameText names = [&](const std::string& scope, const std::string& name) {
    auto found = path_of.find(scope);
    return plain_name(found == path_of.end() ? scope : found->second, name);
  };
  std::string text = "    connector " + connector.name + "(" + join(paths, ", ") + ")\n";
  text += "      define " + inline_define(paths, type.define) + "\n";
  for (const Clause& clause : type.clauses) {
    std::vector<std::string> ports;
    for (int p : clause.params) ports.push_back(paths[static_cast<std::size_t>(p)]);
    text += "      on " + join(ports, ", ");
    if (clause.guard) text += " provided " + text_of(*clause.guard, names, Spelling::PaperGuard);
    text += " do " + text_of(clause.down, names, Spelling::Paper) + "\n";
  }
  return text;
}

}  // namespace

std::string print_paper(const AtomType& atom) {
  std::string text = "  component " + atom.name + "\n";
  for (const Port& port : atom.ports)
    text += "    port $" + port.type + " " + port.name + "(" + join(port.vars, ", ") + ")\n";
  for (const Var& var : atom.data) {
    text += std::string("    data ") + (var.type < Ty::Pair ? "" : "$") + name_of(var.type) + " " + var.name;
    if (var.init) text += " = " + paper_code(*var.init);
    text += "\n";
  }
  text += "    behavior initial to " + atom.initial.at(0);
  if (!atom.initial_action.empty()) text += " do " + text_of(atom.initial_action, plain_name, Spelling::Paper);
  text += "\n";
  for (const std::string& place : atom.places) {
    text += "      state " + place + "\n";
    for (const Transition& t : atom.transitions) {
      if (t.from.at(0) != place) continue;
      text += "        on " + t.port;
      if (t.guard) text += " provided " + text_of(*t.guard, plain_name, Spelling::PaperGuard);
      if (!t.action.empty()) text += " do " + text_of(t.action, plain_name, Spelling::Paper);
      text += " to " + t.to.at(0) + "\n";
    }
  }
  text += "    end\n";
  for (const std::string& place : atom.finals) text += "    final " + place + "\n";
  return text + "  end\n";
}

std::string print_paper(const Description& model, const CompoundType& compound) {
  std::string text = "  component " + compound.name + "\n";
  for (const Component& component : compound.components) {
    std::vector<std::string> args;
    for (const Expr& arg : component.args) args.push_back(paper_code(arg));
    text += "    contains $" + component.type + " " + component.name;
    if (!args.empty()) text += "(" + join(args, ", ") + ")";
    text += "\n";
  }
  for (const Connector& connector : compound.connectors) {
    text += inline_connector(*find_named(model.connector_types, connector.type), connector);
  }
  return text + "  end\n";
}

}  // namespace bip::gen
