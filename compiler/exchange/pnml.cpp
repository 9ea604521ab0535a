// See exchange.hpp. A net has neither data nor priorities, so models are refused whose guards are not decided by
// parameters, that have priorities, or in which a larger interaction hides a smaller one. Each place is a place of an
// atom, each transition an interaction with one transition for each of its ports. Internal transitions are folded into
// the transitions that lead to them. The format is the PT net schema of ISO/IEC 15909-2.
#include "compiler/exchange/exchange.hpp"
#include "runtime/include/bip/assert.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "compiler/analysis/interaction_tree.hpp"
#include "compiler/exchange/plain_name.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/net/abstract_code.hpp"

namespace bip::exchange {

namespace {

using analysis::InteractionTree;
using analysis::Leaves;

class NetWriter {
 public:
  NetWriter(const System& system, const Options& options) : system_(system), options_(options) {}

  Result<std::string> run() {
    if (const std::string timed = system::first_timed(system_); !timed.empty()) refuse("time: " + timed);
    if (!system_.priorities.empty()) refuse(fmt::format("priority `{}`", system_.priorities[PriorityId(0u)].name));
    for (u32 atom = 0; atom < system_.atoms.size() && refusal_.empty(); ++atom) add_atom(AtomId(atom));
    for (u32 row = 0; row < system_.connectors.size() && refusal_.empty(); ++row) {
      if (system_.is_top(ConnectorId(row))) add_connector(ConnectorId(row));
    }
    for (u32 atom = 0; atom < system_.atoms.size() && refusal_.empty(); ++atom) {
      const AtomType& type = type_of(AtomId(atom));
      for (u32 port = 0; port < type.ports.size(); ++port) {
        if (!type.ports[port].exported) add_transitions(path_of(AtomId(atom), port), {{AtomId(atom), port}});
      }
    }
    if (!refusal_.empty()) return Failure{refusal_};
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<pnml xmlns=\"http://www.pnml.org/version-2009/grammar/pnml\">\n"
        "  <net id=\"net\" type=\"http://www.pnml.org/version-2009/grammar/ptnet\">\n    "
        "<name><text>{}</text></name>\n    <page id=\"page\">\n"
        "{}{}{}    </page>\n  </net>\n</pnml>\n",
        plain_name(options_.root_name), places_, transitions_, arcs_);
  }

 private:
  struct PortOf {
    AtomId atom;
    u32 port;
  };

  void refuse(const std::string& what, const Loc& loc = {}) {
    if (!refusal_.empty()) return;
    refusal_ = what;
    if (loc.line != 0 && loc.file < system_.files.size())
      refusal_ += fmt::format(" ({}:{}:{})", system_.files[loc.file], loc.line, loc.column);
  }
  [[nodiscard]] const AtomType& type_of(AtomId atom) const { return system_.atom_types[system_.atoms[atom].type]; }
  [[nodiscard]] std::string path_of(AtomId atom, u32 port) const {
    return plain_name(system_.atoms[atom].path) + '.' + plain_name(type_of(atom).ports[port].name);
  }

  // Parameters are known, data is not.
  [[nodiscard]] bool holds(AtomId atom, ExprId guard, const Loc& loc) {
    if (!guard.is_valid()) return true;
    std::vector<verify::AbstractValue> self(type_of(atom).variables.size());
    for (std::size_t k = 0; k < self.size(); ++k) {
      const DataVariable& variable = type_of(atom).variables[k];
      if (variable.is_param && variable.type != Type::Float && !is_ffi(variable.type))
        self[k] = verify::known(system_.atoms[atom].args[k].int_value);
    }
    const verify::AbstractValue value = verify::evaluate(system_.code, guard, self, {});
    if (!value.is_known) refuse("a guard that data decides", loc);
    return value.is_known && value.value != 0;
  }

  void add_atom(AtomId atom) {
    const AtomType& type = type_of(atom);
    if (!type.priorities.empty())
      return refuse(fmt::format("priorities of atom type `{}`", type.name), type.priorities[0].loc);
    if (!type.invariants.empty())
      return refuse(fmt::format("invariants of atom type `{}`", type.name), type.invariants[0].loc);
    const bool is_automaton = type.is_automaton();
    const bool has_internals = std::any_of(type.transitions.begin(), type.transitions.end(),
                                           [](const Transition& t) { return t.port == Transition::kInternal; });
    if (has_internals && !is_automaton)
      return refuse(fmt::format("internal transitions of `{}`, which is no automaton", type.name), type.loc);
    for (std::size_t k = 0; k < type.transitions.size(); ++k) {
      for (std::size_t j = 0; j < k; ++j) {
        const Transition &a = type.transitions[j], &b = type.transitions[k];
        const bool may_meet = a.port == b.port && (!is_automaton || a.from == b.from);
        if (may_meet && holds(atom, a.guard, a.loc) && holds(atom, b.guard, b.loc))
          refuse("two transitions that may be enabled at once, a run-time error", b.loc);
      }
    }
    std::vector<u32> initial;
    for (u32 place : type.initial) initial.push_back(settled(atom, place));
    BIP_ASSERT(initial.size() == type.initial.size() &&
                   std::all_of(initial.begin(), initial.end(),
                               [&](u32 place) { return place < type.places.size() || !refusal_.empty(); }),
               "atom {} begins at {} places", atom, initial.size());
    for (u32 place = 0; place < type.places.size(); ++place) {
      const bool is_marked = std::find(initial.begin(), initial.end(), place) != initial.end();
      places_ += fmt::format("      <place id=\"p{}_{}\"><name><text>{}.{}</text></name>{}</place>\n", atom.value,
                             place, plain_name(system_.atoms[atom].path), plain_name(type.places[place]),
                             is_marked ? "<initialMarking><text>1</text></initialMarking>" : "");
    }
  }

  // Where internal transitions lead.
  u32 settled(AtomId atom, u32 place) {
    const AtomType& type = type_of(atom);
    for (std::size_t round = 0; round <= type.places.size(); ++round) {
      u32 next = place;
      bool moves = false;
      for (const Transition& t : type.transitions) {
        if (t.port != Transition::kInternal || t.from[0] != place || !holds(atom, t.guard, t.loc)) continue;
        next = t.to[0];
        moves = true;
      }
      if (!moves) return place;
      place = next;
    }
    refuse(fmt::format("internal transitions of `{}` without end", type.name), type.loc);
    return place;
  }

  // Each choice of a transition of every port.
  void add_transitions(const std::string& name, const std::vector<PortOf>& ports) {
    std::vector<std::vector<const Transition*>> found{{}};
    for (const PortOf& port : ports) {
      std::vector<std::vector<const Transition*>> next;
      for (const Transition& t : type_of(port.atom).transitions) {
        if (t.port != port.port || !holds(port.atom, t.guard, t.loc)) continue;
        for (const auto& some : found) {
          next.push_back(some);
          next.back().push_back(&t);
        }
      }
      found = std::move(next);
      if (count_ + found.size() > options_.max_transitions)
        return refuse(
            fmt::format("more than {} transitions of the net (--max-size allows more)", options_.max_transitions));
    }
    for (const auto& some : found) {
      transitions_ +=
          fmt::format("      <transition id=\"t{}\"><name><text>{}</text></name></transition>\n", count_, name);
      for (std::size_t k = 0; k < ports.size(); ++k) {
        const u32 atom = ports[k].atom.value;
        for (u32 place : some[k]->from)
          arcs_ += fmt::format("      <arc id=\"a{}\" source=\"p{}_{}\" target=\"t{}\"/>\n", arc_count_++, atom, place,
                               count_);
        for (u32 place : some[k]->to)
          arcs_ += fmt::format("      <arc id=\"a{}\" source=\"t{}\" target=\"p{}_{}\"/>\n", arc_count_++, count_, atom,
                               settled(ports[k].atom, place));
      }
      ++count_;
    }
  }

  void add_connector(ConnectorId connector) {
    const std::string path = plain_name(system_.connectors[connector].path);
    Result<InteractionTree> tree = analysis::build_interaction_tree(system_, connector);
    if (!tree) return refuse(fmt::format("connector `{}`: {}", path, tree.error()));
    Result<std::vector<Leaves>> all = analysis::list_interactions(*tree, tree->uses[0].root, kMaxInteractions);
    if (!all) return refuse(fmt::format("connector `{}`: {}", path, all.error()));
    const bool prefers = std::any_of(all->begin(), all->end(), [&](const Leaves& leaves) {
      return std::any_of(all->begin(), all->end(), [&](const Leaves& other) {
        return leaves.size() < other.size() && std::includes(other.begin(), other.end(), leaves.begin(), leaves.end());
      });
    });
    const bool is_filtered = std::any_of(tree->nodes.begin(), tree->nodes.end(),
                                         [](const InteractionTree::Node& node) { return node.maximal_only; });
    if (prefers && (options_.maximal_progress || is_filtered)) {
      return refuse(fmt::format("connector `{}`, whose larger interactions go before smaller ones{}", path,
                                is_filtered ? "" : " (all have equal rights with `--disable-maximal-progress`)"));
    }
    for (const Leaves& leaves : *all) {
      const std::vector<std::uint8_t> chosen = analysis::chosen_nodes(*tree, leaves);
      bool is_allowed = true;
      for (const InteractionTree::Use& use : tree->uses) {
        const Clause* clause = chosen[use.root] != 0 ? analysis::chosen_clause(system_, use, chosen) : nullptr;
        if (clause == nullptr || !clause->guard.is_valid()) continue;
        const verify::AbstractValue value = verify::evaluate(system_.code, clause->guard, {}, {});
        if (!value.is_known) return refuse("a guard that data decides", clause->loc);
        is_allowed = is_allowed && value.value != 0;
      }
      std::vector<PortOf> ports;
      for (u32 leaf : leaves) ports.push_back({tree->nodes[leaf].atom, tree->nodes[leaf].port});
      if (is_allowed) add_transitions(path, ports);
    }
  }

  const System& system_;
  const Options& options_;
  std::string refusal_, places_, transitions_, arcs_;
  std::size_t count_ = 0, arc_count_ = 0;
};

}  // namespace

Result<std::string> pnml(const System& system, const Options& options) { return NetWriter(system, options).run(); }

}  // namespace bip::exchange
