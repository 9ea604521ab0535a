// Linear equations over the machine (affine_invariants.hpp): what they are at first; the bounds that they make likely,
// kept only as long as each holds after every step from where all hold (C. Flanagan, R. Leino: Houdini, an Annotation
// Assistant for ESC/Java, 2001); text.
#include <algorithm>
#include <bit>
#include <map>
#include <optional>
#include <set>

#include "compiler/verify/symbolic/cnf.hpp"
#include "compiler/verify/invariants/affine_invariants.hpp"
#include "compiler/verify/invariants/sparse_system.hpp"

namespace bip::verify {

namespace {

// By row of bits: those of an atom stand together.
std::vector<u32> first_bits(const TransitionSystem& machine) {
  std::vector<u32> first(machine.marks.size() + 1, static_cast<u32>(machine.bits.size()));
  for (u32 row = static_cast<u32>(machine.bits.size()); row-- > 0;) first[machine.bits[row].atom] = row;
  for (std::size_t atom = machine.marks.size(); atom-- > 0;) first[atom] = std::min(first[atom], first[atom + 1]);
  return first;
}

class OnMachine {
 public:
  OnMachine(TransitionSystem& machine, const rt::Image& image)
      : m_(machine), image_(image), first_(first_bits(machine)) {}

  // False: not known.
  bool set_total(AffineEquation& equation) const {
    std::uint32_t total = 0;
    for (const AffineEquation::Term& term : equation.terms) {
      std::uint32_t value = 0;
      const bool is_constant = rows_of(term).empty();
      if (is_constant && !constant(term, value)) return false;
      for (u32 row : rows_of(term)) {
        const StateBit& bit_row = m_.bits[row];
        if (bit_row.initial < 0) return false;
        if (bit_row.initial == 0) continue;
        // The last bit of a number that can be negative is its sign.
        const bool is_sign = !term.is_place && row == rows_of(term).back() && now(term).size() == rows_of(term).size();
        value += is_sign ? 0u - (1u << bit_row.position) : 1u << bit_row.position;
      }
      total += static_cast<std::uint32_t>(term.weight) * value;
    }
    equation.total = static_cast<std::int32_t>(total);
    return true;
  }

  // The bits of these variables are 0 from where the bounds end.
  void fix(const std::vector<VariableBound>& bounds) {
    fixed_.assign(m_.circuit.size(), kFree);
    for (const SystemStep& step : m_.steps) fixed_[node_of(step.chosen)] = kFalse;
    for (const VariableBound& bound : bounds) {
      const Word word = now({bound.atom, bound.variable, false, 1});
      for (u32 k = bits_of(bound); k < word.size(); ++k) fix_one(word[k]);
      fix_one(word.back());
    }
  }

  [[nodiscard]] static bool moves_one_of(const Net& net, const SystemStep& step, const std::set<u32>& atoms) {
    return std::any_of(step.parts.begin(), step.parts.end(),
                       [&](const auto& part) { return atoms.contains(net.atom_of_port[part.first]); });
  }

  // A step: whether it is possible, and the bits of its atoms after it.
  struct Taken {
    Signal fine = kFalse;
    std::set<u32> atoms;
    std::map<u32, Signal> next;  // by row of bits
  };
  Taken take(const Net& net, const SystemStep& step, const std::set<u32>& wanted) {
    Taken taken;
    std::vector<u32> rows;
    std::vector<Signal> roots{step.fine};
    for (const auto& [port, when] : step.parts) {
      const u32 atom = net.atom_of_port[port];
      if (!wanted.contains(atom) || !taken.atoms.insert(atom).second) continue;
      for (u32 row = first_[atom]; row < first_[atom + 1]; ++row) {
        rows.push_back(row);
        roots.push_back(m_.bits[row].next);
      }
    }
    fixed_[node_of(step.chosen)] = kTrue;
    const std::vector<Signal> made = with_fixed(m_.circuit, roots, fixed_);
    fixed_[node_of(step.chosen)] = kFalse;
    taken.fine = made[0];
    for (std::size_t k = 0; k < rows.size(); ++k) taken.next.emplace(rows[k], made[k + 1]);
    return taken;
  }

  // Now, or after the step.
  Signal holds(const AffineEquation& equation, const Taken* taken) {
    Sides sides;
    for (const AffineEquation::Term& term : equation.terms)
      add_term(term.weight, taken != nullptr ? next(term, *taken) : now(term), sides);
    sides.less.push_back(word_of(equation.total));
    return equal(m_.circuit, total(sides.more), total(sides.less));
  }
  Signal holds(const VariableBound& bound, const Taken* taken) {
    const AffineEquation::Term variable{bound.atom, bound.variable, false, 1};
    const Word word = taken != nullptr ? next(variable, *taken) : now(variable);
    Signal result = negated(word.back());
    for (u32 k = bits_of(bound); k < word.size(); ++k) result = m_.circuit.make_and(result, negated(word[k]));
    return result;
  }

  // An int is likely to be at most what the places of an equation weigh, with the ints on the other side at their most;
  // two bits more than that has, so that the sum's own bits show it and nothing has to be counted. Where nothing says
  // how large the other side is ("a = b"), nothing is likely.
  [[nodiscard]] std::vector<VariableBound> likely_bounds(const std::vector<AffineEquation>& equations) const {
    std::map<std::pair<u32, u32>, std::int64_t> most;
    for (bool is_new = true; is_new;) {
      // Of the equations of a round the one that allows most counts.
      std::map<std::pair<u32, u32>, std::int64_t> found;
      for (const AffineEquation& one : equations) add_most(one, most, found);
      is_new = !found.empty();
      most.merge(found);
    }
    std::vector<VariableBound> result;
    for (const auto& [variable, number] : most) {
      const auto high = static_cast<std::int32_t>(4 * std::bit_ceil(static_cast<std::uint32_t>(number) + 1) - 1);
      const Range& range = range_of(variable);
      if (range.low < 0 || range.high > high) result.push_back({variable.first, variable.second, high});
    }
    return result;
  }
  [[nodiscard]] bool holds_at_first(const VariableBound& bound) const {
    AffineEquation value{{{bound.atom, bound.variable, false, 1}}, 0};
    return set_total(value) && value.total >= 0 && value.total <= bound.high;
  }

  [[nodiscard]] Word now(const AffineEquation::Term& term) const {
    if (term.is_place) return word_of_bool(m_.marks[term.atom][term.row]);
    return m_.words[image_.atoms[term.atom].first_cell + term.row];
  }

 private:
  [[nodiscard]] const Range& range_of(const std::pair<u32, u32>& variable) const {
    return m_.ranges[image_.atoms[variable.first].first_cell + variable.second];
  }
  // For ints that nothing is known of yet.
  void add_most(const AffineEquation& equation, const std::map<std::pair<u32, u32>, std::int64_t>& known,
                std::map<std::pair<u32, u32>, std::int64_t>& found) const {
    // Of all places and the constant; of the ints with positive and with negative weight. Of a side with an int that
    // may be anything: too much.
    std::int64_t most = std::abs(std::int64_t{equation.total}), sides[2] = {0, 0};
    for (const AffineEquation::Term& term : equation.terms) {
      const std::int64_t weight = std::abs(std::int64_t{term.weight});
      if (term.is_place) {
        most += weight;
        continue;
      }
      const auto at = known.find({term.atom, term.row});
      const Range& range = range_of({term.atom, term.row});
      const std::int64_t high = at != known.end() ? at->second
                                : range.low >= 0 && range.high <= SparseSystem::kMaxNumber
                                    ? range.high
                                    : SparseSystem::kMaxNumber + 1;
      std::int64_t& side = sides[term.weight > 0 ? 0 : 1];
      side = std::min(side + weight * high, SparseSystem::kMaxNumber + 1);
    }
    for (const AffineEquation::Term& term : equation.terms) {
      const std::pair variable(term.atom, term.row);
      const std::int64_t number = most + sides[term.weight > 0 ? 1 : 0];
      if (term.is_place || number > SparseSystem::kMaxNumber || known.contains(variable)) continue;
      std::int64_t& here = found[variable];
      here = std::max(here, number);
    }
  }
  [[nodiscard]] static u32 bits_of(const VariableBound& bound) {
    return static_cast<u32>(std::bit_width(static_cast<std::uint32_t>(bound.high)));
  }
  // Terms that are added, and those that are taken away: so nothing is ever negated, which would cost the solver much.
  struct Sides {
    std::vector<Word> more, less;
  };
  void add_term(std::int32_t weight, const Word& value, Sides& sides) {
    (weight > 0 ? sides.more : sides.less).push_back(multiply(m_.circuit, value, word_of(std::abs(weight))));
  }
  // By twos, so that the numbers stay short.
  [[nodiscard]] Word total(std::vector<Word> words) {
    if (words.empty()) return word_of(0);
    for (; words.size() > 1; words.resize((words.size() + 1) / 2)) {
      for (std::size_t k = 0; 2 * k < words.size(); ++k)
        words[k] = 2 * k + 1 < words.size() ? add(m_.circuit, words[2 * k], words[2 * k + 1]) : words[2 * k];
    }
    return words[0];
  }
  // With what is fixed.
  [[nodiscard]] Word small(const AffineEquation::Term& term) {
    return trimmed(with_fixed(m_.circuit, now(term), fixed_));
  }
  [[nodiscard]] Word next(const AffineEquation::Term& term, const Taken& taken) {
    if (!taken.atoms.contains(term.atom)) return small(term);
    Word word = now(term);
    const std::vector<u32> rows = rows_of(term);
    for (std::size_t k = 0; k < rows.size(); ++k) word[k] = taken.next.at(rows[k]);
    return trimmed(std::move(word));
  }
  void fix_one(Signal bit_signal) {
    if (node_of(bit_signal) != 0) fixed_[node_of(bit_signal)] = kFalse;
  }
  [[nodiscard]] std::vector<u32> rows_of(const AffineEquation::Term& term) const {
    std::vector<u32> rows;
    for (u32 row = first_[term.atom]; row < first_[term.atom + 1]; ++row) {
      if (m_.bits[row].is_place == term.is_place && m_.bits[row].row == term.row) rows.push_back(row);
    }
    return rows;
  }
  [[nodiscard]] bool constant(const AffineEquation::Term& term, std::uint32_t& value) const {
    const Word word = now(term);
    if (word.empty()) return false;
    for (u32 k = 0; k < 32; ++k) {
      if (bit(word, k) > kTrue) return false;
      if (bit(word, k) == kTrue) value |= 1u << k;
    }
    return true;
  }

  TransitionSystem& m_;
  const rt::Image& image_;
  std::vector<u32> first_;
  std::vector<Signal> fixed_;  // by node
};

}  // namespace

namespace {

// A state, for the solver.
class InductionQuery {
 public:
  InductionQuery(const TransitionSystem& machine, const std::vector<std::vector<Signal>>& known)
      : cnf_(machine.circuit, solver_) {
    cnf_.add_state(machine);
    for (const std::vector<Signal>& clause : known) cnf_.add(clause);
  }
  // Is `bad` never true with all of the others?
  bool excludes(const std::vector<Signal>& others, Signal bad, const CancellationToken& cancellation) {
    if (bad == kFalse) return true;
    for (Signal s : others) solver_.assume(cnf_.literal(s));
    solver_.assume(cnf_.literal(bad));
    return solver_.solve(cancellation.within(kSeconds)) == Answer::Unsatisfiable;
  }

 private:
  static constexpr double kSeconds = 2;
  Solver solver_{SolverStyle::Plain};
  Cnf cnf_;
};

}  // namespace

AffineInvariants with_totals(TransitionSystem& machine, const rt::Image& image, AffineInvariants facts) {
  const OnMachine on_machine(machine, image);
  std::erase_if(facts.equations, [&](AffineEquation& one) {
    const bool has_words = std::all_of(one.terms.begin(), one.terms.end(),
                                       [&](const AffineEquation::Term& term) { return !on_machine.now(term).empty(); });
    return !has_words || !on_machine.set_total(one);
  });
  return facts;
}

AffineInvariants with_bounds(const Net& net, TransitionSystem& machine, const rt::Image& image,
                             const std::vector<std::vector<Signal>>& known, const CancellationToken& cancellation,
                             AffineInvariants from) {
  AffineInvariants facts = with_totals(machine, image, std::move(from));
  OnMachine on_machine(machine, image);
  facts.bounds = on_machine.likely_bounds(facts.equations);
  std::erase_if(facts.bounds, [&](const VariableBound& bound) { return !on_machine.holds_at_first(bound); });
  std::set<u32> atoms, bounded;
  std::vector<Signal> now;
  std::map<u32, std::vector<u32>> equations_of;  // by atom: rows
  for (u32 row = 0; row < facts.equations.size() && !facts.bounds.empty(); ++row) {
    for (const AffineEquation::Term& term : facts.equations[row].terms) {
      atoms.insert(term.atom);
      equations_of[term.atom].push_back(row);
    }
    now.push_back(on_machine.holds(facts.equations[row], nullptr));
  }
  std::optional<InductionQuery> question;
  for (bool is_kept = false; !is_kept && !facts.bounds.empty();) {
    if (!question) {
      std::vector<std::vector<Signal>> all = known;
      for (const PlaceValue& one : facts.places) all.push_back(place_clause(one, machine, image));
      question.emplace(machine, all);
    }
    is_kept = true;
    on_machine.fix(facts.bounds);
    bounded.clear();
    for (const VariableBound& bound : facts.bounds) bounded.insert(bound.atom);
    std::vector<std::uint8_t> is_shown(facts.bounds.size(), 1);
    for (const SystemStep& step : machine.steps) {
      if (cancellation.is_over()) return {std::move(facts.equations), {}, std::move(facts.places)};
      if (!OnMachine::moves_one_of(net, step, bounded)) continue;
      const OnMachine::Taken taken = on_machine.take(net, step, atoms);
      if (taken.fine == kFalse) continue;
      std::vector<Signal> all = now;
      all.push_back(taken.fine);
      // Of the others nothing changes.
      std::set<u32> changed;
      for (u32 atom : taken.atoms) changed.insert(equations_of[atom].begin(), equations_of[atom].end());
      for (u32 row : changed) all.push_back(on_machine.holds(facts.equations[row], &taken));
      for (const VariableBound& bound : facts.bounds) all.push_back(on_machine.holds(bound, nullptr));
      for (std::size_t k = 0; k < facts.bounds.size(); ++k) {
        if (is_shown[k] == 0 || !taken.atoms.contains(facts.bounds[k].atom)) continue;
        is_shown[k] = question->excludes(all, negated(on_machine.holds(facts.bounds[k], &taken)), cancellation) ? 1 : 0;
      }
    }
    // What rested on a bound that is not kept is asked again.
    std::size_t next = 0;
    std::erase_if(facts.bounds, [&](const VariableBound&) { return is_shown[next++] == 0; });
    is_kept = facts.bounds.size() == next;
  }
  return facts;
}

Signal equation_signal(const AffineEquation& equation, TransitionSystem& machine, const rt::Image& image) {
  return OnMachine(machine, image).holds(equation, nullptr);
}
std::vector<Signal> place_clause(const PlaceValue& fact, TransitionSystem& machine, const rt::Image& image) {
  const Word& word = machine.words[image.atoms[fact.atom].first_cell + fact.variable];
  return {negated(machine.marks[fact.atom][fact.place]),
          word.empty() ? kTrue : equal(machine.circuit, word, word_of(fact.value))};
}
Signal bound_signal(const VariableBound& bound, TransitionSystem& machine, const rt::Image& image) {
  return OnMachine(machine, image).holds(bound, nullptr);
}

namespace {
std::string term_text(const AffineEquation::Term& term, const System& system) {
  const Atom& atom = system.atoms[AtomId(std::size_t{term.atom})];
  const AtomType& type = system.atom_types[atom.type];
  return atom.path + (term.is_place ? '@' + type.places[term.row] : '.' + type.variables[term.row].name);
}
}  // namespace

std::string equation_row(const AffineEquation& equation, const System& system) {
  std::string out = "equation " + std::to_string(equation.total);
  for (const AffineEquation::Term& term : equation.terms)
    out += ' ' + term_text(term, system) + '*' + std::to_string(term.weight);
  return out;
}

std::string equation_text(const AffineEquation& equation, const System& system) {
  constexpr std::size_t kShown = 12;
  std::string out = "always " + std::to_string(equation.total) + " =";
  for (std::size_t k = 0; k < equation.terms.size() && k < kShown; ++k) {
    const std::int32_t weight = equation.terms[k].weight;
    const std::string name = term_text(equation.terms[k], system);
    out += weight < 0 ? " - " : k == 0 ? " " : " + ";
    if (weight != 1 && weight != -1) out += std::to_string(std::abs(weight)) + ' ';
    out += name.starts_with("ROOT.") ? name.substr(5) : name;
  }
  if (equation.terms.size() > kShown) out += " … (" + std::to_string(equation.terms.size()) + " in all)";
  return out;
}

}  // namespace bip::verify
