// The System as JSON: one object with one list per table. Rows are identified by names where names are unique. Code is
// BIP text in one line. Keys have a fixed order; absent or empty values are omitted, except lists that are always
// expected.
#include <nlohmann/json.hpp>

#include "compiler/base/json_text.hpp"
#include "compiler/graph/code_text.hpp"
#include "compiler/graph/graph.hpp"
#include "compiler/system/system.hpp"

namespace bip::graph {
namespace {

using Json = nlohmann::ordered_json;

class GraphJsonWriter {
 public:
  explicit GraphJsonWriter(const System& system) : system_(system) {}

  Json run(Show show) {
    Json out{{"format", "bipc-graph"}, {"version", 1}, {"files", system_.files}};
    if (show != Show::Structure)
      out["atom_types"] = list(system_.atom_types, [this](const AtomType& t) { return atom_type(t); });
    if (show == Show::Automata) return out;
    out["connector_types"] =
        list(system_.connector_types, [this](const ConnectorType& t) { return connector_type(t); });
    out["compounds"] = list(system_.compounds, [this](const Compound& c) { return compound(c); });
    out["atoms"] = list(system_.atoms, [this](const Atom& a) { return atom(a); });
    out["merged_ports"] = list(system_.choices, [this](const Choice& c) {
      return Json{{"name", c.name}, {"ports", ports(c.ports)}};
    });
    out["connectors"] = list(system_.connectors, [this](const Connector& c) { return connector(c); });
    out["priorities"] = list(system_.priorities, [this](const Priority& p) { return priority(p); });
    return out;
  }

 private:
  template <class Rows, class F>
  static Json list(const Rows& rows, F f) {
    Json out = Json::array();
    for (const auto& row : rows) out.push_back(f(row));
    return out;
  }
  static void put(Json& object, const char* key, const std::string& text) {
    if (!text.empty()) object[key] = text;
  }
  void put_place(Json& object, const Loc& loc) const {
    if (loc.line != 0 && loc.file < system_.files.size())
      object["at"] = system_.files[loc.file] + ":" + std::to_string(loc.line) + ":" + std::to_string(loc.column);
  }
  /// The names of `rows` of a table whose rows have a name.
  template <class Rows>
  static Json names(const std::vector<std::uint32_t>& rows, const Rows& table) {
    Json out = Json::array();
    for (const std::uint32_t row : rows) {
      if constexpr (requires { table[row].name; }) {
        out.push_back(table[row].name);
      } else {
        out.push_back(table[row]);
      }
    }
    return out;
  }
  Json variables(const std::vector<DataVariable>& rows, std::size_t count) const {
    Json out = Json::array();
    for (std::size_t k = 0; k < count; ++k) {
      Json variable{{"name", rows[k].name}, {"type", system_.code.type_name(rows[k].type)}};
      if (rows[k].is_param) variable["parameter"] = true;
      if (rows[k].exported) variable["exported"] = true;
      out.push_back(std::move(variable));
    }
    return out;
  }

  Json atom_type(const AtomType& type) const {
    const CodeNames self = names_of(type);
    Json out{{"name", type.name}};
    put_place(out, type.loc);
    out["data"] = variables(type.variables, type.visible_variables());
    if (!type.clocks.empty())
      out["clocks"] = list(type.clocks, [](const Clock& c) { return Json{{"name", c.name}, {"unit_ns", c.unit}}; });
    out["ports"] = list(type.ports, [&](const Port& p) { return port(type, p); });
    if (!type.merged.empty())
      out["merged_ports"] = list(type.merged, [&](const MergedPort& m) {
        return Json{{"name", m.name}, {"ports", names(m.ports, type.ports)}};
      });
    out["places"] = type.places;
    out["initial"] = {{"to", names(type.initial, type.places)}};
    put(out["initial"], "do", text_of(system_.code, type.initial_action, self));
    put_resume(out["initial"], type, type.initial_resume);
    if (!type.final_places.empty()) out["final"] = names(type.final_places, type.places);
    out["transitions"] = list(type.transitions, [&](const Transition& t) { return transition(type, t, self); });
    if (!type.priorities.empty())
      out["priorities"] = list(type.priorities, [&](const AtomPriority& p) { return atom_priority(type, p, self); });
    if (!type.invariants.empty())
      out["invariants"] = list(type.invariants, [&](const Invariant& i) { return invariant(type, i); });
    return out;
  }
  Json port(const AtomType& type, const Port& row) const {
    Json out{{"name", row.name},
             {"type", system_.port_types[row.type].name},
             {"data", names(row.variables, type.variables)},
             {"exported", row.exported}};
    if (row.external) out["event"] = {{"policy", name_of(row.policy)}, {"class", row.event_class}};
    return out;
  }
  void put_resume(Json& out, const AtomType& type, const Resume& resume) const {
    if (resume.present) out["resume"] = condition_of(system_.code, type, resume.guard, resume.when);
  }
  Json transition(const AtomType& type, const Transition& row, const CodeNames& self) const {
    Json out = Json::object();
    out["port"] = row.port == Transition::kInternal ? Json(nullptr) : Json(type.ports[row.port].name);
    out["from"] = names(row.from, type.places);
    out["to"] = names(row.to, type.places);
    put(out, "provided", condition_of(system_.code, type, row.guard, row.when));
    if (row.urgency != Urgency::Lazy) out["urgency"] = name_of(row.urgency);
    put(out, "do", text_of(system_.code, row.action, self));
    put_resume(out, type, row.resume);
    if (row.async.present) {
      out["async"] = Json::object();
      if (row.async.budget >= 0) out["async"]["budget_ns"] = row.async.budget;
      if (row.async.overrun != Async::kNone) out["async"]["overrun"] = type.ports[row.async.overrun].name;
    }
    put_place(out, row.loc);
    return out;
  }
  Json atom_priority(const AtomType& type, const AtomPriority& row, const CodeNames& self) const {
    const auto side = [&](std::uint32_t p) {
      return p == AtomPriority::kAnyPort ? std::string("*") : type.ports[p].name;
    };
    Json out{{"name", row.name}, {"low", side(row.low)}, {"high", side(row.high)}};
    put(out, "provided", text_of(system_.code, row.guard, self));
    return out;
  }
  Json invariant(const AtomType& type, const Invariant& row) const {
    Json out{{"name", row.name}};
    if (row.scope != InvariantScope::Always)
      out[row.scope == InvariantScope::At ? "at_places" : "from_places"] = names(row.places, type.places);
    out["provided"] = condition_of(system_.code, type, row.condition, row.when);
    return out;
  }

  Json connector_type(const ConnectorType& type) const {
    const CodeNames names_here = names_of(system_, type);
    Json out{{"name", type.name}};
    put_place(out, type.loc);
    out["parameters"] = list(type.params, [this](const ConnectorParam& p) {
      return Json{{"name", p.name}, {"type", system_.port_types[p.type].name}};
    });
    out["data"] = variables(type.variables, type.variables.size());
    out["define"] = define_of(type);
    if (type.resume == ResumeMode::Sync) out["resume"] = "sync";
    out["interactions"] = list(type.clauses, [&](const Clause& c) {
      Json clause{{"on", names(c.params, type.params)}};
      put(clause, "provided", text_of(system_.code, c.guard, names_here));
      put(clause, "up", text_of(system_.code, c.up, names_here));
      put(clause, "down", text_of(system_.code, c.down, names_here));
      return clause;
    });
    if (type.exports)
      out["export"] = {{"name", type.export_name},
                       {"type", system_.port_types[type.export_type].name},
                       {"data", names(type.export_variables, type.variables)}};
    return out;
  }
  void put_parent(Json& out, CompoundId parent) const {
    if (parent.is_valid()) out["in"] = system_.compounds[parent].path;
  }
  Json compound(const Compound& row) const {
    Json out{{"path", row.path}, {"type", row.type}};
    put_parent(out, row.parent);
    put_place(out, row.loc);
    return out;
  }
  Json atom(const Atom& row) const {
    Json out{{"path", row.path}, {"type", system_.atom_types[row.type].name}};
    put_parent(out, row.parent);
    if (!row.args.empty())
      out["arguments"] = list(row.args, [this](const Value& v) { return text_of(system_.code, v); });
    put_place(out, row.loc);
    return out;
  }
  Json port_ref(const PortRef& ref) const {
    switch (ref.kind) {
      case PortRef::Kind::Atom: {
        const Atom& row = system_.atoms[ref.atom];
        return {{"atom", row.path}, {"port", system_.atom_types[row.type].ports[ref.port].name}};
      }
      case PortRef::Kind::Connector: {
        Json out{{"connector", system_.connectors[ref.connector].path}};
        if (ref.maximal_only) out["maximal_only"] = true;
        return out;
      }
      case PortRef::Kind::Choice: break;
    }
    // Its name may occur twice; its row may not.
    return {{"merged_port", ref.choice}};
  }
  Json ports(const std::vector<PortRef>& rows) const {
    return list(rows, [this](const PortRef& p) { return port_ref(p); });
  }
  Json data_ref(const DataRef& ref) const {
    const Atom& row = system_.atoms[ref.atom];
    return row.path + "." + system_.atom_types[row.type].variables[ref.variable].name;
  }
  Json connector(const Connector& row) const {
    Json out{{"path", row.path}, {"type", system_.connector_types[row.type].name}, {"type_row", row.type.value}};
    put_parent(out, row.parent);
    out["ports"] = ports(row.ports);
    if (!row.data.empty()) out["reads"] = list(row.data, [this](const DataRef& d) { return data_ref(d); });
    if (row.bound) out["bound"] = true;
    put_place(out, row.loc);
    return out;
  }
  Json side(const Pattern& pattern) const {
    if (pattern.any_connector) return {{"connector", "*"}};
    Json out{{"connector", system_.connectors[pattern.connector].path}};
    if (!pattern.any_interaction)
      out["interaction"] =
          names(pattern.params, system_.connector_types[system_.connectors[pattern.connector].type].params);
    return out;
  }
  Json priority(const Priority& row) const {
    Json out{{"name", row.name}};
    put_parent(out, row.parent);
    out["low"] = side(row.low);
    out["high"] = side(row.high);
    put(out, "provided", text_of(system_.code, row.guard, names_of(system_, row)));
    put_place(out, row.loc);
    return out;
  }

  const System& system_;
};

}  // namespace

std::string json(const System& system, Show show) { return indented_json(GraphJsonWriter(system).run(show)) + "\n"; }

}  // namespace bip::graph
