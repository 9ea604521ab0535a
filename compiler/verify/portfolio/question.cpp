// See question.hpp.
#include "compiler/verify/portfolio/question.hpp"

namespace bip::verify {

SearchGoal goal_of(const Question& question) {
  SearchGoal goal;
  switch (question.what) {
    case QuestionKind::DeadlockFreedom: goal.stuck = true; break;
    case QuestionKind::NoErrors: goal.faults = true; break;
    case QuestionKind::State:
      goal.state = [&question](const rt::Core& core) { return is_broken(question.property, core); };
      if (connectors_of(question.property).empty()) goal.atoms = atoms_of(question.property);
      break;
    case QuestionKind::NoLocalDeadlock:
    case QuestionKind::Runs:
    case QuestionKind::Branching: break;
  }
  return goal;
}

}  // namespace bip::verify
