// Plans: what an interaction that is Planned consists of, its connector with the hierarchy below expanded to a tree in
// preorder (Plan, in tables.hpp).
//
// Cost: linear in the trees. One builder makes all plans, because each would otherwise allocate what the one before it
// has just given back.
#pragma once
#include <vector>

#include "runtime/core/link/tables.hpp"

namespace bip::rt {

class PlanBuilder {
 public:
  explicit PlanBuilder(Tables& tables) : tables_(tables) {}
  /// Adds the plan of an interaction of a connector and makes the interaction lead to it.
  void add(InteractionInfo& info);
  /// Returns the row of the type's clause for all of its parameters, or kNone.
  [[nodiscard]] u32 clause_of_all(u32 connector_type);

 private:
  // What is still to be added, last first: a define node of a use, below a node of the plan.
  struct Todo {
    u32 use, define, parent;
    bool trigger;
    const PortRef* alternative = nullptr;  // one of the ports of the choice `parent`, not a define node
  };
  // A member of a group of inner rules.
  struct Member {
    u32 group, connector;
  };
  // What the clauses of a plan's connectors say.
  struct Code {
    bool all_have_ranges = true;
    bool any_up = false, any_down = false;
  };

  void list_members(u32 top);
  void add_use(u32 connector, u32 link);
  void add_member();
  void add_node();
  void finish_nodes();
  void finish_uses();

  Tables& tables_;
  Plan plan_;
  Code code_;
  std::size_t links_ = 0, maximal_ = 0;  // nodes of the plan
  std::vector<Todo> todo_;
  std::vector<Member> members_;                // last first
  std::vector<u32> all_params_;                // 0, 1, 2, ...
  std::vector<u32> plan_of_connector_;         // the last one that uses it, plus 1
  std::vector<u32> todo_connectors_, groups_;  // scratch of list_members
  std::vector<u32> listed_for_;                // the same: by connector, the last plan, plus 1
};

}  // namespace bip::rt
