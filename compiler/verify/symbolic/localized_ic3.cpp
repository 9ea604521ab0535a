// See localized_ic3.hpp. The loop of E. Clarke, O. Grumberg, S. Jha, Y. Lu, H. Veith (2000) over the localizations of
// R. Kurshan (1994, section 8.1):
//   1. Initial abstraction: the atoms on whose state the bad states depend are followed, all others are free.
//   2. Model check the abstraction by IC3. A proof is one of the whole system.
//   3. Is the counterexample spurious? It is if an invariant of the whole system excludes one of its states. Departure:
//      it is not replayed in the whole system.
//   4. Refine: add that invariant, or follow atoms whose values the counterexample needs. Departure: Kurshan takes the
//      next variables of the dependency graph; here the unsat cores of lifting name the atoms.
// Ends: proved, out of time, more atoms than the caller allows, or a counterexample that needs no further atom. A round
// that adds no invariant adds an atom, so there are no more of them than atoms.
#include "compiler/verify/symbolic/localized_ic3.hpp"

#include <algorithm>
#include <set>

#include "compiler/base/log.hpp"
#include "compiler/verify/symbolic/cnf.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class LocalizedIc3 {
 public:
  LocalizedIc3(Ic3Problem& problem, TransitionSystem& system, const std::vector<u32>& atom_of_port,
               std::size_t max_atoms, const ExcludeStates& exclude)
      : problem_(problem), system_(system), atom_of_port_(atom_of_port), max_atoms_(max_atoms), exclude_(exclude) {
    // Step 1.
    for (const u32 atom : atoms_below(system, problem.bad)) atoms_.insert(atom);
  }

  LocalizedAnswer run() {
    LocalizedAnswer result;
    while (atoms_.size() <= max_atoms_) {
      follow();
      ++result.rounds;
      // Step 2.
      Ic3Answer answer = run_ic3(problem_);
      BIP_LOG(Ic3, 1, "round {}: {} atoms followed, {} frames, {} states on the way", result.rounds, atoms_.size(),
              answer.frames, answer.required.size());
      // Steps 3 and 4.
      if (answer.end != Ic3End::Reached || !(is_excluded(answer) || add_atoms(answer))) {
        result.answer = std::move(answer);
        break;
      }
    }
    result.followed_atoms.assign(atoms_.begin(), atoms_.end());
    problem_.followed.clear();
    return result;
  }

 private:
  // The bits of the followed atoms keep their next-state functions; IC3 takes all other bits as inputs.
  void follow() {
    problem_.followed.assign(system_.bits.size(), 0);
    for (std::size_t bit = 0; bit < system_.bits.size(); ++bit)
      problem_.followed[bit] = atoms_.contains(system_.bits[bit].atom) ? 1 : 0;
  }

  // Step 3, from the bad state backwards: the last states are what all counterexamples have in common.
  bool is_excluded(const Ic3Answer& answer) {
    for (std::size_t k = answer.required.size(); k-- > 0 && !problem_.cancellation.is_over();) {
      Signal states = kTrue;
      for (const u32 literal : answer.required[k]) {
        const Signal now = system_.bits[cube_bit(literal)].now;
        states = system_.aig.make_and(states, cube_value(literal) ? now : negated(now));
      }
      if (exclude_(states)) return true;
    }
    return false;
  }

  // Step 4: follows the atoms whose values the counterexample needs: if some of them take part in its steps these only,
  // for which step is possible depends on many others by priorities. False: it needs no more.
  bool add_atoms(const Ic3Answer& answer) {
    std::set<u32> needed, taking_part;
    for (const Cube& cube : answer.required) {
      for (const u32 literal : cube) needed.insert(system_.bits[cube_bit(literal)].atom);
    }
    for (const u32 atom : atoms_) needed.erase(atom);
    for (const u32 row : answer.steps) {
      for (std::size_t k = 0; row != kNoRow && k < system_.steps[row].parts.size(); ++k) {
        const u32 atom = atom_of_port_[system_.steps[row].parts[k].first];
        if (needed.contains(atom)) taking_part.insert(atom);
      }
    }
    const std::set<u32>& added = taking_part.empty() ? needed : taking_part;
    atoms_.insert(added.begin(), added.end());
    return !added.empty();
  }

  Ic3Problem& problem_;
  TransitionSystem& system_;
  const std::vector<u32>& atom_of_port_;
  std::size_t max_atoms_;
  const ExcludeStates& exclude_;
  std::set<u32> atoms_;
};

}  // namespace

LocalizedAnswer run_localized_ic3(Ic3Problem& problem, TransitionSystem& system, const std::vector<u32>& atom_of_port,
                                  std::size_t max_atoms, const ExcludeStates& exclude) {
  BIP_ASSERT(problem.system == &system && problem.followed.empty(), "the problem of another system");
  return LocalizedIc3(problem, system, atom_of_port, max_atoms, exclude).run();
}

}  // namespace bip::verify
