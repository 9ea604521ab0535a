// Cycles of an atom type's priorities. Rules without guards that close one are an error; rules of which only guards may
// keep one open are a warning, for then it is a fault of the run (R0010).
//
// Depth first over the ports, each rule an edge, a wildcard one for every port: linear in these edges.
#include <algorithm>

#include "compiler/model/model_builder.hpp"
#include "runtime/core/graph_algorithms.hpp"

namespace bip::model {

namespace {

struct Edge {
  std::uint32_t high = 0, rule = 0;
};
using Edges = std::vector<std::vector<Edge>>;  // by lower port

enum class Rules : std::uint8_t { Unguarded, All };

Edges edges_of(const AtomType& atom, Rules rules, const std::vector<bool>& left_out) {
  Edges edges(atom.ports.size());
  const auto count = static_cast<std::uint32_t>(atom.ports.size());
  for (std::uint32_t row = 0; row < atom.priorities.size(); ++row) {
    const AtomPriority& rule = atom.priorities[row];
    if ((rule.guard.is_valid() && rules == Rules::Unguarded) || left_out[row]) continue;
    for (std::uint32_t port = 0; port < count; ++port) {
      if (rule.low == AtomPriority::kAnyPort && port != rule.high) edges[port].push_back({rule.high, row});
      if (rule.high == AtomPriority::kAnyPort && port != rule.low) edges[rule.low].push_back({port, row});
      if (rule.low == port && rule.high != AtomPriority::kAnyPort) edges[port].push_back({rule.high, row});
    }
  }
  return edges;
}

// The edges of some cycle, in their order; empty if there is none.
std::vector<Edge> first_cycle(const Edges& edges) {
  const auto enter = [](std::uint32_t) { return std::size_t{0}; };
  const auto next = [&](std::uint32_t port, std::size_t& at) {
    return at == edges[port].size() ? kNoSuccessor : edges[port][at++].high;
  };
  std::vector<Edge> cycle;
  for (const auto& [port, after] :
       find_cycle(static_cast<std::uint32_t>(edges.size()), enter, next, [](auto, auto) { return true; }))
    cycle.push_back(edges[port][after - 1]);
  return cycle;
}

std::string cycle_text(const AtomType& atom, const std::vector<Edge>& cycle) {
  std::string text = fmt::format("`{}`", atom.ports[cycle.back().high].name);
  for (const Edge& edge : cycle) text += fmt::format(" < `{}`", atom.ports[edge.high].name);
  return text;
}

void report_cycle(ModelBuilder& b, const AtomType& atom, const syntax::Decl& decl, const std::vector<Edge>& cycle,
                  bool sure) {
  // Rules and their declarations have the same rows: check_atom stops at errors before.
  const std::uint32_t last = cycle.back().rule;
  auto d = b.diags.report(sure ? Diag::kB3010 : Diag::kB3009, decl.atom_priorities[last].range, atom.name,
                          cycle_text(atom, cycle));
  std::vector<bool> labelled(atom.priorities.size());
  labelled[last] = true;
  for (const Edge& edge : cycle) {
    if (!labelled[edge.rule]) d.label(decl.atom_priorities[edge.rule].range, "");
    labelled[edge.rule] = true;
  }
  if (!sure)
    d.help("write guards that exclude each other, or `@SuppressWarning(atomprioritycycle)` before the atom type");
}

}  // namespace

// Without the rule that closes a cycle there may be others: all are reported.
void check_atom_priorities(ModelBuilder& b, const AtomType& atom, const syntax::Decl& decl) {
  std::vector<bool> told(atom.priorities.size());
  const bool sure = !first_cycle(edges_of(atom, Rules::Unguarded, told)).empty();
  if (!sure && is_suppressed(decl.annotations, "atomprioritycycle")) return;
  for (;;) {
    const std::vector<Edge> cycle = first_cycle(edges_of(atom, sure ? Rules::Unguarded : Rules::All, told));
    if (cycle.empty()) return;
    report_cycle(b, atom, decl, cycle, sure);
    told[cycle.back().rule] = true;
  }
}

const MergedPort* merged_with(const AtomType& atom, std::uint32_t port) {
  for (const MergedPort& merged : atom.merged) {
    if (std::find(merged.ports.begin(), merged.ports.end(), port) != merged.ports.end()) return &merged;
  }
  return nullptr;
}

}  // namespace bip::model
