// Derived numbers and words of the shared types.
#include "compiler/model/types.hpp"

namespace bip {

const char* name_of(BoundOp op) {
  static constexpr const char* kNames[] = {"lt", "le", "gt", "ge", "eq"};
  return kNames[static_cast<int>(op)];
}
const char* name_of(Urgency urgency) {
  static constexpr const char* kNames[] = {"lazy", "delayable", "eager"};
  return kNames[static_cast<int>(urgency)];
}
const char* name_of(EventPolicy policy) {
  static constexpr const char* kNames[] = {"remember", "ignore", "error"};
  return kNames[static_cast<int>(policy)];
}

std::uint32_t ConnectorType::bind_count(const IndexVector<PortTypeId, PortType>& types) const {
  std::size_t count = data_reads.size();
  for (const ConnectorParam& param : params) count += types[param.type].variables.size();
  return static_cast<std::uint32_t>(count);
}

}  // namespace bip
