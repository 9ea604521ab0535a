// The System: the instance model, flat and symbolic; the contract between the front end and every back end.
//
// Plain tables in a deterministic order (declaration order, depth first), typed ids, no pointers. Components are
// flattened, interactions are never enumerated: a connector keeps its tree of synchrons and triggers. Its text form is
// .bsys (bsys.hpp): parse(print(s)) == s and print(parse(t)) == t.
#pragma once
#include <string>
#include <variant>
#include <vector>

#include "compiler/model/types.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip {

/// A compound instance: only its name and place in the hierarchy are left after flattening.
struct Compound {
  std::string path;   // "ROOT", "ROOT.left"
  std::string type;   // "Ring"
  CompoundId parent;  // invalid for the root, which is row 0
  Loc loc{};
};

struct Atom {
  std::string path;  // "ROOT.phil[0]"
  AtomTypeId type;
  CompoundId parent;
  std::vector<Value> args;  // one a parameter
  Loc loc{};                // of the `component` line
};

/// What a connector's parameter is bound to: a port of an atom, or another connector's exported port.
struct PortRef {
  enum class Kind : std::uint8_t { Atom, Connector, Choice };
  Kind kind = Kind::Atom;
  AtomId atom;
  std::uint32_t port = 0;  // Atom: row of the atom type's ports
  ConnectorId connector;   // Connector
  // Connector reached through a compound's exported port: only its maximal interactions are seen.
  bool maximal_only = false;
  std::uint32_t choice = 0;  // Choice: row of System::choices
  friend bool operator==(const PortRef&, const PortRef&) = default;
};
/// A merged port: each enabled one of its ports (atoms' ports or connectors' exported ports, no choices) is an
/// alternative.
struct Choice {
  std::string name;  // as it is bound: "a.e", "c.xport"
  std::vector<PortRef> ports;
  friend bool operator==(const Choice&, const Choice&) = default;
};

/// A parameter that is bound through a compound's exported port: traces may show that name (`c.out`).
struct ShownPort {
  std::uint32_t param = 0;
  CompoundId compound;
  std::string name;  // of the exported port
  friend bool operator==(const ShownPort&, const ShownPort&) = default;
};

/// A connector. Rows are in an order where a connector comes after those it is bound to.
struct Connector {
  std::string path;  // "ROOT.conn"
  ConnectorTypeId type;
  CompoundId parent;
  std::vector<PortRef> ports;  // one a parameter
  std::vector<DataRef> data;   // one a data_read
  // Its exported port is bound by another connector: it never runs by itself. A connector whose exported port is
  // bound nowhere never runs at all.
  bool bound = false;
  Loc loc{};
  double weight = 1;               // above 0: how likely its interactions are beside others
  std::vector<ShownPort> shown{};  // by parameter
};

/// One side of a priority rule.
struct Pattern {
  bool any_connector = false;  // *:*  every interaction (of the compound's connectors) not on the other side
  ConnectorId connector;
  bool any_interaction = false;       // c:*
  std::vector<std::uint32_t> params;  // sorted: parameters of the connector
  friend bool operator==(const Pattern&, const Pattern&) = default;
};
/// low < high provided guard: every interaction contained in low's loses against every one that contains high's.
struct Priority {
  std::string name;
  CompoundId parent;
  Pattern low, high;
  ExprId guard;  // invalid: true. Reads Bind = data
  std::vector<DataRef> data;
  Loc loc{};
};

/// A property that a compound states (`property exclusion { never a@CS && b@CS }`), in terms of the whole system.
struct StatedProperty {
  std::string name;                   // "exclusion", "table.exclusion", "ring[2].served[0]": as traces, without ROOT
  std::string text;                   // as `--property` takes it
  std::vector<std::uint32_t> source;  // by byte of the text, and one for its end: offset in the file
  FileId file;
};

/// The properties are no part of the .bsys form: they ask about a system and do not change it.
struct System {
  std::vector<std::string> files;  // rows of Loc::file
  CodeTable code;
  IndexVector<PortTypeId, PortType> port_types;
  IndexVector<AtomTypeId, AtomType> atom_types;
  IndexVector<ConnectorTypeId, ConnectorType> connector_types;
  IndexVector<CompoundId, Compound> compounds;
  IndexVector<AtomId, Atom> atoms;
  std::vector<Choice> choices;
  IndexVector<ConnectorId, Connector> connectors;
  IndexVector<PriorityId, Priority> priorities;
  std::vector<StatedProperty> properties;

  /// True if the connector's interactions are steps: it exports no port.
  [[nodiscard]] bool is_top(ConnectorId id) const { return !connector_types[connectors[id].type].exports; }
};

}  // namespace bip
