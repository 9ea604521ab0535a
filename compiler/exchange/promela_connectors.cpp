// Connectors in Promela. Names: `en3_1` is whether interaction 1 of connector 3 is enabled, `is3_1` whether no larger
// one is, `f3_0` its own variable 0 during a step. The values that an `up` computes appear in the guards above it as
// expressions.
#include <algorithm>

#include <fmt/format.h>

#include "compiler/exchange/promela.hpp"

namespace bip::exchange {

namespace {
using Kind = ConnectorTree::Kind;
bool is_within(const Leaves& a, const Leaves& b) {
  return a.size() < b.size() && std::includes(b.begin(), b.end(), a.begin(), a.end());
}
}  // namespace

std::string PromelaWriter::frame_name(ConnectorId connector, u32 variable) const {
  return fmt::format("f{}_{}", connector.value, variable);
}

Names PromelaWriter::names_of(const ConnectorTree& tree, const ConnectorTree::Use& use,
                              const std::vector<std::uint8_t>& chosen,
                              std::function<std::string(u32 use, u32 variable)> frame) const {
  const Connector& connector = system_.connectors[use.connector];
  const ConnectorType& type = system_.connector_types[connector.type];
  std::vector<std::string> bind;
  for (std::size_t p = 0; p < type.params.size(); ++p) {
    const u32 node = chosen_alternative(tree, use.param_nodes[p], chosen);
    for (u32 v = 0; v < system_.port_types[type.params[p].type].variables.size(); ++v) {
      if (node == kNoRow) bind.emplace_back();
      else if (tree.nodes[node].kind == Kind::Leaf)
        bind.push_back(variable_name(tree.nodes[node].atom,
                                     type_of(tree.nodes[node].atom).ports[tree.nodes[node].port].variables[v]));
      else
        bind.push_back(frame(tree.nodes[node].use,
                             system_.connector_types[system_.connectors[tree.uses[tree.nodes[node].use].connector].type]
                                 .export_variables[v]));
    }
  }
  for (const DataRef& ref : connector.data) bind.push_back(variable_name(ref.atom, ref.variable));
  Names names;
  const u32 row = static_cast<u32>(&use - tree.uses.data());
  names.self = [frame, row](u32 k) { return frame(row, k); };
  names.bind = [bind](u32 k) { return bind.at(k); };
  return names;
}

// Ports, guards bottom up, and that what shows only its maximal interactions shows one.
std::string PromelaWriter::enabled(const ConnectorTree& tree, u32 root, const Leaves& leaves) {
  const std::vector<std::uint8_t> chosen = chosen_nodes(tree, leaves);
  std::string all;
  const auto add = [&](const std::string& condition) { all += (all.empty() ? "" : " && ") + condition; };
  for (u32 leaf : leaves) add(port_name(tree.nodes[leaf].atom, tree.nodes[leaf].port));
  std::map<u32, std::map<u32, std::string>> frames;  // by use, by variable
  for (std::size_t row = tree.uses.size(); row-- > 0 && refusal_.empty();) {
    const ConnectorTree::Use& use = tree.uses[row];
    if (chosen[use.root] == 0 || !is_below(tree, root, use.root)) continue;
    std::map<u32, std::string>& frame = frames[static_cast<u32>(row)];
    const ConnectorType& type = system_.connector_types[system_.connectors[use.connector].type];
    for (u32 k = 0; k < type.variables.size(); ++k) frame[k] = type.variables[k].type == Type::Bool ? "false" : "0";
    const Clause* clause = chosen_clause(system_, use, chosen);
    if (clause == nullptr) continue;
    const Names names = names_of(tree, use, chosen, [&frames](u32 of, u32 variable) { return frames[of][variable]; });
    if (clause->guard.is_valid()) add(code_.text(clause->guard, names));
    code_.substitute(clause->up, names, frame);
  }
  for (u32 row = 0; row < tree.nodes.size(); ++row) {
    const ConnectorTree::Node& node = tree.nodes[row];
    if (node.kind != Kind::Link || !node.maximal_only || chosen[row] == 0 || !is_below(tree, root, row)) continue;
    Leaves own;
    for (u32 leaf : leaves) {
      if (is_below(tree, row, leaf)) own.push_back(leaf);
    }
    Result<std::vector<Leaves>> inner = configurations(tree, node.children[0]);
    if (!inner)
      code_.refuse("connector `" + plain(system_.connectors[tree.uses[node.use].connector].path) +
                   "`: " + inner.error());
    for (std::size_t k = 0; inner && k < inner->size(); ++k) {
      if (is_within(own, (*inner)[k])) add("!(" + enabled(tree, node.children[0], (*inner)[k]) + ')');
    }
  }
  return all;
}

void PromelaWriter::add_connector(ConnectorId connector) {
  const std::string path = plain(system_.connectors[connector].path);
  Result<ConnectorTree> tree = expand(system_, connector);
  if (!tree) return code_.refuse("connector `" + path + "`: " + tree.error());
  Result<std::vector<Leaves>> all = configurations(*tree, tree->uses[0].root);
  if (!all) return code_.refuse("connector `" + path + "`: " + all.error());
  for (const ConnectorTree::Use& use : tree->uses) {
    const ConnectorType& type = system_.connector_types[system_.connectors[use.connector].type];
    for (u32 k = 0; k < type.variables.size(); ++k) {
      if (type.variables[k].type == Type::Float) continue;
      if (is_ffi(type.variables[k].type))
        code_.refuse("data of type " + system_.code.type_name(type.variables[k].type), type.variables[k].loc);
      const std::string declaration = fmt::format(
          "hidden {} {}; /* {}.{} */\n", type.variables[k].type == Type::Bool ? "byte" : "int",
          frame_name(use.connector, k), plain(system_.connectors[use.connector].path), plain(type.variables[k].name));
      // Bound by several, a connector has its data once.
      if (declarations_.find(declaration) == std::string::npos) declarations_ += declaration;
    }
  }
  for (std::size_t k = 0; k < all->size() && refusal_.empty(); ++k) {
    Step step{connector, trees_.size(), fmt::format("{}_{}", connector.value, k), (*all)[k], {}};
    const std::vector<std::uint8_t> chosen = chosen_nodes(*tree, step.leaves);
    for (u32 p = 0; p < tree->uses[0].param_nodes.size(); ++p) {
      if (chosen[tree->uses[0].param_nodes[p]] != 0) step.params.push_back(p);
    }
    macros_ += fmt::format("#define en{} ({})\n", step.name, enabled(*tree, tree->uses[0].root, step.leaves));
    std::string maximal = "en" + step.name;
    for (std::size_t j = 0; options_.maximal_progress && j < all->size(); ++j) {
      if (is_within((*all)[k], (*all)[j])) maximal += fmt::format(" && !en{}_{}", connector.value, j);
    }
    macros_ += fmt::format("#define is{} ({})\n", step.name, maximal);
    steps_.push_back(std::move(step));
  }
  trees_.push_back(std::move(*tree));
}

// Which transition a port has now is remembered: transfers may change what its guard reads.
std::string PromelaWriter::record(AtomId atom, u32 port) {
  std::vector<std::size_t> rows;
  const AtomType& type = type_of(atom);
  for (std::size_t k = 0; k < type.transitions.size(); ++k) {
    if (type.transitions[k].port == port) rows.push_back(k);
  }
  if (rows.size() < 2) return {};
  std::string out = "     if\n";
  for (std::size_t k : rows)
    out += fmt::format("     :: {} -> t{} = {};\n", enabled(atom, type.transitions[k]), atom.value, k);
  return out + "     fi;\n";
}

std::string PromelaWriter::fire(AtomId atom, u32 port) {
  std::string out;
  std::size_t count = 0;
  const AtomType& type = type_of(atom);
  for (const Transition& t : type.transitions) count += t.port == port ? 1 : 0;
  for (std::size_t k = 0; k < type.transitions.size(); ++k) {
    if (type.transitions[k].port != port) continue;
    if (count == 1) return move(atom, type.transitions[k], "     ") + fmt::format("     settle{}();\n", atom.value);
    out += fmt::format("     :: t{} == {} ->\n{}", atom.value, k, move(atom, type.transitions[k], "        "));
  }
  return "     if\n" + out + fmt::format("     fi;\n     settle{}();\n", atom.value);
}

// `down`, then what takes part, in parameter order.
void PromelaWriter::fire_use(const ConnectorTree& tree, u32 row, const std::vector<std::uint8_t>& chosen,
                             std::string& out) {
  const ConnectorTree::Use& use = tree.uses[row];
  const auto frame = [&](u32 of, u32 variable) { return frame_name(tree.uses[of].connector, variable); };
  if (const Clause* clause = chosen_clause(system_, use, chosen))
    out += code_.statements(clause->down, names_of(tree, use, chosen, frame), "     ");
  for (u32 param : use.param_nodes) {
    if (chosen[param] == 0) continue;
    const u32 node = chosen_alternative(tree, param, chosen);
    if (tree.nodes[node].kind == Kind::Link) fire_use(tree, tree.nodes[node].use, chosen, out);
    else out += fire(tree.nodes[node].atom, tree.nodes[node].port);
  }
}

std::string PromelaWriter::effect(const Step& step) {
  const ConnectorTree& tree = trees_[step.tree];
  const std::vector<std::uint8_t> chosen = chosen_nodes(tree, step.leaves);
  const auto frame = [&](u32 of, u32 variable) { return frame_name(tree.uses[of].connector, variable); };
  std::string out;
  for (u32 leaf : step.leaves) out += record(tree.nodes[leaf].atom, tree.nodes[leaf].port);
  for (std::size_t row = tree.uses.size(); row-- > 0;) {
    const ConnectorTree::Use& use = tree.uses[row];
    if (chosen[use.root] == 0) continue;
    const ConnectorType& type = system_.connector_types[system_.connectors[use.connector].type];
    for (u32 k = 0; k < type.variables.size(); ++k) {
      if (type.variables[k].type != Type::Float) out += fmt::format("     {} = 0;\n", frame_name(use.connector, k));
    }
    if (const Clause* clause = chosen_clause(system_, use, chosen))
      out += code_.statements(clause->up, names_of(tree, use, chosen, frame), "     ");
  }
  fire_use(tree, 0, chosen, out);
  return out;
}

std::string PromelaWriter::told(const Step& step) const {
  const auto short_path = [](const std::string& path) {
    return plain(path.starts_with("ROOT.") ? path.substr(5) : path);
  };
  std::string out = short_path(system_.connectors[step.connector].path) + ':';
  for (u32 leaf : step.leaves) {
    const ConnectorTree::Node& node = trees_[step.tree].nodes[leaf];
    out += ' ' + short_path(system_.atoms[node.atom].path) + '.' + plain(type_of(node.atom).ports[node.port].name);
  }
  return out;
}

}  // namespace bip::exchange
