// See why_not.hpp. Guards are evaluated on a copy of their atom's variables; nothing else runs code of the model.
#include "runtime/core/why_not.hpp"

#include <algorithm>
#include <vector>

#include "runtime/core/text.hpp"

namespace bip::rt {

namespace {

constexpr std::size_t kMostLines = 20;  // of missing ports

class WhyNot {
 public:
  explicit WhyNot(const Core& core) : core_(core), tables_(core.tables()), image_(core.image()) {}

  std::string of_connector(u32 connector) {
    const ConnectorType& type = tables_.connector_type(connector);
    const std::string path = relative(image_.connectors[connector].path().c_str());
    if (type.exports && !image_.connectors[connector].bound)
      return path + " is never possible: it exports a port that no connector binds\n";
    if (!is_available(connector, 0)) {
      std::string out = path + " is not possible:\n";
      missing_in(out, connector, 0);
      if (lines_ > kMostLines) out += "  … and " + std::to_string(lines_ - kMostLines) + " more ports\n";
      return out;
    }
    if (type.exports) return path + " offers its port: the connectors that bind it decide\n";
    const InteractionId interaction = tables_.interaction_of(connector);
    if (core_.enabled().weight(interaction) != 0) return path + " is possible\n";
    if (core_.search().listed_count(connector) == 0) return path + " is not possible:\n" + false_guards(connector);
    return path + " is not possible:\n" + hiding_rules(interaction);
  }

  std::string of_port(u32 atom, u32 port) {
    std::string out;
    append_relative(out, image_.atoms[atom]);
    out += std::string(".") + tables_.atom_type(atom).ports[port].name;
    if (core_.enabled_transition(atom, port) != kNone) return out + " is enabled\n";
    out += " is not enabled:\n";
    missing_port(out, atom, port);
    return out;
  }

 private:
  [[nodiscard]] bool is_enabled(const PortRef& ref) const {
    if (ref.choice != kNone) {
      const Span<PortRef>& ports = image_.choices[ref.choice].ports;
      return std::any_of(ports.begin(), ports.end(), [this](const PortRef& port) { return is_enabled(port); });
    }
    return ref.atom != kNone ? core_.enabled_transition(ref.atom, ref.port) != kNone : is_available(ref.connector, 0);
  }
  // By ports alone; guards of connectors come after.
  [[nodiscard]] bool is_available(u32 connector, u32 node) const {
    const DefineNode& row = tables_.connector_type(connector).define[node];
    if (row.is_leaf) return is_enabled(tables_.port_ref(connector, row.param));
    bool any_trigger = false, ready_trigger = false, all = true;
    for (const u32 child : row.children) {
      const bool is_ready = is_available(connector, child);
      const bool is_trigger = tables_.connector_type(connector).define[child].trigger;
      any_trigger |= is_trigger;
      ready_trigger |= is_trigger && is_ready;
      all &= is_ready;
    }
    return any_trigger ? ready_trigger : all;
  }

  void missing_in(std::string& out, u32 connector, u32 node) {
    const DefineNode& row = tables_.connector_type(connector).define[node];
    if (row.is_leaf) return missing_ref(out, tables_.port_ref(connector, row.param));
    const auto is_trigger = [&](u32 child) { return tables_.connector_type(connector).define[child].trigger; };
    const bool any_trigger = std::any_of(row.children.begin(), row.children.end(), is_trigger);
    for (const u32 child : row.children) {
      if ((any_trigger && !is_trigger(child)) || is_available(connector, child)) continue;
      missing_in(out, connector, child);
    }
  }
  void missing_ref(std::string& out, const PortRef& ref) {
    if (ref.choice != kNone) {
      for (const PortRef& port : image_.choices[ref.choice].ports) missing_ref(out, port);
    } else if (ref.atom != kNone) {
      missing_port(out, ref.atom, ref.port);
    } else {
      missing_in(out, ref.connector, 0);
    }
  }

  void missing_port(std::string& out, u32 atom, u32 port) {
    if (lines_++ >= kMostLines) return;
    const AtomType& type = tables_.atom_type(atom);
    std::string head = "  ";
    append_relative(head, image_.atoms[atom]);
    head += std::string(".") + type.ports[port].name + ": ";
    if (core_.actions().is_at_work(atom)) {
      out += head + "its component is at work\n";
      return;
    }
    if (core_.is_timed() && core_.time().busy_until(atom) > core_.now()) {
      out += head + "its component is busy";
      if (core_.time().busy_until(atom) != kForever) {
        out += " until ";
        append_time(out, core_.time().busy_until(atom));
      }
      out += '\n';
      return;
    }
    bool leaves_from_here = false;
    std::string elsewhere;
    for (u32 row = 0; row < type.transitions.size; ++row) {
      const Transition& transition = type.transitions[row];
      if (transition.port != port) continue;
      const bool is_marked = std::all_of(transition.from.begin(), transition.from.end(),
                                         [&](u32 place) { return core_.is_marked(atom, place); });
      if (!is_marked) {
        for (const u32 place : transition.from) {
          const std::string name = std::string("`") + type.places[place] + '`';
          if (core_.is_marked(atom, place) || elsewhere.find(name) != std::string::npos) continue;
          elsewhere += (elsewhere.empty() ? "" : ", ") + name;
        }
        continue;
      }
      leaves_from_here = true;
      out += head + why_not_transition(atom, port, row);
      append_place(out, transition.loc);
      out += '\n';
    }
    if (leaves_from_here) return;
    out += head + "the component is at `" + places_of(core_, atom) + "`, ";
    out += elsewhere.empty() ? "and no transition has this port" : "the port leaves from " + elsewhere;
    append_place(out, type.ports[port].loc);
    out += '\n';
  }
  // Of one whose places are marked, and whose port is disabled.
  [[nodiscard]] std::string why_not_transition(u32 atom, u32 port, u32 row) const {
    const AtomType& type = tables_.atom_type(atom);
    const std::string data = data_of(core_, atom);
    const std::string with = data.empty() ? "" : " (" + data + ")";
    if (!holds(atom, row)) return "the guard is false" + with;
    if (core_.events().is_event_port(atom, port) && is_without_event(atom, port)) return "no event waits";
    const bool has_bounds =
        type.time != nullptr && row < type.time->transitions.size && type.time->transitions[row].when.bounds.size != 0;
    std::string rules;
    for (const AtomPriority& rule : type.priorities) {
      if (rule.low != port && rule.low != kNone) continue;
      rules += (rules.empty() ? "`" : ", `") + std::string(rule.name) + '`';
    }
    if (has_bounds) return "its clocks do not allow it now" + with;
    if (!rules.empty()) return "a priority of its component hides it: " + rules;
    return "it is not enabled" + with;
  }
  [[nodiscard]] bool is_without_event(u32 atom, u32 port) const {
    const std::vector<EventPortRow>& rows = core_.events().ports();
    for (u32 row = 0; row < rows.size(); ++row) {
      if (rows[row].atom == atom && rows[row].port == port) return core_.events().waiting(row) == 0;
    }
    return false;
  }
  // A guard of an atom reads the atom's variables only.
  [[nodiscard]] bool holds(u32 atom, u32 row) const {
    const Transition& transition = tables_.atom_type(atom).transitions[row];
    if (transition.guard == kNone) return true;
    const VariableId first = tables_.atoms[atom].first_cell;
    std::vector<Cell> cells;
    for (u32 k = 0; k < tables_.atom_type(atom).variables.size; ++k) cells.push_back(core_.cell(first + k));
    const Code guard = image_.codes[transition.guard];
    return guard.fn(guard.context, cells.data(), cells.data(), nullptr) == 1;
  }

  // Of a connector whose ports are there.
  [[nodiscard]] std::string false_guards(u32 connector) const {
    std::string out;
    append_guards(out, connector, 0);
    return out.empty() ? "  a priority hides what it binds\n" : out;
  }
  void append_guards(std::string& out, u32 connector, int depth) const {
    constexpr int kMostDepth = 100;
    const ConnectorType& type = tables_.connector_type(connector);
    for (const Clause& clause : type.clauses) {
      if (clause.guard == kNone) continue;
      out += "  the guard of ";
      append_relative(out, image_.connectors[connector]);
      out += " is false";
      append_place(out, clause.loc);
      out += '\n';
    }
    for (u32 param = 0; param < type.params.size && depth < kMostDepth; ++param) {
      const PortRef ref = tables_.port_ref(connector, param);
      if (ref.choice == kNone && ref.atom == kNone) append_guards(out, ref.connector, depth + 1);
    }
  }

  // Evaluated on a copy of all variables.
  [[nodiscard]] bool rule_holds(u32 rule) const {
    const Priority& row = image_.priorities[rule];
    if (row.guard == kNone) return true;
    std::vector<Cell> cells;
    for (const VariableId variable : IdRange<VariableId>(image_.cell_count)) cells.push_back(core_.cell(variable));
    const Code guard = image_.codes[row.guard];
    const u32* const binds = row.bind_count == 0 ? nullptr : core_.parts().memory.binds.rows + row.binds;
    return guard.fn(guard.context, nullptr, cells.data(), binds) == 1;
  }

  // The rules that hide it, each with what is possible at the end of its chain.
  [[nodiscard]] std::string hiding_rules(InteractionId interaction) const {
    const PriorityTables& priorities = core_.priorities();
    std::string out;
    for (const u32 rule : priorities.low_of_interaction[interaction]) {
      if (!rule_holds(rule)) continue;
      std::vector<u32> todo{rule}, seen;
      InteractionId stronger;
      while (!todo.empty() && !stronger.is_valid()) {
        const u32 next = todo.back();
        todo.pop_back();
        if (std::find(seen.begin(), seen.end(), next) != seen.end()) continue;
        seen.push_back(next);
        for (const HighEdge& edge : priorities.high_edges) {
          if (edge.rule == next && core_.search().base_count(edge.interaction) != 0) stronger = edge.interaction;
        }
        for (const u32 row : priorities.next[next]) {
          if (rule_holds(row)) todo.push_back(row);
        }
      }
      if (!stronger.is_valid()) continue;
      out += std::string("  priority `") + image_.priorities[rule].name + "` hides it: ";
      append_relative(out, image_.connectors[tables_.connector_of(stronger)]);
      out += " is possible";
      append_place(out, image_.priorities[rule].loc);
      out += '\n';
    }
    return out.empty() ? "  a priority hides it\n" : out;
  }

  void append_place(std::string& out, SourceLine loc) const {
    if (loc.line == 0) return;
    out += "  ";
    append_line(out, image_, loc);
  }

  const Core& core_;
  const Tables& tables_;
  const Image& image_;
  std::size_t lines_ = 0;
};

}  // namespace

std::string why_not_connector(const Core& core, u32 connector) { return WhyNot(core).of_connector(connector); }
std::string why_not_port(const Core& core, u32 atom, u32 port) { return WhyNot(core).of_port(atom, port); }

}  // namespace bip::rt
