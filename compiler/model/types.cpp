// Derived numbers of the shared types.
#include "compiler/model/types.hpp"

namespace bip {

std::uint32_t ConnectorType::bind_count(const IndexVector<PortTypeId, PortType>& types) const {
  std::size_t count = data_reads.size();
  for (const ConnectorParam& param : params) count += types[param.type].variables.size();
  return static_cast<std::uint32_t>(count);
}

}  // namespace bip
