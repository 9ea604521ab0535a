// Storage behind an Image, and the context of one lowering. Internal to lower/.
//
// Small arrays of types live in an arena, instance tables in vectors that have their final size before anything points
// to them. Names of types and compounds are not copied: the System owns them and must outlive the image. Nothing of
// atoms and connectors is needed after lowering.
#pragma once
#include <string>
#include <vector>

#include "compiler/base/arena.hpp"
#include "compiler/lower/event_classes.hpp"
#include "compiler/lower/fold_tables.hpp"
#include "compiler/lower/lower.hpp"
#include "compiler/lower/unit_names.hpp"

namespace bip::lower {

struct LoweredSystem::Pools {
  Arena arena;
  std::string name;
  std::vector<const char*> files, strings;
  std::vector<rt::Site> sites;
  std::vector<rt::PortType> port_types;
  std::vector<rt::AtomType> atom_types;
  std::vector<rt::ConnectorType> connector_types;
  std::vector<rt::Compound> compounds;
  Table<rt::Atom> atoms;
  std::vector<rt::Cell> args;
  Table<rt::Connector> connectors;
  Table<rt::PortRef> port_refs;
  std::vector<rt::Choice> choices;
  std::vector<rt::ShownPort> shown_ports;
  Table<rt::Bind> binds;
  std::vector<rt::Priority> priorities;
  std::vector<rt::TransitionWeight> transition_weights;
  std::vector<rt::ConnectorWeight> connector_weights;

  /// A copy of `items` that stays where it is.
  template <class T>
  rt::Span<T> list(const std::vector<T>& items) {
    const std::span<const T> copy = arena.list(items);
    return {copy.data(), static_cast<std::uint32_t>(copy.size())};
  }
};

/// A finished vector as the image sees it.
template <class T>
[[nodiscard]] rt::Span<T> span_of(const std::vector<T>& items) {
  return {items.data(), static_cast<std::uint32_t>(items.size())};
}

struct Lowering {
  const System& system;
  LoweredSystem& out;
  LoweredSystem::Pools& pools;
  UniqueNames names;
  std::vector<EventClassUse> event_classes{};

  /// Adds a unit and returns its row; rt::kNone for absent code.
  std::uint32_t guard(CodeOwner owner, std::uint32_t row, const std::string& name, ExprId expr);
  std::uint32_t action(CodeOwner owner, std::uint32_t row, const std::string& name, StmtId body);
};

[[nodiscard]] inline rt::SourceLine loc_of(const Loc& loc) { return {loc.file, loc.line, loc.column}; }
[[nodiscard]] inline rt::CellType cell_type_of(Type type) { return static_cast<rt::CellType>(type); }

/// Port, atom and connector types, and the units of their code.
void lower_types(Lowering& l);
/// What the type has to do with time; null if nothing.
[[nodiscard]] const rt::AtomTime* lower_time(Lowering& l, std::uint32_t row, const AtomType& type);
/// Compounds, atoms, connectors, bindings, priorities, and the units of priority guards.
void lower_instances(Lowering& l);

}  // namespace bip::lower
