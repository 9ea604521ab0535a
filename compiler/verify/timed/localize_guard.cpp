// See localize_guard.hpp.
#include "compiler/verify/timed/localize_guard.hpp"

#include <algorithm>
#include <optional>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Deeper guards count as true. The parser limits the nesting of sources.
constexpr u32 kMaxGuardDepth = 500;

// The guard of a connector of atoms' ports, if it decides the rendezvous and reads nothing but their variables. Else
// null.
const Clause* clause_of(const System& system, const Neighbours::Top& top) {
  const Connector& connector = system.connectors[top.connector];
  const ConnectorType& type = system.connector_types[connector.type];
  if (!top.is_plain || type.clauses.size() != 1 || type.clauses[0].params.size() != type.params.size()) return nullptr;
  const Clause& clause = type.clauses[0];
  return clause.guard.is_valid() && !clause.up.is_valid() ? &clause : nullptr;
}

struct Source {
  u32 atom = 0, port = 0, row = 0, variable = 0;  // row: of the port's variables
};
std::optional<Source> source_of(const System& system, const Connector& connector, u32 bind) {
  BIP_ASSERT(std::all_of(connector.ports.begin(), connector.ports.end(),
                         [](const PortRef& ref) { return ref.kind == PortRef::Kind::Atom; }),
             "`{}` is no rendezvous of atoms", connector.path);
  const ConnectorType& type = system.connector_types[connector.type];
  for (std::size_t p = type.params.size(); p-- > 0;) {
    if (bind < type.params[p].first_bind) continue;
    const PortRef& ref = connector.ports[p];
    const std::vector<u32>& variables = system.atom_types[system.atoms[ref.atom].type].ports[ref.port].variables;
    const u32 variable = bind - type.params[p].first_bind;
    // Data that a connector reads beside its ports stand after all port variables.
    if (variable >= variables.size()) return std::nullopt;
    return Source{ref.atom.value, ref.port, variable, variables[variable]};
  }
  return std::nullopt;
}

class GuardWeakener {
 public:
  GuardWeakener(const System& system, const Connector& connector, CodeTable& code, const VariableFacts& constant,
                const std::vector<Neighbours::Leaf>& inside)
      : system_(system), connector_(connector), code_(code), constant_(constant), inside_(inside) {
    u32 binds = 0;
    for (const Neighbours::Leaf& leaf : inside) {
      first_bind_.push_back(binds);
      binds += static_cast<u32>(
          system.atom_types[system.atoms[AtomId(std::size_t{leaf.atom})].type].ports[leaf.port].variables.size());
    }
  }

  // Returns the weakened condition and appends its text; invalid: true.
  ExprId weaker(ExprId id, std::vector<std::int64_t>& text, u32 depth) {
    const Expr e = code_.exprs[id];
    if (depth > kMaxGuardDepth) return {};
    if (e.op != Op::And) {
      std::vector<std::int64_t> mine;
      const ExprId same = exact(id, mine, depth);
      if (same.is_valid()) text.insert(text.end(), mine.begin(), mine.end());
      return same;
    }
    const ExprId a = weaker(e.a, text, depth + 1), b = weaker(e.b, text, depth + 1);
    if (!a.is_valid() || !b.is_valid()) return a.is_valid() ? a : b;
    text.push_back(static_cast<std::int64_t>(Op::And));
    Expr both = e;
    both.a = a;
    both.b = b;
    return code_.exprs.push(both);
  }

 private:
  // Returns a copy of the expression over member data and constants; invalid: there is none.
  ExprId exact(ExprId id, std::vector<std::int64_t>& text, u32 depth) {
    Expr e = code_.exprs[id];
    if (depth > kMaxGuardDepth) return {};
    switch (e.op) {
      case Op::Call:
      case Op::LoadSelf:
      case Op::ConstFloat: BIP_DIVISION_OPS(BIP_OP_CASE) return {};
      case Op::LoadBind:
        if (!load(e)) return {};
        break;
      case Op::ConstInt:
      case Op::ConstBool:
      case Op::ConstString:
        BIP_UNARY_OPS(BIP_OP_CASE)
        BIP_ARITHMETIC_OPS(BIP_OP_CASE)
        BIP_BITWISE_OPS(BIP_OP_CASE)
        BIP_LOGIC_OPS(BIP_OP_CASE)
        BIP_COMPARISON_OPS(BIP_OP_CASE)
        if (e.a.is_valid() && !(e.a = exact(e.a, text, depth + 1)).is_valid()) return {};
        if (e.b.is_valid() && !(e.b = exact(e.b, text, depth + 1)).is_valid()) return {};
    }
    text.insert(text.end(), {static_cast<std::int64_t>(e.op), e.index, e.int_value});
    return code_.exprs.push(e);
  }

  bool load(Expr& e) const {
    const std::optional<Source> source = source_of(system_, connector_, e.index);
    if (!source) return false;
    const auto leaf = std::find(inside_.begin(), inside_.end(), Neighbours::Leaf{source->atom, source->port});
    if (leaf != inside_.end()) {
      e.index = first_bind_[static_cast<std::size_t>(leaf - inside_.begin())] + source->row;
      return true;
    }
    const AbstractValue value = constant_(source->atom, source->variable);
    if (!value.is_known || (e.type == Type::String && value.value < 0)) return false;
    if (e.type != Type::Int && e.type != Type::Bool && e.type != Type::String) return false;
    e.op = e.type == Type::Int ? Op::ConstInt : e.type == Type::Bool ? Op::ConstBool : Op::ConstString;
    e.index = 0;
    e.int_value = value.value;
    return true;
  }

  const System& system_;
  const Connector& connector_;
  CodeTable& code_;
  const VariableFacts& constant_;
  const std::vector<Neighbours::Leaf>& inside_;
  std::vector<u32> first_bind_;
};

}  // namespace

LocalizedGuard localize_guard(const System& system, const Neighbours::Top& top, CodeTable& code,
                              const VariableFacts& constant, const std::vector<Neighbours::Leaf>& inside) {
  BIP_ASSERT(std::is_sorted(inside.begin(), inside.end()), "{} ports are not in their order", inside.size());
  LocalizedGuard result;
  const Clause* clause = clause_of(system, top);
  if (clause == nullptr) return result;
  result.guard = GuardWeakener(system, system.connectors[top.connector], code, constant, inside)
                     .weaker(clause->guard, result.text, 0);
  return result;
}

bool may_hold(const System& system, const Neighbours::Top& top, const VariableFacts& value) {
  const Clause* clause = clause_of(system, top);
  if (clause == nullptr) return true;
  const Connector& connector = system.connectors[top.connector];
  std::vector<AbstractValue> bind(system.connector_types[connector.type].bind_count(system.port_types));
  for (u32 k = 0; k < bind.size(); ++k) {
    if (const std::optional<Source> source = source_of(system, connector, k))
      bind[k] = value(source->atom, source->variable);
  }
  const AbstractValue guard = evaluate(system.code, clause->guard, {}, bind);
  return !guard.is_known || guard.value != 0;
}

}  // namespace bip::verify
