// The emitted text, its compilation, and its agreement with the interpreter.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>

#include "compiler/emit_cpp/writer.hpp"
#include "compiler/interp/interp.hpp"
#include "tests/unit/emit_cpp/compiled.hpp"
#include "tests/unit/emit_cpp/random_code.hpp"

using namespace bip;
using Catch::Contains;

namespace {

std::string emit(const System& s, bool line_directives = true) {
  emit_cpp::Options options;
  options.with_main = false;
  options.line_directives = line_directives;
  return emit_cpp::emit(*lower::lower(s, "Root"), options);
}

bool same(rt::Cell a, rt::Cell b, Type type) {
  // The bits of a NaN are nobody's promise.
  if (type == Type::Float && std::isnan(a.f) && std::isnan(b.f)) return true;
  return a.bits == b.bits;
}

// 8 variables, transitions with random guards and actions, and a connector with random transfers bound to a second
// atom.
System random_system(std::uint32_t seed) {
  std::vector<DataVariable> variables;
  for (std::size_t k = 0; k < test::kRandomTypes.size(); ++k)
    variables.push_back(test::variable("v" + std::to_string(k), test::kRandomTypes[k]));
  // Names that C++ has taken.
  variables[0].name = "int";
  variables[1].name = "self";
  variables[2].name = "Cell";
  variables[3].name = "EOF";
  variables[4].name = "left";
  variables[5].name = "kImage";
  System s = test::one_atom(variables);
  s.code.string("a \"b\" */ ?\?/ \\\n");
  test::RandomCode code(s.code, seed, false);
  AtomType& type = s.atom_types[AtomTypeId(0u)];
  PortType port_type{"P", {}, {}};
  for (const DataVariable& v : variables) port_type.variables.push_back({v.name, v.type, {}});
  s.port_types.push(port_type);
  type.ports = {{"p", PortTypeId(0u), {0, 1, 2, 3, 4, 5, 6, 7}, true, {}}};
  for (int k = 0; k < 40; ++k) {
    Transition t = test::transition(0, {0}, {0});
    t.guard = code.expr(Type::Bool, 6);
    t.action = code.body(4, 2);
    type.transitions.push_back(t);
  }
  ConnectorType connector;
  connector.name = "C";
  connector.params = {{"a.p", PortTypeId(0u), 0, {}}};
  connector.define = {{false, false, 0, {1}}, {true, false, 0, {}}};
  connector.variables = variables;
  test::RandomCode transfers(s.code, seed + 1, true);
  for (int k = 0; k < 40; ++k) {
    Clause clause;
    clause.params = {0};
    clause.guard = transfers.expr(Type::Bool, 6);
    clause.down = transfers.body(4, 2);
    connector.clauses.push_back(clause);
  }
  s.connector_types.push(connector);
  PortRef ref;
  ref.atom = AtomId(0u);
  s.connectors.push({"ROOT.k", ConnectorTypeId(0u), CompoundId(0u), {ref}, {}, false, {}});
  return s;
}

// Runs every unit of both images on the same random states.
void compare(const rt::Image& a, const rt::Image& b, std::uint32_t seed) {
  REQUIRE(a.codes.size == b.codes.size);
  std::mt19937 random(seed);
  const std::uint32_t bind[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  std::size_t faults = 0;
  for (std::size_t unit = 0; unit < a.codes.size; ++unit) {
    for (int k = 0; k < 60; ++k) {
      const auto atom = test::random_interactions(random);
      const auto own = test::random_interactions(random);
      const bool connector = a.connectors.size > 0 && unit >= 80;
      std::array<rt::Cell, 16> left{}, right{};
      std::copy(atom.begin(), atom.end(), left.begin());
      std::copy(own.begin(), own.end(), left.begin() + 8);
      right = left;
      const std::int32_t status_a =
          a.codes[unit].fn(a.codes[unit].context, connector ? &left[8] : &left[0], left.data(), bind);
      const std::int32_t status_b =
          b.codes[unit].fn(b.codes[unit].context, connector ? &right[8] : &right[0], right.data(), bind);
      INFO("unit " << unit);
      REQUIRE(status_a == status_b);
      faults += status_a > 1 ? 1 : 0;
      for (std::size_t cell = 0; cell < 16; ++cell)
        REQUIRE(same(left[cell], right[cell], test::kRandomTypes[cell % 8]));
    }
  }
  CHECK(faults > 0);
}

}  // namespace

TEST_CASE("constants are spelled so that C++ reads the same") {
  CHECK(emit_cpp::int_literal(INT32_MIN) == "INT32_MIN");
  CHECK(emit_cpp::int_literal(-5) == "-5");
  CHECK(emit_cpp::float_literal(3) == "3.0");
  CHECK(emit_cpp::float_literal(0.1) == "0.1");
  CHECK(emit_cpp::float_literal(-0.0) == "-0.0");
  CHECK(emit_cpp::float_literal(1e300) == "1e+300");
  CHECK(emit_cpp::string_literal("a\"b\\\n\xc3?\?/") == "\"a\\\"b\\\\\\012\\303?\\?/\"");
  CHECK(emit_cpp::comment_text("a*/b\\\n") == "a*.b..");
}

TEST_CASE("functions read like the model") {
  const std::string text = emit(test::producers(2));
  CHECK_THAT(text, Contains("const IntVar n{self[1]};\n"));
  CHECK_THAT(text, Contains("  return n < 10;\n"));
  CHECK_THAT(text, Contains("  n = wrap_add(n, step);\n"));
  CHECK_THAT(text, Contains("  const IntVar from_v{all[bind[0]]};\n"));
  CHECK_THAT(text, Contains("  to_v = from_v;\n"));
  CHECK_THAT(text, Contains("#line 20 \"sum.bip\"\n"));
  CHECK_THAT(text, Contains("/* ROOT.p[1] */ int_cell(2)"));
  CHECK_THAT(emit(test::producers(2), false), !Contains("#line") && Contains("// sum.bip:20\n"));
}

TEST_CASE("operators keep the tree's shape with few parentheses") {
  System s = test::one_atom({test::variable("a", Type::Bool), test::variable("x", Type::Float)});
  test::Code c{s.code};
  const auto a = [&] { return c.self(0, Type::Bool); };
  const auto x = [&] { return c.self(1, Type::Float); };
  const ExprId right = c.binary(Op::Sub, x(), c.binary(Op::Sub, x(), c.f(1)));
  const ExprId left = c.binary(Op::Sub, c.binary(Op::Sub, x(), x()), c.unary(Op::Neg, c.f(-1)));
  const ExprId both = c.binary(Op::And, c.binary(Op::Lt, left, right), a());
  const ExprId any = c.binary(Op::Or, both, c.binary(Op::Eq, c.unary(Op::Not, a()), a()));
  s.atom_types[AtomTypeId(0u)].initial_action = c.set(0, any);
  CHECK_THAT(emit(s), Contains("  a = (x - x - -(-1.0) < x - (x - 1.0) && a) || (!a) == a;\n"));
}

TEST_CASE("if chains and divisions") {
  System s = test::one_atom({test::variable("x", Type::Int), test::variable("y", Type::Int)});
  test::Code c{s.code};
  const StmtId last = c.when(c.binary(Op::Gt, c.self(0), c.i(0)), c.set(1, c.i(2)), c.set(1, c.i(3)));
  const ExprId quotient = c.binary(Op::Div, c.self(0), c.self(1));
  const ExprId rest = c.binary(Op::Mod, c.self(0), c.self(1));
  s.atom_types[AtomTypeId(0u)].initial_action =
      c.body({c.when(c.binary(Op::Eq, c.self(0), c.i(0)), c.set(1, c.i(1)), last),
              c.set(0, c.binary(Op::Add, quotient, rest))});
  const std::string text = emit(s, false);
  CHECK_THAT(text,
             Contains("  if (x == 0) {\n    y = 1;\n  } else if (x > 0) {\n    y = 2;\n  } else {\n    y = 3;\n  }\n"));
  CHECK_THAT(text, Contains("const std::int32_t left = divide(x, y, 0); const std::int32_t right = modulo(x, y, 1); "
                            "return wrap_add(left, right); }()"));
  CHECK_THAT(text, Contains("} catch (const CodeFault& fault) {\n  return fault.status;\n}\n"));
}

TEST_CASE("emitted code agrees with the interpreter on random units") {
  for (const std::uint32_t seed : {1u, 2u}) {
    const System s = random_system(seed);
    const auto lowered = lower::lower(s, "Root");
    const interp::Interpreter interpreter(*lowered);
    const test::Compiled compiled(emit(s), seed == 1 ? "-O0" : "-O2");
    REQUIRE(compiled.image() != nullptr);
    compare(lowered->image, *compiled.image(), seed);
  }
}

TEST_CASE("-a / b beside a / b is right at -O2 too") {
  // g++ 12 takes the second quotient for the negated first one; found by the random units.
  System s = test::one_atom({test::variable("a", Type::Int), test::variable("b", Type::Int)});
  test::Code c{s.code};
  const ExprId plain = c.binary(Op::Div, c.self(0), c.self(1));
  const ExprId negated = c.binary(Op::Div, c.unary(Op::Neg, c.self(0)), c.self(1));
  s.atom_types[AtomTypeId(0u)].initial_action = c.set(0, c.binary(Op::Add, plain, negated));
  const test::Compiled compiled(emit(s), "-O2");
  REQUIRE(compiled.image() != nullptr);
  rt::Cell cells[2] = {};
  cells[0].bits = cells[1].bits = 0x80000000u;
  CHECK(compiled.image()->codes[0].fn(nullptr, cells, cells, nullptr) == 1);
  CHECK(cells[0].i == 2);
}

TEST_CASE("emitted tables are the image") {
  System s = test::producers(30);
  s.atom_types[AtomTypeId(0u)].name = "A \"quoted\" \\ type";
  Priority p;
  p.name = "prio";
  p.parent = CompoundId(0u);
  p.low.connector = ConnectorId(0u);
  p.low.params = {0, 1, 2};
  p.high.any_connector = true;
  s.priorities.push(p);
  const auto lowered = lower::lower(s, "Root(1)");
  const test::Compiled compiled(emit_cpp::emit(*lowered, {.with_main = false}), "-O0");
  REQUIRE(compiled.image() != nullptr);
  const rt::Image& a = lowered->image;
  const rt::Image& b = *compiled.image();
  CHECK(std::string(b.name) == "Root(1)");
  CHECK(b.cell_count == a.cell_count);
  REQUIRE(b.atom_types.size == a.atom_types.size);
  CHECK(std::strcmp(a.atom_types[0].name, b.atom_types[0].name) == 0);
  CHECK(b.atom_types[1].transitions[1].port == rt::kNone);
  REQUIRE(b.atoms.size == a.atoms.size);
  for (std::size_t k = 0; k < a.atoms.size; ++k) {
    CHECK(a.atoms[k].path() == b.atoms[k].path());
    CHECK(a.atoms[k].first_cell == b.atoms[k].first_cell);
    CHECK(a.atoms[k].args == b.atoms[k].args);
  }
  REQUIRE(b.args.size == a.args.size);
  CHECK(b.args[7].bits == a.args[7].bits);
  REQUIRE(b.connectors.size == a.connectors.size);
  CHECK(b.connectors[0].bound);
  CHECK(b.connectors[1].binds == a.connectors[1].binds);
  CHECK(b.connectors[1].parent == a.connectors[1].parent);
  REQUIRE(b.connector_types[0].define[0].children.size == 30);
  CHECK(b.connector_types[0].define[0].children[29] == 30);
  REQUIRE(b.port_refs.size == a.port_refs.size);
  CHECK(b.port_refs[30].connector == 0);
  REQUIRE(b.binds.size == a.binds.size);
  for (std::size_t k = 0; k < a.binds.size; ++k) CHECK(a.binds[k].cell == b.binds[k].cell);
  REQUIRE(b.priorities.size == 1);
  CHECK(b.priorities[0].low.params.size == 3);
  CHECK(b.priorities[0].high.connector == rt::kNone);
}

TEST_CASE("emitted tables that are folded are the image") {
  const System s = test::producers(700);
  const auto lowered = lower::lower(s, "Root");
  const test::Compiled compiled(emit_cpp::emit(*lowered, {.with_main = false}), "-O0");
  REQUIRE(compiled.image() != nullptr);
  const rt::Image& a = lowered->image;
  const rt::Image& b = *compiled.image();
  REQUIRE(b.atoms.size == a.atoms.size);
  CHECK(b.atoms.rows.size < 10);
  for (std::size_t k = 0; k < a.atoms.size; ++k) {
    CHECK(a.atoms[k].path() == b.atoms[k].path());
    CHECK(a.atoms[k].first_cell == b.atoms[k].first_cell);
    CHECK(a.atoms[k].args == b.atoms[k].args);
    CHECK(a.atoms[k].loc.line == b.atoms[k].loc.line);
  }
  REQUIRE(b.port_refs.size == a.port_refs.size);
  for (std::size_t k = 0; k < a.port_refs.size; ++k)
    CHECK((a.port_refs[k].atom == b.port_refs[k].atom && a.port_refs[k].connector == b.port_refs[k].connector));
}

TEST_CASE("several models fit in one translation unit") {
  const System s = test::producers(2);
  const auto lowered = lower::lower(s, "Root");
  std::string text;
  for (const char* name : {"other", "model"}) {
    text += emit_cpp::emit(*lowered, {.namespace_name = name, .with_main = false, .line_directives = false});
  }
  const test::Compiled compiled(text, "-O0");
  REQUIRE(compiled.image() != nullptr);
  CHECK(compiled.image()->atoms.size == 3);
}
