// What a run on several nodes would be: nodes, conflict sets and why the large ones are so large, interactions over
// several nodes, messages. As data; as text for `bipc check --placement`, as JSON with `--json`.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/driver/known_conflicts.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::driver {

/// A place in the text of the model; line 0: unknown.
struct TextPlace {
  std::string file;
  std::uint32_t line = 0, column = 0;
};

struct ReportedConnector {
  std::string path;
  TextPlace place;
};

/// Why interactions are in one conflict set: the component, connector or rule that joins the most of them.
struct SetReason {
  enum class Kind : std::uint8_t { Component, Connector, Rule };
  Kind kind = Kind::Component;
  std::string name;  // path of the component or connector, name of the rule
  TextPlace place;   // of a connector or a rule
  std::string at;    // of a component: the place at which it offers them; empty: any
  std::size_t interactions = 0;
  std::vector<ReportedConnector> connectors;  // of a component: of those interactions, in the order of the model
};

struct ReportedSet {
  std::size_t interactions = 0, components = 0;
  std::string coordinator;  // a node; empty: the set is split
  std::optional<SetReason> reason;
  // Of split sets: nodes with what they coordinate, and how many components are locked.
  std::vector<std::pair<std::string, std::size_t>> coordinates;
  std::size_t locked = 0;
};

/// Sets that are larger than `split above` says, and have one coordinator for the same reason.
struct WholeSets {
  std::string why;
  std::size_t count = 0, largest = 0;
};

struct BorderInteraction {
  std::string name;
  TextPlace place;  // of its connector
  std::size_t messages = 0;
  std::vector<std::string> nodes;
  std::optional<std::uint64_t> count;  // how often it was taken, if the placement has counts
};

struct PlacementReport {
  struct Node {
    std::string name, address;  // no address: empty
    std::size_t components = 0, coordinates = 0;
  };
  /// How much is listed; all of it is counted.
  struct Limits {
    std::size_t reasons = 1, border = 20;
  };
  std::vector<Node> nodes;
  std::size_t interactions = 0;
  std::size_t set_count = 0;
  std::vector<ReportedSet> sets;  // the largest first: those of several interactions, but at least one
  std::vector<WholeSets> whole_sets;
  RemovedConflicts removed;
  std::size_t border_count = 0, border_messages = 0;
  std::vector<BorderInteraction> border;
  struct Counted {
    double border_part = 0, messages_per_step = 0;
  };
  std::optional<Counted> counted;  // if the placement has counts, and a step was counted
};

/// Reads the placement. Nothing: a diagnostic was reported.
[[nodiscard]] std::optional<PlacementReport> report_placement(Compilation& c, const std::string& placement_path,
                                                              PlacementReport::Limits limits);

[[nodiscard]] std::string placement_text(const PlacementReport& report);
/// One line. `report` may be null: then it says what refused the placement.
[[nodiscard]] std::string placement_json(const Compilation& c, const std::string& file,
                                         const std::string& placement_path, const PlacementReport* report);

}  // namespace bip::driver
