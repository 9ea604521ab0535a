// See round_monitor.hpp.
#include "compiler/verify/liveness/round_monitor.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "compiler/verify/net/net.hpp"
#include "compiler/verify/symbolic/property_signal.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Participants of a step that depend on the state: each set of them is a unit of its own. More than this many are left
// out of fairness.
constexpr std::size_t kMostDependentParts = 4;

Property as_condition(Property property) {
  // broken_signal says where it is true.
  property.is_never = true;
  return property;
}

void insert_atom(std::vector<std::uint32_t>& atoms, std::uint32_t atom) {
  const auto at = std::lower_bound(atoms.begin(), atoms.end(), atom);
  if (at == atoms.end() || *at != atom) atoms.insert(at, atom);
}

// By node: does one of the bits stand below it?
std::vector<std::uint8_t> nodes_above(const Aig& aig, const std::vector<StateBit>& bits) {
  std::vector<std::uint8_t> is_above(aig.size(), 0);
  for (const StateBit& bit : bits) is_above[node_of(bit.now)] = 1;
  for (std::uint32_t node = 1; node < aig.size(); ++node) {
    if (aig.is_input(node)) continue;
    const Aig::Node& operands = aig.node(node);
    is_above[node] = is_above[node_of(operands.a)] | is_above[node_of(operands.b)];
  }
  return is_above;
}

}  // namespace

RoundMonitor::RoundMonitor(const TransitionSystem& system, const rt::Image& image, const Formula& formula,
                           const Automaton* automaton, const Fairness& fairness, const Part& part,
                           const StateClauses& clauses, const std::vector<std::uint32_t>& expected)
    : machine_(system), aig_(machine_.aig), tables_(rt::link(image, rt::MaximalProgress::On)), expected_(expected) {
  BIP_ASSERT((automaton == nullptr || !automaton->is_empty()) && system.unsupported.empty(),
             "no automaton, or no circuit");
  find_conditions(formula, image, part);
  find_units(fairness, part);
  add_end(part);
  cut(part, clauses);
  if (is_strong_) add_guesses();
  if (automaton == nullptr) {
    run_tester(formula);
  } else {
    run_automaton(*automaton);
    find_violated(*automaton);
  }
  add_rounds();
}

void RoundMonitor::find_conditions(const Formula& formula, const rt::Image& image, const Part& part) {
  BIP_ASSERT(conditions_.empty(), "{} conditions before they are found", conditions_.size());
  states_ = formula.states.size();
  for (const Property& condition : formula.states)
    conditions_.push_back(broken_signal(as_condition(condition), machine_, image));
  for (const StepCondition& condition : formula.steps) {
    Signal happens = kFalse;
    for (const SystemStep& step : machine_.steps) {
      if (!condition.instances.empty()) {
        for (const auto& [port, when] : step.parts) {
          if (std::binary_search(condition.instances.begin(), condition.instances.end(), port) &&
              part.has(tables_.port_atom[port]))
            happens = aig_.make_or(happens, aig_.make_and(step.chosen, when));
        }
      } else if (condition.is_port) {
        for (const auto& [port, when] : step.parts) {
          if (port == tables_.instance(condition.owner, condition.port))
            happens = aig_.make_or(happens, aig_.make_and(step.chosen, when));
        }
      } else if (tables_.is_of_connector(step.interaction) &&
                 tables_.interactions[step.interaction].row == condition.owner) {
        happens = aig_.make_or(happens, step.chosen);
      }
    }
    conditions_.push_back(happens);
  }
}

// What cannot be named exactly is possible more rarely here than it is, or left out: then more runs are fair.
void RoundMonitor::find_units(const Fairness& fairness, const Part& part) {
  is_strong_ = fairness.has(FairnessKind::Strong);
  // The term; the interaction and its ports, or the atom.
  using Key = std::tuple<std::size_t, rt::InteractionId, std::uint32_t, std::vector<std::uint32_t>>;
  std::map<Key, Unit> units;
  const auto add = [&](const Key& key, Signal when, const SystemStep& step) -> Unit& {
    Unit& unit = units[key];
    std::tie(unit.term, unit.interaction, unit.atom, unit.ports) = key;
    unit.is_strong = fairness.terms[unit.term].is_strong();
    const Signal possible = aig_.make_and(step.fine, when);
    unit.possible = aig_.make_or(unit.possible, possible);
    unit.taken = aig_.make_or(unit.taken, aig_.make_and(step.chosen, possible));
    return unit;
  };
  // Of atoms, and of what has a name. All atoms of its interactions must be kept.
  const auto add_one = [&](std::size_t term, std::uint32_t atom, Signal when, const SystemStep& step) {
    Unit& unit = add(Key(term, rt::InteractionId(), atom, std::vector<std::uint32_t>()), when, step);
    for (const auto& [port, ignored] : step.parts) insert_atom(unit.atoms, tables_.port_atom[port]);
  };
  const auto add_interactions = [&](std::size_t term, const SystemStep& step) {
    std::vector<Signal> when;
    for (const auto& [port, taken] : step.parts) {
      if (taken != kTrue && std::find(when.begin(), when.end(), taken) == when.end()) when.push_back(taken);
    }
    if (when.size() > kMostDependentParts) return;
    for (std::uint32_t set = 0; set < std::uint32_t{1} << when.size(); ++set) {
      Signal is_set = kTrue;
      for (std::size_t k = 0; k < when.size(); ++k)
        is_set = aig_.make_and(is_set, (set >> k & 1) != 0 ? when[k] : negated(when[k]));
      std::vector<std::uint32_t> ports;
      for (const auto& [port, taken] : step.parts) {
        const auto at = std::find(when.begin(), when.end(), taken);
        if (at == when.end() || (set >> (at - when.begin()) & 1) != 0) ports.push_back(port);
      }
      if (ports.empty() || is_set == kFalse) continue;
      std::sort(ports.begin(), ports.end());
      Unit& unit = add(Key(term, step.interaction, 0u, std::move(ports)), is_set, step);
      // Whether it is possible depends on each of its participants.
      for (const auto& [port, ignored] : step.parts) insert_atom(unit.atoms, tables_.port_atom[port]);
    }
  };
  for (const SystemStep& step : machine_.steps) {
    for (std::size_t row = 0; row < fairness.terms.size(); ++row) {
      const FairnessTerm& term = fairness.terms[row];
      if (term.unit == FairnessUnit::Interactions) {
        add_interactions(row, step);
      } else if (term.unit == FairnessUnit::Connector) {
        if (tables_.is_of_connector(step.interaction) && tables_.connector_of(step.interaction) == term.owner)
          add_one(row, 0, kTrue, step);
      } else {
        for (const auto& [port, when] : step.parts) {
          const std::uint32_t atom = tables_.port_atom[port];
          const bool is_meant = term.unit == FairnessUnit::Atoms ||
                                (atom == term.owner &&
                                 (term.unit == FairnessUnit::Atom || port == tables_.instance(term.owner, term.port)));
          if (is_meant) add_one(row, atom, when, step);
        }
      }
    }
  }
  for (auto& [key, unit] : units) {
    if (unit.possible == kFalse) continue;
    if (std::all_of(unit.atoms.begin(), unit.atoms.end(), [&](std::uint32_t atom) { return part.has(atom); }))
      units_.push_back(std::move(unit));
  }
}

// The last state of a run repeats. Of a part, what others do is a step in which nothing of it moves; the system's end
// is none of its own.
void RoundMonitor::add_end(const Part& part) {
  SystemStep end{.interaction = {}, .chosen = aig_.make_input(), .possible = kTrue, .fine = kTrue, .parts = {}};
  if (part.has_all()) {
    std::vector<Signal> possible, chosen{end.chosen};
    for (const SystemStep& step : machine_.steps) {
      possible.push_back(step.possible);
      chosen.push_back(step.chosen);
    }
    end.possible = aig_.make_and(negated(aig_.make_or_of(possible)), negated(machine_.state_fault));
    end.fine = end.possible;
    // No step is left out of the circuit's cone, so one of them happens.
    happened_ = aig_.make_or_of(chosen);
  }
  machine_.steps.push_back(std::move(end));
}

// The bits of other atoms become inputs. What ties them to the rest is asked of each step.
void RoundMonitor::cut(const Part& part, const StateClauses& clauses) {
  if (part.has_all()) {
    clauses_ = clauses;
    return;
  }
  std::vector<StateBit> bits;
  std::vector<std::uint32_t> row(machine_.bits.size(), kNoRow);
  std::vector<std::uint8_t> is_cut(aig_.size(), 0);
  for (std::size_t k = 0; k < row.size(); ++k) {
    const StateBit& bit = machine_.bits[k];
    if (!part.has(bit.atom)) {
      is_cut[node_of(bit.now)] = 1;
      continue;
    }
    row[k] = static_cast<std::uint32_t>(bits.size());
    bits.push_back(bit);
  }
  StateClauses all = clauses;
  for (const Signal inside : machine_.in_range) all.push_back({inside});
  machine_.in_range.clear();
  std::vector<std::vector<std::uint32_t>> groups;
  for (const std::vector<std::uint32_t>& group : machine_.exactly_one) {
    BIP_ASSERT(std::all_of(group.begin(), group.end(),
                           [&](std::uint32_t bit) { return (row[bit] != kNoRow) == (row[group[0]] != kNoRow); }),
               "a group of {} bits is of atoms that are kept and others", group.size());
    if (row[group[0]] != kNoRow) {
      groups.emplace_back();
      for (const std::uint32_t bit : group) groups.back().push_back(row[bit]);
      continue;
    }
    all.emplace_back();
    for (const std::uint32_t bit : group) all.back().push_back(machine_.bits[bit].now);
    for (std::size_t i = 0; i < group.size(); ++i) {
      for (std::size_t j = i + 1; j < group.size(); ++j)
        all.push_back({negated(machine_.bits[group[i]].now), negated(machine_.bits[group[j]].now)});
    }
  }
  machine_.exactly_one = std::move(groups);
  // What kept atoms do reads some of the others; what is said of these alone, or ties them to the kept, is asked for.
  std::vector<std::uint8_t> is_read(aig_.size(), 0);
  std::vector<std::uint32_t> todo;
  const auto read = [&](Signal signal) { todo.push_back(node_of(signal)); };
  for (const StateBit& bit : bits) read(bit.next);
  for (const Signal condition : conditions_) read(condition);
  for (const Unit& unit : units_) read(unit.possible);
  for (const SystemStep& step : machine_.steps) {
    if (std::any_of(step.parts.begin(), step.parts.end(),
                    [&](const auto& taking) { return part.has(tables_.port_atom[taking.first]); }))
      read(step.fine);
  }
  while (!todo.empty()) {
    const std::uint32_t node = todo.back();
    todo.pop_back();
    if (is_read[node] != 0) continue;
    is_read[node] = 1;
    if (node == 0 || aig_.is_input(node)) continue;
    read(aig_.node(node).a);
    read(aig_.node(node).b);
  }
  machine_.bits = std::move(bits);
  const std::vector<std::uint8_t> above_kept = nodes_above(aig_, machine_.bits);
  std::vector<std::uint8_t> reads_cut(aig_.size(), 0), reads_other(aig_.size(), 0);
  for (std::uint32_t node = 1; node < aig_.size(); ++node) {
    if (aig_.is_input(node)) {
      reads_cut[node] = is_cut[node];
      reads_other[node] = is_cut[node] != 0 && is_read[node] == 0 ? 1 : 0;
      continue;
    }
    const Aig::Node operands = aig_.node(node);
    reads_cut[node] = reads_cut[node_of(operands.a)] | reads_cut[node_of(operands.b)];
    reads_other[node] = reads_other[node_of(operands.a)] | reads_other[node_of(operands.b)];
  }
  std::vector<Signal> ties;
  for (std::vector<Signal>& clause : all) {
    const auto any = [&](const std::vector<std::uint8_t>& of) {
      return std::any_of(clause.begin(), clause.end(), [&](Signal s) { return of[node_of(s)] != 0; });
    };
    if (!any(reads_cut)) {
      if (any(above_kept)) clauses_.push_back(std::move(clause));
    } else if (!any(reads_other) || any(above_kept)) {
      ties.push_back(aig_.make_or_of(clause));
    }
  }
  constraint_ = aig_.make_and_of(ties);
}

std::uint32_t RoundMonitor::add_bit(std::int8_t initial, const std::string& name) {
  StateBit bit;
  bit.now = aig_.make_input();
  bit.next = bit.now;
  bit.initial = initial;
  bit.atom = kNoRow;
  machine_.bits.push_back(bit);
  names_.resize(machine_.bits.size());
  names_.back() = name;
  return static_cast<std::uint32_t>(machine_.bits.size() - 1);
}

std::uint32_t RoundMonitor::add_bit_of_round(const std::string& name) {
  const std::uint32_t bit = add_bit(0, name);
  is_of_round_.resize(machine_.bits.size(), 0);
  is_of_round_[bit] = 1;
  return bit;
}

void RoundMonitor::add_guesses() {
  const std::uint32_t started = add_bit(0, "%started0");
  started_ = now(started);
  machine_.bits[started].next = aig_.make_or(started_, aig_.make_input());
  std::vector<Signal> fails;
  for (const std::uint32_t unit : expected_) {
    if (!units_[unit].is_strong) {
      never_.push_back(kFalse);
      continue;
    }
    // It keeps the value that it has at first, which is any.
    never_.push_back(now(add_bit(-1, "%never" + std::to_string(never_.size()))));
    fails.push_back(aig_.make_and(never_.back(), units_[unit].possible));
  }
  guess_fails_ = aig_.make_and(started_, aig_.make_or_of(fails));
}

Signal RoundMonitor::matches(std::uint64_t required, std::uint64_t forbidden) {
  std::vector<Signal> all;
  for (std::size_t k = 0; k < conditions_.size(); ++k) {
    if ((required >> k & 1) != 0) all.push_back(conditions_[k]);
    if ((forbidden >> k & 1) != 0) all.push_back(negated(conditions_[k]));
  }
  return aig_.make_and_of(all);
}

// One bit a state; which edge of several is taken is an input.
void RoundMonitor::run_automaton(const Automaton& automaton) {
  const std::size_t width = automaton.edges.size();
  for (std::size_t state = 0; state <= width; ++state) {
    automaton_bits_.push_back(add_bit(state == 0 ? 1 : 0));
    machine_.bits.back().is_place = true;
    machine_.bits.back().is_alone = true;
  }
  machine_.exactly_one.push_back(automaton_bits_);
  BIP_ASSERT(automaton_bits_.size() == width + 1, "{} bits of {} states", automaton_bits_.size(), width);
  std::vector<Signal> marks(32, kFalse);
  std::vector<std::vector<Signal>> arrives(width);
  for (std::size_t state = 0; state < width; ++state) {
    const std::vector<AutomatonEdge>& edges = automaton.edges[state];
    Signal rest = aig_.make_and(now(automaton_bits_[state]), negated(guess_fails_));
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const AutomatonEdge& edge = edges[k];
      const bool is_only =
          std::all_of(edges.begin() + static_cast<std::ptrdiff_t>(k) + 1, edges.end(), [&](const AutomatonEdge& later) {
            return (later.required & edge.forbidden) != 0 || (later.forbidden & edge.required) != 0;
          });
      const Signal wanted = is_only ? kTrue : aig_.make_input();
      const Signal is_taken = aig_.make_and(rest, aig_.make_and(matches(edge.required, edge.forbidden), wanted));
      rest = aig_.make_and(rest, negated(is_taken));
      arrives[edge.to].push_back(is_taken);
      if (automaton.may_accept[state] == 0 || automaton.may_accept[edge.to] == 0) continue;
      inside_ = aig_.make_or(inside_, is_taken);
      for (std::size_t mark = 0; mark < marks.size(); ++mark) {
        if ((edge.marks >> mark & 1) != 0) marks[mark] = aig_.make_or(marks[mark], is_taken);
      }
    }
  }
  for (std::size_t mark = 0; mark < marks.size(); ++mark) {
    if ((automaton.marks >> mark & 1) != 0) marks_.push_back(marks[mark]);
  }
  std::vector<Signal> none;
  for (std::size_t state = 0; state < width; ++state) {
    machine_.bits[automaton_bits_[state]].next = aig_.make_or_of(arrives[state]);
    none.push_back(negated(machine_.bits[automaton_bits_[state]].next));
  }
  machine_.bits[automaton_bits_[width]].next = aig_.make_and_of(none);
}

// What is promised of a point is any value, kept by a constraint on the step that leaves it. Numbers of bits are those
// of certificates: operators in the order in which the formula's text ends them, each once.
void RoundMonitor::run_tester(const Formula& formula) {
  constexpr std::size_t kDone = 1;
  std::vector<std::uint32_t> operators, bits(formula.nodes.size(), kNoRow);
  std::vector<std::uint8_t> is_done(formula.nodes.size(), 0);
  for (std::vector<std::pair<std::uint32_t, std::size_t>> path{{formula.root, 0}}; !path.empty();) {
    const auto [row, state] = path.back();
    const FormulaNode& node = formula.nodes[row];
    const bool is_leaf =
        node.kind == FormulaKind::Constant || node.kind == FormulaKind::State || node.kind == FormulaKind::Step;
    if (is_leaf || is_done[row] != 0 || state > kDone) {
      path.pop_back();
      if (is_leaf || is_done[row] != 0) continue;
      is_done[row] = 1;
      if (looks_ahead(node.kind) || looks_back(node.kind)) operators.push_back(row);
      continue;
    }
    ++path.back().second;
    path.emplace_back(state == 0 ? node.a : node.b, 0);
  }
  const FormulaNode& root = formula.nodes[formula.root];
  const bool is_promise = root.kind == FormulaKind::Until || root.kind == FormulaKind::Release;
  for (std::size_t k = 0; k < operators.size(); ++k) {
    const std::uint32_t row = operators[k];
    // The formula is false at first.
    const bool is_known = looks_back(formula.nodes[row].kind) || (is_promise && row == formula.root);
    bits[row] = add_bit(is_known ? 0 : -1, "%bit" + std::to_string(k));
  }
  std::vector<Signal> value(formula.nodes.size(), kFalse), later(formula.nodes.size(), kFalse);
  for (const std::uint32_t row : operators) {
    if (looks_ahead(formula.nodes[row].kind)) later[row] = machine_.bits[bits[row]].next = aig_.make_input();
  }
  for (std::size_t row = 0; row < formula.nodes.size(); ++row) {
    const FormulaNode& node = formula.nodes[row];
    const Signal a = value[node.a], b = value[node.b];
    const auto before = [&] { return bits[row] == kNoRow ? kFalse : now(bits[row]); };
    switch (node.kind) {
      case FormulaKind::Constant: value[row] = node.value ? kTrue : kFalse; break;
      case FormulaKind::State: value[row] = conditions_[node.row]; break;
      case FormulaKind::Step: value[row] = conditions_[states_ + node.row]; break;
      case FormulaKind::Not: value[row] = negated(a); break;
      case FormulaKind::And: value[row] = aig_.make_and(a, b); break;
      case FormulaKind::Or: value[row] = aig_.make_or(a, b); break;
      case FormulaKind::Next: value[row] = later[row]; break;
      case FormulaKind::Until: value[row] = aig_.make_or(b, aig_.make_and(a, later[row])); break;
      case FormulaKind::Release: value[row] = aig_.make_and(b, aig_.make_or(a, later[row])); break;
      case FormulaKind::Previously: value[row] = before(); break;
      case FormulaKind::Since: value[row] = aig_.make_or(b, aig_.make_and(a, before())); break;
    }
  }
  std::vector<Signal> kept{constraint_, negated(guess_fails_)};
  const auto keep = [&](std::uint32_t bit, Signal promised) {
    kept.push_back(negated(aig_.make_xor(now(bit), promised)));
  };
  for (const std::uint32_t row : operators) {
    const FormulaNode& node = formula.nodes[row];
    const bool is_of_operand = node.kind == FormulaKind::Next || node.kind == FormulaKind::Previously;
    const Signal is = value[is_of_operand ? node.a : row];
    if (looks_back(node.kind)) machine_.bits[bits[row]].next = is;
    else keep(bits[row], is);
    if (node.kind == FormulaKind::Until) marks_.push_back(negated(aig_.make_and(is, negated(value[node.b]))));
    if (node.kind == FormulaKind::Release) marks_.push_back(negated(aig_.make_and(negated(is), value[node.b])));
  }
  if (!is_promise) {
    const std::uint32_t bit = add_bit(0, "%bit" + std::to_string(operators.size()));
    machine_.bits[bit].next = aig_.make_input();
    keep(bit, value[formula.root]);
  }
  constraint_ = aig_.make_and_of(kept);
  inside_ = kTrue;
}

// As find_bad_prefix has it: such a state of the automaton is entered, or will be by the state alone, whatever the
// step.
void RoundMonitor::find_violated(const Automaton& automaton) {
  const std::uint64_t of_states = first_conditions(states_);
  std::vector<Signal> fine;
  for (const SystemStep& step : machine_.steps) {
    if (step.interaction.is_valid()) fine.push_back(step.fine);
  }
  const Signal has_steps = aig_.make_or_of(fine);
  for (std::uint32_t state = 0; state < automaton.edges.size(); ++state) {
    if (automaton.accepts_whatever_follows(state)) violated_ = aig_.make_or(violated_, now(automaton_bits_[state]));
    for (const AutomatonEdge& edge : automaton.edges[state]) {
      if ((edge.required & ~of_states) != 0 || !automaton.accepts_whatever_follows(edge.to)) continue;
      Signal is_there =
          aig_.make_and(now(automaton_bits_[state]), matches(edge.required & of_states, edge.forbidden & of_states));
      if ((edge.forbidden & ~of_states) != 0) is_there = aig_.make_and(is_there, negated(has_steps));
      violated_ = aig_.make_or(violated_, is_there);
    }
  }
}

// A bit for each mark and unit that says whether it was seen in this round.
void RoundMonitor::add_rounds() {
  const Signal counts = aig_.make_and(aig_.make_and(inside_, happened_), started_);
  BIP_ASSERT(!is_strong_ || never_.size() == expected_.size(), "{} guesses of {} units", never_.size(),
             expected_.size());
  demands_ = marks_;
  for (std::size_t k = 0; k < expected_.size(); ++k) {
    const Unit& unit = units_[expected_[k]];
    BIP_ASSERT(!unit.atoms.empty() && std::is_sorted(unit.atoms.begin(), unit.atoms.end()),
               "unit {} depends on {} atoms", expected_[k], unit.atoms.size());
    const Signal excused = unit.is_strong ? never_[k] : negated(unit.possible);
    demands_.push_back(aig_.make_or(unit.taken, excused));
  }
  const std::vector<Signal> all = demands_;
  std::erase(demands_, kTrue);
  std::vector<std::uint32_t> bits;
  std::vector<Signal> seen;
  const bool is_alone = demands_.size() == 1;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Signal signal = all[k];
    if (signal == kTrue) continue;
    if (is_alone) lone_demand_ = k;
    else bits.push_back(add_bit_of_round("%seen" + std::to_string(k)));
    seen.push_back(is_alone ? signal : aig_.make_or(now(bits.back()), signal));
  }
  round_ = aig_.make_and(counts, aig_.make_and_of(seen));
  const Signal goes_on = aig_.make_and(counts, negated(round_));
  for (std::size_t k = 0; k < bits.size(); ++k) machine_.bits[bits[k]].next = aig_.make_and(goes_on, seen[k]);
}

Signal RoundMonitor::more_rounds_than(std::uint32_t rounds) {
  while (counter_.size() <= rounds) {
    const Signal before = counter_.empty() ? kTrue : now(counter_.back());
    const std::uint32_t bit = add_bit_of_round("%over" + std::to_string(counter_.size()));
    machine_.bits[bit].next = aig_.make_or(now(bit), aig_.make_and(before, round_));
    counter_.push_back(bit);
  }
  return now(counter_[rounds]);
}

}  // namespace bip::verify
