// Evaluates a property in a state of the core, and prints it for certificates.
#include "compiler/system/system.hpp"
#include "compiler/verify/property/expression.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "compiler/model/fold.hpp"
#include "runtime/core/text.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

bool is_unary(const PropertyNode& node) { return operand_count(node.op) == 1; }

struct Number {
  std::int64_t i = 0;
  double f = 0;
};

Number evaluate(const Property& property, std::uint32_t row, const rt::Core& core) {
  BIP_ASSERT(row < property.nodes.size(), "node {} of {}", row, property.nodes.size());
  const PropertyNode& node = property.nodes[row];
  const auto of = [](std::int64_t i) { return Number{i, static_cast<double>(i)}; };
  switch (node.kind) {
    case PropertyKind::Constant: return node.type == Type::Float ? Number{0, node.float_value} : of(node.int_value);
    case PropertyKind::At: return of(core.is_marked(node.owner, node.row) ? 1 : 0);
    case PropertyKind::Data: {
      const rt::Cell& variable = core.cell(core.image().atoms[node.owner].variable(node.row));
      return node.type == Type::Float ? Number{0, variable.f} : of(variable.i);
    }
    case PropertyKind::CanConnector:
      for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
        if (core.candidate(k).connector == node.owner) return of(1);
      }
      return of(0);
    case PropertyKind::CanPort: return of(core.enabled_transition(node.owner, node.row) != rt::kNone ? 1 : 0);
    case PropertyKind::HappensConnector:
    case PropertyKind::HappensPort:
    case PropertyKind::Temporal: BIP_UNREACHABLE("a property of runs");
    case PropertyKind::Operator: break;
  }
  const Number a = evaluate(property, node.a, core), b = is_unary(node) ? a : evaluate(property, node.b, core);
  const bool floats = property.nodes[node.a].type == Type::Float || property.nodes[node.b].type == Type::Float;
  const auto i32 = [](const Number& n) { return static_cast<std::int32_t>(n.i); };
  // What the rest of the property says of this state is then of no matter.
  if (!floats && is_division(node.op) && division_faults(i32(a), i32(b))) return of(0);
  if (is_unary(node)) return floats ? Number{0, -a.f} : of(fold_int(node.op, i32(a)));
  if (!floats) return of(fold_int(node.op, i32(a), i32(b)));
  if (is_comparison(node.op)) return of(fold_comparison(node.op, a.f, b.f) ? 1 : 0);
  return Number{0, fold_float(node.op, a.f, b.f)};
}

// Not to be mistaken for an int: "2.0".
std::string float_text(double value) {
  std::string text = fmt::format("{}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string node_text(const Property& property, std::uint32_t row, const System& system) {
  const PropertyNode& node = property.nodes[row];
  const auto type_of = [&]() -> const AtomType& {
    return system.atom_types[system.atoms[AtomId(std::size_t{node.owner})].type];
  };
  const auto path = [&] { return system.atoms[AtomId(std::size_t{node.owner})].path; };
  switch (node.kind) {
    case PropertyKind::Constant:
      if (node.type == Type::Bool) return node.int_value != 0 ? "true" : "false";
      if (node.type == Type::Float) return float_text(node.float_value);
      return std::to_string(node.int_value);
    case PropertyKind::At: return "(at " + path() + ' ' + type_of().places[node.row] + ')';
    case PropertyKind::Data: return "(data " + path() + ' ' + type_of().variables[node.row].name + ')';
    case PropertyKind::CanConnector:
      return "(can " + system.connectors[ConnectorId(std::size_t{node.owner})].path + ')';
    case PropertyKind::CanPort: return "(can-port " + path() + ' ' + type_of().ports[node.row].name + ')';
    case PropertyKind::HappensConnector:
    case PropertyKind::HappensPort:
    case PropertyKind::Temporal: BIP_UNREACHABLE("a property of runs");
    case PropertyKind::Operator: break;
  }
  std::string text = '(' + std::string(info_of(node.op).word) + ' ' + node_text(property, node.a, system);
  if (!is_unary(node)) text += ' ' + node_text(property, node.b, system);
  return text + ')';
}

}  // namespace

bool is_condition(const Property& expression) { return expression.nodes[expression.root].type == Type::Bool; }

double value_in(const Property& expression, const rt::Core& core) {
  const Number value = evaluate(expression, expression.root, core);
  return expression.nodes[expression.root].type == Type::Float ? value.f : static_cast<double>(value.i);
}

bool has_fault(const Property& property, const rt::Core& core) {
  return property.fault != Property::kNoRow && evaluate(property, property.fault, core).i != 0;
}

bool is_true(const Property& expression, const rt::Core& core) {
  return !has_fault(expression, core) && evaluate(expression, expression.root, core).i != 0;
}

std::string value_text(const Property& expression, const rt::Core& core) {
  const PropertyNode& root = expression.nodes[expression.root];
  if (has_fault(expression, core)) return "a division by zero, or of the least int by -1";
  const Number value = evaluate(expression, expression.root, core);
  if (root.type == Type::Bool) return value.i != 0 ? "true" : "false";
  rt::Cell cell{};
  if (root.type == Type::Float) cell.f = value.f;
  else cell.i = static_cast<std::int32_t>(value.i);
  // A string that is in no state has no row.
  if (root.type == Type::String && cell.i < 0) return "a string that the model does not have";
  std::string text;
  const rt::CellType type = root.type == Type::Float    ? rt::CellType::Float
                            : root.type == Type::String ? rt::CellType::String
                                                        : rt::CellType::Int;
  rt::append_value(text, core.image(), type, cell);
  return text;
}

bool is_broken(const Property& property, const rt::Core& core) {
  return (evaluate(property, property.root, core).i != 0) == property.is_never;
}

namespace {
template <class Test>
std::vector<std::uint32_t> owners_of(const Property& property, const Test& test) {
  std::vector<std::uint32_t> owners;
  for (const PropertyNode& node : property.nodes) {
    if (test(node.kind)) owners.push_back(node.owner);
  }
  std::sort(owners.begin(), owners.end());
  owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
  return owners;
}
}  // namespace

bool asks_offers(const Property& property) {
  return std::any_of(property.nodes.begin(), property.nodes.end(), [](const PropertyNode& node) {
    return node.kind == PropertyKind::CanConnector || node.kind == PropertyKind::CanPort;
  });
}

std::vector<std::uint32_t> atoms_of(const Property& property) { return owners_of(property, names_atom); }

std::vector<std::uint32_t> atoms_of(const std::vector<Property>& properties) {
  std::vector<std::uint32_t> atoms;
  for (const Property& property : properties) {
    const std::vector<std::uint32_t> own = atoms_of(property);
    atoms.insert(atoms.end(), own.begin(), own.end());
  }
  std::sort(atoms.begin(), atoms.end());
  atoms.erase(std::unique(atoms.begin(), atoms.end()), atoms.end());
  return atoms;
}

std::vector<std::uint32_t> connectors_of(const Property& property) {
  return owners_of(property, [](PropertyKind kind) { return kind == PropertyKind::CanConnector; });
}

std::uint32_t copy_part(const Property& from, std::uint32_t row, Property& to) {
  PropertyNode node = from.nodes[row];
  if (node.kind == PropertyKind::Operator) {
    const bool is_unary = node.a == node.b;
    node.a = copy_part(from, node.a, to);
    node.b = is_unary ? node.a : copy_part(from, node.b, to);
  }
  BIP_ASSERT(node.kind != PropertyKind::Operator || (node.a < to.nodes.size() && node.b < to.nodes.size()),
             "a copy of node {} stands before its operands", row);
  to.nodes.push_back(node);
  return static_cast<std::uint32_t>(to.nodes.size() - 1);
}

std::vector<DataRef> data_of(const Property& property) {
  std::vector<DataRef> data;
  for (const PropertyNode& node : property.nodes) {
    if (node.kind == PropertyKind::Data) data.push_back({AtomId(std::size_t{node.owner}), node.row});
  }
  return data;
}

std::string certificate_text(const Property& property, const System& system) {
  const std::string expr = node_text(property, property.root, system);
  return property.is_never ? expr : "(not " + expr + ')';
}

}  // namespace bip::verify
