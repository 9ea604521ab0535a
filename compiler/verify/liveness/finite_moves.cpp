// See finite_moves.hpp.
#include "compiler/verify/liveness/finite_moves.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "compiler/base/log.hpp"
#include "compiler/verify/invariants/houdini.hpp"
#include "compiler/verify/invariants/pair_lemmas.hpp"
#include "compiler/verify/symbolic/cnf.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::array<std::uint32_t, 4> kBounds = {1, 4, 16, 64};
// Of the time that is left, for one search.
constexpr double kShareOfPort = 1.0 / 8;
// For what excludes ends, and for the property of what is left.
constexpr double kShareOfLemmas = 7.0 / 8, kShareOfRest = 1.0 / 2;

using Instances = std::vector<std::uint32_t>;  // of ports, in ascending order

std::uint32_t add(Formula& formula, const FormulaNode& node) {
  formula.nodes.push_back(node);
  return static_cast<std::uint32_t>(formula.nodes.size() - 1);
}
std::uint32_t add_step(Formula& formula, Instances instances) {
  StepCondition condition;
  condition.instances = std::move(instances);
  formula.steps.push_back(std::move(condition));
  return add(formula, {.kind = FormulaKind::Step, .row = static_cast<std::uint32_t>(formula.steps.size() - 1)});
}
std::uint32_t add_always(Formula& formula, std::uint32_t node) {
  const std::uint32_t never = add(formula, {.kind = FormulaKind::Constant, .value = false});
  return add(formula, {.kind = FormulaKind::Release, .a = never, .b = node});
}
std::uint32_t add_eventually(Formula& formula, std::uint32_t node) {
  const std::uint32_t any = add(formula, {.kind = FormulaKind::Constant, .value = true});
  return add(formula, {.kind = FormulaKind::Until, .a = any, .b = node});
}
void add_alternative(Formula& formula, std::uint32_t node) {
  formula.root = add(formula, {.kind = FormulaKind::Or, .a = formula.root, .b = node});
  formula.response.reset();
}

// Or the finite ports move again and again, which they do not.
Formula up_to(const Formula& formula, const Instances& finite) {
  Formula made = formula;
  if (!finite.empty()) {
    const std::uint32_t moves = add_step(made, finite);
    const std::uint32_t soon = add_eventually(made, moves);
    add_alternative(made, add_always(made, soon));
  }
  return made;
}
// Or from some point on the port does not move.
Formula or_rests(Formula formula, std::uint32_t port) {
  const std::uint32_t moves = add_step(formula, {port});
  const std::uint32_t rests = add(formula, {.kind = FormulaKind::Not, .a = moves});
  const std::uint32_t for_ever = add_always(formula, rests);
  add_alternative(formula, add_eventually(formula, for_ever));
  return formula;
}

class FiniteMoves {
 public:
  FiniteMoves(const Formula& formula, const System& system, const rt::Image& image, const RunCircuit& circuit,
              const KLivenessOptions& options)
      : formula_(formula),
        system_(system),
        image_(image),
        circuit_(circuit),
        options_(options),
        tables_(rt::link(image, rt::MaximalProgress::On)) {}

  KLivenessProof run() {
    KLivenessProof none;
    none.reason = circuit_.problem;
    if (!circuit_.problem.empty() || is_invariant_of_past(formula_)) return none;
    find_ports();
    if (ports_.size() > kMostMovingPorts) return none;
    find_finite();
    if (finite_.empty()) {
      none.is_out_of_time = options_.cancellation.is_over();
      return none;
    }
    KLivenessProof proof;
    // A run of which each step has a finite port ends, and what excludes ends excludes it.
    if (is_each_step_finite() && has_no_end()) {
      proof.outcome = Outcome::Holds;
      proof.atoms = static_cast<std::uint32_t>(circuit_.machine.marks.size());
      proof.may_have_errors = may_have_errors(circuit_, options_.cancellation);
    } else {
      KLivenessOptions options = options_;
      options.cancellation = options_.cancellation.within(options_.cancellation.seconds_left() * kShareOfRest);
      proof = prove_by_k_liveness(up_to(formula_, finite_), system_, image_, circuit_, options);
    }
    proof.finite_ports = static_cast<std::uint32_t>(finite_.size());
    return proof;
  }

 private:
  struct Port {
    std::uint32_t instance = 0;
    std::vector<std::uint8_t> keeps = {};  // the atoms of its part
    bool is_finite = false;
    bool has_run = false;  // its part moves it for ever, as long as no other port of the part is known to be finite
    // By bound: the finite ports of the part when it was tried, and one more.
    std::array<std::size_t, kBounds.size()> tried_with = {};
  };

  void find_ports() {
    const std::vector<std::uint8_t> named = named_atoms(formula_, circuit_.machine, image_);
    std::vector<std::uint8_t> is_listed(tables_.port_atom.size(), 0);
    for (const SystemStep& step : circuit_.machine.steps) {
      for (const auto& [port, when] : step.parts) is_listed[port] = 1;
    }
    for (std::uint32_t port = 0; port < is_listed.size(); ++port) {
      if (is_listed[port] == 0) continue;
      ports_.push_back({.instance = port, .keeps = named});
      ports_.back().keeps[tables_.port_atom[port]] = 1;
    }
    // What the property speaks of mostly moves least.
    std::stable_partition(ports_.begin(), ports_.end(),
                          [&](const Port& port) { return named[tables_.port_atom[port.instance]] != 0; });
  }

  // With one more finite port, others may have smaller bounds.
  void find_finite() {
    for (std::size_t level = 0; level < kBounds.size();) {
      bool has_more = false;
      for (Port& port : ports_) {
        if (options_.cancellation.is_over() || is_each_step_finite()) return;
        has_more = is_found_finite(port, level) || has_more;
      }
      level = has_more ? 0 : level + 1;
    }
  }
  bool is_found_finite(Port& port, std::size_t level) {
    if (port.is_finite) return false;
    const auto known = static_cast<std::size_t>(std::count_if(finite_.begin(), finite_.end(), [&](std::uint32_t other) {
      return port.keeps[tables_.port_atom[other]] != 0;
    }));
    if (port.tried_with[level] == known + 1) return false;
    if (port.has_run && *std::max_element(port.tried_with.begin(), port.tried_with.end()) == known + 1) return false;
    port.tried_with[level] = known + 1;
    KLivenessOptions options;
    options.cancellation = options_.cancellation.within(options_.cancellation.seconds_left() * kShareOfPort);
    options.attempt = KLivenessAttempt{port.keeps, kBounds[level]};
    options.report = options_.report;
    const KLivenessProof proof =
        prove_by_k_liveness(or_rests(up_to(formula_, finite_), port.instance), system_, image_, circuit_, options);
    port.has_run = proof.has_run;
    if (proof.outcome != Outcome::Holds) return false;
    port.is_finite = true;
    finite_.insert(std::lower_bound(finite_.begin(), finite_.end(), port.instance), port.instance);
    BIP_LOG(Ic3, 1, "port {} moves finitely often: at most {} rounds", port.instance, kBounds[level]);
    return true;
  }
  // Does a finite port take part in each step, whatever the state?
  [[nodiscard]] bool is_each_step_finite() const {
    Solver solver;
    Cnf cnf(circuit_.machine.aig, solver);
    for (const bool is_solved : {false, true}) {
      if (is_solved) cnf.add_state(circuit_.machine);
      for (const SystemStep& step : circuit_.machine.steps) {
        std::vector<Signal> without{step.fine};
        for (const auto& [port, when] : step.parts) {
          if (std::binary_search(finite_.begin(), finite_.end(), port)) without.push_back(negated(when));
        }
        if (without.size() == 1) return false;
        if (!is_solved) continue;
        for (const Signal signal : without) solver.assume(cnf.literal(signal));
        if (solver.solve(options_.cancellation) != Answer::Unsatisfiable) return false;
      }
    }
    return true;
  }
  // By lemmas about two components each.
  [[nodiscard]] bool has_no_end() const {
    Ic3Problem problem;
    problem.system = &circuit_.machine;
    // In final places, too: the last state repeats.
    problem.bad = circuit_.machine.ended;
    problem.invariants = circuit_.clauses;
    problem.cancellation = options_.cancellation.within(options_.cancellation.seconds_left() * kShareOfLemmas);
    return houdini(problem, find_pair_lemmas(problem, system_)).is_enough;
  }

  const Formula& formula_;
  const System& system_;
  const rt::Image& image_;
  const RunCircuit& circuit_;
  const KLivenessOptions& options_;
  const rt::Tables tables_;
  std::vector<Port> ports_;
  Instances finite_;
};

}  // namespace

KLivenessProof prove_by_finite_moves(const Formula& formula, const System& system, const rt::Image& image,
                                     const RunCircuit& circuit, const KLivenessOptions& options) {
  return FiniteMoves(formula, system, image, circuit, options).run();
}

}  // namespace bip::verify
