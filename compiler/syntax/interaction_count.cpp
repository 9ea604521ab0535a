// See interaction_count.hpp.
#include "compiler/syntax/interaction_count.hpp"

namespace bip::syntax {
namespace {

double count_of(const PortExpr& e) {
  if (e.kind == PortExprKind::Port) return 1;
  GroupCount group;
  for (const PortExpr* child : e.children) group.add(count_of(*child), child->trigger);
  return group.count();
}

}  // namespace

double interaction_count(const ConnectorBody& body, std::size_t ports) {
  if (body.define != nullptr) return count_of(*body.define);
  GroupCount subsets;
  for (std::size_t k = 0; k < ports; ++k) subsets.add(1, /*is_trigger=*/true);
  return subsets.count();
}

}  // namespace bip::syntax
