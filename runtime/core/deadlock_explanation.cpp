// The wait-for graph of a deadlock. An atom that offers an exported port waits for the atoms whose ports are missing in
// the connectors of that port; what is missing in a group is found bottom up, once, and kept to a few names a group,
// which keeps the whole linear. See deadlock_explanation.hpp.
#include "runtime/core/deadlock_explanation.hpp"

#include <algorithm>

#include "runtime/core/graph_algorithms.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

namespace {

constexpr std::size_t kMissingKept = 4;  // names a group
constexpr std::size_t kWantsKept = 16;   // edges an atom
constexpr u32 kMetKept = 64;             // participants of the last step looked at
constexpr std::size_t kLinesShown = 10;
constexpr std::size_t kEndsShown = 8;     // components at either end of a cycle
constexpr std::size_t kCycleStarts = 32;  // places from which the shortest cycle is looked for

struct Want {
  u32 port = 0;         // of the waiting atom's type
  u32 missing = kNone;  // port instance that is not there; kNone: no connector binds the port
  bool held = false;    // by whom the atom met last: a fork waits for the one who took it
};

class DeadlockExplainer {
 public:
  explicit DeadlockExplainer(const Core& core) : core_(core), tables_(core.tables()), image_(core.image()) {
    look_at_connectors();
    look_at_atoms();
  }

  [[nodiscard]] std::vector<DeadlockWait> waits() const {
    std::vector<DeadlockWait> rows;
    for (const u32 atom : waiting_) {
      for (const Want& want : wants_[atom]) {
        DeadlockWait& row = rows.emplace_back(DeadlockWait{.atom = atom, .port = want.port});
        if (want.missing == kNone) continue;
        row.missing_atom = tables_.port_atom[want.missing];
        row.missing_port = want.missing - tables_.port_base(row.missing_atom);
      }
    }
    return rows;
  }

  /// Atoms, each waits for the next one: strong components, then breadth first within the smallest.
  std::vector<u32> shortest_cycle() {
    const u32 count = image_.atoms.size;
    WaitForGraph graph{tables_, wants_, std::vector<u32>(count, kNone), {}};
    StrongComponents<std::size_t> search;
    search.begin(count);
    for (u32 start = 0; start < count; ++start) search.visit(start, graph);
    const std::vector<u32>& part = graph.part;
    std::vector<std::vector<u32>>& parts = graph.parts;
    std::vector<u32> best;
    std::size_t starts = 0;
    std::vector<u32> seen(count, kNone), from(count, kNone);
    std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    for (const std::vector<u32>& members : parts) {
      for (u32 start : members) {
        if (wants_[start].empty() || starts >= kCycleStarts) break;
        std::vector<u32> queue{start};
        seen[start] = start;
        bool closed = false;
        for (std::size_t head = 0; head < queue.size() && !closed; ++head) {
          for (const Want& want : wants_[queue[head]]) {
            if (want.missing == kNone) continue;
            const u32 to = tables_.port_atom[want.missing];
            if (part[to] != part[start]) continue;
            if (to == start) {
              closed = true;
              std::vector<u32> cycle;
              for (u32 at = queue[head]; at != start; at = from[at]) cycle.push_back(at);
              cycle.push_back(start);
              std::reverse(cycle.begin(), cycle.end());
              if (best.empty() || cycle.size() < best.size()) best = std::move(cycle);
              break;
            }
            if (seen[to] == start) continue;
            seen[to] = start;
            from[to] = queue[head];
            queue.push_back(to);
          }
        }
        if (closed) ++starts;
      }
    }
    return best;
  }

  std::string text(std::uint64_t steps, std::uint64_t seed) {
    std::string tail = "   (";
    append_number(tail, steps);
    tail += steps == 1 ? " step, seed " : " steps, seed ";
    append_number(tail, seed);
    tail += ")\n";
    std::string out = "deadlock[V0001]: ";
    if (waiting_.empty() && guards_.empty()) {
      const std::string guards = false_guards();
      out += !listening_.empty() ? "no component offers a port, and no event waits"
             : guards.empty()    ? "no component offers a port: all have come to an end"
                                 : "no component offers a port: guards are false";
      return out + tail + guards + listeners();
    }
    const std::vector<u32> cycle = shortest_cycle();
    if (!cycle.empty()) {
      // What is merely held gets no line of its own, unless there is nothing else.
      std::vector<std::pair<u32, Want>> lines;
      for (const bool with_held : {false, true}) {
        if (!lines.empty()) break;
        for (std::size_t i = 0; i < cycle.size(); ++i) {
          const u32 next = cycle[(i + 1) % cycle.size()];
          for (const Want& want : wants_[cycle[i]]) {
            if (want.missing == kNone || tables_.port_atom[want.missing] != next) continue;
            if (with_held || !want.held) lines.emplace_back(cycle[i], want);
            break;
          }
        }
      }
      append_number(out, lines.size());
      out += (lines.size() == 1 ? " component waits for itself" : " components wait for each other") + tail;
      for (std::size_t i = 0; i < lines.size() && i < kLinesShown; ++i)
        append_wait(out, lines[i].first, lines[i].second);
      append_rest(out, lines.size());
      out += "  cycle: ";
      for (std::size_t i = 0; i < cycle.size(); ++i) {
        // Of a long way round the two ends say what it looks like.
        if (cycle.size() > 2 * kEndsShown && i == kEndsShown) {
          out += "… -> ";
          i = cycle.size() - kEndsShown;
        }
        out += relative(image_.atoms[cycle[i]].path().c_str()) + std::string(" -> ");
      }
      out += relative(image_.atoms[cycle[0]].path().c_str()) + std::string("\n");
      return out + listeners();
    }
    append_number(out, waiting_.size());
    out += (waiting_.size() == 1 ? " component waits in vain" : " components wait in vain") + tail;
    for (std::size_t i = 0; i < waiting_.size() && i < kLinesShown; ++i) {
      if (wants_[waiting_[i]].empty()) continue;
      append_wait(out, waiting_[i], wants_[waiting_[i]][0]);
    }
    append_rest(out, waiting_.size());
    for (std::size_t i = 0; i < guards_.size() && i < kLinesShown; ++i) {
      out += "  connector " + image_.connectors[guards_[i]].path() + ": " + why_no_candidate(guards_[i]);
      append_connector_data(out, guards_[i]);
      append_place(out, image_.connectors[guards_[i]].loc);
      out += '\n';
    }
    return out + listeners();
  }

 private:
  void append_rest(std::string& out, std::size_t count) const {
    if (count <= kLinesShown) return;
    out += "  … and ";
    append_number(out, count - kLinesShown);
    out += " more\n";
  }
  void append_place(std::string& out, SourceLine loc) const {
    if (loc.line == 0) return;
    out += "  ";
    append_line(out, image_, loc);
  }
  // "phil[0] at `has_left`"
  void append_atom(std::string& out, u32 atom) const {
    append_relative(out, image_.atoms[atom]);
    out += " at `" + places_of(core_, atom) + '`';
  }
  // Where the atom could go from here.
  [[nodiscard]] SourceLine way_out(u32 atom) const {
    for (const Transition& transition : tables_.atom_type(atom).transitions) {
      const bool leaves = std::all_of(transition.from.begin(), transition.from.end(),
                                      [&](u32 place) { return core_.is_marked(atom, place); });
      if (leaves) return transition.loc;
    }
    return image_.atoms[atom].loc;
  }
  void append_wait(std::string& out, u32 atom, const Want& want) const {
    const AtomType& type = tables_.atom_type(atom);
    out += "  ";
    append_atom(out, atom);
    const u32 row = core_.enabled_transition(atom, want.port);
    append_place(out, row == kNone ? SourceLine{} : type.transitions[row].loc);
    out += std::string("   wants ") + type.ports[want.port].name;
    if (want.missing == kNone) {
      out += bound_[tables_.instance(atom, want.port)] ? ", which is ready" : ", which no connector binds";
    } else {
      const u32 other = tables_.port_atom[want.missing];
      out += "  <- ";
      append_atom(out, other);
      append_place(out, way_out(other));
      append_guard_data(out, other, want.missing - tables_.port_base(other));
    }
    out += '\n';
  }
  // Is a guard all that keeps a transition from being taken?
  [[nodiscard]] bool is_kept_by_guard(u32 atom, const Transition& t) const {
    return t.guard != kNone &&
           std::all_of(t.from.begin(), t.from.end(), [&](u32 place) { return core_.is_marked(atom, place); });
  }
  // "  a at `S`  m.bip:9: the guard of go is false (n = 2)": of each component, where none offers a port.
  [[nodiscard]] std::string false_guards() const {
    std::string out;
    std::size_t count = 0;
    for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
      const AtomType& type = tables_.atom_type(atom);
      if (type.time != nullptr) continue;
      for (const Transition& t : type.transitions) {
        if (t.port >= type.ports.size || !is_kept_by_guard(atom, t)) continue;
        if (count++ < kLinesShown) {
          out += "  ";
          append_atom(out, atom);
          append_place(out, t.loc);
          append_guard_data(out, atom, t.port);
          out += '\n';
        }
        break;
      }
    }
    append_rest(out, count);
    return out;
  }
  // ": its guard is false (n = 6, square = 36)", where a guard is all that keeps the port from being offered.
  void append_guard_data(std::string& out, u32 atom, u32 port) const {
    const AtomType& type = tables_.atom_type(atom);
    const bool is_guarded = std::any_of(type.transitions.begin(), type.transitions.end(), [&](const Transition& t) {
      return t.port == port && is_kept_by_guard(atom, t);
    });
    if (!is_guarded || type.time != nullptr) return;
    out += std::string(": the guard of ") + type.ports[port].name + " is false";
    if (const std::string data = data_of(core_, atom); !data.empty()) out += " (" + data + ")";
  }

  // Of a connector whose ports are available.
  [[nodiscard]] std::string why_no_candidate(u32 connector) const {
    const u32 plan = tables_.interactions[tables_.interaction_of(connector)].plan();
    const bool has_inner_rules = plan != kNone && !tables_.plans[plan].witnesses.empty();
    return has_inner_rules ? "a guard is false, or a priority hides what it binds" : "its guard is false";
  }

  // " (left: level = 3; right: level = 4)": data of the components that the connector binds itself.
  void append_connector_data(std::string& out, u32 connector) const {
    std::vector<u32> atoms;
    for (const DefineNode& node : tables_.connector_type(connector).define) {
      if (!node.is_leaf) continue;
      const PortRef& ref = tables_.port_ref(connector, node.param);
      if (ref.choice == kNone && ref.atom != kNone && std::find(atoms.begin(), atoms.end(), ref.atom) == atoms.end())
        atoms.push_back(ref.atom);
    }
    std::string all;
    for (std::size_t i = 0; i < atoms.size() && i < kMissingKept; ++i) {
      const bool has_time = tables_.atom_type(atoms[i]).time != nullptr;
      const std::string data = has_time ? std::string() : data_of(core_, atoms[i]);
      if (data.empty()) continue;
      all += all.empty() ? " (" : "; ";
      append_relative(all, image_.atoms[atoms[i]]);
      all += ": " + data;
    }
    if (!all.empty()) out += all + ')';
  }

  // What is available, and what is missing where it is not; connectors come after those they are bound to.
  void look_at_connectors() {
    std::vector<Csr::Pair> up_port, up_connector;
    bound_.assign(tables_.port_atom.size(), false);
    for (u32 connector = 0; connector < image_.connectors.size; ++connector) {
      const ConnectorType& type = tables_.connector_type(connector);
      first_node_.push_back(static_cast<u32>(available_.size()));
      const u32 base = first_node_.back();
      available_.resize(base + type.define.size, false);
      missing_.resize(base + type.define.size);
      above_.resize(base + type.define.size, kNone);
      for (u32 i = type.define.size; i-- > 0;) look_at_node(connector, type, base, i, up_port, up_connector);
      if (available_[base] && !type.exports && core_.search().listed_count(connector) == 0)
        guards_.push_back(connector);
    }
    up_port_ = Csr::build(tables_.port_atom.size(), up_port);
    up_connector_ = Csr::build(image_.connectors.size, up_connector);
    connector_of_.resize(available_.size());
    for (u32 connector = 0; connector < image_.connectors.size; ++connector) {
      for (u32 i = 0; i < tables_.connector_type(connector).define.size; ++i)
        connector_of_[first_node_[connector] + i] = connector;
    }
  }
  void look_at_node(u32 connector, const ConnectorType& type, u32 base, u32 i, std::vector<Csr::Pair>& up_port,
                    std::vector<Csr::Pair>& up_connector) {
    const DefineNode& node = type.define[i];
    if (node.is_leaf) {
      const PortRef& ref = tables_.port_ref(connector, node.param);
      if (ref.choice != kNone) {
        look_at_choice(image_.choices[ref.choice], base + i, up_port, up_connector);
      } else if (ref.atom != kNone) {
        const u32 instance = tables_.instance(ref.atom, ref.port);
        up_port.push_back({instance, base + i});
        bound_[instance] = true;
        available_[base + i] = core_.enabled_transition(ref.atom, ref.port) != kNone;
        if (!available_[base + i]) missing_[base + i].push_back(instance);
      } else {
        const u32 below = first_node_[ref.connector];
        up_connector.push_back({ref.connector, base + i});
        available_[base + i] = available_[below];
        missing_[base + i] = missing_[below];
      }
      return;
    }
    bool any_trigger = false, ready_trigger = false, all = true;
    for (u32 child : node.children) {
      above_[base + child] = base + i;
      any_trigger |= type.define[child].trigger;
      ready_trigger |= type.define[child].trigger && available_[base + child];
      all &= available_[base + child];
    }
    available_[base + i] = any_trigger ? ready_trigger : all;
    if (available_[base + i]) return;
    for (u32 child : node.children) {
      if (any_trigger && !type.define[child].trigger) continue;
      for (u32 instance : missing_[base + child]) {
        if (missing_[base + i].size() < kMissingKept) missing_[base + i].push_back(instance);
      }
    }
  }

  // A merged port misses what each of its ports misses.
  void look_at_choice(const Choice& choice, u32 row, std::vector<Csr::Pair>& up_port,
                      std::vector<Csr::Pair>& up_connector) {
    for (const PortRef& ref : choice.ports) {
      if (ref.atom != kNone) {
        const u32 instance = tables_.instance(ref.atom, ref.port);
        up_port.push_back({instance, row});
        bound_[instance] = true;
        const bool enabled = core_.enabled_transition(ref.atom, ref.port) != kNone;
        available_[row] = available_[row] || enabled;
        if (!enabled && missing_[row].size() < kMissingKept) missing_[row].push_back(instance);
      } else {
        const u32 below = first_node_[ref.connector];
        up_connector.push_back({ref.connector, row});
        available_[row] = available_[row] || available_[below];
        for (u32 instance : missing_[below]) {
          if (missing_[row].size() < kMissingKept) missing_[row].push_back(instance);
        }
      }
    }
    if (available_[row]) missing_[row].clear();
  }

  void look_at_atoms() {
    wants_.resize(image_.atoms.size);
    last_interactions_ = core_.history().last_of_atoms(core_.tables());
    for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
      const AtomType& type = tables_.atom_type(atom);
      bool offers = false;
      for (u32 port = 0; port < type.ports.size; ++port) {
        if (!type.ports[port].exported || core_.enabled_transition(atom, port) == kNone) continue;
        offers = true;
        add_wants(atom, port);
      }
      if (offers) waiting_.push_back(atom);
      prefer_holders(atom);
    }
    for (const EventPortRow& row : core_.events().ports()) {
      if (takes_from_here(row.atom, row.port) && (listening_.empty() || listening_.back() != row.atom))
        listening_.push_back(row.atom);
    }
  }
  // Leaves a transition of the port what is marked?
  [[nodiscard]] bool takes_from_here(u32 atom, u32 port) const {
    for (const Transition& transition : tables_.atom_type(atom).transitions) {
      if (transition.port != port) continue;
      if (std::all_of(transition.from.begin(), transition.from.end(),
                      [&](u32 place) { return core_.is_marked(atom, place); }))
        return true;
    }
    return false;
  }
  // Whom an event might wake: "  panel at `IDLE`  panel.bip:21   takes events at press, turn".
  [[nodiscard]] std::string listeners() const {
    std::string out;
    for (std::size_t i = 0; i < listening_.size() && i < kLinesShown; ++i) {
      const u32 atom = listening_[i];
      out += "  ";
      append_atom(out, atom);
      const char* before = "   takes events at ";
      for (const EventPortRow& row : core_.events().ports()) {
        if (row.atom != atom || !takes_from_here(atom, row.port)) continue;
        out += before;
        out += tables_.atom_type(atom).ports[row.port].name;
        before = ", ";
      }
      out += '\n';
    }
    append_rest(out, listening_.size());
    return out;
  }
  // Of several that could release the atom, the one it met last is the one that has it.
  void prefer_holders(u32 atom) {
    const InteractionId interaction = last_interactions_[atom];
    if (!interaction.is_valid() || !tables_.is_of_connector(interaction)) return;
    const InteractionInfo& info = tables_.interactions[interaction];
    std::vector<u32> met;
    for (u32 i = 0; i < std::min(info.count, kMetKept); ++i)
      met.push_back(tables_.port_atom[tables_.flat_ports[info.first + i]]);
    if (info.plan() != kNone) {
      const Plan& plan = tables_.plans[info.plan()];
      for (u32 i = 0; i < std::min(plan.node_count, kMetKept); ++i) {
        const PlanNode& node = tables_.plan_nodes[plan.first_node + i];
        if (node.kind == NodeKind::Leaf) met.push_back(tables_.port_atom[node.ref]);
      }
    }
    std::vector<Want> held;
    for (Want want : wants_[atom]) {
      if (want.missing == kNone || std::find(met.begin(), met.end(), tables_.port_atom[want.missing]) == met.end())
        continue;
      want.held = true;
      held.push_back(want);
    }
    if (!held.empty()) wants_[atom] = std::move(held);
  }
  void add_wants(u32 atom, u32 port) {
    std::vector<Want>& wants = wants_[atom];
    const u32 instance = tables_.instance(atom, port);
    const std::size_t before = wants.size();
    std::vector<u32> todo(up_port_[instance].begin(), up_port_[instance].end());
    while (!todo.empty() && wants.size() < kWantsKept) {
      const u32 node = todo.back();
      todo.pop_back();
      const u32 group = above_[node];
      if (group != kNone) {
        for (u32 missing : missing_[group]) {
          // A connector of two ports of the atom itself: it takes one of them, and waits for others at most.
          if (tables_.port_atom[missing] == atom) continue;
          if (wants.size() < kWantsKept) wants.push_back({port, missing});
        }
        todo.push_back(group);
      } else {
        const Span<u32> up = up_connector_[connector_of_[node]];
        todo.insert(todo.end(), up.begin(), up.end());
      }
    }
    if (wants.size() == before) wants.push_back({port, kNone});
  }

  // Enumerates the atoms that an atom waits for; keeps the components.
  struct WaitForGraph {
    const Tables& tables;
    const std::vector<std::vector<Want>>& wants;  // by atom
    std::vector<u32> part;                        // by atom
    std::vector<std::vector<u32>> parts;

    std::size_t enter(u32) { return 0; }
    u32 next(u32 atom, std::size_t& edge) {
      while (edge < wants[atom].size()) {
        const u32 missing = wants[atom][edge++].missing;
        if (missing != kNone) return tables.port_atom[missing];
      }
      return kNoSuccessor;
    }
    void reach(u32, u32) {}
    void close(const u32* members, std::size_t count) {
      for (std::size_t k = 0; k < count; ++k) part[members[k]] = static_cast<u32>(parts.size());
      parts.emplace_back(members, members + count);
      std::sort(parts.back().begin(), parts.back().end());
    }
  };

  const Core& core_;
  const Tables& tables_;
  const Image& image_;
  std::vector<u32> first_node_;                   // by connector
  std::vector<bool> available_;                   // by (connector, define node)
  std::vector<std::vector<u32>> missing_;         // the same: port instances
  std::vector<u32> above_;                        // the same: its group
  std::vector<u32> connector_of_;                 // the same
  Csr up_port_, up_connector_;                    // leaves that a port, a connector is bound by
  std::vector<bool> bound_;                       // by port instance
  std::vector<std::vector<Want>> wants_;          // by atom
  std::vector<InteractionId> last_interactions_;  // by atom
  std::vector<u32> waiting_;                      // atoms that offer a port
  std::vector<u32> guards_;                       // connectors that only guards keep from acting
  std::vector<u32> listening_;                    // atoms whose places let them take events from outside
};

}  // namespace

std::string deadlock_story(const Core& core, std::uint64_t steps, std::uint64_t seed) {
  return DeadlockExplainer(core).text(steps, seed);
}

DeadlockWaits deadlock_waits(const Core& core) {
  DeadlockExplainer explainer(core);
  return {explainer.waits(), explainer.shortest_cycle()};
}

std::vector<u32> deadlock_cycle(const Core& core) { return DeadlockExplainer(core).shortest_cycle(); }

}  // namespace bip::rt
