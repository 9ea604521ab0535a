// See symmetric_property.hpp. Each subexpression gets the number of its class (hash consing): a term is its operator
// and the classes of its operands, sorted where their order does not count.
#include "compiler/verify/property/symmetric_property.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

using std::uint32_t;

// Over the truth values, and over ints, which wrap. The sum of floats depends on its order.
bool is_associative(const PropertyNode& node) {
  if (node.kind != PropertyKind::Operator || node.type == Type::Float) return false;
  return node.op == Op::And || node.op == Op::Or || node.op == Op::Add || node.op == Op::Mul;
}
bool is_commutative(Op op) {
  return op == Op::And || op == Op::Or || op == Op::Add || op == Op::Mul || op == Op::Eq || op == Op::Ne;
}

}  // namespace

PropertyImages::PropertyImages(const Property& property) : property_(property) {
  const std::vector<PropertyNode>& nodes = property.nodes;
  is_inner_.assign(nodes.size(), 1);
  BIP_ASSERT(property.root < nodes.size(), "node {} of {} is the root", property.root, nodes.size());
  is_inner_[property.root] = 0;
  for (const PropertyNode& node : nodes) {
    if (node.kind != PropertyKind::Operator) continue;
    for (const uint32_t operand : {node.a, operand_count(node.op) == 1 ? node.a : node.b}) {
      const bool is_same = is_associative(node) && is_associative(nodes[operand]) && nodes[operand].op == node.op;
      if (!is_same) is_inner_[operand] = 0;
    }
  }
  root_class_ = class_of({}, terms_);
}

bool PropertyImages::is_preserved_by(const std::map<uint32_t, uint32_t>& exchange) const {
  std::map<Term, uint32_t> terms = terms_;
  return class_of(exchange, terms) == root_class_;
}

uint32_t PropertyImages::class_of(const std::map<uint32_t, uint32_t>& exchange, std::map<Term, uint32_t>& terms) const {
  const std::vector<PropertyNode>& nodes = property_.nodes;
  std::vector<uint32_t> classes(nodes.size(), 0);
  for (uint32_t row = 0; row < nodes.size(); ++row) {
    const PropertyNode& node = nodes[row];
    BIP_ASSERT(node.kind != PropertyKind::Operator || (node.a < row && node.b < row),
               "node {} stands before its operands", row);
    // The operator above takes the operands of this one.
    if (is_inner_[row] != 0) continue;
    Term term{static_cast<uint32_t>(node.kind), static_cast<uint32_t>(node.type)};
    const auto image_of = [&](uint32_t atom) {
      const auto found = exchange.find(atom);
      return found == exchange.end() ? atom : found->second;
    };
    switch (node.kind) {
      case PropertyKind::Constant: {
        const auto bits = std::bit_cast<std::uint64_t>(node.float_value);
        term.insert(term.end(), {static_cast<uint32_t>(node.int_value), static_cast<uint32_t>(bits),
                                 static_cast<uint32_t>(bits >> 32)});
        break;
      }
      case PropertyKind::At:
      case PropertyKind::Data:
      case PropertyKind::CanPort:
      case PropertyKind::HappensPort: term.insert(term.end(), {image_of(node.owner), node.row}); break;
      case PropertyKind::CanConnector:
      case PropertyKind::HappensConnector: term.push_back(node.owner); break;
      case PropertyKind::Temporal: term.insert(term.end(), {static_cast<uint32_t>(node.temporal), row}); break;
      case PropertyKind::Operator: {
        const bool is_unary = operand_count(node.op) == 1;
        term.push_back(static_cast<uint32_t>(node.op));
        const auto first = static_cast<std::ptrdiff_t>(term.size());
        std::vector<uint32_t> open{node.a};
        if (!is_unary) open.push_back(node.b);
        for (std::size_t k = 0; k < open.size(); ++k) {
          const PropertyNode& operand = nodes[open[k]];
          if (is_associative(node) && is_associative(operand) && operand.op == node.op) {
            open.push_back(operand.a);
            open.push_back(operand.b);
          } else {
            term.push_back(classes[open[k]]);
          }
        }
        if (!is_unary && is_commutative(node.op)) std::sort(term.begin() + first, term.end());
        break;
      }
    }
    classes[row] = terms.try_emplace(std::move(term), static_cast<uint32_t>(terms.size())).first->second;
  }
  return classes[property_.root];
}

}  // namespace bip::verify
