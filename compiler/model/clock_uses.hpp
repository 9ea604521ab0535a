// Which clocks do actions read? Those whose values are given to C++ (build_ffi_calls.cpp). Linear in the actions.
#pragma once
#include "compiler/model/code_uses.hpp"
#include "compiler/model/model.hpp"

namespace bip::model {

/// Does an action of the type read the clock's value?
[[nodiscard]] inline bool is_read_by_actions(const CodeTable& code, const AtomType& type, const Clock& clock) {
  bool found = false;
  const auto look = [&](StmtId action) {
    for_each_stmt(code, action, [&](const Stmt& s) {
      for_each_expr(code, s.value,
                    [&](const Expr& e) { found = found || (e.op == Op::LoadSelf && e.index == clock.variable); });
    });
  };
  look(type.initial_action);
  for (const Transition& t : type.transitions) look(t.action);
  return found;
}

}  // namespace bip::model
