// The image of hand-built systems: layout, bindings, units, sites.
#include <catch2/catch.hpp>

#include <algorithm>
#include <ctime>
#include <set>

#include "compiler/lower/lower.hpp"
#include "compiler/lower/unit_names.hpp"
#include "tests/unit/lower/hand_built.hpp"

using namespace bip;
using bip::test::Code;

TEST_CASE("cells are laid out atoms first, then connectors") {
  const System s = test::producers(3);
  const auto l = lower::lower(s, "Root()");
  const rt::Image& im = l->image;
  CHECK(std::string(im.name) == "Root()");
  REQUIRE(im.atoms.size == 4);
  CHECK(im.atoms[0].first_cell == 0);
  CHECK(im.atoms[1].first_cell == 2);
  CHECK(im.atoms[3].first_cell == 6);
  REQUIRE(im.connectors.size == 2);
  CHECK(im.connectors[0].first_cell == 8);
  CHECK(im.connectors[1].first_cell == 9);
  CHECK(im.cell_count == 9);
  CHECK(im.args.size == 3);
  CHECK(im.args[im.atoms[2].args].i == 3);
  CHECK(im.connectors[0].bound);
}

TEST_CASE("bindings name the rows of port variables, own and exported ones") {
  const System s = test::producers(3);
  const auto l = lower::lower(s, "Root");
  const rt::Image& im = l->image;
  const rt::Connector& sum = im.connectors[0];
  REQUIRE(sum.bind_count == 3);
  CHECK(im.binds[sum.binds].cell == 1);
  CHECK(im.binds[sum.binds + 1].cell == 3);
  CHECK(im.binds[sum.binds + 2].cell == 5);
  const rt::Connector& take = im.connectors[1];
  REQUIRE(take.bind_count == 2);
  CHECK(take.bind_count == s.connector_types[ConnectorTypeId(1u)].bind_count(s.port_types));
  CHECK(im.binds[take.binds].cell == sum.first_cell);
  CHECK(im.binds[take.binds + 1].cell == im.atoms[3].first_cell + 1);
  const rt::PortRef& from = im.port_refs[take.ports];
  CHECK(from.atom == rt::kNone);
  CHECK(from.connector == 0);
  CHECK(im.port_refs[take.ports + 1].atom == 3);
}

TEST_CASE("data reads follow the port variables, and priority guards bind data") {
  System s = test::producers(2);
  Code c{s.code};
  ConnectorType& take = s.connector_types[ConnectorTypeId(1u)];
  take.data_reads.push_back({"c.total", Type::Int});
  s.connectors[ConnectorId(1u)].data.push_back({AtomId(2u), 1});
  Priority p;
  p.name = "prio1";
  p.parent = CompoundId(0u);
  p.low.any_connector = true;
  p.high.connector = ConnectorId(1u);
  p.high.any_interaction = true;
  p.guard = c.binary(Op::Gt, c.bind(0), c.i(3));
  p.data = {{AtomId(1u), 1}};
  s.priorities.push(p);
  const auto l = lower::lower(s, "Root");
  const rt::Image& im = l->image;
  const rt::Connector& row = im.connectors[1];
  REQUIRE(row.bind_count == 3);
  CHECK(im.binds[row.binds + 2].cell == im.atoms[2].first_cell + 1);
  REQUIRE(im.priorities.size == 1);
  REQUIRE(im.priorities[0].bind_count == 1);
  CHECK(im.binds[im.priorities[0].binds].cell == im.atoms[1].first_cell + 1);
  CHECK(im.priorities[0].low.connector == rt::kNone);
  CHECK(l->units[im.priorities[0].guard].name == "Root_prio1_guard");
}

TEST_CASE("one unit a guard or action of a type, with readable unique names") {
  const System s = test::producers(3);
  const auto l = lower::lower(s, "Root");
  std::vector<std::string> names;
  for (const auto& unit : l->units) names.push_back(unit.name);
  CHECK(names == std::vector<std::string>{"Producer_initial", "Producer_on_put_from_run_guard",
                                          "Producer_on_put_from_run_action", "Sum_on_p0_p1_p2_up",
                                          "Take_on_from_to_guard", "Take_on_from_to_down"});
  CHECK(l->codes.size() == names.size());
  CHECK(l->image.codes.size == names.size());
  CHECK(l->image.atom_types[0].transitions[0].guard == 1);
  CHECK(l->image.atom_types[1].transitions[1].port == rt::kNone);
  CHECK(l->image.connector_types[1].clauses[0].up == rt::kNone);
}

TEST_CASE("names are made unique and valid") {
  lower::UniqueNames names;
  CHECK(names.make("a.b[0]") == "a_b_0");
  CHECK(names.make("a_b_0") == "a_b_0_2");
  CHECK(names.make("a.b.0") == "a_b_0_3");
  CHECK(names.make("a_b_0_2") == "a_b_0_2_2");
  CHECK(names.make("?3") == "x3");
  CHECK(names.make("__x") == "x");
  CHECK(names.make("") == "x_2");
}

TEST_CASE("one site a division of ints, in the order of the expressions") {
  System s = test::one_atom({test::variable("x", Type::Int)});
  Code c{s.code};
  const ExprId quotient = c.binary(Op::Div, c.self(0), c.i(2));
  const ExprId ratio = c.binary(Op::Div, c.f(1), c.f(2));
  const ExprId rest = c.binary(Op::Mod, quotient, c.i(3));
  const auto l = lower::lower(s, "Root");
  CHECK(l->site_of_expr[quotient.value] == 0);
  CHECK(l->site_of_expr[ratio.value] == rt::kNone);
  CHECK(l->site_of_expr[rest.value] == 1);
  CHECK(l->image.sites.size == 2);
  CHECK(l->image.sites[1].loc.column == s.code.exprs[rest].loc.column);
}

TEST_CASE("row 0 of the strings is always the empty one") {
  CodeTable code;
  CHECK(code.string("a") == 1);
  CHECK(code.string("a") == 1);
  CHECK(code.string("") == 0);
  System s = test::one_atom({});
  s.code.strings.clear();
  const auto l = lower::lower(s, "Root");
  REQUIRE(l->image.strings.size == 1);
  CHECK(std::string(l->image.strings[0]).empty());
}

TEST_CASE("lowering takes time in proportion to the atoms") {
  const auto processor_seconds = [](const System& s) {
    double least = 1e9;
    for (int k = 0; k < 3; ++k) {
      const std::clock_t start = std::clock();
      REQUIRE(lower::lower(s, "Root"));
      least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    }
    return least;
  };
  const System few = test::producers(10000), many = test::producers(100000);
  const auto l = lower::lower(many, "Root");
  CHECK(l->units.size() == 6);
  CHECK(l->image.atoms.size == 100001);
  CHECK(l->image.binds.size == 100002);
  // Ten times the atoms; quadratic would be a hundred. The processor's time: other processes are not in it, their
  // caches are.
  CHECK(processor_seconds(many) < 40 * processor_seconds(few) + 0.05);
}
