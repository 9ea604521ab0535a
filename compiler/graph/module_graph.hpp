// The modules of a robot's functional level: their services, tasks and posters, who reads which poster, and the rules
// between services. As a picture, as DOT and as JSON (compiler/docs/genom.md, Pictures).
//
// Rows refer to each other by index. Deterministic, in the order of the rows; linear but for the layout (layers.hpp).
#pragma once
#include <compare>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace bip::graph {

struct ModuleRow {
  struct Service {
    std::string name;
    bool is_activity = false;  // else it is over at once
  };
  struct Task {
    std::string name, period;  // "20 ms"; empty: it has none
  };
  std::string name;
  std::vector<Task> tasks;
  std::vector<Service> services;
  std::vector<std::string> posters, in_ports;  // out ports are posters
};

/// A service, a poster or an in port of a module.
struct ModuleMember {
  std::size_t module = 0, row = 0;
  auto operator<=>(const ModuleMember&) const = default;
};

/// A task reads a poster of another module.
struct PosterRead {
  std::size_t module = 0, task = 0;
  ModuleMember poster;
};

/// GenoM 3: where an in port reads until it is connected to another out port.
struct PortConnection {
  ModuleMember poster, in_port;
};

struct RuleRow {
  std::string name, text, report;        // the text is without the others
  std::vector<ModuleMember> subjects;    // services that it admits, stops or lets wait
  std::vector<ModuleMember> services;    // others whose state or requests it looks at
  std::vector<ModuleMember> posters;     // that it looks at
  std::vector<ModuleMember> tasks;       // that it watches
  std::optional<ModuleMember> recovery;  // a service that it runs
};

struct ModuleGraph {
  std::string name;
  std::vector<ModuleRow> modules;
  std::vector<PosterRead> reads;
  std::vector<PortConnection> connections;
  std::vector<RuleRow> rules;
};

[[nodiscard]] std::string dot(const ModuleGraph& graph);
/// One object with `"format": "bipc-modules"` and a final newline.
[[nodiscard]] std::string json(const ModuleGraph& graph);
/// A whole SVG document.
[[nodiscard]] std::string svg(const ModuleGraph& graph);

}  // namespace bip::graph
