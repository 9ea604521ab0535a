// What may be asked about states: `never phil[0]@EATS && phil[1]@EATS`, `always pump.level <= 10`, `never !can refill`.
//
//   property = ('never' | 'always') expr
//   expr     = C's operators over: COMPONENT@PLACE, COMPONENT.DATA, can CONNECTOR, can COMPONENT.PORT, ints, floats,
//   strings, true, false
//
// It speaks of stable states. `can c`: connector c has an interaction that may be taken; `can a.p`: port p of a is
// enabled. Paths are those of traces, without ROOT. Division is left out: a property must not fail itself.
#pragma once
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/symbolic/transition_system.hpp"
#include "runtime/core/core.hpp"

namespace bip::verify {

enum class PropertyKind : std::uint8_t { Constant, At, Data, CanConnector, CanPort, Operator };
struct PropertyNode {
  PropertyKind kind = PropertyKind::Constant;
  Type type = Type::Bool;
  Op op = Op::And;             // Operator; a unary one has no b
  std::uint32_t a = 0, b = 0;  // rows of nodes
  std::int32_t int_value = 0;  // Constant; a string: row, or -1 if the system has no such string
  double float_value = 0;
  std::uint32_t owner = 0;  // atom or connector
  std::uint32_t row = 0;    // place, variable or port
};
struct Property {
  std::vector<PropertyNode> nodes;  // operands before operators
  std::uint32_t root = 0;
  bool is_never = false;  // the states that break it: where the expression is true
  std::string text;
};

/// The error is what was wrong, with its column.
[[nodiscard]] Result<Property> parse_property(const std::string& text, const System& system);

/// Does the core's state break the property?
[[nodiscard]] bool is_broken(const Property& property, const rt::Core& core);
/// The same as a circuit.
[[nodiscard]] Signal broken_signal(const Property& property, TransitionSystem& machine, const rt::Image& image);
/// The components that it speaks of, each once, in the order of the system.
[[nodiscard]] std::vector<std::uint32_t> atoms_of(const Property& property);
/// The connectors that it asks for, each once.
[[nodiscard]] std::vector<std::uint32_t> connectors_of(const Property& property);
/// For certificates: "(and (at ROOT.a EATS) (lt (data ROOT.a n) 3))".
[[nodiscard]] std::string certificate_text(const Property& property, const System& system);

}  // namespace bip::verify
