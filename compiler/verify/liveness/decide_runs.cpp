// See decide_runs.hpp. The table is the whole strategy.
#include "compiler/verify/liveness/decide_runs.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "compiler/system/system.hpp"
#include "compiler/verify/liveness/finite_moves.hpp"
#include "compiler/verify/portfolio/portfolio.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

enum class RunsEngine : std::uint8_t { Graph, Neighbourhoods, KLiveness, FiniteMoves };
struct RunsTurn {
  RunsEngine engine;
  double fraction = 1;               // of the time that is left
  double fraction_alone = fraction;  // if finite moves are not tried
  double at_most = std::numeric_limits<double>::infinity();
};
// What is small is visited at once. A graph is made anew in its second turn.
constexpr RunsTurn kRunsTurns[] = {
    {RunsEngine::Graph, 1.0 / 8, 1.0 / 8, 3},
    {RunsEngine::Neighbourhoods, 1.0 / 2, 1.0 / 2, 120},
    {RunsEngine::KLiveness, 1.0 / 4, 1.0 / 2, 120},
    {RunsEngine::FiniteMoves, 3.0 / 4, 3.0 / 4, 180},
    {RunsEngine::Graph, 2.0 / 3},
    // An attempt has more time now than in the first turn; or the graph gave up for memory.
    {RunsEngine::KLiveness}};

// Of the time of neighbourhoods, for the question whether runs end.
constexpr double kShareOfDeadlock = 1.0 / 2;

class RunsPortfolio {
 public:
  RunsPortfolio(const Formula& formula, const System& system, const rt::Image& image, const LivenessOptions& options)
      : formula_(formula), system_(system), image_(image), options_(options) {}

  RunsDecision run(StateAccess access) {
    if (access == StateAccess::Undetermined) {
      graph_reason_ = reason_without_graph(system_);
      may_visit_ = false;
    }
    // A certificate has rounds of one monitor.
    may_split_ =
        options_.add_state == nullptr && rt::link(image_, rt::MaximalProgress::On).port_atom.size() <= kMostMovingPorts;
    for (const RunsTurn& turn : kRunsTurns) {
      if (!is_due(turn.engine)) continue;
      const bool is_graph = turn.engine == RunsEngine::Graph;
      const double left = options_.cancellation.seconds_left();
      // Questions that need little time are answered in the first turns. If the graph cannot grow, all time that is
      // left is for the proof.
      const bool is_last = turn.engine == RunsEngine::KLiveness && !may_visit_;
      const double fraction = may_split_ ? turn.fraction : turn.fraction_alone;
      const double seconds = is_last ? left : std::min(left * fraction, turn.at_most);
      BIP_ASSERT(seconds <= std::max(left, 0.0), "{} s of {} s for a turn", seconds, left);
      if (is_graph) visit(seconds);
      else if (turn.engine == RunsEngine::Neighbourhoods) look_around(seconds);
      else prove(seconds, turn.engine);
      if (decision_.outcome != Outcome::Unknown) return std::move(decision_);
      if (options_.cancellation.is_over()) break;
    }
    decision_.reason = graph_reason_;
    if (!proof_reason_.empty() && proof_reason_ != graph_reason_)
      decision_.reason += (graph_reason_.empty() ? "" : "; ") + proof_reason_;
    return std::move(decision_);
  }

 private:
  [[nodiscard]] bool is_due(RunsEngine engine) const {
    switch (engine) {
      case RunsEngine::Graph: return may_visit_;
      // They have no certificate.
      case RunsEngine::Neighbourhoods: return options_.add_state == nullptr && has_neighbourhoods(system_, image_);
      case RunsEngine::KLiveness: return may_prove_;
      case RunsEngine::FiniteMoves: return may_split_;
    }
    BIP_UNREACHABLE("an engine of runs");
  }
  void look_around(double seconds) {
    NeighbourhoodOptions options;
    options.fairness = options_.fairness;
    options.cancellation = options_.cancellation.within(seconds);
    options.never_ends = [&] { return never_ends(options.cancellation); };
    const NeighbourhoodProof proof = prove_by_neighbourhoods(formula_, system_, image_, options);
    if (!proof.is_proved) return;
    decision_.outcome = Outcome::Holds;
    decision_.by_neighbourhoods = proof;
  }
  // A run that ends where each atom is final is no deadlock: some atom never is.
  bool never_ends(const CancellationToken& cancellation) {
    const bool may_be_final = std::none_of(system_.atoms.begin(), system_.atoms.end(), [&](const Atom& atom) {
      return system_.atom_types[atom.type].final_places.empty();
    });
    if (may_be_final) return false;
    PortfolioLimits limits;
    limits.cancellation = cancellation.within(cancellation.seconds_left() * kShareOfDeadlock);
    limits.megabytes = options_.megabytes;
    const auto access = may_visit_ ? StateAccess::Searchable : StateAccess::Undetermined;
    Portfolio portfolio(
        system_, image_, access, [] { return true; }, options_.report);
    return portfolio.decide(Question{}, limits).outcome == Outcome::Holds;
  }
  void visit(double seconds) {
    LivenessOptions options = options_;
    options.cancellation = options_.cancellation.within(seconds);
    decision_.on_graph = decide_liveness(formula_, image_, options);
    decision_.outcome = decision_.on_graph.outcome;
    graph_reason_ = decision_.on_graph.reason;
    may_visit_ = decision_.on_graph.is_out_of_time;
  }
  void prove(double seconds, RunsEngine engine) {
    KLivenessOptions options;
    options.fairness = options_.fairness;
    options.cancellation = options_.cancellation.within(seconds);
    options.report = options_.report;
    options.wants_certificate = options_.add_state != nullptr;
    if (!circuit_) circuit_ = make_run_circuit(system_, image_, options_.megabytes, options.cancellation);
    const bool is_split = engine == RunsEngine::FiniteMoves;
    KLivenessProof proof = is_split ? prove_by_finite_moves(formula_, system_, image_, *circuit_, options)
                                    : prove_by_k_liveness(formula_, system_, image_, *circuit_, options);
    if (!is_split) {
      proof_reason_ = proof.reason;
      may_prove_ = proof.is_out_of_time;
    }
    if (proof.outcome != Outcome::Holds) return;
    decision_.outcome = Outcome::Holds;
    decision_.proof = std::move(proof);
  }

  const Formula& formula_;
  const System& system_;
  const rt::Image& image_;
  const LivenessOptions& options_;
  RunsDecision decision_;
  std::string graph_reason_, proof_reason_;
  std::optional<RunCircuit> circuit_;
  bool may_visit_ = true, may_prove_ = true, may_split_ = true;
};

}  // namespace

std::string reason_without_graph(const System& system) {
  return system.code.has_cpp()
             ? "what the model's C++ remembers is part of no state, so no cycle of states is known"
             : "the model draws random numbers, which no state determines, so no cycle of states is known";
}

RunsDecision decide_runs(const Formula& formula, const System& system, const rt::Image& image, StateAccess access,
                         const LivenessOptions& options) {
  return RunsPortfolio(formula, system, image, options).run(access);
}

}  // namespace bip::verify
