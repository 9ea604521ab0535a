// The sample System: two atom types, a connector that exports, one above it, priorities; see bsys_sample.hpp.
#include "tests/unit/system/bsys_sample.hpp"

#include <limits>

namespace bip::test {
namespace {

/// Appends code rows.
class Code {
 public:
  explicit Code(CodeTable& table) : table_(table) {}

  ExprId constant(Op op, Type type, std::int32_t i, double f = 0) {
    Expr e;
    e.op = op;
    e.type = type;
    e.int_value = i;
    e.float_value = f;
    return table_.exprs.push(e);
  }
  ExprId i(std::int32_t value) { return constant(Op::ConstInt, Type::Int, value); }
  ExprId b(bool value) { return constant(Op::ConstBool, Type::Bool, value ? 1 : 0); }
  ExprId f(double value) { return constant(Op::ConstFloat, Type::Float, 0, value); }
  ExprId s(std::int32_t row) { return constant(Op::ConstString, Type::String, row); }
  ExprId load(Op op, Type type, std::uint32_t index) {
    Expr e;
    e.op = op;
    e.type = type;
    e.index = index;
    return table_.exprs.push(e);
  }
  ExprId self(Type type, std::uint32_t index) { return load(Op::LoadSelf, type, index); }
  ExprId bind(Type type, std::uint32_t index) { return load(Op::LoadBind, type, index); }
  ExprId op(Op o, Type type, ExprId a, ExprId b_ = {}, Loc loc = {}) {
    Expr e;
    e.op = o;
    e.type = type;
    e.a = a;
    e.b = b_;
    e.loc = loc;
    return table_.exprs.push(e);
  }
  StmtId store(StmtOp o, Type type, std::uint32_t index, ExprId value, StmtId next = {}, Loc loc = {}) {
    Stmt s;
    s.op = o;
    s.type = type;
    s.index = index;
    s.value = value;
    s.next = next;
    s.loc = loc;
    return table_.stmts.push(s);
  }
  StmtId branch(ExprId condition, StmtId then_body, StmtId else_body, StmtId next = {}, Loc loc = {}) {
    Stmt s;
    s.op = StmtOp::If;
    s.value = condition;
    s.then_body = then_body;
    s.else_body = else_body;
    s.next = next;
    s.loc = loc;
    return table_.stmts.push(s);
  }

 private:
  CodeTable& table_;
};

DefineNode leaf(std::uint32_t param, bool trigger) {
  return {.is_leaf = true, .trigger = trigger, .param = param, .children = {}};
}
DefineNode group(std::vector<std::uint32_t> children, bool trigger = false) {
  return {.is_leaf = false, .trigger = trigger, .param = 0, .children = std::move(children)};
}

/// Hidden variables 5 to 11: two clocks and a limit. Every kind of bound, urgency and policy occurs.
void add_time(AtomType& type, Code& c) {
  using enum Type;
  for (const char* name : {"t", "u"}) {
    type.clocks.push_back({.name = name,
                           .unit = 1'000'000,
                           .variable = static_cast<std::uint32_t>(type.variables.size()),
                           .loc = {0, 12, 3}});
    for (const Type variable : {Float, Bool, Float})
      type.variables.push_back(
          {.name = std::string("clock ") + name, .type = variable, .is_param = false, .exported = false, .loc = {}});
  }
  type.variables.push_back({.name = "limit 0", .type = Float, .is_param = false, .exported = false, .loc = {}});
  const Bound at_least{.clock = 0, .op = BoundOp::Ge, .ticks = 5'000'000, .loc = {0, 17, 9}};
  const Bound difference{.clock = 1, .minus = 0, .op = BoundOp::Lt, .ticks = -7, .loc = {}};
  const Bound measured{.clock = 0, .op = BoundOp::Le, .variable = 11, .loc = {}};
  const auto measure = [&] {
    return c.store(StmtOp::StoreSelf, Float, 11, c.op(Op::IntToFloat, Float, c.self(Int, 0)));
  };
  type.initial_resume = {.present = true,
                         .guard = {},
                         .when = {.bounds = {{.clock = 1, .op = BoundOp::Gt, .ticks = 1}}},
                         .loc = {0, 11, 30}};
  type.transitions[0].when = {.bounds = {at_least, difference}};
  type.transitions[0].urgency = Urgency::Eager;
  type.transitions[0].resume = {
      .present = true, .guard = c.self(Bool, 2), .when = {.bounds = {measured}, .measure = measure()}, .loc = {}};
  type.transitions[2].when = {.bounds = {measured, {.clock = 1, .op = BoundOp::Eq, .ticks = 3}}, .measure = measure()};
  type.transitions[2].urgency = Urgency::Delayable;
  type.ports[1].external = true;
  type.ports[1].policy = EventPolicy::Ignore;
  type.ports[1].event_class = "space::Button";
  type.invariants.push_back({.name = "life",
                             .scope = InvariantScope::Always,
                             .places = {},
                             .condition = {},
                             .loc = {},
                             .when = {.bounds = {measured}, .measure = measure()}});
}

/// Interactions: param n, data x, on, f, s. Every operator occurs in its code.
AtomType worker(Code& c) {
  using enum Type;
  AtomType type;
  type.name = "Worker";
  type.loc = {0, 10, 1};
  type.variables = {{.name = "n", .type = Int, .is_param = true, .exported = false, .loc = {0, 10, 18}},
                    {.name = "x", .type = Int, .is_param = false, .exported = true, .loc = {0, 11, 12}},
                    {.name = "on", .type = Bool, .is_param = false, .exported = false, .loc = {}},
                    {.name = "f", .type = Float, .is_param = false, .exported = false, .loc = {}},
                    {.name = "s", .type = String, .is_param = false, .exported = true, .loc = {}}};
  type.ports = {{.name = "put", .type = PortTypeId(1u), .variables = {1, 3}, .exported = true, .loc = {0, 13, 3}},
                {.name = "tick", .type = PortTypeId(0u), .variables = {}, .exported = false, .loc = {}}};
  type.places = {"idle", "busy", "an odd place"};
  type.initial = {0, 2};
  type.initial_action = c.store(StmtOp::StoreSelf, Int, 1, c.i(std::numeric_limits<std::int32_t>::min()),
                                c.store(StmtOp::StoreSelf, String, 4, c.s(1)), {0, 11, 16});

  const ExprId sum = c.op(Op::Add, Int, c.op(Op::Mul, Int, c.self(Int, 0), c.i(3)), c.op(Op::Neg, Int, c.self(Int, 1)));
  const ExprId bits = c.op(Op::BitXor, Int, c.op(Op::BitOr, Int, sum, c.i(8)),
                           c.op(Op::BitAnd, Int, c.op(Op::BitNot, Int, c.self(Int, 1)), c.i(255)));
  const ExprId quotient =
      c.op(Op::Mod, Int, c.op(Op::Div, Int, bits, c.self(Int, 0), {0, 17, 20}), c.i(7), {0, 17, 24});
  const ExprId compare =
      c.op(Op::And, Bool, c.op(Op::Lt, Bool, quotient, c.i(-3)),
           c.op(Op::Or, Bool, c.op(Op::Not, Bool, c.self(Bool, 2)), c.op(Op::Ne, Bool, c.self(String, 4), c.s(2))));
  type.transitions.push_back({.port = 0, .from = {0}, .to = {1, 2}, .guard = compare, .action = {}, .loc = {0, 17, 3}});

  const ExprId real = c.op(Op::Div, Float, c.op(Op::Sub, Float, c.self(Float, 3), c.f(0.1)),
                           c.op(Op::IntToFloat, Float, c.self(Int, 1)), {1, 1, 1});
  const StmtId inner = c.branch(c.b(false), {}, c.store(StmtOp::StoreSelf, Bool, 2, c.b(true)));
  const StmtId last =
      c.store(StmtOp::StoreSelf, Bool, 2, c.op(Op::Ge, Bool, c.self(Float, 3), c.f(-0.0)), {}, {0, 21, 9});
  const StmtId body =
      c.branch(c.op(Op::Le, Bool, c.self(Float, 3), c.f(std::numeric_limits<double>::infinity())),
               c.store(StmtOp::StoreSelf, Float, 3, real, inner),
               c.store(StmtOp::StoreSelf, Float, 3, c.f(std::numeric_limits<double>::quiet_NaN())), last, {0, 20, 5});
  type.transitions.push_back(
      {.port = Transition::kInternal, .from = {1}, .to = {0}, .guard = {}, .action = body, .loc = {0, 19, 3}});
  type.transitions.push_back({.port = 1,
                              .from = {2},
                              .to = {2},
                              .guard = c.op(Op::Eq, Bool, c.op(Op::Gt, Bool, c.f(1e300), c.f(3)), c.b(true)),
                              .action = {},
                              .loc = {}});
  type.priorities = {{.name = "p", .low = 0, .high = 1, .guard = c.self(Bool, 2), .loc = {0, 30, 3}},
                     {.name = "q", .low = AtomPriority::kAnyPort, .high = 0, .guard = {}, .loc = {}}};
  type.invariants = {
      {.name = "i", .scope = InvariantScope::Always, .places = {}, .condition = c.b(true), .loc = {0, 31, 3}},
      {.name = "j", .scope = InvariantScope::At, .places = {0, 2}, .condition = c.self(Bool, 2), .loc = {}},
      {.name = "k", .scope = InvariantScope::From, .places = {1}, .condition = c.b(true), .loc = {}}};
  add_time(type, c);
  return type;
}

/// define (a' b c) d: exports, reads a datum of a component.
ConnectorType gather(Code& c) {
  using enum Type;
  ConnectorType type;
  type.name = "Gather";
  type.loc = {1, 2, 1};
  type.params = {{.name = "a", .type = PortTypeId(1u), .first_bind = 0, .loc = {1, 2, 24}},
                 {.name = "b.p", .type = PortTypeId(2u), .first_bind = 2, .loc = {}},
                 {.name = "c", .type = PortTypeId(0u), .first_bind = 3, .loc = {}},
                 {.name = "d'", .type = PortTypeId(0u), .first_bind = 3, .loc = {}}};
  type.data_reads = {{.path = "w.s", .type = String}};
  type.variables = {{.name = "max", .type = Int, .is_param = false, .exported = false, .loc = {1, 3, 8}}};
  type.define = {group({1, 5}), group({2, 3, 4}), leaf(0, true), leaf(1, false), leaf(2, false), leaf(3, false)};
  const StmtId up = c.store(StmtOp::StoreSelf, Int, 0, c.bind(Int, 0), {}, {1, 5, 9});
  const StmtId down = c.store(StmtOp::StoreBind, Int, 0, c.self(Int, 0),
                              c.store(StmtOp::StoreBind, Bool, 2, c.op(Op::Eq, Bool, c.bind(String, 3), c.s(0))));
  type.clauses = {
      {.params = {0, 3}, .guard = c.op(Op::Gt, Bool, c.bind(Int, 0), c.i(0)), .up = up, .down = {}, .loc = {1, 5, 3}},
      {.params = {0, 1, 3}, .guard = {}, .up = {}, .down = down, .loc = {}}};
  type.exports = true;
  type.export_name = "out";
  type.export_type = PortTypeId(3u);
  type.export_variables = {0};
  type.resume = ResumeMode::Sync;
  return type;
}

ConnectorType single(std::uint32_t port_type) {
  ConnectorType type;
  type.name = "?single";
  type.params = {{.name = "p", .type = PortTypeId(port_type), .first_bind = 0, .loc = {}}};
  type.define = {group({1}), leaf(0, true)};
  return type;
}

}  // namespace

System make_sample_system() {
  using enum Type;
  System s;
  s.files = {"models/a \"b\".bip", "stdlib/\xc3\xa9.bip"};
  s.code.strings = {"", "tab\t, line\n, quote \", back \\, byte \x01\xff", "plain"};
  Code c(s.code);
  s.port_types.push({.name = "Tick", .variables = {}, .loc = {0, 1, 1}});
  s.port_types.push(
      {.name = "Data",
       .variables = {{.name = "v", .type = Int, .loc = {0, 2, 20}}, {.name = "w", .type = Float, .loc = {}}},
       .loc = {0, 2, 3}});
  s.port_types.push({.name = "?3", .variables = {{.name = "on", .type = Bool, .loc = {}}}, .loc = {}});
  s.port_types.push({.name = "Int", .variables = {{.name = "m", .type = Int, .loc = {}}}, .loc = {}});
  s.atom_types.push(worker(c));
  AtomType flag;
  flag.variables = {{.name = "on", .type = Bool, .is_param = true, .exported = false, .loc = {}},
                    {.name = "f", .type = Float, .is_param = true, .exported = false, .loc = {}},
                    {.name = "text", .type = String, .is_param = true, .exported = false, .loc = {}}};
  flag.ports = {{.name = "p", .type = PortTypeId(2u), .variables = {0}, .exported = true, .loc = {}},
                {.name = "t", .type = PortTypeId(0u), .variables = {}, .exported = true, .loc = {}},
                {.name = "u", .type = PortTypeId(0u), .variables = {}, .exported = true, .loc = {}}};
  flag.merged = {{.name = "either", .type = PortTypeId(0u), .ports = {1, 2}, .loc = {0, 33, 3}}};
  flag.places = {"only"};
  flag.initial = {0};
  s.atom_types.push(flag);
  s.connector_types.push(gather(c));
  s.connector_types.push(single(3));
  s.connector_types.push(single(0));

  s.compounds.push({.path = "ROOT", .type = "Main", .parent = {}, .loc = {}});
  s.compounds.push({.path = "ROOT.left[0]", .type = "Half", .parent = CompoundId(0u), .loc = {0, 40, 3}});
  s.atoms.push({.path = "ROOT.w",
                .type = AtomTypeId(0u),
                .parent = CompoundId(0u),
                .args = {{.type = Int, .int_value = -5}},
                .loc = {0, 41, 3}});
  s.atoms.push(
      {.path = "ROOT.left[0].g",
       .type = AtomTypeId(1u),
       .parent = CompoundId(1u),
       .args = {{.type = Bool, .int_value = 1}, {.type = Float, .float_value = 2.5}, {.type = String, .int_value = 2}},
       .loc = {}});
  const auto port = [](std::uint32_t atom, std::uint32_t row) {
    PortRef ref;
    ref.atom = AtomId(atom);
    ref.port = row;
    return ref;
  };
  PortRef exported;
  exported.kind = PortRef::Kind::Connector;
  exported.connector = ConnectorId(0u);
  PortRef maximal = exported;
  maximal.maximal_only = true;
  s.connectors.push({.path = "ROOT.gather",
                     .type = ConnectorTypeId(0u),
                     .parent = CompoundId(0u),
                     .ports = {port(0, 0), port(1, 0), port(1, 1), port(1, 1)},
                     .data = {{AtomId(0u), 4}},
                     .bound = true,
                     .loc = {0, 44, 5}});
  s.connectors.push({.path = "ROOT.top",
                     .type = ConnectorTypeId(1u),
                     .parent = CompoundId(0u),
                     .ports = {exported},
                     .data = {},
                     .loc = {}});
  s.connectors.push({.path = "ROOT.top2",
                     .type = ConnectorTypeId(1u),
                     .parent = CompoundId(1u),
                     .ports = {maximal},
                     .data = {},
                     .loc = {}});
  s.connectors.push({.path = "ROOT.t",
                     .type = ConnectorTypeId(2u),
                     .parent = CompoundId(1u),
                     .ports = {port(1, 1)},
                     .data = {},
                     .loc = {}});
  PortRef choice;
  choice.kind = PortRef::Kind::Choice;
  s.choices.push_back({.name = "g.either", .ports = {port(1, 1), port(1, 2)}});
  s.choices.push_back({.name = "outs", .ports = {exported, maximal}});
  s.connectors.push({.path = "ROOT.e",
                     .type = ConnectorTypeId(2u),
                     .parent = CompoundId(1u),
                     .ports = {choice},
                     .data = {},
                     .loc = {}});
  choice.choice = 1;
  s.connectors.push({.path = "ROOT.f",
                     .type = ConnectorTypeId(1u),
                     .parent = CompoundId(1u),
                     .ports = {choice},
                     .data = {},
                     .loc = {}});

  Pattern one, any, all;
  one.connector = ConnectorId(0u);
  one.params = {0, 3};
  any.connector = ConnectorId(3u);
  any.any_interaction = true;
  all.any_connector = true;
  const ExprId guard = c.op(Op::Lt, Bool, c.bind(Int, 0), c.i(100));
  // Two rules share one guard, as the instances of a compound type do.
  s.priorities.push({.name = "urgent",
                     .parent = CompoundId(0u),
                     .low = one,
                     .high = any,
                     .guard = guard,
                     .data = {{AtomId(0u), 1}},
                     .loc = {0, 50, 3}});
  s.priorities.push({.name = "again",
                     .parent = CompoundId(0u),
                     .low = any,
                     .high = one,
                     .guard = guard,
                     .data = {{AtomId(0u), 1}},
                     .loc = {}});
  s.priorities.push(
      {.name = "rest", .parent = CompoundId(1u), .low = all, .high = any, .guard = {}, .data = {}, .loc = {}});
  return s;
}

}  // namespace bip::test
