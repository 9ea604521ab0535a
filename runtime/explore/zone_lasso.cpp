// A response without a limit of time: is there a run in which a request waits for ever while time goes on?
//
// Either time passes for ever after the last step: in a node that no instant has to end. Or steps follow for ever, and
// time does: a cycle of nodes of which the same request waits, with a step that is *later*. At a later step the
// observer's clock has reached Locations::in_time, and it begins again; any step at which it has may be later or not,
// so the runs with infinitely many later steps are those in which time diverges (Tripakis, Yovine, Bouajjani 2005). The
// amount is a divisor of the model's constants: with another one, say a tick, clocks would creep by it from round to
// round, and the graph would be as large as the constants. A cycle of nodes is one of runs as long as nodes are joined
// only if they are equal, not if one includes the other (Li 2009: Extra_LU preserves emptiness; Laarman et al. 2013).
// An action that may return at infinitely many instants returns.
#include <algorithm>
#include <map>

#include "bip/assert.hpp"
#include "runtime/core/graph_algorithms.hpp"
#include "runtime/explore/heap_bytes.hpp"
#include "runtime/explore/zone_search.hpp"

namespace bip::rt {

namespace {

// Arcs by the node that they leave, and the strong components of the nodes.
struct ArcGraph {
  const std::vector<ZoneArc>& arcs;
  std::vector<u32> first;  // by node, and the end
  std::vector<u32> component;
  std::vector<std::vector<u32>> members;  // by component

  ArcGraph(const std::vector<ZoneArc>& all, std::size_t nodes) : arcs(all), first(nodes + 1, 0), component(nodes, 0) {
    BIP_ASSERT(std::is_sorted(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.from < b.from; }),
               "nodes are expanded in their order");
    for (const ZoneArc& arc : all) ++first[arc.from + 1];
    for (std::size_t node = 0; node < nodes; ++node) first[node + 1] += first[node];
    StrongComponents<u32> search;
    search.begin(nodes);
    for (const ZoneArc& arc : all) search.visit(arc.from, *this);
  }
  // As StrongComponents asks.
  u32 enter(u32 node) { return first[node]; }
  u32 next(u32 node, u32& arc) { return arc < first[node + 1] ? arcs[arc++].to : kNoSuccessor; }
  void reach(u32, u32) {}
  void close(const u32* nodes, std::size_t size) {
    for (std::size_t k = 0; k < size; ++k) component[nodes[k]] = static_cast<u32>(members.size());
    members.emplace_back(nodes, nodes + size);
  }

  [[nodiscard]] bool is_on_cycle(const ZoneArc& arc) const { return component[arc.from] == component[arc.to]; }
  // The fewest arcs from a node to another one of its component; none, if they are the same.
  void append_path(std::vector<u32>& walk, u32 from, u32 to) const {
    std::vector<u32> by(component.size(), kNone), queue{from};
    for (std::size_t head = 0; head < queue.size() && by[to] == kNone && from != to; ++head) {
      for (u32 arc = first[queue[head]]; arc < first[queue[head] + 1]; ++arc) {
        if (by[arcs[arc].to] != kNone || !is_on_cycle(arcs[arc])) continue;
        by[arcs[arc].to] = arc;
        queue.push_back(arcs[arc].to);
      }
    }
    const std::size_t begin = walk.size();
    for (u32 node = to; node != from; node = arcs[by[node]].from) {
      BIP_ASSERT(by[node] != kNone, "node {} does not lead to node {}", from, to);
      walk.push_back(by[node]);
    }
    std::reverse(walk.begin() + static_cast<std::ptrdiff_t>(begin), walk.end());
  }
};

}  // namespace

// A node is entered, or one that is equal is there already.
void ZoneSearch::note_arc(const ZoneNode& to, u32 row) {
  if (to.parent == kNone || to.is_requested || !locations_[nodes_[to.parent].location].observed.is_pending) return;
  arcs_.push_back({to.parent, row, to.edge, to.is_later, to.interaction, to.config, to.origin});
  node_bytes_ += sizeof(ZoneArc) + heap_bytes(to.origin);
}

void ZoneSearch::enter_later(u32 location, const Zone& zone, const ZoneNode& label) {
  const ZoneBound& reached = locations_.in_time();
  Zone later = zone;
  if (!later.meet({0, reached.i, -reached.limit})) return;
  later.set_clock(reached.i, 0);
  ZoneNode node = label;
  node.is_later = true;
  enter(location, std::move(later), std::move(node));
}

bool ZoneSearch::find_idle(u32 node) {
  const ZoneNode& at = nodes_[node];
  if (!is_without_limit() || !locations_[at.location].observed.is_pending) return false;
  // A run that ends in an error is not looked at: where guards fault has been cut, or the search begins anew.
  // An action that may return does so some time.
  if (at.is_still || at.is_faulty || at.is_waking || !at.zone.is_unbounded()) return false;
  std::vector<i64> point = at.zone.least_point();
  if (!enter_core(locations_[at.location], point)) {
    locations_.cut_by_all();
    return false;
  }
  match_ = {};
  match_.node = node;
  match_.point = std::move(point);
  match_.is_far = match_.is_idle = true;
  return true;
}

// Is the atom busy, and may it go on?
bool ZoneSearch::may_go_on(u32 node, u32 atom) {
  const Location& at = locations_[nodes_[node].location];
  return at.waits[atom] != kNone && std::any_of(at.groups.begin(), at.groups.end(), [&](const WaitGroup& group) {
           return group.leader == at.leaders[atom] && wakes(group, nodes_[node].zone);
         });
}

// Now and then, and when the search has ended, also at a limit: what was found is there.
void ZoneSearch::find_lasso() {
  if (!is_without_limit() || match_.node != kNone || !report_.inexact.empty()) return;
  report_.has_standing_cycle = false;
  const ArcGraph graph(arcs_, nodes_.size());
  // By component: has it a later step; of which atom does the action never return, though it may?
  std::vector<std::uint8_t> has_later(graph.members.size(), 0);
  refused_.assign(graph.members.size(), kNone);
  for (const ZoneArc& arc : arcs_) {
    if (graph.is_on_cycle(arc) && arc.is_later) has_later[graph.component[arc.from]] = 1;
  }
  for (u32 arc = 0; arc < arcs_.size(); ++arc) {
    const u32 start = arcs_[arc].from, component = graph.component[start];
    if (!graph.is_on_cycle(arcs_[arc])) continue;
    if (has_later[component] == 0) report_.has_standing_cycle = true;
    if (!arcs_[arc].is_later || refused_[component] != kNone) continue;
    std::vector<u32> walk{arc};
    for (u32 atom = 0; atom < image_.atoms.size && refused_[component] == kNone; ++atom) {
      const auto returns = [&](u32 node) { return !may_go_on(node, atom); };
      if (std::any_of(walk.begin(), walk.end(), [&](u32 taken) { return returns(arcs_[taken].from); })) continue;
      const std::vector<u32>& nodes = graph.members[component];
      const auto found = std::find_if(nodes.begin(), nodes.end(), returns);
      if (found == nodes.end()) refused_[component] = atom;
      else graph.append_path(walk, arcs_[walk.back()].to, *found);
    }
    if (refused_[component] != kNone) {
      if (!options_.is_stopped || !options_.is_stopped()) continue;
      // Other cycles were not looked at.
      report_.end = ExploreEnd::Stopped;
      return;
    }
    graph.append_path(walk, arcs_[walk.back()].to, start);
    match_ = {};
    match_.node = start;
    match_.point = nodes_[start].zone.least_point();
    match_.is_state = true;
    match_.arcs = std::move(walk);
    return;
  }
}

// The most later steps on a way from the node, of which no cycle has one; but the cycles of a component in which an
// action never returns have a rank of their own.
std::vector<u32> ZoneSearch::ranks(ZoneReport& report) const {
  const ArcGraph graph(arcs_, nodes_.size());
  BIP_ASSERT(graph.members.size() == refused_.size(), "{} components, {} of them judged", graph.members.size(),
             refused_.size());
  // Components are numbered from the last ones on.
  std::vector<std::pair<u32, u32>> levels(graph.members.size());
  std::map<std::pair<u32, u32>, u32> rank_of_level;
  for (u32 component = 0; component < graph.members.size(); ++component) {
    u32 level = 0;
    for (const u32 node : graph.members[component]) {
      for (u32 arc = graph.first[node]; arc < graph.first[node + 1]; ++arc) {
        const u32 to = graph.component[arcs_[arc].to];
        BIP_ASSERT(to <= component, "component {} leads to component {}", component, to);
        const bool is_lower = arcs_[arc].is_later || refused_[component] != kNone || refused_[to] != kNone;
        if (to != component) level = std::max(level, levels[to].first + (is_lower ? 1 : 0));
      }
    }
    levels[component] = {level, refused_[component] == kNone ? 0 : component + 1};
    rank_of_level[levels[component]] = 0;
  }
  u32 count = 0;
  for (auto& [level, rank] : rank_of_level) rank = count++;
  std::vector<u32> ranks(nodes_.size(), 0);
  report.later = locations_.in_time().limit;
  report.returning.clear();
  for (u32 component = 0; component < graph.members.size(); ++component) {
    const u32 rank = rank_of_level[levels[component]];
    for (const u32 node : graph.members[component]) ranks[node] = rank;
    if (refused_[component] != kNone) report.returning.emplace_back(rank, refused_[component]);
  }
  return ranks;
}

}  // namespace bip::rt
