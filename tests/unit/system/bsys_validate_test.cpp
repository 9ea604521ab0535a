// Each promise broken once: `validate` must see it. A check that never fires would be found here.
#include <catch2/catch.hpp>

#include <functional>
#include <utility>

#include "compiler/system/bsys.hpp"
#include "tests/unit/system/bsys_sample.hpp"

using namespace bip;

namespace {

struct Break {
  const char* says;
  std::function<void(System&)> apply;
};
AtomType& worker(System& s) { return s.atom_types[AtomTypeId(0u)]; }
ConnectorType& gather(System& s) { return s.connector_types[ConnectorTypeId(0u)]; }
Connector& conn(System& s, std::uint32_t row) { return s.connectors[ConnectorId(row)]; }
Priority& rule(System& s, std::uint32_t row) { return s.priorities[PriorityId(row)]; }
Expr& guard_of(System& s) { return s.code.exprs[worker(s).transitions[0].guard]; }

const std::vector<Break>& breaks() {
  static const std::vector<Break> list{
      {"row 0 of the strings", [](System& s) { s.code.strings[0].push_back('x'); }},
      {"two rows", [](System& s) { s.code.strings[1] = s.code.strings[2]; }},
      {"no file", [](System& s) { worker(s).loc.file = 7; }},
      {"port's type is no row", [](System& s) { worker(s).ports[0].type = PortTypeId(99u); }},
      {"one variable of the atom a variable", [](System& s) { worker(s).ports[0].variables.pop_back(); }},
      {"has not the variable's type", [](System& s) { worker(s).ports[0].variables[0] = 3; }},
      {"variable is no row", [](System& s) { worker(s).ports[0].variables[0] = 30; }},
      {"parameter's variable comes after data", [](System& s) { worker(s).variables[3].is_param = true; }},
      {"set of places is empty", [](System& s) { worker(s).transitions[0].from.clear(); }},
      {"place is no row", [](System& s) { worker(s).transitions[0].to[0] = 3; }},
      {"transition's port", [](System& s) { worker(s).transitions[0].port = 2; }},
      {"clock's unit", [](System& s) { worker(s).clocks[0].unit = 0; }},
      {"do not follow", [](System& s) { worker(s).clocks[1].variable = 9; }},
      {"float, bool, float", [](System& s) { worker(s).variables[9].type = Type::Int; }},
      {"hidden variable is a parameter or exported", [](System& s) { worker(s).variables[11].exported = true; }},
      {"shows a hidden variable", [](System& s) { worker(s).ports[0].variables[1] = 11; }},
      {"events from outside is exported", [](System& s) { worker(s).ports[0].external = true; }},
      {"bound's clock is no row", [](System& s) { worker(s).transitions[0].when.bounds[0].clock = 2; }},
      {"clock with itself", [](System& s) { worker(s).transitions[0].when.bounds[1].minus = 1; }},
      {"clocks of two units", [](System& s) { worker(s).clocks[1].unit = 1; }},
      {"end of time", [](System& s) { worker(s).transitions[0].when.bounds[0].ticks = kMaxTicks + 1; }},
      {"none of the hidden ones", [](System& s) { worker(s).transitions[0].when.bounds[0].variable = 3; }},
      {"bound's variable is no float", [](System& s) { worker(s).transitions[0].when.bounds[0].variable = 9; }},
      {"nothing measures", [](System& s) { worker(s).transitions[2].when.measure = {}; }},
      {"to do with time", [](System& s) { worker(s).transitions[1].urgency = Urgency::Eager; }},
      {"first bind", [](System& s) { gather(s).params[1].first_bind = 1; }},
      {"not a tree in preorder",
       [](System& s) {
         gather(s).define[1].children = {2, 4, 3};
       }},
      {"no later row", [](System& s) { gather(s).define[1].children[0] = 0; }},
      {"two parents",
       [](System& s) {
         gather(s).define[0].children = {1, 2};
       }},
      {"no group at its root", [](System& s) { gather(s).define.clear(); }},
      {"a define is empty", [](System& s) { gather(s).define[1].children.clear(); }},
      {"twice in the define", [](System& s) { gather(s).define[5].param = 0; }},
      {"leaf of a define has children", [](System& s) { gather(s).define[5].children = {5}; }},
      {"no interaction",
       [](System& s) {
         gather(s).clauses[0].params = {1, 3};
       }},
      {"no interaction",
       [](System& s) {
         gather(s).clauses[0].params = {0, 1, 2};
       }},
      {"not sorted",
       [](System& s) {
         gather(s).clauses[0].params = {3, 0};
       }},
      {"one interaction",
       [](System& s) {
         gather(s).clauses[1].params = {0, 3};
       }},
      {"exported port has not one variable", [](System& s) { gather(s).export_variables.clear(); }},
      {"exported port's type", [](System& s) { gather(s).export_type = {}; }},
      {"no root", [](System& s) { s.compounds.rows().clear(); }},
      {"row 0 is the root", [](System& s) { s.compounds[CompoundId(0u)].parent = CompoundId(0u); }},
      {"no earlier row", [](System& s) { s.compounds[CompoundId(1u)].parent = CompoundId(1u); }},
      {"parent is no row", [](System& s) { s.atoms[AtomId(0u)].parent = {}; }},
      {"one argument a parameter", [](System& s) { s.atoms[AtomId(0u)].args.clear(); }},
      {"one argument a parameter", [](System& s) { s.atoms[AtomId(0u)].args.resize(2); }},
      {"not its parameter's type", [](System& s) { s.atoms[AtomId(1u)].args[0].type = Type::Int; }},
      {"neither 0 nor 1", [](System& s) { s.atoms[AtomId(1u)].args[0].int_value = 2; }},
      {"string is no row", [](System& s) { s.atoms[AtomId(1u)].args[2].int_value = -1; }},
      {"one port a parameter", [](System& s) { conn(s, 0).ports.pop_back(); }},
      {"no atom", [](System& s) { conn(s, 0).ports[0].atom = {}; }},
      {"no port of its atom", [](System& s) { conn(s, 0).ports[0].port = 9; }},
      {"not exported",
       [](System& s) {
         conn(s, 0).ports[2] = conn(s, 0).ports[0];
         conn(s, 0).ports[2].port = 1;
       }},
      {"other variables", [](System& s) { conn(s, 0).ports[2].port = 0; }},
      {"no earlier connector", [](System& s) { conn(s, 1).ports[0].connector = ConnectorId(1u); }},
      {"exports no port", [](System& s) { conn(s, 2).ports[0].connector = ConnectorId(1u); }},
      {"`bound` is wrong", [](System& s) { conn(s, 3).bound = true; }},
      {"bound to no choice", [](System& s) { conn(s, 4).ports[0].choice = 2; }},
      {"choice within a choice", [](System& s) { s.choices[1].ports[0].kind = PortRef::Kind::Choice; }},
      {"choice has no ports", [](System& s) { s.choices[0].ports.clear(); }},
      {"different variables", [](System& s) { s.choices[0].ports[1].port = 0; }},
      {"no earlier connector", [](System& s) { s.choices[1].ports[1].connector = s.connectors.push(conn(s, 0)); }},
      {"priority's port", [](System& s) { worker(s).priorities[0].low = 7; }},
      {"same", [](System& s) { worker(s).priorities[0].low = 1; }},
      {"no condition", [](System& s) { worker(s).invariants[0].condition = {}; }},
      {"if it is not `always`", [](System& s) { worker(s).invariants[1].places.clear(); }},
      {"places are not sorted",
       [](System& s) {
         worker(s).invariants[1].places = {2, 0};
       }},
      {"fewer than two", [](System& s) { s.atom_types[AtomTypeId(1u)].merged[0].ports.pop_back(); }},
      {"merged port's port has other", [](System& s) { s.atom_types[AtomTypeId(1u)].merged[0].ports[0] = 0; }},
      {"one datum", [](System& s) { conn(s, 0).data.clear(); }},
      {"type of its data read", [](System& s) { conn(s, 0).data[0].variable = 1; }},
      {"no variable of its atom", [](System& s) { conn(s, 0).data[0].variable = 50; }},
      {"pattern's connector", [](System& s) { rule(s, 0).low.connector = {}; }},
      {"pattern is empty", [](System& s) { rule(s, 0).low.params.clear(); }},
      {"pattern's parameters are not sorted",
       [](System& s) {
         rule(s, 0).low.params = {3, 0};
       }},
      {"both sides", [](System& s) { rule(s, 2).high.any_connector = true; }},
      {"data of no atom", [](System& s) { rule(s, 0).data[0].atom = {}; }},
      {"code is no row", [](System& s) { worker(s).transitions[0].guard = ExprId(100000u); }},
      {"guard is not a bool", [](System& s) { worker(s).transitions[0].guard = s.code.exprs[guard_of(s).a].a; }},
      {"part of another one", [](System& s) { worker(s).transitions[2].guard = guard_of(s).a; }},
      {"part of two", [](System& s) { guard_of(s).b = guard_of(s).a; }},
      {"part of two", [](System& s) { s.code.exprs[guard_of(s).b].a = worker(s).transitions[0].guard; }},
      {"no row", [](System& s) { guard_of(s).a = {}; }},
      {"no operator", [](System& s) { guard_of(s).op = static_cast<Op>(99); }},
      {"wrong type", [](System& s) { guard_of(s).op = Op::Add; }},
      {"wrong type", [](System& s) { s.code.exprs[ExprId(0u)].type = Type::Float; }},
      {"no variable", [](System& s) { s.code.stmts[worker(s).initial_action].index = 40; }},
      {"another type", [](System& s) { s.code.stmts[worker(s).initial_action].index = 2; }},
      {"read-only", [](System& s) { s.code.stmts[worker(s).initial_action].index = 0; }},
      {"a statement has no operator",
       [](System& s) { s.code.stmts[worker(s).initial_action].op = static_cast<StmtOp>(99); }},
      {"a statement without a condition has branches",
       [](System& s) {
         Stmt& first = s.code.stmts[worker(s).initial_action];
         first.then_body = std::exchange(first.next, {});
       }},
      {"outside `down`", [](System& s) { std::swap(gather(s).clauses[1].up, gather(s).clauses[1].down); }},
  };
  return list;
}

}  // namespace

TEST_CASE("validate sees each broken promise") {
  for (const Break& broken : breaks()) {
    System s = test::make_sample_system();
    broken.apply(s);
    std::string all;
    for (const std::string& problem : system::validate(s)) all += problem + "\n";
    INFO("wanted: " << broken.says << "\ngot: " << all);
    CHECK(all.find(broken.says) != std::string::npos);
  }
}
