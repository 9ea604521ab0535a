// The instances of the naive oracle: the compounds of the description, with arrays and loops unfolded.
#pragma once
#include <memory>
#include <set>

#include "tools/gen/naive_value.hpp"

namespace bip::gen {

struct WorldAtom {
  std::string path;
  const AtomType* type = nullptr;
  Values args;
};
struct WorldOption {
  int atom = -1;     // else a connector's exported port
  std::string port;  // of the atom
  int connector = -1;
  bool maximal_only = false;
};
/// What a parameter is bound to; several for merged ports.
using WorldPort = std::vector<WorldOption>;
struct WorldConnector {
  std::string path;
  const ConnectorType* type = nullptr;
  std::vector<WorldPort> ports;
  int compound = 0;  // the instance that declares it
  bool bound = false, bound_by_sibling = false;
  /// Rules of its compound are about its interactions.
  [[nodiscard]] bool is_top_level() const { return !type->exports || (bound && !bound_by_sibling); }
};
/// A side of a rule: connector -1 is *:*.
struct WorldPattern {
  int connector = -1;
  bool any_interaction = false;
  std::set<int> params;
};
struct WorldRule {
  int compound = 0;
  WorldPattern low, high;
  const Priority* source = nullptr;
  std::map<std::string, std::pair<int, std::string>> data;  // "a.x": atom, variable
};

struct World {
  std::vector<WorldAtom> atoms;
  std::vector<WorldConnector> connectors;
  std::vector<WorldRule> rules;
};
[[nodiscard]] World build_world(const Description& model);

/// Leaves of an interaction: atom and port.
using Leaves = std::set<std::pair<int, std::string>>;
/// One interaction that a connector's structure gives, whether it is ever enabled or not.
struct Node {
  int connector = 0;
  std::set<int> params;
  Leaves leaves;
};
/// All of a connector, nested and merged alternatives multiplied out. Stops at `limit` rows.
[[nodiscard]] std::vector<Node> structural_interactions(const World& world, int connector, std::size_t limit);

}  // namespace bip::gen
