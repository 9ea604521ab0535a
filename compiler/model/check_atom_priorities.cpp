// Cycles of an atom type's priorities. Rules without guards that close one are an error; rules of which only guards may
// keep one open are a warning, for then it is a fault of the run (R0010).
//
// Depth first over the ports, each rule an edge, a wildcard one for every port: linear in these edges.
#include <algorithm>

#include "compiler/model/model_builder.hpp"

namespace bip::model {

namespace {

struct Edge {
  std::uint32_t high = 0, rule = 0;
};
using Edges = std::vector<std::vector<Edge>>;  // by lower port

Edges edges_of(const AtomType& atom, bool with_guards) {
  Edges edges(atom.ports.size());
  const auto count = static_cast<std::uint32_t>(atom.ports.size());
  for (std::uint32_t row = 0; row < atom.priorities.size(); ++row) {
    const AtomPriority& rule = atom.priorities[row];
    if (rule.guard.is_valid() && !with_guards) continue;
    for (std::uint32_t port = 0; port < count; ++port) {
      if (rule.low == AtomPriority::kAnyPort && port != rule.high) edges[port].push_back({rule.high, row});
      if (rule.high == AtomPriority::kAnyPort && port != rule.low) edges[rule.low].push_back({port, row});
      if (rule.low == port && rule.high != AtomPriority::kAnyPort) edges[port].push_back({rule.high, row});
    }
  }
  return edges;
}

// The edges of some cycle, in their order; empty if there is none.
std::vector<Edge> find_cycle(const Edges& edges) {
  enum class State : std::uint8_t { New, Open, Done };
  std::vector<State> states(edges.size(), State::New);
  struct Frame {
    std::uint32_t port;
    std::size_t next = 0;
  };
  std::vector<Frame> path;
  for (std::uint32_t start = 0; start < edges.size(); ++start) {
    if (states[start] != State::New) continue;
    path.push_back({start});
    states[start] = State::Open;
    while (!path.empty()) {
      Frame& top = path.back();
      if (top.next == edges[top.port].size()) {
        states[top.port] = State::Done;
        path.pop_back();
        continue;
      }
      const Edge edge = edges[top.port][top.next++];
      if (states[edge.high] == State::New) {
        states[edge.high] = State::Open;
        path.push_back({edge.high});
      } else if (states[edge.high] == State::Open) {
        std::vector<Edge> cycle;
        const auto first = std::find_if(path.begin(), path.end(), [&](const Frame& f) { return f.port == edge.high; });
        for (auto it = first; it != path.end(); ++it) cycle.push_back(edges[it->port][it->next - 1]);
        return cycle;
      }
    }
  }
  return {};
}

std::string cycle_text(const AtomType& atom, const std::vector<Edge>& cycle) {
  std::string text = fmt::format("`{}`", atom.ports[cycle.back().high].name);
  for (const Edge& edge : cycle) text += fmt::format(" < `{}`", atom.ports[edge.high].name);
  return text;
}

}  // namespace

void check_atom_priorities(ModelBuilder& b, const AtomType& atom, const syntax::Decl& decl) {
  std::vector<Edge> cycle = find_cycle(edges_of(atom, false));
  const bool sure = !cycle.empty();
  if (!sure) cycle = find_cycle(edges_of(atom, true));
  if (cycle.empty() || (!sure && is_suppressed(decl.annotations, "atomprioritycycle"))) return;
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

const MergedPort* merged_with(const AtomType& atom, std::uint32_t port) {
  for (const MergedPort& merged : atom.merged) {
    if (std::find(merged.ports.begin(), merged.ports.end(), port) != merged.ports.end()) return &merged;
  }
  return nullptr;
}

}  // namespace bip::model
