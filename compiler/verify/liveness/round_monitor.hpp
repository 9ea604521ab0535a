// A monitor beside the circuit of a system: the automaton of a negated formula, and what fairness asks of a run, as
// bits that every step sets anew. It counts the rounds of a run: in one round the automaton has shown each of its
// marks, and each unit of fairness has had its turn or could not have it.
//
// A run that violates the formula and is fair has rounds without end. So a bound for the number of rounds of all runs
// is a proof that the formula holds (K. Claessen, N. Sörensson: A Liveness Checking Algorithm that Counts, FMCAD 2012).
// The automaton's choices are inputs. Strong fairness is a guess, made once for each unit: it is never possible from
// some point on, which the monitor checks, or it has its turn in every round. The last state of a run that ends repeats
// by a step without participants.
//
// The circuit may be cut down to some atoms: the state of all others is any state, in each step anew (localization:
// R. Kurshan, Computer-Aided Verification of Coordinating Processes, 1994). Only units of fairness whose atoms are all
// kept are asked for. Each makes more runs, so what is proved holds. Cost: linear in the circuit, and for each
// interaction whose participants depend on the state up to 15 units.
//
// For a certificate the automaton is not ours but the tester that certcheck makes of the formula, whose bits lemmas can
// name (compiler/docs/certificate.md): a promise for each operator that looks ahead, which each step must keep.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/verify/liveness/automaton.hpp"
#include "compiler/verify/liveness/run_circuit.hpp"
#include "compiler/verify/property/fairness.hpp"
#include "compiler/verify/symbolic/transition_system.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::verify {

class RoundMonitor {
 public:
  /// All: the run ends where the system does. Others: what no kept atom takes part in may happen for ever.
  struct Part {
    std::vector<std::uint8_t> keeps;  // by atom; empty: all
    [[nodiscard]] bool has_all() const { return keeps.empty(); }
    [[nodiscard]] bool has(std::uint32_t atom) const { return has_all() || keeps[atom] != 0; }
  };

  /// `system` and `image` are of one compilation; the automaton is that of the formula's negation and not empty; null:
  /// the tester, which sees no violation of an invariant. `clauses` hold in every reachable state of the system.
  /// A round needs the turns of the units in `expected` alone.
  RoundMonitor(const TransitionSystem& system, const rt::Image& image, const Formula& formula,
               const Automaton* automaton, const Fairness& fairness, const Part& part, const StateClauses& clauses,
               const std::vector<std::uint32_t>& expected);
  RoundMonitor(const RoundMonitor&) = delete;
  RoundMonitor& operator=(const RoundMonitor&) = delete;

  /// The states in which more than `rounds` rounds are over. Makes the counter longer if need be.
  [[nodiscard]] Signal more_rounds_than(std::uint32_t rounds);
  /// Of an invariant that looks back: the states that violate it, whatever follows.
  [[nodiscard]] Signal violated() const { return violated_; }

  [[nodiscard]] const TransitionSystem& machine() const { return machine_; }
  [[nodiscard]] const StateClauses& clauses() const { return clauses_; }
  /// Holds in every state: what ties the state of kept atoms to that of others.
  [[nodiscard]] Signal constraint() const { return constraint_; }
  struct Unit {
    Signal possible = kFalse, taken = kFalse;
    std::vector<std::uint32_t> atoms;
    std::size_t term = 0;  // of the fairness
    bool is_strong = false;
    rt::InteractionId interaction;          // of fairness of interactions
    std::uint32_t atom = 0;                 // of fairness of atoms
    std::vector<std::uint32_t> ports = {};  // instances that take part
  };
  /// All whose atoms are kept. The same for all monitors of a part.
  [[nodiscard]] const std::vector<Unit>& units() const { return units_; }
  /// What each round shows: marks, and turns of the expected units.
  [[nodiscard]] const std::vector<Signal>& demands() const { return demands_; }
  /// Returns what certificates call a bit that no atom has: "%seen2".
  [[nodiscard]] const std::string& name_of(std::uint32_t bit) const { return names_[bit]; }
  /// The only one, which needs no bit; numbered with those that are always met.
  [[nodiscard]] std::optional<std::size_t> lone_demand() const { return lone_demand_; }
  /// This step may be one of a round.
  [[nodiscard]] Signal inside() const { return inside_; }
  /// Is the bit of the machine one that counts, or that says what the round has shown?
  [[nodiscard]] bool is_of_round(std::uint32_t bit) const {
    return is_of_round_.size() > bit && is_of_round_[bit] != 0;
  }

 private:
  void find_conditions(const Formula& formula, const rt::Image& image, const Part& part);
  void find_units(const Fairness& fairness, const Part& part);
  void cut(const Part& part, const StateClauses& clauses);
  void add_end(const Part& part);
  void add_guesses();
  void run_automaton(const Automaton& automaton);
  void run_tester(const Formula& formula);
  void find_violated(const Automaton& automaton);
  void add_rounds();
  std::uint32_t add_bit(std::int8_t initial, const std::string& name = {});
  std::uint32_t add_bit_of_round(const std::string& name);
  [[nodiscard]] Signal now(std::uint32_t bit) const { return machine_.bits[bit].now; }
  [[nodiscard]] Signal matches(std::uint64_t required, std::uint64_t forbidden);

  TransitionSystem machine_;
  Aig& aig_;
  const rt::Tables tables_;
  StateClauses clauses_;
  Signal constraint_ = kTrue, violated_ = kFalse;
  std::size_t states_ = 0;          // conditions on states; the others are on steps
  std::vector<Signal> conditions_;  // true at this position
  std::vector<Unit> units_;
  const std::vector<std::uint32_t> expected_;  // rows of units_
  bool is_strong_ = false;                     // some fairness is
  std::vector<Signal> never_;  // by expected unit: guessed to be impossible from the start of rounds on; weak: false
  Signal started_ = kTrue, guess_fails_ = kFalse, happened_ = kTrue;
  std::vector<std::uint32_t> automaton_bits_;  // by state of the automaton, one more: it has no edge
  std::vector<Signal> marks_;                  // by mark that counts: an edge with it is taken
  Signal inside_ = kFalse;                     // an edge between states that may accept is taken
  Signal round_ = kFalse;                      // this step ends a round
  std::vector<Signal> demands_;
  std::optional<std::size_t> lone_demand_;
  std::vector<std::uint8_t> is_of_round_;  // by bit
  std::vector<std::string> names_;         // by bit; those of atoms have none
  std::vector<std::uint32_t> counter_;     // bit k: more than k rounds are over
};

}  // namespace bip::verify
