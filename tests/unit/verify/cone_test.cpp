// The cone of influence and the CNF of what lies in it.
#include <catch2/catch.hpp>

#include "compiler/verify/symbolic/cnf.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;
using test::lock_and_users;

/// A counter and a switch, which share nothing. No port has two transitions: whether both are enabled, a fault that
/// ends the run, would make every step depend on the places.
const char* const kTwoIslands = R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Counter()
    data int n = 0
    data int unused = 0
    export port Signal more()
    place S
    initial to S
    on more from S to S provided (n < 5) do { n = n + 1; unused = (unused + n) % 7; }
  end
  atom type Switch()
    export port Signal flip(), back()
    place OFF, ON
    initial to OFF
    on flip from OFF to ON
    on back from ON to OFF
  end
  compound type Root()
    component Counter c()
    component Switch s()
    connector One m(c.more), f(s.flip), b(s.back)
  end
end
)";

std::vector<u32> atoms_in(const TransitionSystem& system, const ConeOfInfluence& cone) {
  std::vector<u32> atoms;
  for (std::size_t k = 0; k < system.bits.size(); ++k) {
    if (cone.bits[k] != 0 && (atoms.empty() || atoms.back() != system.bits[k].atom))
      atoms.push_back(system.bits[k].atom);
  }
  return atoms;
}

}  // namespace

TEST_CASE("cone of influence: what shares nothing stays outside") {
  const HandMadeNet made(kTwoIslands);
  const TransitionSystem system = build_transition_system(*made.compiled.system, made.compiled.lowered->image);
  REQUIRE(system.unsupported.empty());
  // n == 5 needs the counter's n alone: neither the switch nor the data that n only writes to.
  const Word& n = system.words[0];
  const ConeOfInfluence counter = cone_of_influence(system, {n[0]});
  CHECK(atoms_in(system, counter) == std::vector<u32>{0});
  for (std::size_t k = 0; k < system.bits.size(); ++k) {
    if (system.bits[k].atom == 0 && !system.bits[k].is_place)
      CHECK((counter.bits[k] != 0) == (system.bits[k].row == 0));
  }
  CHECK(std::count(counter.steps.begin(), counter.steps.end(), 1) == 1);
  // One place of an automaton brings the others.
  const ConeOfInfluence places = cone_of_influence(system, {system.marks[1][1]});
  CHECK(atoms_in(system, places) == std::vector<u32>{1});
  CHECK(std::count(places.bits.begin(), places.bits.end(), 1) == 2);
}

TEST_CASE("cone of influence: of constants nothing, through shared connectors everything") {
  const HandMadeNet islands(kTwoIslands);
  const TransitionSystem separate = build_transition_system(*islands.compiled.system, islands.compiled.lowered->image);
  CHECK(atoms_in(separate, cone_of_influence(separate, {kTrue})).empty());
  const HandMadeNet made(lock_and_users());
  const TransitionSystem system = build_transition_system(*made.compiled.system, made.compiled.lowered->image);
  CHECK(atoms_in(system, cone_of_influence(system, {system.marks[1][0]})) == std::vector<u32>{0, 1, 2});
}

TEST_CASE("cone of influence: nodes are covered if all that they depend on is") {
  const HandMadeNet made(kTwoIslands);
  TransitionSystem system = build_transition_system(*made.compiled.system, made.compiled.lowered->image);
  const Signal of_counter = system.aig.make_and(system.words[0][0], system.words[0][1]);
  const Signal of_both = system.aig.make_and(of_counter, system.marks[1][1]);
  const std::vector<std::uint8_t> covered = nodes_in_cone(system, cone_of_influence(system, {of_counter}));
  CHECK(covered[node_of(of_counter)] == 1);
  CHECK(covered[node_of(of_both)] == 0);
  CHECK(covered[0] == 1);
}

TEST_CASE("CNF: the solver agrees with the and-inverter graph") {
  Aig aig;
  const Signal x = aig.make_input(), y = aig.make_input(), z = aig.make_input();
  Solver solver;
  Cnf cnf(aig, solver);
  const Signal choice = aig.make_ite(x, y, negated(z));
  CHECK(cnf.encoded(choice) == 0);
  const Lit literal = cnf.literal(choice);
  CHECK(cnf.encoded(negated(choice)) == -literal);
  for (unsigned row = 0; row < 8; ++row) {
    const bool a = (row & 1) != 0, b = (row & 2) != 0, c = (row & 4) != 0;
    for (const bool expected : {false, true}) {
      solver.assume(a ? cnf.literal(x) : -cnf.literal(x));
      solver.assume(b ? cnf.literal(y) : -cnf.literal(y));
      solver.assume(c ? cnf.literal(z) : -cnf.literal(z));
      solver.assume(expected ? literal : -literal);
      CHECK((solver.solve({}) == Answer::Satisfiable) == ((a ? b : !c) == expected));
    }
  }
}

}  // namespace bip::verify
