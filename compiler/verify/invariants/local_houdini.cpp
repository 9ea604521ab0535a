// See local_houdini.hpp. Each question has a solver of its own, made anew: it has some dozens of variables.
#include "compiler/verify/invariants/local_houdini.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>

#include "compiler/base/log.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Of answers that are kept for questions that are alike.
constexpr std::size_t kMostBytes = std::size_t{64} << 20;

using AtomPair = std::pair<u32, u32>;  // ascending; twice the same: of one component

// What there is of each component and of each step.
struct LocalParts {
  explicit LocalParts(const LocalQuestions& of)
      : questions(of),
        system(*of.system),
        atoms_of_step(system.steps.size()),
        steps_of_atom(system.marks.size()),
        first_port(system.marks.size(), kNoRow),
        groups_of_atom(system.marks.size()),
        ranges_of_atom(system.marks.size()),
        exclusions_of_atom(system.marks.size()),
        is_choice(system.aig.size(), 0) {
    BIP_ASSERT(of.kind_of_step.size() == system.steps.size() && of.type_of_atom.size() == system.marks.size(),
               "kinds of {} steps, types of {} atoms", of.kind_of_step.size(), of.type_of_atom.size());
    for (u32 port = 0; port < of.atom_of_port.size(); ++port) {
      u32& first = first_port[of.atom_of_port[port]];
      first = std::min(first, port);
    }
    for (u32 row = 0; row < system.steps.size(); ++row) {
      std::vector<u32>& atoms = atoms_of_step[row];
      for (const auto& [port, when] : system.steps[row].parts) {
        const u32 atom = of.atom_of_port[port];
        if (std::find(atoms.begin(), atoms.end(), atom) == atoms.end()) atoms.push_back(atom);
      }
      for (const u32 atom : atoms) steps_of_atom[atom].push_back(row);
      is_choice[node_of(system.steps[row].chosen)] = 1;
    }
    for (u32 row = 0; row < of.exclusions.size(); ++row) {
      for (const Exclusion::Of& one : of.exclusions[row].signals) exclusions_of_atom[one.atom].emplace_back(row, &one);
    }
    for (u32 group = 0; group < system.exactly_one.size(); ++group)
      groups_of_atom[system.bits[system.exactly_one[group][0]].atom].push_back(group);
    add_ranges();
  }
  /// Calls see(of a, of b) for each two signals of these atoms that exclude each other.
  template <class See>
  void for_each_exclusion(u32 a, u32 b, const See& see) const {
    for (const auto& [row, of_a] : exclusions_of_atom[a]) {
      for (const auto& [other_row, of_b] : exclusions_of_atom[b]) {
        if (row == other_row) see(*of_a, *of_b);
      }
    }
  }
  [[nodiscard]] bool takes_part(u32 atom, u32 step) const {
    return std::find(atoms_of_step[step].begin(), atoms_of_step[step].end(), atom) != atoms_of_step[step].end();
  }

  const LocalQuestions& questions;
  const TransitionSystem& system;
  std::vector<std::vector<u32>> atoms_of_step;   // in the order of the step's ports
  std::vector<std::vector<u32>> steps_of_atom;   // in which it takes part
  std::vector<u32> first_port;                   // by atom
  std::vector<std::vector<u32>> groups_of_atom;  // rows of exactly_one
  std::vector<std::vector<Signal>> ranges_of_atom;
  std::vector<std::vector<std::pair<u32, const Exclusion::Of*>>> exclusions_of_atom;  // with the row of the exclusion
  std::vector<std::uint8_t> is_choice;                                                // by node: the input of a step

 private:
  // Those that are about several components are left out.
  void add_ranges() {
    std::unordered_map<u32, u32> atom_of_node;
    for (const StateBit& bit : system.bits) atom_of_node.emplace(node_of(bit.now), bit.atom);
    for (const Signal inside : system.in_range) {
      std::vector<u32> todo{node_of(inside)};
      u32 atom = kNoRow;
      bool is_local = true;
      while (!todo.empty() && is_local) {
        const u32 node = todo.back();
        todo.pop_back();
        if (system.aig.is_input(node)) {
          const auto at = atom_of_node.find(node);
          is_local = at != atom_of_node.end() && (atom == kNoRow || atom == at->second);
          if (is_local) atom = at->second;
        } else if (node != 0) {
          todo.push_back(node_of(system.aig.node(node).a));
          todo.push_back(node_of(system.aig.node(node).b));
        }
      }
      if (is_local && atom != kNoRow) ranges_of_atom[atom].push_back(inside);
    }
  }
};

// The circuit where one step is chosen, as far as it is asked for.
class StepCircuit {
 public:
  StepCircuit(const LocalParts& parts, u32 step, Solver& solver)
      : system_(parts.system), parts_(parts), chosen_(node_of(system_.steps[step].chosen)), solver_(solver) {
    true_ = solver_.new_variable();
    solver_.add({true_});
    literals_.emplace(0, -true_);
  }

  [[nodiscard]] Lit literal(Signal signal) {
    std::vector<u32> todo{node_of(signal)};
    while (!todo.empty()) {
      const u32 node = todo.back();
      if (literals_.contains(node)) {
        todo.pop_back();
        continue;
      }
      if (system_.aig.is_input(node)) {
        literals_.emplace(node, parts_.is_choice[node] == 0 ? solver_.new_variable()
                                : node == chosen_           ? true_
                                                            : -true_);
        continue;
      }
      const auto [a, b] = system_.aig.node(node);
      // The operand that may be constant first: what it decides is not encoded.
      const Lit a_literal = encoded(a), b_literal = encoded(b);
      if (a_literal == -true_ || b_literal == -true_) {
        literals_.emplace(node, -true_);
      } else if (a_literal == 0 || b_literal == 0) {
        const bool is_b_first = b_literal == 0 && (a_literal != 0 || parts_.is_choice[node_of(b)] != 0);
        todo.push_back(node_of(is_b_first ? b : a));
      } else if (a_literal == true_ || b_literal == true_) {
        literals_.emplace(node, a_literal == true_ ? b_literal : a_literal);
      } else {
        const Lit out = solver_.new_variable();
        literals_.emplace(node, out);
        solver_.add({-out, a_literal});
        solver_.add({-out, b_literal});
        solver_.add({out, -a_literal, -b_literal});
      }
    }
    return encoded(signal);
  }

 private:
  [[nodiscard]] Lit encoded(Signal signal) const {
    const auto at = literals_.find(node_of(signal));
    if (at == literals_.end()) return 0;
    return (signal & 1) != 0 ? -at->second : at->second;
  }

  const TransitionSystem& system_;
  const LocalParts& parts_;
  u32 chosen_;
  Solver& solver_;
  Lit true_ = 0;
  std::unordered_map<u32, Lit> literals_;  // by node
};

// The candidates, and which of them remain.
struct LocalCandidates {
  LocalCandidates(const TransitionSystem& of, std::vector<Cube> given)
      : system(of), cubes(std::move(given)), holds(cubes.size(), 1) {
    for (u32 row = 0; row < cubes.size(); ++row) rows[atoms_of(row)].push_back(row);
  }
  [[nodiscard]] AtomPair atoms_of(u32 row) const {
    const u32 a = system.bits[cube_bit(cubes[row].front())].atom, b = system.bits[cube_bit(cubes[row].back())].atom;
    return std::minmax(a, b);
  }
  /// Rows of those about these two; twice the same: about it alone.
  [[nodiscard]] std::span<const u32> about(u32 a, u32 b) const {
    const auto at = rows.find(std::minmax(a, b));
    return at == rows.end() ? std::span<const u32>() : at->second;
  }

  const TransitionSystem& system;
  std::vector<Cube> cubes;
  std::vector<std::uint8_t> holds;  // by row
  std::map<AtomPair, std::vector<u32>> rows;
};

// A candidate by the places of its components in a question, whatever their names are.
using CubeShape = std::array<std::uint64_t, 2>;
struct ShapedRow {
  CubeShape shape{};
  u32 row = 0;
  friend auto operator<=>(const ShapedRow&, const ShapedRow&) = default;
};

// Does a step break candidates about those that take part, or about one of them and another one?
struct StepQuestion {
  u32 step = 0;
  std::vector<u32> atoms{};          // those that take part, and the other one
  std::vector<ShapedRow> assumed{};  // candidates that hold before the step, sorted
  std::vector<ShapedRow> asked{};    // those of them that may not hold after it, sorted
  std::string key{};                 // equal: the same question but for names
};

class StepQuestions {
 public:
  StepQuestions(const LocalParts& parts, const LocalCandidates& candidates) : parts_(parts), candidates_(candidates) {}

  [[nodiscard]] StepQuestion about(u32 step) const {
    StepQuestion made{.step = step, .atoms = parts_.atoms_of_step[step]};
    add_all(made, made.atoms.size(), made.assumed);
    made.asked = made.assumed;
    finish(made);
    return made;
  }
  /// `other` does not take part.
  [[nodiscard]] StepQuestion about(u32 step, u32 other) const {
    StepQuestion made{.step = step, .atoms = parts_.atoms_of_step[step]};
    const std::size_t taking_part = made.atoms.size();
    made.atoms.push_back(other);
    add_all(made, taking_part, made.assumed);
    for (std::size_t role = 0; role < taking_part; ++role) add(made, role, taking_part, made.asked);
    made.assumed.insert(made.assumed.end(), made.asked.begin(), made.asked.end());
    add(made, taking_part, taking_part, made.assumed);
    finish(made);
    return made;
  }

 private:
  // Of the first `count` components.
  void add_all(const StepQuestion& made, std::size_t count, std::vector<ShapedRow>& rows) const {
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j <= i; ++j) add(made, j, i, rows);
    }
  }
  void add(const StepQuestion& made, std::size_t a, std::size_t b, std::vector<ShapedRow>& rows) const {
    for (const u32 row : candidates_.about(made.atoms[a], made.atoms[b])) {
      if (candidates_.holds[row] == 0) continue;
      const Cube& cube = candidates_.cubes[row];
      ShapedRow shaped{.row = row};
      for (std::size_t k = 0; k < cube.size(); ++k) {
        const StateBit& bit = parts_.system.bits[cube_bit(cube[k])];
        const std::size_t role = bit.atom == made.atoms[a] ? a : b;
        shaped.shape[k] = (std::uint64_t{role} + 1) << 40 | std::uint64_t{bit.row} << 8 | (bit.is_place ? 128u : 0u) |
                          bit.position << 1 | (cube_value(cube[k]) ? 1u : 0u);
      }
      std::sort(shaped.shape.begin(), shaped.shape.end());
      rows.push_back(shaped);
    }
  }
  void finish(StepQuestion& made) const {
    std::sort(made.assumed.begin(), made.assumed.end());
    std::sort(made.asked.begin(), made.asked.end());
    const auto put = [&](std::uint64_t value) { made.key.append(reinterpret_cast<const char*>(&value), sizeof value); };
    put(parts_.questions.kind_of_step[made.step]);
    for (const u32 atom : made.atoms) put(parts_.questions.type_of_atom[atom]);
    for (const auto& [port, when] : parts_.system.steps[made.step].parts) {
      const u32 atom = parts_.questions.atom_of_port[port];
      put(port - parts_.first_port[atom]);
    }
    for (std::size_t i = 0; i < made.atoms.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        parts_.for_each_exclusion(made.atoms[j], made.atoms[i], [&](const Exclusion::Of& a, const Exclusion::Of& b) {
          put(std::uint64_t{i} << 32 | j);
          put(std::uint64_t{a.mark} << 32 | b.mark);
        });
      }
    }
    put(~std::uint64_t{0});
    for (const ShapedRow& row : made.assumed) {
      put(row.shape[0]);
      put(row.shape[1]);
    }
  }

  const LocalParts& parts_;
  const LocalCandidates& candidates_;
};

// Asks the solver: which of the candidates does the step break?
class StepSolver {
 public:
  StepSolver(const LocalParts& parts, const LocalCandidates& candidates, const StepQuestion& question)
      : system_(parts.system),
        candidates_(candidates),
        question_(question),
        solver_(SolverStyle::Plain),
        circuit_(parts, question.step, solver_) {
    solver_.add({circuit_.literal(system_.steps[question.step].fine)});
    for (std::size_t i = 0; i < question.atoms.size(); ++i) {
      add_state(parts, question.atoms[i]);
      for (std::size_t j = 0; j < i; ++j) {
        parts.for_each_exclusion(question.atoms[j], question.atoms[i],
                                 [&](const Exclusion::Of& a, const Exclusion::Of& b) {
                                   solver_.add({-circuit_.literal(a.signal), -circuit_.literal(b.signal)});
                                 });
      }
    }
    for (const ShapedRow& assumed : question.assumed) {
      std::vector<Lit> clause;
      for (const u32 literal : candidates_.cubes[assumed.row]) clause.push_back(-now(literal));
      solver_.add(clause);
    }
  }

  /// Rows of question.asked. Nothing: the time is over.
  std::optional<std::vector<u32>> broken(const CancellationToken& cancellation) {
    // That some cube is entered, each with a literal that implies it.
    const Lit some_is_entered = solver_.new_variable();
    std::vector<Lit> some{-some_is_entered};
    std::vector<std::pair<u32, Lit>> open;
    for (u32 k = 0; k < question_.asked.size(); ++k) {
      const Cube& cube = candidates_.cubes[question_.asked[k].row];
      if (std::none_of(cube.begin(), cube.end(), [&](u32 literal) { return next(literal) != now(literal); })) continue;
      open.emplace_back(k, solver_.new_variable());
      for (const u32 literal : cube) solver_.add({-open.back().second, next(literal)});
      some.push_back(open.back().second);
    }
    std::vector<u32> result;
    if (open.empty()) return result;
    solver_.add(some);
    for (;;) {
      solver_.assume(some_is_entered);
      const Answer answer = solver_.solve(cancellation);
      if (answer == Answer::Unknown) return std::nullopt;
      if (answer == Answer::Unsatisfiable) break;
      // The model is gone once a clause is added.
      const auto entered = std::stable_partition(open.begin(), open.end(), [&](const auto& candidate) {
        const Cube& cube = candidates_.cubes[question_.asked[candidate.first].row];
        return !std::all_of(cube.begin(), cube.end(), [&](u32 literal) { return solver_.is_true(next(literal)); });
      });
      BIP_ENSURE(entered != open.end(), "a step into none of {} cubes", open.size());
      for (auto at = entered; at != open.end(); ++at) {
        result.push_back(at->first);
        solver_.add({-at->second});
      }
      open.erase(entered, open.end());
    }
    return result;
  }

 private:
  void add_state(const LocalParts& parts, u32 atom) {
    for (const Signal inside : parts.ranges_of_atom[atom]) solver_.add({circuit_.literal(inside)});
    for (const u32 group : parts.groups_of_atom[atom]) {
      std::vector<Lit> places;
      for (const u32 bit : system_.exactly_one[group]) places.push_back(circuit_.literal(system_.bits[bit].now));
      solver_.add(places);
      add_at_most_one(solver_, places);
    }
  }
  [[nodiscard]] Lit now(u32 literal) {
    const Lit positive = circuit_.literal(system_.bits[cube_bit(literal)].now);
    return cube_value(literal) ? positive : -positive;
  }
  [[nodiscard]] Lit next(u32 literal) {
    const Lit positive = circuit_.literal(system_.bits[cube_bit(literal)].next);
    return cube_value(literal) ? positive : -positive;
  }

  const TransitionSystem& system_;
  const LocalCandidates& candidates_;
  const StepQuestion& question_;
  Solver solver_;
  StepCircuit circuit_;
};

// Asks each question again whose assumptions have become fewer, until no candidate is refuted.
class LocalHoudini {
 public:
  LocalHoudini(const LocalParts& parts, LocalCandidates& candidates, const CancellationToken& cancellation)
      : parts_(parts),
        candidates_(candidates),
        questions_(parts, candidates),
        partners_(parts.steps_of_atom.size()),
        open_(parts.atoms_of_step.size()),
        cancellation_(cancellation) {
    for (const auto& [pair, rows] : candidates.rows) {
      if (pair.first == pair.second) continue;
      partners_[pair.first].push_back(pair.second);
      partners_[pair.second].push_back(pair.first);
    }
  }

  /// False: the time is over.
  bool run() {
    for (Open& open : open_) open.is_whole = true;
    do {
      std::vector<Open> now(open_.size());
      now.swap(open_);
      refuted_.clear();
      for (u32 step = 0; step < now.size(); ++step) {
        if (cancellation_.is_over() || !ask(step, std::move(now[step]))) return false;
      }
      for (const u32 row : refuted_) ask_again_about(row);
    } while (!refuted_.empty());
    BIP_LOG(Houdini, 1, "{} kinds of local questions", answers_.size());
    return true;
  }

 private:
  // What is asked about a step: all, or candidates about one that takes part and one of these others.
  struct Open {
    bool is_whole = false;
    std::vector<u32> others;
  };

  bool ask(u32 step, Open open) {
    if (open.is_whole) {
      if (!ask(questions_.about(step))) return false;
      open.others.clear();
      for (const u32 atom : parts_.atoms_of_step[step]) {
        for (const u32 other : partners_[atom]) {
          if (!parts_.takes_part(other, step)) open.others.push_back(other);
        }
      }
    }
    std::sort(open.others.begin(), open.others.end());
    open.others.erase(std::unique(open.others.begin(), open.others.end()), open.others.end());
    return std::all_of(open.others.begin(), open.others.end(),
                       [&](u32 other) { return ask(questions_.about(step, other)); });
  }
  bool ask(StepQuestion question) {
    if (question.asked.empty()) return true;
    if (const auto known = answers_.find(question.key); known != answers_.end()) {
      refute(question, known->second);
      return true;
    }
    std::optional<std::vector<u32>> broken = StepSolver(parts_, candidates_, question).broken(cancellation_);
    if (!broken) return false;
    refute(question, *broken);
    bytes_ += question.key.size() + broken->size() * sizeof(u32);
    if (bytes_ < kMostBytes) answers_.emplace(std::move(question.key), std::move(*broken));
    return true;
  }
  void refute(const StepQuestion& question, const std::vector<u32>& broken) {
    for (const u32 k : broken) {
      candidates_.holds[question.asked[k].row] = 0;
      refuted_.push_back(question.asked[k].row);
    }
  }

  // Each question that assumed the refuted candidate.
  void ask_again_about(u32 row) {
    const auto [x, y] = candidates_.atoms_of(row);
    if (x != y) {
      ask_again(x, y);
      return ask_again(y, x);
    }
    for (const u32 step : parts_.steps_of_atom[x]) open_[step].is_whole = true;
    for (const u32 partner : partners_[x]) ask_again(partner, x);
  }
  void ask_again(u32 atom, u32 other) {
    for (const u32 step : parts_.steps_of_atom[atom]) {
      if (parts_.takes_part(other, step)) open_[step].is_whole = true;
      else open_[step].others.push_back(other);
    }
  }

  const LocalParts& parts_;
  LocalCandidates& candidates_;
  const StepQuestions questions_;
  std::vector<std::vector<u32>> partners_;                     // by atom: others with which it shares a candidate
  std::vector<Open> open_;                                     // by step, in the next round
  std::vector<u32> refuted_;                                   // rows of candidates, in this round
  std::unordered_map<std::string, std::vector<u32>> answers_;  // by key: rows of `asked`
  std::size_t bytes_ = 0;                                      // of all questions that the solver was asked
  const CancellationToken& cancellation_;
};

}  // namespace

std::vector<Cube> keep_locally_inductive(const LocalQuestions& questions, std::vector<Cube> candidates,
                                         const CancellationToken& cancellation) {
  std::erase_if(candidates, [&](const Cube& cube) { return meets_initial(cube, *questions.system); });
  const LocalParts parts(questions);
  LocalCandidates filtered(*questions.system, std::move(candidates));
  if (!LocalHoudini(parts, filtered, cancellation).run()) return {};
  std::vector<Cube> kept;
  for (std::size_t row = 0; row < filtered.cubes.size(); ++row) {
    if (filtered.holds[row] != 0) kept.push_back(std::move(filtered.cubes[row]));
  }
  BIP_LOG(Houdini, 1, "{} of {} candidates are inductive by parts", kept.size(), filtered.cubes.size());
  return kept;
}

}  // namespace bip::verify
