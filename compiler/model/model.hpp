// The type model: names resolved, types checked, code built. What needs an instance (array sizes, bindings of arrays,
// values of arguments) stays as syntax plus scopes in CompoundType and is done by system/.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/model/types.hpp"
#include "compiler/syntax/syntax.hpp"

namespace bip {

using CompoundTypeId = Id<struct CompoundTypeTag>;

struct CompoundType {
  std::string name;
  std::vector<Slot> params;               // read-only; loop variables take the slots after them
  const syntax::Decl* decl = nullptr;     // items, priorities, exports: instantiated by system/
  Loc loc{};
};

/// Which kind a type name has.
struct TypeName {
  enum class Kind : std::uint8_t { Port, Connector, Atom, Compound } kind = Kind::Port;
  std::uint32_t row = 0;
  SourceRange range;
};

struct Model {
  const SourceMap* sources = nullptr;
  std::vector<std::string> files;
  CodeTable code;
  IndexVector<PortTypeId, PortType> port_types;
  IndexVector<ConnectorTypeId, ConnectorType> connector_types;
  IndexVector<AtomTypeId, AtomType> atom_types;
  IndexVector<CompoundTypeId, CompoundType> compound_types;
  std::unordered_map<std::string, TypeName> type_names;
};

namespace model {
/// Names, types and all checks that need no instance. nullopt if there were errors.
[[nodiscard]] std::optional<Model> build_model(const syntax::Syntax& syntax, const SourceMap& sources, Diagnostics& diags);
/// Text of the tables, for --emit=model.
[[nodiscard]] std::string dump(const Model& model);
}  // namespace model

}  // namespace bip
