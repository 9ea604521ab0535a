// Systems and code written by hand, for the unit tests of lower, interp and emit_cpp.
#pragma once
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "compiler/model/operators.hpp"
#include "compiler/system/system.hpp"

namespace bip::test {

/// Short spellings for rows of a CodeTable.
struct Code {
  CodeTable& table;

  ExprId add(Op op, Type type, ExprId a = {}, ExprId b = {}) {
    Expr e;
    e.op = op;
    e.type = type;
    e.a = a;
    e.b = b;
    e.loc = {0, 10, static_cast<std::uint32_t>(table.exprs.size() + 1)};
    return table.exprs.push(e);
  }
  ExprId constant(Op op, Type type, std::int32_t value) {
    const ExprId id = add(op, type);
    table.exprs[id].int_value = value;
    return id;
  }
  ExprId i(std::int32_t value) { return constant(Op::ConstInt, Type::Int, value); }
  ExprId b(bool value) { return constant(Op::ConstBool, Type::Bool, value ? 1 : 0); }
  ExprId s(const std::string& text) {
    return constant(Op::ConstString, Type::String, static_cast<std::int32_t>(table.string(text)));
  }
  ExprId f(double value) {
    const ExprId id = add(Op::ConstFloat, Type::Float);
    table.exprs[id].float_value = value;
    return id;
  }
  ExprId load(Op op, std::uint32_t index, Type type) {
    const ExprId id = add(op, type);
    table.exprs[id].index = index;
    return id;
  }
  ExprId self(std::uint32_t index, Type type = Type::Int) { return load(Op::LoadSelf, index, type); }
  ExprId bind(std::uint32_t index, Type type = Type::Int) { return load(Op::LoadBind, index, type); }
  ExprId unary(Op op, ExprId a) { return add(op, op == Op::IntToFloat ? Type::Float : table.exprs[a].type, a); }
  ExprId binary(Op op, ExprId a, ExprId b) { return add(op, result_of(op, table.exprs[a].type), a, b); }

  StmtId store(StmtOp op, std::uint32_t index, ExprId value) {
    Stmt s;
    s.op = op;
    s.type = table.exprs[value].type;
    s.index = index;
    s.value = value;
    s.loc = {0, 20 + static_cast<std::uint32_t>(table.stmts.size()), 5};
    return table.stmts.push(s);
  }
  StmtId set(std::uint32_t index, ExprId value) { return store(StmtOp::StoreSelf, index, value); }
  StmtId set_bind(std::uint32_t index, ExprId value) { return store(StmtOp::StoreBind, index, value); }
  StmtId when(ExprId condition, StmtId then_body, StmtId else_body = {}) {
    const StmtId id = store(StmtOp::If, 0, condition);
    table.stmts[id].then_body = then_body;
    table.stmts[id].else_body = else_body;
    return id;
  }
  /// Chains the statements; the first one stands for the body.
  StmtId body(std::initializer_list<StmtId> stmts) {
    StmtId previous;
    for (const StmtId id : stmts) {
      if (previous.is_valid()) table.stmts[previous].next = id;
      previous = id;
    }
    return *stmts.begin();
  }
};

inline DataVariable variable(std::string name, Type type, bool is_param = false) {
  DataVariable s;
  s.name = std::move(name);
  s.type = type;
  s.is_param = is_param;
  return s;
}

inline Transition transition(std::uint32_t port, std::vector<std::uint32_t> from, std::vector<std::uint32_t> to) {
  Transition t;
  t.port = port;
  t.from = std::move(from);
  t.to = std::move(to);
  t.loc = {0, 7, 3};
  return t;
}

/// An atom type Cell with the given variables, one place, and neither ports nor transitions; one instance ROOT.c.
inline System one_atom(std::vector<DataVariable> variables) {
  System s;
  s.files = {"cell.bip"};
  s.code.string("");
  AtomType type;
  type.name = "Cell";
  type.variables = std::move(variables);
  type.places = {"S"};
  type.initial = {0};
  s.atom_types.push(type);
  s.compounds.push({"ROOT", "Root", {}, {0, 1, 1}});
  s.atoms.push({"ROOT.c", AtomTypeId(0u), CompoundId(0u), {}, {0, 2, 3}});
  return s;
}

/// n producers, each with `int step` and `int n` (n grows by step while n < 10), summed by one connector `sum` into its
/// own data, exported and bound by `take` with a consumer's `total`.
inline System producers(std::uint32_t n) {
  System s;
  s.files = {"sum.bip"};
  s.code.string("");
  Code c{s.code};
  const PortTypeId data_port = s.port_types.push({"IntPort", {{"v", Type::Int, {}}}, {}});

  AtomType producer;
  producer.name = "Producer";
  producer.variables = {variable("step", Type::Int, true), variable("n", Type::Int)};
  producer.ports = {{"put", data_port, {1}, true, {}}};
  producer.places = {"run"};
  producer.initial = {0};
  producer.initial_action = c.set(1, c.self(0));
  Transition put = transition(0, {0}, {0});
  put.guard = c.binary(Op::Lt, c.self(1), c.i(10));
  put.action = c.set(1, c.binary(Op::Add, c.self(1), c.self(0)));
  producer.transitions = {put};
  const AtomTypeId producer_id = s.atom_types.push(producer);

  AtomType consumer;
  consumer.name = "Consumer";
  consumer.variables = {variable("spare", Type::Float), variable("total", Type::Int)};
  consumer.ports = {{"get", data_port, {1}, true, {}}};
  consumer.places = {"idle", "busy"};
  consumer.initial = {0};
  consumer.transitions = {transition(0, {0}, {1}), transition(Transition::kInternal, {1}, {0})};
  const AtomTypeId consumer_id = s.atom_types.push(consumer);

  ConnectorType sum;
  sum.name = "Sum";
  sum.variables = {variable("total", Type::Int)};
  sum.define.push_back({false, false, 0, {}});
  Clause up;
  ExprId value = c.i(0);
  for (std::uint32_t k = 0; k < n; ++k) {
    sum.params.push_back({"p" + std::to_string(k), data_port, k, {}});
    sum.define.push_back({true, false, k, {}});
    sum.define[0].children.push_back(k + 1);
    up.params.push_back(k);
    value = c.binary(Op::Add, value, c.bind(k));
  }
  up.up = c.set(0, value);
  sum.clauses = {up};
  sum.exports = true;
  sum.export_name = "out";
  sum.export_type = data_port;
  sum.export_variables = {0};
  const ConnectorTypeId sum_id = s.connector_types.push(sum);

  ConnectorType take;
  take.name = "Take";
  take.params = {{"from", data_port, 0, {}}, {"to", data_port, 1, {}}};
  take.define = {{false, false, 0, {1, 2}}, {true, false, 0, {}}, {true, false, 1, {}}};
  Clause down;
  down.params = {0, 1};
  down.guard = c.binary(Op::Gt, c.bind(0), c.i(0));
  down.down = c.set_bind(1, c.bind(0));
  take.clauses = {down};
  const ConnectorTypeId take_id = s.connector_types.push(take);

  const CompoundId root = s.compounds.push({"ROOT", "Root", {}, {0, 1, 1}});
  Connector sum_instance{"ROOT.sum", sum_id, root, {}, {}, true, {0, 30, 3}};
  for (std::uint32_t k = 0; k < n; ++k) {
    Value step;
    step.int_value = static_cast<std::int32_t>(k + 1);
    const AtomId id = s.atoms.push({"ROOT.p[" + std::to_string(k) + "]", producer_id, root, {step}, {0, 25, 3}});
    PortRef ref;
    ref.atom = id;
    sum_instance.ports.push_back(ref);
  }
  const AtomId consumer_atom = s.atoms.push({"ROOT.c", consumer_id, root, {}, {0, 26, 3}});
  const ConnectorId sum_row = s.connectors.push(sum_instance);
  PortRef from, to;
  from.kind = PortRef::Kind::Connector;
  from.connector = sum_row;
  to.atom = consumer_atom;
  s.connectors.push({"ROOT.take", take_id, root, {from, to}, {}, false, {0, 31, 3}});
  return s;
}

}  // namespace bip::test
