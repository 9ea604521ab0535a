// The passes over one compound type; see build_compound.cpp for their order.
#pragma once
#include <array>
#include <set>

#include "compiler/model/model_builder.hpp"

namespace bip::model {

/// Deepest nesting of compound types, and longest chain of inline connectors that are used before they are declared.
inline constexpr std::uint32_t kMaxNesting = 500;

enum class BuildState : std::uint8_t { Untouched, Building, Done };

/// All compound types: a compound is built after those it contains.
struct CompoundBuilders {
  ModelBuilder& b;
  std::vector<const syntax::Decl*> decls;                        // by CompoundTypeId
  std::vector<const syntax::Decl*> atom_decls, connector_decls;  // by AtomTypeId; by ConnectorTypeId, typed ones
  std::set<std::array<std::uint32_t, 4>>
      modified;  // clauses (file, offset), atom types and ports that warn_modified has seen
  std::vector<BuildState> states;
  std::vector<std::uint32_t> heights;  // of what is built: compounds within compounds
  std::uint32_t depth = 0;             // of those that are being built

  /// Builds the compound if it is not yet; false if it contains itself.
  bool ensure(CompoundTypeId id);
};

struct CompoundBuilder {
  CompoundBuilders& all;
  ModelBuilder& b;
  const syntax::Decl& decl;
  CompoundType& out;
  Scope scope{};  // parameters and loop variables
  std::unordered_map<std::string, std::uint32_t> components{}, connectors{};
  std::vector<const syntax::CompoundItem*> connector_items{};  // by family: its first item
  std::vector<BuildState> connector_states{};
  std::vector<std::vector<bool>> bound_ports{};  // by component family and port
  std::vector<bool> bound_connectors{};
  std::unordered_set<std::string> loop_priorities{};  // names of those in a `for`
  std::uint32_t loop_depth = 0;
  std::uint32_t chain = 0;  // inline connectors that are being built, each for the one before
  std::uint32_t height = 0;

  void build();
  // families.cpp
  enum class ItemPlace : std::uint8_t { Body, Loop };
  void declare_families(std::span<const syntax::CompoundItem* const> items, NameSpace& names, ItemPlace place);
  // paths.cpp
  bool element(const syntax::PathPart& part, bool is_array, ElementRef& ref, const std::string& what);
  bool port_path(const syntax::Path& path, PortPath& ref);
  bool component_port(const syntax::Path& path, std::uint32_t family, PortPath& ref);
  bool connector_port(const syntax::Path& path, std::uint32_t family, PortPath& ref);
  /// Reported: a path that means no data is an error.
  enum class Lookup : std::uint8_t { Silent, Reported };
  bool data_path(const syntax::Path& path, DataPath& ref, Lookup lookup);
  // deep_paths.cpp
  bool deep_port_path(const syntax::Path& path, PortPath& ref);
  std::optional<std::pair<std::uint32_t, Type>> deep_data(const ComponentFamily& family,
                                                          std::span<const syntax::PathPart> parts) const;
  // inline_connector.cpp
  std::vector<DataRead> data_reads(const syntax::CompoundItem& i, CompoundItem& row);
  // build_items.cpp
  CompoundItem item(const syntax::CompoundItem& i);
  void component_item(const syntax::CompoundItem& i, CompoundItem& row);
  void connector_item(const syntax::CompoundItem& i, CompoundItem& row);
  void check_same_export(const syntax::CompoundItem& i, const ConnectorType& type, const ConnectorFamily& family);
  std::vector<ExprId> arguments(const syntax::CompoundItem& i, const ComponentFamily& family);
  // build_compound.cpp
  void build_priority(const syntax::CompoundPriority& p);
  void build_exports();
  void merge_target(const syntax::CompoundExport& e, PortExport& row, const PortPath& target);
  void pattern(const syntax::InteractionPattern& p, PatternPath& row);
  void check_top_level(const syntax::CompoundPriority& p);
  void check_top_level(const syntax::CompoundItem& i);
  void warn_unbound();
  // check_transfers.cpp
  void warn_modified(const std::vector<CompoundItem>& rows);
};

/// The exported data named `name` of a component family: variable or row, and type.
std::optional<std::pair<std::uint32_t, Type>> exported_data(const Model& model, const ComponentFamily& family,
                                                            std::string_view name);

using OuterBindings = std::unordered_map<std::string, Binding>;
/// The names with their values in `self`, or while that is not known, with 1.
[[nodiscard]] OuterBindings outer_bindings(CodeTable& code, std::span<const OuterValue> values,
                                           const std::vector<Value>* self);
/// The outer value that the name is in the scope of a compound, or nullopt.
[[nodiscard]] std::optional<OuterValue> outer_value(const Scope& scope, const syntax::Path& path);

/// Builds the type of an inline connector. `counts[k]`: how many parameters path k stands for (1 without [*]).
/// `paths` are the connector's resolved ports, `reads` the data of components that its code names, `values` its outer
/// values.
void build_inline_connector(ModelBuilder& b, const syntax::CompoundItem& item, const std::vector<PortPath>& paths,
                            const std::vector<std::uint32_t>& counts, const std::vector<DataRead>& reads,
                            const OuterBindings& values, ConnectorType& out);

}  // namespace bip::model
