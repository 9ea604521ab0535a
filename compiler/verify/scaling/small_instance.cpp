// See small_instance.hpp.
#include "compiler/verify/scaling/small_instance.hpp"

#include <algorithm>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class ScaledProperty {
 public:
  ScaledProperty(const Property& property, const System& large_system, const IndexFamilies& large,
                 const Dimensions& dimensions, const System& small_system, const InstanceView& small)
      : property_(property),
        large_system_(large_system),
        large_(large),
        dimensions_(dimensions),
        small_system_(small_system),
        small_(small) {}

  std::optional<Property> run() {
    // Operands stand before operators, so one pass suffices.
    for (u32 row = 0; row < property_.nodes.size(); ++row) rows_.push_back(copy(property_.nodes[row]));
    const std::optional<u32> root = rows_[property_.root];
    if (!root) return std::nullopt;
    result_.root = *root;
    result_.fault =
        property_.fault == Property::kNoRow ? Property::kNoRow : rows_[property_.fault].value_or(Property::kNoRow);
    result_.is_never = property_.is_never;
    result_.text = property_.text;
    return std::move(result_);
  }

 private:
  [[nodiscard]] std::optional<u32> atom(u32 row) const {
    BIP_ASSERT(row < large_.of_atom.size(), "atom {} of {}", row, large_.of_atom.size());
    const Element element = large_.of_atom[row];
    const std::vector<u32>& atoms = small_.families.rows[small_.family_of_large[element.family]].atoms;
    const std::size_t length = large_.rows[element.family].atoms.size(), half = (atoms.size() + 1) / 2;
    if (dimensions_.of_family[element.family] == Dimensions::kFixed || element.index < half)
      return atoms[element.index];
    const std::size_t from_end = length - element.index;
    return from_end <= atoms.size() - half ? std::optional(atoms[atoms.size() - from_end]) : std::nullopt;
  }
  [[nodiscard]] std::optional<u32> connector(u32 row) const {
    const std::string& path = large_system_.connectors[ConnectorId(std::size_t{row})].path;
    for (std::size_t k = 0; k < small_system_.connectors.size(); ++k) {
      if (small_system_.connectors[ConnectorId(k)].path == path) return static_cast<u32>(k);
    }
    return std::nullopt;
  }
  std::optional<u32> copy(PropertyNode node) {
    BIP_ASSERT(node.kind != PropertyKind::Operator ||
                   (node.a < rows_.size() && (operand_count(node.op) < 2 || node.b < rows_.size())),
               "node {} stands before its operands", rows_.size());
    std::optional<u32> owner;
    switch (node.kind) {
      case PropertyKind::Constant:
        if (node.type == Type::String) return std::nullopt;
        break;
      case PropertyKind::At:
      case PropertyKind::Data:
      case PropertyKind::CanPort:
        owner = atom(node.owner);
        if (!owner) return std::nullopt;
        node.owner = *owner;
        break;
      case PropertyKind::CanConnector:
        owner = connector(node.owner);
        if (!owner) return std::nullopt;
        node.owner = *owner;
        break;
      case PropertyKind::HappensConnector:
      case PropertyKind::HappensPort:
      case PropertyKind::Temporal: return std::nullopt;
      case PropertyKind::Operator: {
        const bool is_binary = operand_count(node.op) == 2;
        const std::optional<u32> a = rows_[node.a], b = is_binary ? rows_[node.b] : a;
        const bool may_be_less = is_binary && (node.op == Op::And || node.op == Op::Or);
        if (!a || !b) return !may_be_less ? std::nullopt : a ? a : b;
        node.a = *a;
        if (is_binary) node.b = *b;
        break;
      }
    }
    result_.nodes.push_back(node);
    return static_cast<u32>(result_.nodes.size() - 1);
  }

  const Property& property_;
  const System& large_system_;
  const IndexFamilies& large_;
  const Dimensions& dimensions_;
  const System& small_system_;
  const InstanceView& small_;
  Property result_;
  std::vector<std::optional<u32>> rows_;  // by node of the property: that of the result
};

}  // namespace

std::optional<Question> question_at(const Question& question, const System& large_system, const IndexFamilies& large,
                                    const Dimensions& dimensions, const System& small_system,
                                    const InstanceView& small) {
  Question result;
  result.what = question.what;
  if (question.what != QuestionKind::State) return result;
  std::optional<Property> property =
      ScaledProperty(question.property, large_system, large, dimensions, small_system, small).run();
  if (!property) return std::nullopt;
  result.property = std::move(*property);
  return result;
}

}  // namespace bip::verify
