// See run_circuit.hpp.
#include "compiler/verify/liveness/run_circuit.hpp"

#include "compiler/system/inner_priorities.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/symbolic/ic3.hpp"
#include "compiler/verify/symbolic/mode_signals.hpp"

namespace bip::verify {

namespace {

// Of the time that is left.
constexpr double kShareOfInvariants = 1.0 / 4, kShareOfInternals = 1.0 / 4, kShareOfRemark = 1.0 / 16;

void find_clauses(RunCircuit& circuit, const System& system, const rt::Image& image,
                  const CancellationToken& cancellation) {
  circuit.net = build_net(system);
  const Net& net = circuit.net;
  if (net.too_large_atom != kNoRow || !system::first_inner_priority(system).empty()) return;
  const CancellationToken share = cancellation.within(cancellation.seconds_left() * kShareOfInvariants);
  circuit.proof = prove_deadlock_freedom(net, share);
  if (circuit.proof->reachable.empty()) circuit.proof = find_reachable_modes(net);
  circuit.clauses = mode_clauses(net, *circuit.proof, circuit.machine, image);
  circuit.affine = find_affine_invariants(net, circuit.machine, image, circuit.clauses, share);
  const AffineInvariants& affine = circuit.affine;
  for (const AffineEquation& equation : affine.equations)
    circuit.clauses.push_back({equation_signal(equation, circuit.machine, image)});
  for (const VariableBound& bound : affine.bounds)
    circuit.clauses.push_back({bound_signal(bound, circuit.machine, image)});
  for (const PlaceValue& value : affine.places) circuit.clauses.push_back(place_clause(value, circuit.machine, image));
}

}  // namespace

RunCircuit make_run_circuit(const System& system, const rt::Image& image, std::size_t megabytes,
                            const CancellationToken& cancellation) {
  RunCircuit circuit;
  circuit.machine = build_transition_system(system, image, megabytes);
  if (!circuit.machine.unsupported.empty()) circuit.problem = circuit.machine.unsupported;
  else if (circuit.machine.starts_with_fault) circuit.problem = "the initial state could not be entered";
  else if (!ranges_hold(circuit.machine, cancellation)) circuit.problem = "the ranges of data could not be confirmed";
  if (!circuit.problem.empty()) return circuit;
  find_clauses(circuit, system, image, cancellation);
  // A step after which the circuit has lost its way must not be reachable, or runs would be missing.
  if (!is_never(circuit, circuit.machine.lost, cancellation.within(cancellation.seconds_left() * kShareOfInternals)))
    circuit.problem = "more internal transitions in a row than the circuit follows";
  return circuit;
}

bool is_never(const RunCircuit& circuit, Signal bad, const CancellationToken& cancellation) {
  Ic3Problem problem;
  problem.system = &circuit.machine;
  problem.bad = bad;
  problem.invariants = circuit.clauses;
  problem.cancellation = cancellation;
  return run_ic3(problem).end == Ic3End::Safe;
}

bool may_have_errors(const RunCircuit& circuit, const CancellationToken& cancellation) {
  return !is_never(circuit, circuit.machine.error, cancellation.within(cancellation.seconds_left() * kShareOfRemark));
}

}  // namespace bip::verify
