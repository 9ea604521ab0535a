// Hand-built images for the runtime's tests: types and instances by name, `define` as BIP2 text, code as lambdas.
// Owns everything that the image points to; keep it alive as long as a Core runs on the image.
#pragma once
#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "bip/image.hpp"

namespace bip::rt::testing {

using u32 = std::uint32_t;
using Fn = std::function<std::int32_t(Cell* self, Cell* all, const u32* bind)>;

struct TransitionSpec {
  std::string port = {};  // empty: internal
  std::vector<std::string> from = {}, to = {};
  Fn guard = nullptr, action = nullptr;
};
struct PortSpec {
  std::string name = {};
  std::vector<std::string> vars = {};  // names of variables, all int
  bool exported = true;
};
struct AtomTypeSpec {
  std::string name = {};
  std::vector<std::string> params = {}, data = {};
  std::vector<PortSpec> ports = {};
  std::vector<std::string> places = {}, initial = {};
  std::vector<TransitionSpec> transitions = {};
  Fn initial_action = nullptr;
};
struct ClauseSpec {
  std::vector<std::string> params = {};
  Fn guard = nullptr, up = nullptr, down = nullptr;
  bool may_fault = false;  // guard and `up`
};
struct ConnectorTypeSpec {
  std::string name = {};
  std::vector<std::pair<std::string, u32>> params = {};  // name, number of int variables
  std::string define = {};                               // "p' (q r)'"
  std::vector<ClauseSpec> clauses = {};
  std::vector<std::string> data = {};
  bool exports = false;
  std::vector<std::string> exported_data = {};
};
struct PatternSpec {
  std::string connector = {};  // empty: *:*
  bool any = true;             // c:*
  std::vector<std::string> params = {};
};

class ImageBuilder {
 public:
  ImageBuilder() {
    image_.name = "Test";
    static const char* const kRootPath = "ROOT";
    compounds_.push_back({kRootPath, kNone});
    strings_.push_back("");
    strings_.push_back("a\"b\n");
    files_.push_back("test.bip");
  }
  ImageBuilder(const ImageBuilder&) = delete;
  ImageBuilder& operator=(const ImageBuilder&) = delete;

  u32 compound(const std::string& path, u32 parent) {
    compounds_.push_back({keep(path), parent});
    return static_cast<u32>(compounds_.size()) - 1;
  }
  void atom_type(const AtomTypeSpec& spec) {
    AtomType type{};
    type.name = keep(spec.name);
    std::vector<Var> variables;
    for (const std::string& name : spec.params) variables.push_back({keep(name), CellType::Int, true, false});
    for (const std::string& name : spec.data) variables.push_back({keep(name), CellType::Int, false, true});
    const auto variable_row = [&](const std::string& name) {
      for (u32 i = 0; i < variables.size(); ++i) {
        if (variables[i].name == name) return i;
      }
      throw std::logic_error("variable " + name);
    };
    std::vector<Port> ports;
    for (const PortSpec& port : spec.ports) {
      std::vector<u32> rows;
      for (const std::string& var : port.vars) rows.push_back(variable_row(var));
      ports.push_back(
          {keep(port.name), port_type(static_cast<u32>(port.vars.size())), keep(rows), port.exported, {0, line_, 3}});
      ++line_;
    }
    std::vector<const char*> places;
    for (const std::string& name : spec.places) places.push_back(keep(name));
    const auto place_rows = [&](const std::vector<std::string>& names) {
      std::vector<u32> rows;
      for (const std::string& name : names) {
        for (u32 i = 0; i < spec.places.size(); ++i) {
          if (spec.places[i] == name) rows.push_back(i);
        }
      }
      return keep(rows);
    };
    std::vector<Transition> transitions;
    for (const TransitionSpec& t : spec.transitions) {
      u32 port = kNone;
      for (u32 i = 0; i < spec.ports.size(); ++i) {
        if (spec.ports[i].name == t.port) port = i;
      }
      transitions.push_back({port, place_rows(t.from), place_rows(t.to), code(t.guard), code(t.action), {0, line_, 5}});
      ++line_;
    }
    type.variables = keep(variables);
    type.ports = keep(ports);
    type.places = keep(places);
    type.initial = place_rows(spec.initial);
    type.initial_action = code(spec.initial_action);
    type.transitions = keep(transitions);
    type.loc = {0, line_++, 1};
    atom_type_rows_[spec.name] = static_cast<u32>(atom_types_.size());
    atom_types_.push_back(type);
    atom_specs_.push_back(spec);
  }
  u32 atom(const std::string& name, const std::string& type_name, const std::vector<std::int32_t>& args = {}) {
    const u32 type = atom_type_rows_.at(type_name);
    Atom row{};
    row.name = keep("ROOT." + name);
    row.type = type;
    row.first_cell = cells_;
    row.args = static_cast<u32>(args_.size());
    for (std::int32_t value : args) {
      Cell cell{0};
      cell.i = value;
      args_.push_back(cell);
    }
    row.loc = {0, line_++, 3};
    cells_ += atom_types_[type].variables.size;
    atom_rows_[name] = static_cast<u32>(atoms_.size());
    atoms_.push_back(row);
    return atom_rows_[name];
  }
  void connector_type(const ConnectorTypeSpec& spec) {
    ConnectorType type{};
    type.name = keep(spec.name);
    std::vector<ConnectorParam> params;
    u32 bind = 0;
    for (const auto& [name, vars] : spec.params) {
      params.push_back({keep(name), port_type(vars), bind});
      bind += vars;
    }
    std::vector<Var> variables;
    for (const std::string& name : spec.data) variables.push_back({keep(name), CellType::Int, false, false});
    std::vector<Clause> clauses;
    for (const ClauseSpec& clause : spec.clauses) {
      std::vector<u32> rows;
      for (const std::string& name : clause.params) rows.push_back(param_row(spec, name));
      std::sort(rows.begin(), rows.end());
      clauses.push_back({keep(rows),
                         code(clause.guard),
                         code(clause.up),
                         code(clause.down),
                         {0, line_++, 5},
                         clause.may_fault,
                         clause.may_fault});
    }
    std::vector<u32> exported;
    for (const std::string& name : spec.exported_data) {
      for (u32 i = 0; i < spec.data.size(); ++i) {
        if (spec.data[i] == name) exported.push_back(i);
      }
    }
    define_.clear();
    const char* at = spec.define.c_str();
    parse_group(spec, at);
    type.params = keep(params);
    type.variables = keep(variables);
    std::vector<DefineNode> nodes;
    for (const Parsed& node : define_) nodes.push_back({node.is_leaf, node.trigger, node.param, keep(node.children)});
    type.define = keep(nodes);
    type.clauses = keep(clauses);
    type.exports = spec.exports;
    type.export_name = "x";
    type.export_type = port_type(static_cast<u32>(exported.size()));
    type.export_variables = keep(exported);
    type.loc = {0, line_++, 1};
    connector_type_rows_[spec.name] = static_cast<u32>(connector_types_.size());
    connector_types_.push_back(type);
    connector_specs_.push_back(spec);
  }
  /// ports: "atom.port", or a connector's name for its exported port ("name!" through a compound: maximal only).
  /// reads: "atom.variable", data beyond the ports.
  u32 connector(const std::string& name, const std::string& type_name, const std::vector<std::string>& ports,
                const std::vector<std::string>& reads = {}, u32 parent = 0) {
    Connector row{};
    row.name = keep("ROOT." + name);
    row.type = connector_type_rows_.at(type_name);
    row.ports = static_cast<u32>(port_refs_.size());
    row.binds = static_cast<u32>(binds_.size());
    row.loc = {0, line_++, 3};
    row.parent = parent;
    for (std::string port : ports) {
      const std::size_t dot = port.rfind('.');
      if (dot == std::string::npos) {
        const bool maximal = port.back() == '!';
        if (maximal) port.pop_back();
        const u32 below = connector_rows_.at(port);
        connectors_[below].bound = true;
        port_refs_.push_back({kNone, 0, below, maximal});
        // Frames follow the atoms' cells: resolved in image().
        for (u32 variable : connector_types_[connectors_[below].type].export_variables) {
          frame_binds_.push_back({static_cast<u32>(binds_.size()), below});
          binds_.push_back({variable});
        }
        continue;
      }
      const u32 atom_row = atom_rows_.at(port.substr(0, dot));
      const AtomType& type = atom_types_[atoms_[atom_row].type];
      u32 port_row = 0;
      while (type.ports[port_row].name != port.substr(dot + 1)) ++port_row;
      port_refs_.push_back({atom_row, port_row, kNone, false});
      for (u32 variable : type.ports[port_row].variables) binds_.push_back({atoms_[atom_row].first_cell + variable});
    }
    for (const std::string& read : reads) binds_.push_back({variable(read).value});
    row.bind_count = static_cast<u32>(binds_.size()) - row.binds;
    connector_rows_[name] = static_cast<u32>(connectors_.size());
    connectors_.push_back(row);
    return connector_rows_[name];
  }
  void priority(const std::string& name, const PatternSpec& low, const PatternSpec& high, Fn guard = nullptr,
                const std::vector<std::string>& reads = {}, u32 parent = 0) {
    Priority row{};
    row.name = keep(name);
    row.parent = parent;
    row.low = pattern(low);
    row.high = pattern(high);
    row.guard = code(guard);
    row.binds = static_cast<u32>(binds_.size());
    for (const std::string& read : reads) binds_.push_back({variable(read).value});
    row.bind_count = static_cast<u32>(binds_.size()) - row.binds;
    row.loc = {0, line_++, 3};
    priorities_.push_back(row);
  }

  const Image& image() {
    if (built_) return image_;
    built_ = true;
    u32 cells = cells_;
    for (Connector& row : connectors_) {
      row.first_cell = cells;
      cells += connector_types_[row.type].variables.size;
    }
    for (const auto& [bind, below] : frame_binds_) binds_[bind].cell += connectors_[below].first_cell;
    image_.cell_count = cells;
    const auto view = [](const auto& v) {
      return Span<std::remove_cvref_t<decltype(v[0])>>{v.data(), static_cast<u32>(v.size())};
    };
    image_.files = view(files_);
    image_.strings = view(strings_);
    image_.codes = view(codes_);
    image_.sites = view(sites_);
    image_.port_types = view(port_types_);
    image_.atom_types = view(atom_types_);
    image_.connector_types = view(connector_types_);
    image_.compounds = view(compounds_);
    image_.atoms = view(atoms_);
    image_.args = view(args_);
    image_.connectors = view(connectors_);
    image_.port_refs = view(port_refs_);
    image_.binds = view(binds_);
    image_.priorities = view(priorities_);
    return image_;
  }
  VariableId variable(const std::string& read) const {
    const std::size_t dot = read.rfind('.');
    const u32 atom_row = atom_rows_.at(read.substr(0, dot));
    const AtomType& type = atom_types_[atoms_[atom_row].type];
    for (u32 i = 0; i < type.variables.size; ++i) {
      if (type.variables[i].name == read.substr(dot + 1)) return atoms_[atom_row].variable(i);
    }
    throw std::logic_error("variable " + read);
  }
  /// How many variables the port "atom.port" shows.
  u32 port_vars(const std::string& name) const {
    const std::size_t dot = name.rfind('.');
    const AtomType& type = atom_types_[atoms_[atom_rows_.at(name.substr(0, dot))].type];
    for (const Port& port : type.ports) {
      if (port.name == name.substr(dot + 1)) return port.variables.size;
    }
    throw std::logic_error("port " + name);
  }
  /// The status of a fault at a new site.
  std::int32_t fault(FaultKind kind) {
    sites_.push_back({{0, 77, 9}});
    return fault_status(static_cast<u32>(sites_.size()) - 1, kind);
  }

 private:
  struct Parsed {
    bool is_leaf = false, trigger = false;
    u32 param = 0;
    std::vector<u32> children;
  };
  static u32 param_row(const ConnectorTypeSpec& spec, const std::string& name) {
    for (u32 i = 0; i < spec.params.size(); ++i) {
      if (spec.params[i].first == name) return i;
    }
    throw std::logic_error("param " + name);
  }
  u32 parse_group(const ConnectorTypeSpec& spec, const char*& at) {
    const u32 row = static_cast<u32>(define_.size());
    define_.push_back({});
    while (*at != '\0' && *at != ')') {
      if (*at == ' ') {
        ++at;
        continue;
      }
      u32 child = 0;
      if (*at == '(') {
        child = parse_group(spec, ++at);
        ++at;
      } else {
        std::string name;
        while (*at != '\0' && std::string(" ()'").find(*at) == std::string::npos) name += *at++;
        child = static_cast<u32>(define_.size());
        define_.push_back({true, false, param_row(spec, name), {}});
      }
      if (*at == '\'') {
        define_[child].trigger = true;
        ++at;
      }
      define_[row].children.push_back(child);
    }
    return row;
  }
  Pattern pattern(const PatternSpec& spec) {
    Pattern row{};
    if (spec.connector.empty()) {
      row.any_connector = true;
      return row;
    }
    row.connector = connector_rows_.at(spec.connector);
    row.any_interaction = spec.any && spec.params.empty();
    std::vector<u32> params;
    for (const std::string& name : spec.params)
      params.push_back(param_row(connector_specs_[connectors_[row.connector].type], name));
    std::sort(params.begin(), params.end());
    row.params = keep(params);
    return row;
  }
  u32 port_type(u32 vars) {
    if (port_type_rows_.count(vars) != 0) return port_type_rows_[vars];
    std::vector<Var> rows;
    for (u32 i = 0; i < vars; ++i)
      rows.push_back({keep(i == 0 ? "v" : "v" + std::to_string(i)), CellType::Int, false, false});
    port_types_.push_back({keep("P" + std::to_string(vars)), keep(rows)});
    return port_type_rows_[vars] = static_cast<u32>(port_types_.size()) - 1;
  }
  static std::int32_t trampoline(const void* context, Cell* self, Cell* all, const u32* bind) {
    return (*static_cast<const Fn*>(context))(self, all, bind);
  }
  u32 code(const Fn& fn) {
    if (!fn) return kNone;
    functions_.push_back(fn);
    codes_.push_back({&trampoline, &functions_.back()});
    return static_cast<u32>(codes_.size()) - 1;
  }
  const char* keep(const std::string& text) {
    texts_.push_back(text);
    return texts_.back().c_str();
  }
  template <class T>
  Span<T> keep(const std::vector<T>& rows) {
    static std::deque<std::vector<T>> pool;  // lives as long as the tests
    pool.push_back(rows);
    return {pool.back().data(), static_cast<u32>(rows.size())};
  }

  Image image_;
  bool built_ = false;
  u32 cells_ = 0, line_ = 1;
  std::deque<std::string> texts_;
  std::deque<Fn> functions_;
  std::vector<Code> codes_;
  std::vector<Site> sites_;
  std::vector<const char*> files_, strings_;
  std::vector<PortType> port_types_;
  std::vector<AtomType> atom_types_;
  std::vector<AtomTypeSpec> atom_specs_;
  std::vector<ConnectorType> connector_types_;
  std::vector<ConnectorTypeSpec> connector_specs_;
  std::vector<Compound> compounds_;
  std::vector<Atom> atoms_;
  std::vector<Cell> args_;
  std::vector<Connector> connectors_;
  std::vector<PortRef> port_refs_;
  std::vector<Bind> binds_;
  std::vector<Priority> priorities_;
  std::vector<std::pair<u32, u32>> frame_binds_;
  std::vector<Parsed> define_;
  std::map<std::string, u32> atom_type_rows_, connector_type_rows_, atom_rows_, connector_rows_;
  std::map<u32, u32> port_type_rows_;
};

/// `on port from A to B` chains: an atom type of places with one transition a line.
inline AtomTypeSpec always_ready(const std::string& name) {
  return {.name = name,
          .ports = {{.name = "p", .vars = {}}},
          .places = {"S"},
          .initial = {"S"},
          .transitions = {{"p", {"S"}, {"S"}}}};
}

}  // namespace bip::rt::testing
