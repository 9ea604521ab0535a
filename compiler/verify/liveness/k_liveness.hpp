// k-liveness: proves a property of runs on the circuit of the system, without visiting its states. No run has more than
// k rounds of the monitor of the negated property (round_monitor.hpp), which IC3 shows for k = 0, 1, 4, 16, …
//
// Tried first on the atoms that the property speaks of alone, then on those around them as well, and at last on all of
// them; parts and bounds take turns, each with a share of the time. Fairness is expected of a unit only once a run with
// more rounds, in which states repeat, leaves it out (refinement: E. Clarke, O. Grumberg, S. Jha, Y. Lu, H. Veith
// 2000); a part with such a run that leaves out none is given up. An invariant that looks back needs no bound: its
// violation is a state. Sound for systems with C++ and floats, too, whose values are any; incomplete in practice: many
// rounds need many lemmas. What is violated is left to the graph of states (liveness.hpp).
//
// K. Claessen, N. Sörensson: A Liveness Checking Algorithm that Counts (FMCAD 2012).
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/system/system_ids.hpp"
#include "compiler/verify/liveness/run_circuit.hpp"
#include "compiler/verify/property/fairness.hpp"
#include "compiler/verify/portfolio/question.hpp"
#include "compiler/verify/property/formula.hpp"
#include "compiler/verify/solver/cancellation.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::verify {

// One search: for a bound of so many rounds on the part with these atoms.
struct KLivenessAttempt {
  std::vector<std::uint8_t> keeps;  // by atom
  std::uint32_t rounds = 0;
};
struct KLivenessOptions {
  Fairness fairness;
  CancellationToken cancellation;
  std::uint32_t most_rounds = 256;
  bool wants_certificate = false;  // the monitor is the tester that certificates speak of; no invariants that look back
  std::optional<KLivenessAttempt> attempt = std::nullopt;  // nothing else is tried
  Report report;
};
struct KLivenessProof {
  Outcome outcome = Outcome::Unknown;  // Holds or Unknown
  std::string reason;                  // Unknown
  bool is_out_of_time = false;         // Unknown: with more time it may be proved
  bool has_run = false;                // Unknown: of the only attempt; the part has a run of rounds without end
  // Holds: of the proof.
  std::uint32_t rounds = 0, atoms = 0, units = 0, frames = 0;
  std::size_t lemmas = 0;
  std::uint32_t finite_ports = 0;  // it rests on these, which move finitely often (finite_moves.hpp)
  bool may_have_errors = false;    // some step may end in a run-time error
  std::string rows;                // of the certificate, if one is wanted
};

/// `system`, `image` and the circuit are of one compilation, without time and without a fault in the initialization.
/// Code of the image is not called.
[[nodiscard]] KLivenessProof prove_by_k_liveness(const Formula& formula, const System& system, const rt::Image& image,
                                                 const RunCircuit& circuit, const KLivenessOptions& options);

/// Returns by atom whether the formula speaks of it: of its state, or of steps in which it may take part.
[[nodiscard]] std::vector<std::uint8_t> named_atoms(const Formula& formula, const TransitionSystem& machine,
                                                    const rt::Image& image);

}  // namespace bip::verify
