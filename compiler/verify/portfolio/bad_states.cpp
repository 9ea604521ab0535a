// See bad_states.hpp.
#include "compiler/verify/portfolio/bad_states.hpp"

#include "compiler/verify/invariants/affine_bounds.hpp"
#include "compiler/verify/symbolic/property_signal.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

Signal bad_states(const Question& question, TransitionSystem& machine, const rt::Image& image) {
  switch (question.what) {
    case QuestionKind::DeadlockFreedom: return machine.stuck;
    case QuestionKind::NoErrors: return machine.error;
    case QuestionKind::State: return broken_signal(question.property, machine, image);
    case QuestionKind::NoLocalDeadlock:
    case QuestionKind::Runs:
    case QuestionKind::Branching: break;
  }
  BIP_UNREACHABLE("no set of states is a local deadlock");
}

std::vector<std::vector<Signal>> affine_clauses(const AffineInvariants& affine, TransitionSystem& machine,
                                                const rt::Image& image) {
  std::vector<std::vector<Signal>> clauses;
  for (const AffineEquation& equation : affine.equations)
    clauses.push_back({equation_signal(equation, machine, image)});
  for (const VariableBound& bound : affine.bounds) clauses.push_back({bound_signal(bound, machine, image)});
  for (const PlaceValue& value : affine.places) clauses.push_back(place_clause(value, machine, image));
  return clauses;
}

}  // namespace bip::verify
