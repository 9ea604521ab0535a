// Properties of stable states: `never phil[0]@EATS && phil[1]@EATS`, `always pump.level <= 10`, `never !can refill`.
//
//   property = ('never' | 'always') expr
//   expr     = C's operators over: COMPONENT@PLACE, COMPONENT.DATA, can CONNECTOR, can COMPONENT.PORT, ints, floats,
//              strings, true, false, and quantifiers over positions of arrays (quantifier.hpp)
//
// `can c` is true if connector c has an enabled interaction that nothing hides, `can a.p` if port p of a is enabled.
// Paths are those of traces, without ROOT. A division of ints by 0, or of the least int by -1, fails as in models: a
// state in which the property fails violates it. The parser says so in the expression itself, so that no engine and no
// checker has to know. Properties of runs: formula.hpp.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/system/system_ids.hpp"
#include "runtime/core/core.hpp"

namespace bip::verify {

/// The last three are met while a property of runs is parsed (formula.hpp); no Property that is handed out has them.
enum class PropertyKind : std::uint8_t {
  Constant,
  At,
  Data,
  CanConnector,
  CanPort,
  Operator,
  HappensConnector,
  HappensPort,
  Temporal
};
enum class TemporalOperator : std::uint8_t {
  Always,
  Never,
  Eventually,
  Next,
  LeadsTo,
  Until,
  Unless,
  // Of the past.
  Previously,
  Once,
  Historically,
  Since,
  // Of branching time.
  Possibly
};
/// Is the owner of such a node an atom?
[[nodiscard]] constexpr bool names_atom(PropertyKind kind) {
  return kind == PropertyKind::At || kind == PropertyKind::Data || kind == PropertyKind::CanPort;
}
struct PropertyNode {
  PropertyKind kind = PropertyKind::Constant;
  Type type = Type::Bool;
  Op op = Op::And;  // Operator; a unary one has no b
  TemporalOperator temporal = TemporalOperator::Always;
  std::uint32_t a = 0, b = 0;  // rows of nodes
  std::int32_t int_value = 0;  // Constant; a string: row, or -1 if the system has no such string
  double float_value = 0;
  std::uint32_t owner = 0;  // atom or connector
  std::uint32_t row = 0;    // place, variable or port
};
struct Property {
  static constexpr std::uint32_t kNoRow = 0xffffffffu;
  std::vector<PropertyNode> nodes;  // operands before operators
  std::uint32_t root = 0;
  std::uint32_t fault = kNoRow;  // where it holds, a division fails; kNoRow: none can
  bool is_never = false;         // states where the expression is true violate it; else those where it is false
  std::string text;
  // Of a property that is a quantifier, or one and another condition: states where so many of these rows are true, and
  // the row beside them, and no others, violate it.
  struct Counted {
    std::vector<std::uint32_t> rows;
    std::uint32_t least = 0;
    std::uint32_t beside = kNoRow;
  };
  std::optional<Counted> counted = {};
};

/// Parses a property and resolves its names in `system`. The error says the first problem and its column. Cost:
/// linear in the text, with what quantifiers write out (quantifier.hpp), and the system; a property has at most 16,000
/// nodes, written out 1,000,000.
[[nodiscard]] Result<Property> parse_property(const std::string& text, const System& system);

/// Parses an expression as those of properties, of any type but string, and resolves its names.
[[nodiscard]] Result<Property> parse_value(const std::string& text, const System& system);
/// Is it true or false, and no number?
[[nodiscard]] bool is_condition(const Property& expression);
/// The expression's value in the core's stable state; a truth value is 0 or 1. Cost as of is_broken.
[[nodiscard]] double value_in(const Property& expression, const rt::Core& core);

/// Does the core's stable state violate the property? Cost: linear in the expression, `can CONNECTOR` in the
/// candidates.
[[nodiscard]] bool is_broken(const Property& property, const rt::Core& core);
/// Does the property fail itself in the core's stable state: a division by 0, or of the least int by -1?
[[nodiscard]] bool has_fault(const Property& property, const rt::Core& core);
/// Returns the rows of the atoms that the property is about, each once, ascending.
[[nodiscard]] std::vector<std::uint32_t> atoms_of(const Property& property);
[[nodiscard]] std::vector<std::uint32_t> atoms_of(const std::vector<Property>& properties);
/// Does the property ask what can be done (`can`)? With time that changes within a location.
[[nodiscard]] bool asks_offers(const Property& property);
/// Copies the part of the tree that this row is the root of, its operands first. Returns its row in `to`.
std::uint32_t copy_part(const Property& from, std::uint32_t row, Property& to);
/// The data that it reads.
[[nodiscard]] std::vector<DataRef> data_of(const Property& property);
/// Returns the rows of the connectors in `can CONNECTOR`, each once, ascending.
[[nodiscard]] std::vector<std::uint32_t> connectors_of(const Property& property);
/// Returns the expression of violating states as certificates have it: "(and (at ROOT.a EATS) (lt (data ROOT.a n) 3))".
[[nodiscard]] std::string certificate_text(const Property& property, const System& system);

}  // namespace bip::verify
