// See property_ranges.hpp.
#include "compiler/verify/regions/property_ranges.hpp"

namespace bip::verify {

Range PropertyRanges::of_state(const PropertyNode& node, u32 state) const {
  const LocalSpace& space = space_of_(node.owner);
  if (node.kind == PropertyKind::At) {
    const bool is_marked = space.is_marked(state, node.row);
    return truth_range(!is_marked, is_marked);
  }
  if (node.kind == PropertyKind::CanPort)
    return truth_range(!space.surely_offers(state, node.row), space.may_offer(state, node.row));
  return space.range(state, node.row);
}

bool PropertyRanges::may_be(bool value, const std::map<u32, u32>& state_of) const {
  std::vector<Range> ranges;
  for (const PropertyNode& node : property_.nodes) ranges.push_back(evaluate(node, ranges, state_of));
  const auto includes = [&](u32 row, std::int64_t number) {
    return ranges[row].low <= number && ranges[row].high >= number;
  };
  return includes(property_.root, value ? 1 : 0) ||
         (property_.fault != Property::kNoRow && includes(property_.fault, 1));
}

Range PropertyRanges::evaluate(const PropertyNode& node, const std::vector<Range>& ranges,
                               const std::map<u32, u32>& state_of) const {
  const Range any = node.type == Type::Bool ? kAnyBool : kAnyInt;
  switch (node.kind) {
    case PropertyKind::Constant: return node.type == Type::Float ? any : Range{node.int_value, node.int_value};
    case PropertyKind::At:
    case PropertyKind::Data:
    case PropertyKind::CanPort: return of_state(node, state_of.at(node.owner));
    case PropertyKind::Operator: break;
    case PropertyKind::CanConnector:
    case PropertyKind::HappensConnector:
    case PropertyKind::HappensPort:
    case PropertyKind::Temporal: return any;
  }
  // Of floats and FFI values nothing is known; an int may be compared with a float.
  const auto has_range = [&](u32 operand) {
    const Type type = property_.nodes[operand].type;
    return type != Type::Float && !is_ffi(type) && !ranges[operand].is_empty();
  };
  if (node.type == Type::Float || !has_range(node.a) || (operand_count(node.op) == 2 && !has_range(node.b))) return any;
  const Range &a = ranges[node.a], &b = ranges[node.b];
  switch (operand_count(node.op)) {
    case 1:
      if (node.op == Op::Not) return {1 - a.high, 1 - a.low};
      if (node.op == Op::Neg) return fitted({-a.high, -a.low});
      return any;
    case 2: return IntervalDomain::apply(node.op, a, b);
    default: return any;
  }
}

}  // namespace bip::verify
