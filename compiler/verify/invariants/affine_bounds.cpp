// See affine_bounds.hpp.
#include "compiler/verify/invariants/affine_bounds.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <optional>
#include <set>

#include "compiler/base/log.hpp"
#include "compiler/verify/symbolic/cnf.hpp"
#include "compiler/verify/invariants/sparse_system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Returns by atom its first state bit; the bits of an atom stand together.
std::vector<u32> first_bits(const TransitionSystem& transition_system) {
  std::vector<u32> first(transition_system.marks.size() + 1, static_cast<u32>(transition_system.bits.size()));
  for (u32 row = static_cast<u32>(transition_system.bits.size()); row-- > 0;)
    first[transition_system.bits[row].atom] = row;
  for (std::size_t atom = transition_system.marks.size(); atom-- > 0;)
    first[atom] = std::min(first[atom], first[atom + 1]);
  return first;
}

/// Equations and bounds as signals of the AIG, in a state and after a step.
class AffineEncoder {
 public:
  AffineEncoder(TransitionSystem& transition_system, const rt::Image& image)
      : transition_system_(transition_system), image_(image), first_(first_bits(transition_system)) {}

  // Computes the total in the initial state. False: an initial value is not known.
  bool set_total(AffineEquation& equation) const {
    std::uint32_t total = 0;
    for (const AffineEquation::Term& term : equation.terms) {
      std::uint32_t value = 0;
      const bool is_constant = rows_of(term).empty();
      if (is_constant && !constant(term, value)) return false;
      for (u32 row : rows_of(term)) {
        const StateBit& bit_row = transition_system_.bits[row];
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

  // Assumes the bounds: the bits of these variables above their bounds are 0, and so are the choices of all steps.
  void assume_bounds(const std::vector<VariableBound>& bounds) {
    fixed_.assign(transition_system_.aig.size(), kFree);
    for (const SystemStep& step : transition_system_.steps) fixed_[node_of(step.chosen)] = kFalse;
    for (const VariableBound& bound : bounds) {
      const Word word = now({bound.atom, bound.variable, false, 1});
      for (u32 k = bits_of(bound); k < word.size(); ++k) fix_to_zero(word[k]);
      fix_to_zero(word.back());
    }
  }

  [[nodiscard]] static bool moves_one_of(const Net& net, const SystemStep& step, const std::set<u32>& atoms) {
    return std::any_of(step.parts.begin(), step.parts.end(),
                       [&](const auto& part) { return atoms.contains(net.graph.atom_of_port[part.first]); });
  }

  // A step: whether it is possible, and the next values of its atoms' bits.
  struct StepImage {
    Signal fine = kFalse;
    std::set<u32> atoms;
    std::map<u32, Signal> next;  // by row of bits
  };
  StepImage image_of(const Net& net, const SystemStep& step, const std::set<u32>& wanted) {
    StepImage after;
    std::vector<u32> rows;
    std::vector<Signal> roots{step.fine};
    for (const auto& [port, when] : step.parts) {
      const u32 atom = net.graph.atom_of_port[port];
      if (!wanted.contains(atom) || !after.atoms.insert(atom).second) continue;
      for (u32 row = first_[atom]; row < first_[atom + 1]; ++row) {
        rows.push_back(row);
        roots.push_back(transition_system_.bits[row].next);
      }
    }
    fixed_[node_of(step.chosen)] = kTrue;
    const std::vector<Signal> made = with_fixed(transition_system_.aig, roots, fixed_);
    fixed_[node_of(step.chosen)] = kFalse;
    after.fine = made[0];
    for (std::size_t k = 0; k < rows.size(); ++k) after.next.emplace(rows[k], made[k + 1]);
    return after;
  }

  // The equation or bound in the current state, or after a step.
  Signal holds(const AffineEquation& equation, const StepImage* after) {
    Sides sides;
    for (const AffineEquation::Term& term : equation.terms)
      add_term(term.weight, after != nullptr ? next(term, *after) : now(term), sides);
    sides.less.push_back(word_of(equation.total));
    return equal(transition_system_.aig, total(sides.more), total(sides.less));
  }
  Signal holds(const VariableBound& bound, const StepImage* after) {
    const AffineEquation::Term variable{bound.atom, bound.variable, false, 1};
    const Word word = after != nullptr ? next(variable, *after) : now(variable);
    Signal result = negated(word.back());
    for (u32 k = bits_of(bound); k < word.size(); ++k)
      result = transition_system_.aig.make_and(result, negated(word[k]));
    return result;
  }

  // Candidates: an int is at most what the places of an equation weigh plus the largest values of the ints on the other
  // side. Rounded up by two bits, so that the sum's own bits decide it and no comparison is needed. No candidate where
  // the other side is unbounded ("a = b").
  [[nodiscard]] std::vector<VariableBound> candidate_bounds(const std::vector<AffineEquation>& equations) const {
    std::map<std::pair<u32, u32>, std::int64_t> most;
    for (bool is_new = true; is_new;) {
      // Of the equations of a round the weakest counts.
      std::map<std::pair<u32, u32>, std::int64_t> found;
      for (const AffineEquation& equation : equations) add_largest(equation, most, found);
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
  [[nodiscard]] bool holds_initially(const VariableBound& bound) const {
    AffineEquation value{{{bound.atom, bound.variable, false, 1}}, 0};
    return set_total(value) && value.total >= 0 && value.total <= bound.high;
  }

  [[nodiscard]] Word now(const AffineEquation::Term& term) const {
    if (term.is_place) return word_of_bool(transition_system_.marks[term.atom][term.row]);
    return transition_system_.words[image_.atoms[term.atom].first_cell + term.row];
  }

 private:
  [[nodiscard]] const Range& range_of(const std::pair<u32, u32>& variable) const {
    return transition_system_.ranges[image_.atoms[variable.first].first_cell + variable.second];
  }
  // Adds the largest values that the equation allows for ints without a bound so far.
  void add_largest(const AffineEquation& equation, const std::map<std::pair<u32, u32>, std::int64_t>& bounds,
                   std::map<std::pair<u32, u32>, std::int64_t>& found) const {
    // The sum of all place weights and the constant; the largest sums of the ints with positive and negative weight. A
    // side with an unbounded int exceeds kMaxNumber.
    std::int64_t most = std::abs(std::int64_t{equation.total}), sides[2] = {0, 0};
    for (const AffineEquation::Term& term : equation.terms) {
      const std::int64_t weight = std::abs(std::int64_t{term.weight});
      if (term.is_place) {
        most += weight;
        continue;
      }
      const auto bound = bounds.find({term.atom, term.row});
      const Range& range = range_of({term.atom, term.row});
      const std::int64_t high = bound != bounds.end() ? bound->second
                                : range.low >= 0 && range.high <= SparseSystem::kMaxNumber
                                    ? range.high
                                    : SparseSystem::kMaxNumber + 1;
      std::int64_t& side = sides[term.weight > 0 ? 0 : 1];
      side = std::min(side + weight * high, SparseSystem::kMaxNumber + 1);
    }
    for (const AffineEquation::Term& term : equation.terms) {
      const std::pair variable(term.atom, term.row);
      const std::int64_t number = most + sides[term.weight > 0 ? 1 : 0];
      if (term.is_place || number > SparseSystem::kMaxNumber || bounds.contains(variable)) continue;
      std::int64_t& largest = found[variable];
      largest = std::max(largest, number);
    }
  }
  [[nodiscard]] static u32 bits_of(const VariableBound& bound) {
    return static_cast<u32>(std::bit_width(static_cast<std::uint32_t>(bound.high)));
  }
  // Terms that are added, and those that are after away: so nothing is ever negated, which would cost the solver much.
  struct Sides {
    std::vector<Word> more, less;
  };
  void add_term(std::int32_t weight, const Word& value, Sides& sides) {
    (weight > 0 ? sides.more : sides.less)
        .push_back(multiply(transition_system_.aig, value, word_of(std::abs(weight))));
  }
  // A balanced tree of adders keeps the words short.
  [[nodiscard]] Word total(std::vector<Word> words) {
    if (words.empty()) return word_of(0);
    for (; words.size() > 1; words.resize((words.size() + 1) / 2)) {
      for (std::size_t k = 0; 2 * k < words.size(); ++k)
        words[k] =
            2 * k + 1 < words.size() ? add(transition_system_.aig, words[2 * k], words[2 * k + 1]) : words[2 * k];
    }
    return words[0];
  }
  // The current value under the assumed bounds.
  [[nodiscard]] Word bounded(const AffineEquation::Term& term) {
    return trimmed(with_fixed(transition_system_.aig, now(term), fixed_));
  }
  [[nodiscard]] Word next(const AffineEquation::Term& term, const StepImage& after) {
    if (!after.atoms.contains(term.atom)) return bounded(term);
    Word word = now(term);
    const std::vector<u32> rows = rows_of(term);
    for (std::size_t k = 0; k < rows.size(); ++k) word[k] = after.next.at(rows[k]);
    return trimmed(std::move(word));
  }
  void fix_to_zero(Signal bit_signal) {
    if (node_of(bit_signal) != 0) fixed_[node_of(bit_signal)] = kFalse;
  }
  [[nodiscard]] std::vector<u32> rows_of(const AffineEquation::Term& term) const {
    std::vector<u32> rows;
    for (u32 row = first_[term.atom]; row < first_[term.atom + 1]; ++row) {
      if (transition_system_.bits[row].is_place == term.is_place && transition_system_.bits[row].row == term.row)
        rows.push_back(row);
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

  TransitionSystem& transition_system_;
  const rt::Image& image_;
  std::vector<u32> first_;
  std::vector<Signal> fixed_;  // by node
};

/// SAT queries about one state in which everything assumed holds.
class InductionQuery {
 public:
  InductionQuery(const TransitionSystem& transition_system, const std::vector<std::vector<Signal>>& assumed)
      : cnf_(transition_system.aig, solver_) {
    cnf_.add_state(transition_system);
    for (const std::vector<Signal>& clause : assumed) cnf_.add(clause);
  }
  // Do the others exclude `bad`? False also if the query takes too long.
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

AffineInvariants with_totals(TransitionSystem& transition_system, const rt::Image& image, AffineInvariants facts) {
  const AffineEncoder encoder(transition_system, image);
  std::erase_if(facts.equations, [&](AffineEquation& equation) {
    const bool has_words = std::all_of(equation.terms.begin(), equation.terms.end(),
                                       [&](const AffineEquation::Term& term) { return !encoder.now(term).empty(); });
    return !has_words || !encoder.set_total(equation);
  });
  return facts;
}

AffineInvariants with_bounds(const Net& net, TransitionSystem& transition_system, const rt::Image& image,
                             const std::vector<std::vector<Signal>>& assumed, const CancellationToken& cancellation,
                             AffineInvariants from) {
  AffineInvariants facts = with_totals(transition_system, image, std::move(from));
  AffineEncoder encoder(transition_system, image);
  facts.bounds = encoder.candidate_bounds(facts.equations);
  std::erase_if(facts.bounds, [&](const VariableBound& bound) { return !encoder.holds_initially(bound); });
  std::set<u32> atoms, bounded;
  std::vector<Signal> now;
  std::map<u32, std::vector<u32>> equations_of;  // by atom: rows
  for (u32 row = 0; row < facts.equations.size() && !facts.bounds.empty(); ++row) {
    for (const AffineEquation::Term& term : facts.equations[row].terms) {
      atoms.insert(term.atom);
      equations_of[term.atom].push_back(row);
    }
    now.push_back(encoder.holds(facts.equations[row], nullptr));
  }
  BIP_LOG(Affine, 1, "{} equations, {} candidate bounds", facts.equations.size(), facts.bounds.size());
  std::optional<InductionQuery> query;
  for (bool is_fixpoint = false; !is_fixpoint && !facts.bounds.empty();) {
    if (!query) {
      std::vector<std::vector<Signal>> all = assumed;
      for (const PlaceValue& value : facts.places) all.push_back(place_clause(value, transition_system, image));
      query.emplace(transition_system, all);
    }
    is_fixpoint = true;
    encoder.assume_bounds(facts.bounds);
    bounded.clear();
    for (const VariableBound& bound : facts.bounds) bounded.insert(bound.atom);
    std::vector<std::uint8_t> is_inductive(facts.bounds.size(), 1);
    for (const SystemStep& step : transition_system.steps) {
      if (cancellation.is_over()) return {std::move(facts.equations), {}, std::move(facts.places)};
      if (!AffineEncoder::moves_one_of(net, step, bounded)) continue;
      const AffineEncoder::StepImage after = encoder.image_of(net, step, atoms);
      if (after.fine == kFalse) continue;
      std::vector<Signal> all = now;
      all.push_back(after.fine);
      // The other equations do not change.
      std::set<u32> changed;
      for (u32 atom : after.atoms) changed.insert(equations_of[atom].begin(), equations_of[atom].end());
      for (u32 row : changed) all.push_back(encoder.holds(facts.equations[row], &after));
      for (const VariableBound& bound : facts.bounds) all.push_back(encoder.holds(bound, nullptr));
      for (std::size_t k = 0; k < facts.bounds.size(); ++k) {
        if (is_inductive[k] == 0 || !after.atoms.contains(facts.bounds[k].atom)) continue;
        is_inductive[k] = query->excludes(all, negated(encoder.holds(facts.bounds[k], &after)), cancellation) ? 1 : 0;
      }
    }
    // Bounds that were shown with the help of a refuted one are checked again.
    std::size_t next = 0;
    std::erase_if(facts.bounds, [&](const VariableBound&) { return is_inductive[next++] == 0; });
    is_fixpoint = facts.bounds.size() == next;
  }
  return facts;
}

Signal equation_signal(const AffineEquation& equation, TransitionSystem& transition_system, const rt::Image& image) {
  return AffineEncoder(transition_system, image).holds(equation, nullptr);
}
std::vector<Signal> place_clause(const PlaceValue& fact, TransitionSystem& transition_system, const rt::Image& image) {
  const Word& word = transition_system.words[image.atoms[fact.atom].first_cell + fact.variable];
  return {negated(transition_system.marks[fact.atom][fact.place]),
          word.empty() ? kTrue : equal(transition_system.aig, word, word_of(fact.value))};
}
Signal bound_signal(const VariableBound& bound, TransitionSystem& transition_system, const rt::Image& image) {
  return AffineEncoder(transition_system, image).holds(bound, nullptr);
}

}  // namespace bip::verify
