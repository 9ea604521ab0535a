// The state of one unfolding. Passes over a compound instance, in this order: components (depth first), connectors
// (those that are bound by others first), priorities. Each lives in its own file.
#pragma once
#include <map>
#include <set>

#include "compiler/system/instantiate.hpp"
#include "compiler/system/system.hpp"

namespace bip::system {

/// An element of a component family: an atom, or a compound instance (row of Instantiator::instances).
struct Element {
  static constexpr std::uint32_t kHole = 0xffffffffu;
  std::uint32_t row = kHole;
};

/// A connector that is declared but perhaps not yet resolved.
struct PendingConnector {
  const CompoundItem* item = nullptr;
  std::vector<Value> self;  // values of parameters and loop variables where it was declared
  std::uint32_t family = 0;
  std::string name;  // "c[3]"
  ConnectorId id;    // valid when resolved
  bool in_progress = false;
  bool failed = false;  // reported
};

/// A priority that a `for` makes.
struct PendingPriority {
  std::uint32_t rule = 0;  // row of CompoundType::priorities
  std::string name;        // "p[3]"
  std::vector<Value> self;
};

struct Instance {
  CompoundTypeId type;
  CompoundId row;
  std::vector<Value> params;
  std::vector<std::vector<Element>> components;        // by family and index
  std::vector<std::vector<std::uint32_t>> connectors;  // by family and index: rows of pending, or kHole
  std::vector<PendingConnector> pending;
  std::vector<PendingPriority> priorities;
};

/// Instances of a compound with all of its parts, itself included. Counts stop at 2^40.
struct InstanceCount {
  std::uint64_t atoms = 0;
  std::uint64_t compounds = 0;
};

/// Lower bounds of the instances of compound types: what loops and arrays declare whose sizes depend on parameters is
/// not counted. Each type is counted once.
class LeastCounts {
 public:
  explicit LeastCounts(const Model& model) : model_(model), known_(model.compound_types.size()) {}
  InstanceCount of(CompoundTypeId type);
  /// `count` and what `item` of a compound of this type declares.
  InstanceCount with(InstanceCount count, CompoundTypeId type, const CompoundItem& item);

 private:
  const Model& model_;
  std::vector<std::optional<InstanceCount>> known_;  // by type
};

/// Limits the diagnostics: a loop may repeat one without end.
inline constexpr std::size_t kEnoughErrors = 50;

struct Instantiator {
  Model& model;
  Diagnostics& diags;
  const UnfoldingLimits& limits;
  System out{};
  std::vector<Instance> instances{};
  std::map<std::pair<const CompoundItem*, std::vector<std::uint32_t>>, ConnectorTypeId> expanded{};
  std::size_t rounds = 0;
  bool stopped = false;                     // a limit was reached: unwind
  std::set<std::uint32_t> warned_cycles{};  // compound types
  std::set<std::string> property_names{};

  // instantiate.cpp
  std::uint32_t compound(CompoundTypeId type, std::vector<Value> params, std::string path, CompoundId parent, Loc loc,
                         std::size_t depth);
  std::optional<Value> value(ExprId expr, const std::vector<Value>& self, SourceRange at);
  void items(std::uint32_t instance, const std::vector<CompoundItem>& list, std::vector<Value>& self,
             std::size_t depth);
  void component(std::uint32_t instance, const CompoundItem& item, const std::vector<Value>& self, bool in_loop,
                 std::size_t depth);
  void property(std::uint32_t instance, const CompoundItem& item, const std::vector<Value>& self);
  void declare_connector(std::uint32_t instance, const CompoundItem& item, const std::vector<Value>& self);
  void declare_priority(std::uint32_t instance, const CompoundItem& item, const std::vector<Value>& self);
  bool are_weights(const AtomType& type, const std::vector<Value>& args, SourceRange at);
  bool too_many(std::size_t count, const char* what, SourceRange at) {
    return is_beyond(limits.instances, count, what, at);
  }
  bool is_beyond(std::size_t limit, std::size_t count, const char* what, SourceRange at);

  // count_instances.cpp
  /// Whether the root has more instances than the limit (reported); loops are not looked at.
  bool is_too_large(CompoundTypeId root);

  // resolve_bindings.cpp
  enum class ElementKind : std::uint8_t { Component, Connector };
  std::optional<std::uint32_t> find(const Instance& in, const ElementRef& ref, ElementKind kind,
                                    const std::vector<Value>& self, SourceRange at);
  ConnectorId resolve_connector(std::uint32_t instance, std::uint32_t pending, std::size_t depth);
  ConnectorId bind_connector(std::uint32_t instance, std::uint32_t pending, std::size_t depth);
  bool resolve_port(std::uint32_t instance, const PortPath& path, const std::vector<Value>& self,
                    std::vector<PortRef>& to, std::size_t depth, std::vector<ShownPort>* shown = nullptr);
  std::optional<PortRef> exported_port(std::uint32_t instance, std::uint32_t row, std::size_t depth);
  std::optional<DataRef> resolve_data(std::uint32_t instance, const DataPath& path, const std::vector<Value>& self);
  PortRef choice_of(const std::string& path, const std::vector<PortRef>& ports);
  PortRef atom_port(AtomId atom, std::uint32_t port);
  void check_components(ConnectorId id, SourceRange at);

  // instantiate_priorities.cpp
  void priorities(std::uint32_t instance);
  std::optional<std::vector<std::uint32_t>> pattern_connectors(std::uint32_t instance, const PatternPath& path,
                                                               const std::vector<Value>& self);
  bool pattern(std::uint32_t instance, const PatternPath& path, std::uint32_t pending, const std::vector<Value>& self,
               Pattern& to);
  void check_priorities(std::size_t first_rule, const std::vector<const PriorityRule*>& rules);
  enum class GuardedRules : std::uint8_t { Ignored, Followed };
  bool check_cycle(CompoundId parent, std::size_t first_rule, const std::vector<const PriorityRule*>& rules,
                   GuardedRules guarded);

  // check_alternatives.cpp
  void check_alternatives(ConnectorId id, SourceRange at);

  std::map<std::pair<std::uint32_t, std::uint32_t>, PortRef> merged_exports{};  // by instance and export
  std::map<std::pair<std::uint32_t, std::uint32_t>, PortRef> merged_ports{};    // by atom and PortPath::port
  std::vector<std::uint32_t> stamps{};  // by atom: the last connector that saw it
};

// drop_unused_types.cpp
void drop_unused_types(System& system, std::uint32_t own_file);

}  // namespace bip::system
