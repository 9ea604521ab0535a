// See k_liveness.hpp.
#include "compiler/verify/liveness/k_liveness.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "compiler/base/log.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/liveness/automaton.hpp"
#include "compiler/verify/liveness/round_monitor.hpp"
#include "compiler/verify/symbolic/ic3.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Of the time that is left an attempt may use this part, and each search in it, with units that the ones before taught,
// that one.
constexpr double kShareOfAttempt = 1.0 / 2, kShareOfSearch = 1.0 / 4;
// Of a part, which mostly has such runs because it lacks what would end them.
constexpr std::uint32_t kMostRoundsOfPart = 64;

using AtomMask = std::vector<std::uint8_t>;  // by atom

// The values of a circuit's signals along a counterexample.
class CircuitRun {
 public:
  CircuitRun(const TransitionSystem& machine, const Ic3Answer& answer) : machine_(machine) {
    std::vector<std::uint8_t> state;
    for (const StateBit& bit : machine.bits) state.push_back(bit.initial > 0 ? 1 : 0);
    for (const u32 literal : answer.first) {
      if (machine.bits[cube_bit(literal)].initial < 0) state[cube_bit(literal)] = cube_value(literal) ? 1 : 0;
    }
    states_.push_back(state);
    for (const std::vector<Signal>& inputs : answer.inputs) {
      BIP_ASSERT(state.size() == machine.bits.size(), "{} bits of a state of {}", state.size(), machine.bits.size());
      std::vector<std::uint8_t>& values = values_.emplace_back(machine.aig.size(), 0);
      for (std::size_t bit = 0; bit < state.size(); ++bit) values[node_of(machine.bits[bit].now)] = state[bit];
      for (const Signal input : inputs) values[node_of(input)] = 1;
      for (u32 node = 1; node < machine.aig.size(); ++node) {
        if (machine.aig.is_input(node)) continue;
        const Aig::Node& operands = machine.aig.node(node);
        BIP_ASSERT(node_of(operands.a) < node && node_of(operands.b) < node, "node {} comes before its operands", node);
        values[node] = of(values, operands.a) && of(values, operands.b) ? 1 : 0;
      }
      for (std::size_t bit = 0; bit < state.size(); ++bit) state[bit] = of(values, machine.bits[bit].next) ? 1 : 0;
      states_.push_back(state);
    }
  }
  [[nodiscard]] std::uint8_t bit(std::size_t position, u32 row) const { return states_[position][row]; }
  [[nodiscard]] bool value(std::size_t position, Signal signal) const { return of(values_[position], signal); }

 private:
  static bool of(const std::vector<std::uint8_t>& values, Signal signal) {
    return (values[node_of(signal)] != 0) != ((signal & 1) != 0);
  }
  const TransitionSystem& machine_;
  std::vector<std::vector<std::uint8_t>> states_, values_;  // by position: by bit, by node
};

class KLiveness {
 public:
  KLiveness(const Formula& formula, const System& system, const rt::Image& image, const RunCircuit& circuit,
            const KLivenessOptions& options)
      : formula_(formula), system_(system), image_(image), circuit_(circuit), options_(options) {}

  KLivenessProof run() {
    Result<Automaton> automaton = make_automaton(formula_, RunsOf::Negation);
    if (!automaton) return unknown(automaton.error());
    automaton_ = std::move(*automaton);
    if (options_.wants_certificate && (automaton_.is_empty() || is_invariant_of_past(formula_)))
      return unknown("there is no certificate of a proof on the circuit");
    if (automaton_.is_empty()) {
      result_.outcome = Outcome::Holds;
      return std::move(result_);
    }
    if (!circuit_.problem.empty()) return unknown(circuit_.problem);
    if (options_.attempt) {
      parts_.push_back({{options_.attempt->keeps}, {}, nullptr, false});
      (void)is_proved(0, options_.attempt->rounds);
      result_.has_run = parts_[0].has_run;
    } else {
      find_parts();
      try_parts();
    }
    if (result_.outcome == Outcome::Unknown)
      return unknown(options_.cancellation.is_cancelled() ? "interrupted"
                     : options_.cancellation.is_over()    ? "the time is over"
                                                          : "no bound for the rounds of a run was found");
    return std::move(result_);
  }

 private:
  KLivenessProof unknown(const std::string& reason) {
    result_.outcome = Outcome::Unknown;
    result_.reason = reason;
    result_.is_out_of_time = options_.cancellation.is_over();
    return std::move(result_);
  }

  struct Part {
    RoundMonitor::Part atoms;
    std::vector<std::uint32_t> expected = {};  // units of fairness that a round needs: as they turn out to matter
    std::unique_ptr<RoundMonitor> monitor = nullptr;
    bool has_run = false;  // of rounds without end, fair to all units: no bound exists
  };

  // The atoms of the property, then those that take part in steps with them, and so on; at last all.
  void find_parts() {
    const rt::Tables tables = rt::link(image_, rt::MaximalProgress::On);
    AtomMask kept = named_atoms(formula_, circuit_.machine, image_);
    distance_.assign(kept.size(), 0);
    const auto has_all = [&] { return std::find(kept.begin(), kept.end(), 0) == kept.end(); };
    for (bool grows = true; grows && !has_all();) {
      parts_.push_back({{kept}, {}, nullptr, false});
      AtomMask more = kept;
      for (const SystemStep& step : circuit_.machine.steps) {
        if (std::any_of(step.parts.begin(), step.parts.end(),
                        [&](const auto& part) { return kept[tables.port_atom[part.first]] != 0; })) {
          for (const auto& [port, ignored] : step.parts) more[tables.port_atom[port]] = 1;
        }
      }
      grows = more != kept;
      kept = std::move(more);
      for (std::size_t atom = 0; atom < kept.size(); ++atom) distance_[atom] += kept[atom] == 0 ? 1 : 0;
    }
    parts_.emplace_back();
  }

  [[nodiscard]] static std::uint32_t bound_of(std::size_t turn) {
    return turn == 0 ? 0 : std::uint32_t{1} << std::min<std::size_t>(2 * turn - 2, 30);
  }
  // Turn t: the part number p with the bound number t - p.
  void try_parts() {
    const bool is_invariant = is_invariant_of_past(formula_);
    for (std::size_t turn = 0;; ++turn) {
      bool is_tried = false;
      for (std::size_t part = 0; part < parts_.size() && part <= turn; ++part) {
        const std::uint32_t bound = bound_of(turn - part);
        const std::uint32_t most = parts_[part].atoms.has_all() ? options_.most_rounds : kMostRoundsOfPart;
        if (parts_[part].has_run || bound > most || (is_invariant && turn != part)) continue;
        if (options_.cancellation.is_over()) return;
        is_tried = true;
        if (is_proved(part, bound)) return;
      }
      if (!is_tried && turn >= parts_.size()) return;
    }
  }

  bool is_proved(std::size_t row, std::uint32_t bound) {
    Part& part = parts_[row];
    // The only attempt has all of the time.
    const double share = options_.attempt ? 1 : kShareOfAttempt,
                 share_of_search = options_.attempt ? 1 : kShareOfSearch;
    const CancellationToken attempt = options_.cancellation.within(options_.cancellation.seconds_left() * share);
    for (;;) {
      if (!part.monitor)
        part.monitor = std::make_unique<RoundMonitor>(circuit_.machine, image_, formula_,
                                                      options_.wants_certificate ? nullptr : &automaton_,
                                                      options_.fairness, part.atoms, circuit_.clauses, part.expected);
      RoundMonitor& monitor = *part.monitor;
      const bool is_invariant = is_invariant_of_past(formula_);
      Ic3Problem problem;
      problem.bad = is_invariant ? monitor.violated() : monitor.more_rounds_than(bound);
      problem.system = &monitor.machine();
      problem.invariants = monitor.clauses();
      problem.constraint = monitor.constraint();
      problem.cancellation = attempt.within(options_.cancellation.seconds_left() * share_of_search);
      problem.report = [this](std::uint32_t, std::size_t lemmas) {
        if (options_.report) options_.report("k-liveness", lemmas, "lemmas");
      };
      if (!is_invariant) observe(monitor, problem.observed);
      // Promises are kept by the constraint alone, so what it reads is followed, too.
      if (options_.wants_certificate) problem.observed.push_back(monitor.constraint());
      const Ic3Answer answer = run_ic3(problem);
      BIP_LOG(Ic3, 1, "part {} of {}, {} of {} units, at most {} rounds: {}", row + 1, parts_.size(),
              part.expected.size(), monitor.units().size(), bound,
              answer.end == Ic3End::Safe      ? "proved"
              : answer.end == Ic3End::Reached ? "more"
                                              : "stopped");
      if (answer.end == Ic3End::Safe) {
        note_proof(part, bound, answer);
        return true;
      }
      if (answer.end == Ic3End::Stopped || is_invariant || !learns_from(answer, part)) return false;
    }
  }
  void note_proof(const Part& part, std::uint32_t bound, const Ic3Answer& answer) {
    result_.outcome = Outcome::Holds;
    if (!options_.attempt) result_.may_have_errors = may_have_errors(circuit_, options_.cancellation);
    result_.rounds = bound;
    result_.frames = answer.frames;
    result_.lemmas = answer.lemmas.size();
    result_.units = static_cast<std::uint32_t>(part.expected.size());
    const AtomMask& keeps = part.atoms.keeps;
    result_.atoms = static_cast<std::uint32_t>(
        keeps.empty() ? system_.atoms.size() : static_cast<std::size_t>(std::count(keeps.begin(), keeps.end(), 1)));
    if (options_.wants_certificate) write_certificate(part, answer);
  }

  // The turns that are expected, the invariants, and the lemmas, which speak of the monitor's bits, too.
  void write_certificate(const Part& part, const Ic3Answer& answer) {
    const rt::Tables tables = rt::link(image_, rt::MaximalProgress::On);
    const RoundMonitor& monitor = *part.monitor;
    std::string& out = result_.rows;
    out = "rounds " + std::to_string(result_.rounds) + '\n';
    for (const std::uint32_t row : part.expected) {
      const RoundMonitor::Unit& unit = monitor.units()[row];
      out += "turn";
      const FairnessTerm& term = options_.fairness.terms[unit.term];
      if (term.has_name()) out += ' ' + certificate_text(term, system_);
      else if (term.unit == FairnessUnit::Atoms) out += ' ' + system_.atoms[AtomId(unit.atom)].path;
      else if (tables.is_of_connector(unit.interaction))
        out += ' ' + system_.connectors[ConnectorId(tables.connector_of(unit.interaction))].path;
      for (const std::uint32_t port : unit.ports) {
        const std::uint32_t atom = tables.port_atom[port];
        const Atom& owner = system_.atoms[AtomId(std::size_t{atom})];
        out += ' ' + owner.path + '.' + system_.atom_types[owner.type].ports[port - tables.instance(atom, 0)].name;
      }
      out += '\n';
    }
    out += invariant_rows(circuit_.net, circuit_.proof ? &*circuit_.proof : nullptr, circuit_.affine, circuit_.machine,
                          system_);
    // A single demand has no bit here: where it is met the round ends.
    if (const std::optional<std::size_t> demand = monitor.lone_demand())
      out += "lemma !%seen" + std::to_string(*demand) + '\n';
    for (const Cube& cube : answer.lemmas) {
      out += "lemma";
      for (const std::uint32_t literal : cube) {
        const StateBit& bit = monitor.machine().bits[cube_bit(literal)];
        out += ' ' + (bit.atom != kNoRow ? literal_text(bit, !cube_value(literal), system_)
                                         : (cube_value(literal) ? "!" : "") + monitor.name_of(cube_bit(literal)));
      }
      out += '\n';
    }
  }

  static void observe(const RoundMonitor& monitor, std::vector<Signal>& observed) {
    observed = monitor.demands();
    observed.push_back(monitor.inside());
    for (const RoundMonitor::Unit& unit : monitor.units()) {
      observed.push_back(unit.possible);
      observed.push_back(unit.taken);
    }
  }

  // Follows the run of a counterexample. If a part of it repeats, all demands included, then some unit that was not
  // expected is left out there: the nearest ones are expected from now on. Or none is left out, and no bound exists.
  // True: units were added.
  bool learns_from(const Ic3Answer& answer, Part& part) {
    const std::vector<std::uint32_t> left_out = units_left_out(answer, *part.monitor, part.has_run);
    if (left_out.empty()) return false;
    const auto cost = [&](std::uint32_t unit) {
      std::uint32_t most = 0, sum = 0;
      for (const std::uint32_t atom : part.monitor->units()[unit].atoms) {
        most = std::max(most, distance_[atom]);
        sum += distance_[atom];
      }
      return std::pair(most, sum);
    };
    const auto nearest = cost(*std::min_element(left_out.begin(), left_out.end(),
                                                [&](std::uint32_t a, std::uint32_t b) { return cost(a) < cost(b); }));
    std::copy_if(left_out.begin(), left_out.end(), std::back_inserter(part.expected),
                 [&](std::uint32_t unit) { return cost(unit) == nearest; });
    part.monitor.reset();
    return true;
  }
  // Of the cycle that leaves out fewest; empty if there is no cycle, or one that leaves out none (`has_run`).
  std::vector<std::uint32_t> units_left_out(const Ic3Answer& answer, const RoundMonitor& monitor, bool& has_run) const {
    const CircuitRun run(monitor.machine(), answer);
    std::map<std::vector<std::uint8_t>, std::size_t> first;  // position of a state
    std::map<std::size_t, std::size_t> last;                 // by first position
    for (std::size_t at = 0; at <= answer.steps.size(); ++at) {
      std::vector<std::uint8_t> state;
      for (std::uint32_t bit = 0; bit < monitor.machine().bits.size(); ++bit) {
        if (!monitor.is_of_round(bit)) state.push_back(run.bit(at, bit));
      }
      const auto [found, is_new] = first.try_emplace(std::move(state), at);
      if (!is_new) last[found->second] = at;
    }
    std::vector<std::uint32_t> fewest;
    for (const auto& [begin, end] : last) {
      const auto sometimes = [&, begin = begin, end = end](const auto& holds) {
        for (std::size_t at = begin; at < end; ++at) {
          if (holds(at)) return true;
        }
        return false;
      };
      if (sometimes([&](std::size_t at) { return !run.value(at, monitor.inside()); })) continue;
      if (!std::all_of(monitor.demands().begin(), monitor.demands().end(),
                       [&](Signal demand) { return sometimes([&](std::size_t at) { return run.value(at, demand); }); }))
        continue;
      std::vector<std::uint32_t> left_out;
      for (std::uint32_t row = 0; row < monitor.units().size(); ++row) {
        const RoundMonitor::Unit& unit = monitor.units()[row];
        if (sometimes([&](std::size_t at) { return run.value(at, unit.taken); })) continue;
        const bool is_due = unit.is_strong ? sometimes([&](std::size_t at) { return run.value(at, unit.possible); })
                                           : !sometimes([&](std::size_t at) { return !run.value(at, unit.possible); });
        if (is_due) left_out.push_back(row);
      }
      if (left_out.empty()) {
        has_run = true;
        return {};
      }
      if (fewest.empty() || left_out.size() < fewest.size()) fewest = std::move(left_out);
    }
    return fewest;
  }

  const Formula& formula_;
  const System& system_;
  const rt::Image& image_;
  const RunCircuit& circuit_;
  const KLivenessOptions& options_;
  Automaton automaton_;
  std::vector<Part> parts_;
  std::vector<std::uint32_t> distance_;  // by atom: from those of the property
  KLivenessProof result_;
};

}  // namespace

std::vector<std::uint8_t> named_atoms(const Formula& formula, const TransitionSystem& machine, const rt::Image& image) {
  const rt::Tables tables = rt::link(image, rt::MaximalProgress::On);
  AtomMask named(machine.marks.size(), 0);
  const auto name_connector = [&](std::uint32_t row) {
    for (const SystemStep& step : machine.steps) {
      if (!tables.is_of_connector(step.interaction) || tables.connector_of(step.interaction) != row) continue;
      for (const auto& [port, ignored] : step.parts) named[tables.port_atom[port]] = 1;
    }
  };
  for (const Property& condition : formula.states) {
    for (const std::uint32_t atom : atoms_of(condition)) named[atom] = 1;
    for (const std::uint32_t row : connectors_of(condition)) name_connector(row);
  }
  for (const StepCondition& condition : formula.steps) {
    if (!condition.instances.empty()) continue;
    if (condition.is_port) named[condition.owner] = 1;
    else name_connector(condition.owner);
  }
  return named;
}

KLivenessProof prove_by_k_liveness(const Formula& formula, const System& system, const rt::Image& image,
                                   const RunCircuit& circuit, const KLivenessOptions& options) {
  return KLiveness(formula, system, image, circuit, options).run();
}

}  // namespace bip::verify
