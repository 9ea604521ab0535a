// See exchange.hpp. Writes one process that takes one step at a time, with one alternative per interaction, each a
// `d_step`, so that SPIN's states are the stable ones. If no alternative is executable the process waits forever, which
// is SPIN's invalid end state; after a run-time error it ends. Cost: the number of interactions times the size of each.
//
// Names in the text: `p3` the place of atom 3 (`m3_1`: is place 1 of a Petri net atom marked?), `d3_0` its variable 0,
// `on3_1` whether its port 1 is enabled, `settle3()` what happens to it before anything reads it again; `en3_1`
// whether interaction 1 of connector 3 is enabled, `is3_1` whether no larger one is, `f3_0` the connector's own data
// while a step is taken. What an `up` computes stands in the guards above it as an expression.
#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "compiler/analysis/graph_algorithms.hpp"
#include "compiler/analysis/interaction_tree.hpp"
#include "compiler/exchange/exchange.hpp"
#include "compiler/exchange/plain_name.hpp"
#include "compiler/exchange/promela_code.hpp"
#include "compiler/exchange/promela_formula.hpp"
#include "compiler/exchange/promela_runs.hpp"
#include "compiler/system/inner_priorities.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::exchange {

namespace {

using analysis::InteractionTree;
using analysis::kNoRow;
using analysis::Leaves;

const char* type_name(Type type) { return type == Type::Bool ? "bool" : "int"; }

bool is_within(const Leaves& a, const Leaves& b) {
  return a.size() < b.size() && std::includes(b.begin(), b.end(), a.begin(), a.end());
}

class PromelaWriter {
 public:
  PromelaWriter(const System& system, const Options& options)
      : system_(system), options_(options), code_(system, refusal_) {}
  Result<std::string> run();

 private:
  /// One interaction of a connector on top.
  struct Step {
    ConnectorId connector;
    std::size_t tree = 0;  // row of trees_
    std::string name;      // "3_1": of connector 3 the second
    Leaves leaves;
    std::vector<u32> params;  // that take part
  };

  // Atoms.
  [[nodiscard]] const AtomType& type_of(AtomId atom) const { return system_.atom_types[system_.atoms[atom].type]; }
  [[nodiscard]] std::string variable_name(AtomId atom, u32 variable) const;
  [[nodiscard]] Names names_of(AtomId atom) const;
  [[nodiscard]] std::string marked(AtomId atom, const std::vector<u32>& places) const;
  [[nodiscard]] std::string end() const;
  [[nodiscard]] std::string not_hidden(const Step& step) const;
  [[nodiscard]] std::string property(const PromelaRuns& runs, MayFault may_fault);
  [[nodiscard]] std::string enabled(AtomId atom, const Transition& t);
  [[nodiscard]] std::string both(AtomId atom, const Transition& a, const Transition& b);
  [[nodiscard]] std::string move(AtomId atom, const Transition& t, const std::string& indent);
  void declare(AtomId atom);
  void add_ports(AtomId atom);
  void add_settle(AtomId atom);
  void add_initial(AtomId atom, std::string& out);
  [[nodiscard]] std::string port_name(AtomId atom, u32 port) const {
    return "on" + std::to_string(atom.value) + '_' + std::to_string(port);
  }

  // Connectors.
  void add_connector(ConnectorId connector);
  [[nodiscard]] std::string enabled(const InteractionTree& tree, u32 root, const Leaves& leaves);
  [[nodiscard]] Names names_of(const InteractionTree& tree, const InteractionTree::Use& use,
                               const std::vector<std::uint8_t>& chosen,
                               std::function<std::string(u32 use, u32 variable)> frame) const;
  [[nodiscard]] std::string frame_name(ConnectorId connector, u32 variable) const;
  [[nodiscard]] std::string effect(const Step& step);
  void fire_use(const InteractionTree& tree, u32 use, const std::vector<std::uint8_t>& chosen, std::string& out);
  [[nodiscard]] std::string record(AtomId atom, u32 port);
  [[nodiscard]] std::string fire(AtomId atom, u32 port);
  [[nodiscard]] std::string told(const Step& step) const;

  // Priorities.
  enum class RuleSide : std::uint8_t { Low, High };
  [[nodiscard]] bool matches(const Priority& rule, RuleSide side, const Step& step) const;
  void add_priorities();
  [[nodiscard]] bool has_cycle(const std::vector<std::set<std::size_t>>& next) const;

  const System& system_;
  const Options& options_;
  std::string refusal_;
  PromelaCode code_;
  std::string declarations_, macros_, inlines_;
  std::vector<InteractionTree> trees_;  // of the connectors on top
  std::vector<Step> steps_;
};

// ---- atoms ----------------------------------------------------------------------------------------------------------

std::string PromelaWriter::variable_name(AtomId atom, u32 variable) const {
  BIP_ASSERT(variable < type_of(atom).variables.size(), "variable {} of atom {}", variable, atom);
  if (type_of(atom).variables[variable].is_param && type_of(atom).variables[variable].type != Type::Float) {
    const std::int32_t value = system_.atoms[atom].args[variable].int_value;
    return value < 0 ? fmt::format("({})", value) : std::to_string(value);
  }
  return fmt::format("d{}_{}", atom.value, variable);
}

Names PromelaWriter::names_of(AtomId atom) const {
  Names names;
  names.self = [this, atom](u32 k) { return variable_name(atom, k); };
  names.bind = [](u32) { return std::string(); };
  return names;
}

std::string PromelaWriter::marked(AtomId atom, const std::vector<u32>& places) const {
  BIP_ASSERT(!type_of(atom).is_automaton() || places.size() == 1, "atom {} is at {} places", atom, places.size());
  if (type_of(atom).is_automaton()) return fmt::format("p{} == {}", atom.value, places[0]);
  std::string all;
  for (u32 place : places) all += fmt::format("{}m{}_{}", all.empty() ? "" : " && ", atom.value, place);
  return all;
}

std::string PromelaWriter::enabled(AtomId atom, const Transition& t) {
  const std::string is_marked = marked(atom, t.from);
  return t.guard.is_valid() ? fmt::format("({} && {})", is_marked, code_.text(t.guard, names_of(atom)))
                            : '(' + is_marked + ')';
}

// Both at once; empty if their places exclude each other.
std::string PromelaWriter::both(AtomId atom, const Transition& a, const Transition& b) {
  if (type_of(atom).is_automaton() && a.from != b.from) return {};
  return fmt::format("({} && {})", enabled(atom, a), enabled(atom, b));
}

// Tokens, action, invariants. A run-time error sets `fault`; what is done after that no longer matters.
std::string PromelaWriter::move(AtomId atom, const Transition& t, const std::string& indent) {
  const AtomType& type = type_of(atom);
  std::string out;
  if (type.is_automaton()) {
    out += fmt::format("{}p{} = {};\n", indent, atom.value, t.to[0]);
  } else {
    for (u32 place : t.from) out += fmt::format("{}m{}_{} = false;\n", indent, atom.value, place);
    for (u32 place : t.to) {
      out += fmt::format("{0}if\n{0}:: m{1}_{2} -> fault = true;\n{0}:: else -> m{1}_{2} = true;\n{0}fi;\n", indent,
                         atom.value, place);
    }
  }
  out += code_.statements(t.action, names_of(atom), indent);
  if (!type.invariants.empty()) out += fmt::format("{}keep{}();\n", indent, atom.value);
  return out;
}

void PromelaWriter::declare(AtomId atom) {
  const AtomType& type = type_of(atom);
  declarations_ += fmt::format("/* {}:", plain_name(system_.atoms[atom].path));
  for (std::size_t place = 0; place < type.places.size(); ++place)
    declarations_ += fmt::format(" {} {}", place, plain_name(type.places[place]));
  declarations_ += " */\n";
  const auto is_initial = [&](std::size_t place) {
    return std::find(type.initial.begin(), type.initial.end(), place) != type.initial.end();
  };
  if (type.is_automaton())
    declarations_ +=
        fmt::format("{} p{} = {};\n", type.places.size() > 255 ? "int" : "byte", atom.value, type.initial[0]);
  for (std::size_t place = 0; !type.is_automaton() && place < type.places.size(); ++place) {
    declarations_ += fmt::format("bool m{}_{} = {};\n", atom.value, place, is_initial(place));
  }
  for (std::size_t k = 0; k < type.variables.size(); ++k) {
    const DataVariable& variable = type.variables[k];
    if (is_ffi(variable.type)) code_.refuse("data of type " + system_.code.type_name(variable.type), variable.loc);
    if (!variable.is_param && variable.type != Type::Float)
      declarations_ +=
          fmt::format("{} d{}_{}; /* {} */\n", type_name(variable.type), atom.value, k, plain_name(variable.name));
  }
}

void PromelaWriter::add_ports(AtomId atom) {
  const AtomType& type = type_of(atom);
  const std::size_t count = type.ports.size();
  std::vector<std::set<std::size_t>> above(count);
  std::vector<std::vector<std::string>> guards(count, std::vector<std::string>(count));
  for (const AtomPriority& rule : type.priorities) {
    for (u32 low = 0; low < count; ++low) {
      for (u32 high = 0; high < count; ++high) {
        const bool fits_low = rule.low == AtomPriority::kAnyPort
                                  ? rule.high == AtomPriority::kAnyPort || low != rule.high
                                  : rule.low == low;
        const bool fits_high = rule.high == AtomPriority::kAnyPort
                                   ? rule.low == AtomPriority::kAnyPort || high != rule.low
                                   : rule.high == high;
        if (!fits_low || !fits_high) continue;
        above[low].insert(high);
        std::string& guard = guards[low][high];
        guard += (guard.empty() ? "" : " || ") + code_.text(rule.guard, names_of(atom));
      }
    }
  }
  if (has_cycle(above)) return code_.refuse("priorities of an atom that only guards keep from being a cycle", type.loc);
  const bool has_rules = !type.priorities.empty();
  for (u32 port = 0; port < count; ++port) {
    std::string some;
    for (const Transition& t : type.transitions) {
      if (t.port == port) some += (some.empty() ? "" : " || ") + enabled(atom, t);
    }
    if (some.empty()) some = "false";
    const std::string name = port_name(atom, port);
    macros_ += fmt::format("#define {}{} ({})", has_rules ? "raw_" : "", name, some);
    macros_ += fmt::format(" /* {}.{} */\n", plain_name(system_.atoms[atom].path), plain_name(type.ports[port].name));
    if (!has_rules) continue;
    std::string covered = "false";
    for (std::size_t high : above[port]) {
      const std::string other = port_name(atom, static_cast<u32>(high));
      covered += fmt::format(" || (({}) && (raw_{} || covers_{}))", guards[port][high], other, other);
    }
    macros_ += fmt::format("#define covers_{0} ({1})\n#define {0} (raw_{0} && !covers_{0})\n", name, covered);
  }
}

// Invariants; internal transitions until there is none; two transitions at once.
void PromelaWriter::add_settle(AtomId atom) {
  const AtomType& type = type_of(atom);
  if (!type.invariants.empty()) {
    inlines_ += fmt::format("inline keep{}() {{\n", atom.value);
    for (const Invariant& row : type.invariants) {
      std::string places = "true";
      if (row.scope != InvariantScope::Always && !type.is_automaton())
        places = row.places.empty() ? "true" : marked(atom, row.places);
      else if (row.scope != InvariantScope::Always)
        places = row.places.size() > 1 ? "false"
                 : row.places.empty()  ? (row.scope == InvariantScope::At ? "false" : "true")
                                       : marked(atom, row.places);
      for (u32 place = 0; row.scope == InvariantScope::At && !type.is_automaton() && place < type.places.size();
           ++place) {
        if (!std::binary_search(row.places.begin(), row.places.end(), place))
          places += fmt::format(" && !m{}_{}", atom.value, place);
      }
      inlines_ += fmt::format("  if\n  :: ({}) && !({}) -> fault = true;\n  :: else -> skip;\n  fi;\n", places,
                              code_.text(row.condition, names_of(atom)));
    }
    inlines_ += "}\n";
  }
  std::string internals, twice, ports_twice;
  for (std::size_t k = 0; k < type.transitions.size(); ++k) {
    const Transition& t = type.transitions[k];
    for (std::size_t j = 0; j < k; ++j) {
      if (type.transitions[j].port != t.port) continue;
      const std::string pair = both(atom, type.transitions[j], t);
      if (pair.empty()) continue;
      std::string& list = t.port == Transition::kInternal ? twice : ports_twice;
      list += (list.empty() ? "" : " || ") + pair;
    }
    if (t.port == Transition::kInternal)
      internals += fmt::format("  :: !fault && {} ->\n{}", enabled(atom, t), move(atom, t, "     "));
  }
  inlines_ += fmt::format("inline settle{}() {{\n", atom.value);
  if (!internals.empty()) {
    inlines_ += "  do\n";
    if (!twice.empty()) inlines_ += fmt::format("  :: !fault && ({}) -> fault = true;\n", twice);
    inlines_ += internals + "  :: else -> break;\n  od;\n";
  }
  if (!ports_twice.empty())
    inlines_ += fmt::format("  if\n  :: ({}) -> fault = true;\n  :: else -> skip;\n  fi;\n", ports_twice);
  // SPIN refuses a loop at the end of a `d_step`: what leaves it would lead outside.
  if (ports_twice.empty()) inlines_ += "  skip;\n";
  inlines_ += "}\n";
}

void PromelaWriter::add_initial(AtomId atom, std::string& out) {
  const AtomType& type = type_of(atom);
  out += code_.statements(type.initial_action, names_of(atom), "    ");
  if (!type.invariants.empty()) out += fmt::format("    keep{}();\n", atom.value);
  out += fmt::format("    settle{}();\n", atom.value);
}

// ---- connectors -----------------------------------------------------------------------------------------------------

std::string PromelaWriter::frame_name(ConnectorId connector, u32 variable) const {
  return fmt::format("f{}_{}", connector.value, variable);
}

Names PromelaWriter::names_of(const InteractionTree& tree, const InteractionTree::Use& use,
                              const std::vector<std::uint8_t>& chosen,
                              std::function<std::string(u32 use, u32 variable)> frame) const {
  const Connector& connector = system_.connectors[use.connector];
  const ConnectorType& type = system_.connector_types[connector.type];
  std::vector<std::string> bind;
  for (std::size_t p = 0; p < type.params.size(); ++p) {
    const u32 node = analysis::chosen_alternative(tree, use.param_nodes[p], chosen);
    for (u32 v = 0; v < system_.port_types[type.params[p].type].variables.size(); ++v) {
      if (node == kNoRow) bind.emplace_back();
      else if (tree.nodes[node].kind == InteractionTree::Kind::Leaf)
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
std::string PromelaWriter::enabled(const InteractionTree& tree, u32 root, const Leaves& leaves) {
  const std::vector<std::uint8_t> chosen = analysis::chosen_nodes(tree, leaves);
  std::string all;
  const auto add = [&](const std::string& condition) { all += (all.empty() ? "" : " && ") + condition; };
  for (u32 leaf : leaves) add(port_name(tree.nodes[leaf].atom, tree.nodes[leaf].port));
  std::map<u32, std::map<u32, std::string>> frames;  // by use, by variable
  for (std::size_t row = tree.uses.size(); row-- > 0 && refusal_.empty();) {
    const InteractionTree::Use& use = tree.uses[row];
    if (chosen[use.root] == 0 || !tree.is_below(root, use.root)) continue;
    std::map<u32, std::string>& frame = frames[static_cast<u32>(row)];
    const ConnectorType& type = system_.connector_types[system_.connectors[use.connector].type];
    for (u32 k = 0; k < type.variables.size(); ++k) frame[k] = type.variables[k].type == Type::Bool ? "false" : "0";
    const Clause* clause = analysis::chosen_clause(system_, use, chosen);
    if (clause == nullptr) continue;
    const Names names = names_of(tree, use, chosen, [&frames](u32 of, u32 variable) { return frames[of][variable]; });
    if (clause->guard.is_valid()) add(code_.text(clause->guard, names));
    code_.substitute(clause->up, names, frame);
  }
  for (u32 row = 0; row < tree.nodes.size(); ++row) {
    const InteractionTree::Node& node = tree.nodes[row];
    if (node.kind != InteractionTree::Kind::Link || !node.maximal_only || chosen[row] == 0 || !tree.is_below(root, row))
      continue;
    Leaves own;
    for (u32 leaf : leaves) {
      if (tree.is_below(row, leaf)) own.push_back(leaf);
    }
    Result<std::vector<Leaves>> inner = analysis::list_interactions(tree, node.children[0], kMaxInteractions);
    if (!inner)
      code_.refuse("connector `" + plain_name(system_.connectors[tree.uses[node.use].connector].path) +
                   "`: " + inner.error());
    for (std::size_t k = 0; inner && k < inner->size(); ++k) {
      if (is_within(own, (*inner)[k])) add("!(" + enabled(tree, node.children[0], (*inner)[k]) + ')');
    }
  }
  return all;
}

void PromelaWriter::add_connector(ConnectorId connector) {
  const std::string path = plain_name(system_.connectors[connector].path);
  Result<InteractionTree> tree = analysis::build_interaction_tree(system_, connector);
  if (!tree) return code_.refuse("connector `" + path + "`: " + tree.error());
  Result<std::vector<Leaves>> all = analysis::list_interactions(*tree, tree->uses[0].root, kMaxInteractions);
  if (!all) return code_.refuse("connector `" + path + "`: " + all.error());
  for (const InteractionTree::Use& use : tree->uses) {
    const ConnectorType& type = system_.connector_types[system_.connectors[use.connector].type];
    for (u32 k = 0; k < type.variables.size(); ++k) {
      if (type.variables[k].type == Type::Float) continue;
      if (is_ffi(type.variables[k].type))
        code_.refuse("data of type " + system_.code.type_name(type.variables[k].type), type.variables[k].loc);
      const std::string declaration =
          fmt::format("hidden {} {}; /* {}.{} */\n", type.variables[k].type == Type::Bool ? "byte" : "int",
                      frame_name(use.connector, k), plain_name(system_.connectors[use.connector].path),
                      plain_name(type.variables[k].name));
      // Bound by several, a connector has its data once.
      if (declarations_.find(declaration) == std::string::npos) declarations_ += declaration;
    }
  }
  for (std::size_t k = 0; k < all->size() && refusal_.empty(); ++k) {
    Step step{connector, trees_.size(), fmt::format("{}_{}", connector.value, k), (*all)[k], {}};
    const std::vector<std::uint8_t> chosen = analysis::chosen_nodes(*tree, step.leaves);
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
void PromelaWriter::fire_use(const InteractionTree& tree, u32 row, const std::vector<std::uint8_t>& chosen,
                             std::string& out) {
  const InteractionTree::Use& use = tree.uses[row];
  const auto frame = [&](u32 of, u32 variable) { return frame_name(tree.uses[of].connector, variable); };
  if (const Clause* clause = analysis::chosen_clause(system_, use, chosen))
    out += code_.statements(clause->down, names_of(tree, use, chosen, frame), "     ");
  for (u32 param : use.param_nodes) {
    if (chosen[param] == 0) continue;
    const u32 node = analysis::chosen_alternative(tree, param, chosen);
    if (tree.nodes[node].kind == InteractionTree::Kind::Link) fire_use(tree, tree.nodes[node].use, chosen, out);
    else out += fire(tree.nodes[node].atom, tree.nodes[node].port);
  }
}

std::string PromelaWriter::effect(const Step& step) {
  const InteractionTree& tree = trees_[step.tree];
  const std::vector<std::uint8_t> chosen = analysis::chosen_nodes(tree, step.leaves);
  const auto frame = [&](u32 of, u32 variable) { return frame_name(tree.uses[of].connector, variable); };
  std::string out;
  for (u32 leaf : step.leaves) out += record(tree.nodes[leaf].atom, tree.nodes[leaf].port);
  for (std::size_t row = tree.uses.size(); row-- > 0;) {
    const InteractionTree::Use& use = tree.uses[row];
    if (chosen[use.root] == 0) continue;
    const ConnectorType& type = system_.connector_types[system_.connectors[use.connector].type];
    for (u32 k = 0; k < type.variables.size(); ++k) {
      if (type.variables[k].type != Type::Float) out += fmt::format("     {} = 0;\n", frame_name(use.connector, k));
    }
    if (const Clause* clause = analysis::chosen_clause(system_, use, chosen))
      out += code_.statements(clause->up, names_of(tree, use, chosen, frame), "     ");
  }
  fire_use(tree, 0, chosen, out);
  return out;
}

std::string PromelaWriter::told(const Step& step) const {
  const auto short_path = [](const std::string& path) {
    return plain_name(path.starts_with("ROOT.") ? path.substr(5) : path);
  };
  std::string out = short_path(system_.connectors[step.connector].path) + ':';
  for (u32 leaf : step.leaves) {
    const InteractionTree::Node& node = trees_[step.tree].nodes[leaf];
    out += ' ' + short_path(system_.atoms[node.atom].path) + '.' + plain_name(type_of(node.atom).ports[node.port].name);
  }
  return out;
}

// ---- priorities, and the whole --------------------------------------------------------------------------------------

bool PromelaWriter::matches(const Priority& rule, RuleSide side, const Step& step) const {
  const Pattern& pattern = side == RuleSide::High ? rule.high : rule.low;
  const Pattern& other = side == RuleSide::High ? rule.low : rule.high;
  if (pattern.any_connector)
    return system_.connectors[step.connector].parent == rule.parent &&
           (other.any_connector || !matches(rule, side == RuleSide::High ? RuleSide::Low : RuleSide::High, step));
  BIP_ASSERT(std::is_sorted(step.params.begin(), step.params.end()) &&
                 std::is_sorted(pattern.params.begin(), pattern.params.end()),
             "parameters of step `{}` are not in order", step.name);
  if (pattern.connector != step.connector) return false;
  const std::vector<u32>& outer = side == RuleSide::High ? step.params : pattern.params;
  const std::vector<u32>& inner = side == RuleSide::High ? pattern.params : step.params;
  return pattern.any_interaction || std::includes(outer.begin(), outer.end(), inner.begin(), inner.end());
}

bool PromelaWriter::has_cycle(const std::vector<std::set<std::size_t>>& next) const {
  std::vector<u32> missing(next.size(), 0), order;
  for (const std::set<std::size_t>& successors : next) {
    for (std::size_t to : successors) ++missing[to];
  }
  return !topological_order(missing, order, [&](u32 from, const auto& see) {
    for (std::size_t to : next[from]) see(static_cast<u32>(to));
  });
}

// `hides0`: what rule 0 matches is hidden, by an interaction that its high side matches or through a chain of rules.
void PromelaWriter::add_priorities() {
  const std::size_t count = system_.priorities.size();
  std::vector<std::set<std::size_t>> next(count);
  for (std::size_t r = 0; r < count; ++r) {
    const Priority& rule = system_.priorities[PriorityId(r)];
    Names names;
    names.self = [](u32) { return std::string(); };
    names.bind = [&](u32 k) { return variable_name(rule.data[k].atom, rule.data[k].variable); };
    std::string above = "false";
    for (const Step& step : steps_) {
      if (!matches(rule, RuleSide::High, step)) continue;
      above += " || is" + step.name;
      for (std::size_t s = 0; s < count; ++s) {
        if (matches(system_.priorities[PriorityId(s)], RuleSide::Low, step)) next[r].insert(s);
      }
    }
    for (std::size_t s : next[r]) above += fmt::format(" || hides{}", s);
    macros_ += fmt::format("#define hides{} ({} && ({})) /* {} */\n", r, code_.text(rule.guard, names), above,
                           plain_name(rule.name));
  }
  if (has_cycle(next)) code_.refuse("priorities that only guards keep from being a cycle");
}

// Where the model may end: an end that SPIN takes for a valid one.
std::string PromelaWriter::end() const {
  std::string all;
  for (u32 row = 0; row < system_.atoms.size(); ++row) {
    const AtomId atom(row);
    const AtomType& type = type_of(atom);
    if (type.final_places.empty()) return {};
    std::string at_final;
    for (u32 place = 0; place < type.places.size(); ++place) {
      const bool is_final = std::binary_search(type.final_places.begin(), type.final_places.end(), place);
      if (type.is_automaton() && is_final) at_final += (at_final.empty() ? "" : " || ") + marked(atom, {place});
      if (!type.is_automaton() && !is_final) at_final += (at_final.empty() ? "!" : " && !") + marked(atom, {place});
    }
    if (!at_final.empty()) all += (all.empty() ? "(" : " && (") + at_final + ")";
  }
  return "  :: " + (all.empty() ? "true" : all) + " -> break /* final */\n";
}

// The interaction is a candidate.
std::string PromelaWriter::not_hidden(const Step& step) const {
  std::string text = "is" + step.name;
  for (std::size_t r = 0; r < system_.priorities.size(); ++r) {
    if (matches(system_.priorities[PriorityId(r)], RuleSide::Low, step)) text += fmt::format(" && !hides{}", r);
  }
  return text;
}

// The formula of the runs from the first stable state on; runs that end in an error are none. After the last step the
// state repeats, in SPIN (stutter extension) as here.
std::string PromelaWriter::property(const PromelaRuns& runs, MayFault may_fault) {
  if (options_.formula == nullptr) return {};
  const ConditionNames names{.marked = [this](AtomId atom, u32 place) { return "(" + marked(atom, {place}) + ")"; },
                             .variable = [this](AtomId atom, u32 variable) { return variable_name(atom, variable); },
                             .can_port = [this](AtomId atom, u32 port) { return port_name(atom, port); },
                             .can_connector =
                                 [this](ConnectorId connector) {
                                   std::string some = "false";
                                   for (const Step& step : steps_) {
                                     if (step.connector == connector) some += " || (" + not_hidden(step) + ")";
                                   }
                                   return "(" + some + ")";
                                 }};
  const Result<std::string> text = ltl_text(*options_.formula, names, runs, macros_);
  if (!text) {
    code_.refuse(text.error());
    return {};
  }
  return fmt::format("\nltl property {{ {}{} }}\n", runs.premise(may_fault), *text);
}

Result<std::string> PromelaWriter::run() {
  if (const std::string timed = system::first_timed(system_); !timed.empty()) code_.refuse("time: " + timed);
  if (const std::string inner = system::first_inner_priority(system_); !inner.empty()) code_.refuse(inner);
  std::string initial, alternatives;
  for (u32 row = 0; row < system_.atoms.size(); ++row) {
    const AtomId atom(row);
    declare(atom);
    add_ports(atom);
    add_settle(atom);
    add_initial(atom, initial);
    declarations_ += fmt::format("hidden int t{};\n", row);
    if (!refusal_.empty()) return Failure{refusal_};
  }
  for (u32 row = 0; row < system_.connectors.size(); ++row) {
    if (system_.is_top(ConnectorId(row))) add_connector(ConnectorId(row));
    if (!refusal_.empty()) return Failure{refusal_};
  }
  BIP_ASSERT(std::all_of(steps_.begin(), steps_.end(), [&](const Step& step) { return step.tree < trees_.size(); }),
             "a step of none of {} trees", trees_.size());
  add_priorities();
  std::vector<StepText> all;
  std::vector<std::string> effects;  // of each, after its condition
  for (const Step& step : steps_) {
    const InteractionTree& tree = trees_[step.tree];
    StepText text{not_hidden(step), step.connector, {}};
    for (u32 leaf : step.leaves) text.ports.emplace_back(tree.nodes[leaf].atom, tree.nodes[leaf].port);
    all.push_back(std::move(text));
    effects.push_back(fmt::format("     printf(\"{}\\n\");\n{}", told(step), effect(step)));
  }
  for (u32 row = 0; row < system_.atoms.size(); ++row) {
    const AtomId atom(row);
    for (u32 port = 0; port < type_of(atom).ports.size(); ++port) {
      if (type_of(atom).ports[port].exported) continue;
      const std::string name = plain_name(system_.atoms[atom].path) + '.' + plain_name(type_of(atom).ports[port].name);
      all.push_back({port_name(atom, port), std::nullopt, {{atom, port}}});
      effects.push_back(fmt::format("     printf(\"{}\\n\");\n{}{}", name, record(atom, port), fire(atom, port)));
    }
  }
  const PromelaRuns runs(all, options_.formula != nullptr ? *options_.formula : verify::Formula{}, options_.fairness);
  for (std::size_t k = 0; k < all.size(); ++k) {
    alternatives +=
        fmt::format("  :: d_step {{ {} ->\n{}{}     }}\n", runs.before_step(k), effects[k], runs.after_step(k));
  }
  alternatives += runs.alternatives();
  const auto faults = [](const std::string& text) { return text.find("fault = true") != std::string::npos; };
  const std::string asked =
      property(runs, faults(initial) || faults(inlines_) || faults(alternatives) ? MayFault::Yes : MayFault::No);
  if (options_.formula != nullptr) macros_ += runs.declarations();
  if (!refusal_.empty()) return Failure{refusal_};
  const bool is_asked = !asked.empty();
  return fmt::format(
      "/* {} by bipc export. {}:\n"
      "   spin -a m.pml && cc -O2 -fwrapv {}-o pan pan.c && ./pan {}-m1000000, then spin -t m.pml */\n"
      "{}bool fault = false; /* a run-time error: the end, no deadlock */\n{}\n{}\n"
      "init {{\n  d_step {{\n{}    {};\n  }}\n  do\n  :: fault -> break\n{}{}  od\n}}\n{}",
      plain_name(options_.root_name),
      is_asked ? "A run that violates the property is an acceptance cycle" : "Deadlocks are invalid end states",
      is_asked ? "" : "-DSAFETY ", is_asked ? "-a " : "", declarations_, macros_, inlines_, initial,
      is_asked ? runs.start() : "skip", is_asked ? "" : end(), alternatives, asked);
}

}  // namespace

Result<std::string> promela(const System& system, const Options& options) {
  return PromelaWriter(system, options).run();
}

}  // namespace bip::exchange
