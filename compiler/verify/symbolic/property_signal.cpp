// See property_signal.hpp.
#include "compiler/verify/symbolic/property_signal.hpp"

#include <vector>

#include "compiler/model/operators.hpp"
#include "compiler/verify/symbolic/symbolic_code.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

Word signal_of(const Property& property, std::uint32_t row, TransitionSystem& m, const rt::Image& image,
               const std::vector<std::uint32_t>& port_base) {
  const PropertyNode& node = property.nodes[row];
  Aig& c = m.aig;
  switch (node.kind) {
    case PropertyKind::Constant: return node.type == Type::Float ? Word{} : word_of(node.int_value);
    case PropertyKind::At: return word_of_bool(m.marks[node.owner][node.row]);
    case PropertyKind::Data: return m.words[image.atoms[node.owner].first_cell + node.row];
    case PropertyKind::CanConnector: return word_of_bool(m.connector_can[node.owner]);
    case PropertyKind::CanPort: return word_of_bool(m.port_is_on[port_base[node.owner] + node.row]);
    case PropertyKind::HappensConnector:
    case PropertyKind::HappensPort:
    case PropertyKind::Temporal: BIP_UNREACHABLE("a property of runs");
    case PropertyKind::Operator: break;
  }
  const bool is_unary = operand_count(node.op) == 1;
  const Word a = signal_of(property, node.a, m, image, port_base);
  const Word b = is_unary ? a : signal_of(property, node.b, m, image, port_base);
  // Floats are not followed: any value.
  if (a.empty() || b.empty()) return node.type == Type::Bool ? word_of_bool(c.make_input()) : Word{};
  if (is_division(node.op)) {
    const Division division = divide(c, a, b);
    return node.op == Op::Div ? division.quotient : division.remainder;
  }
  return is_unary ? apply(c, node.op, a) : apply(c, node.op, a, b);
}

}  // namespace

Signal violating_signal(const Property& property, TransitionSystem& machine, const rt::Image& image) {
  std::vector<std::uint32_t> port_base;
  std::uint32_t next = 0;
  for (const rt::Atom& atom : image.atoms) {
    port_base.push_back(next);
    next += image.atom_types[atom.type].ports.size;
  }
  BIP_ASSERT(property.nodes[property.root].type == Type::Bool, "a property of type {}",
             property.nodes[property.root].type);
  const Signal holds = signal_of(property, property.root, machine, image, port_base)[0];
  return property.is_never ? holds : negated(holds);
}

Signal broken_signal(const Property& property, TransitionSystem& machine, const rt::Image& image) {
  // A state in which the run ends with a fault is none.
  return machine.aig.make_and(negated(machine.state_fault), violating_signal(property, machine, image));
}

}  // namespace bip::verify
