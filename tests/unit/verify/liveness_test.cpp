// Formulas and their automata: on random runs that end in a cycle an automaton accepts what the formula's meaning says,
// which is evaluated without it; the usual forms have few states.
#include <catch2/catch.hpp>

#include <vector>

#include "compiler/verify/liveness/automaton.hpp"

namespace bip::verify {

namespace {

constexpr std::uint32_t kConditions = 3;  // two of states, one of steps

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 2654435761u + 1) {}
  std::uint32_t below(std::uint32_t count) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::uint32_t>(state_ >> 33) % count;
  }

 private:
  std::uint64_t state_;
};

std::uint32_t add(Formula& formula, FormulaNode node) {
  formula.nodes.push_back(node);
  return static_cast<std::uint32_t>(formula.nodes.size() - 1);
}
enum class Looks : std::uint8_t { Anywhere, Back };
std::uint32_t random_node(Formula& formula, Random& random, int depth, Looks looks = Looks::Anywhere) {
  if (depth == 0 || random.below(6) == 0) {
    const std::uint32_t row = random.below(kConditions + 1);
    if (row == kConditions) return add(formula, {.kind = FormulaKind::Constant, .value = random.below(2) == 0});
    return row < 2 ? add(formula, {.kind = FormulaKind::State, .row = row}) : add(formula, {.kind = FormulaKind::Step});
  }
  constexpr FormulaKind kKinds[] = {FormulaKind::Not,   FormulaKind::And,        FormulaKind::Or,
                                    FormulaKind::Since, FormulaKind::Previously, FormulaKind::Next,
                                    FormulaKind::Until, FormulaKind::Until,      FormulaKind::Release};
  constexpr std::uint32_t kLookBack = 5;  // the first ones
  const FormulaKind kind =
      kKinds[random.below(looks == Looks::Back ? kLookBack : static_cast<std::uint32_t>(std::size(kKinds)))];
  if (looks_back(kind)) looks = Looks::Back;
  const std::uint32_t a = random_node(formula, random, depth - 1, looks);
  const bool is_unary = kind == FormulaKind::Not || kind == FormulaKind::Next || kind == FormulaKind::Previously;
  const std::uint32_t b = is_unary ? a : random_node(formula, random, depth - 1, looks);
  return add(formula, {.kind = kind, .a = a, .b = b});
}
Formula random_formula(Random& random) {
  Formula formula;
  formula.states.resize(2);
  formula.steps.resize(1);
  formula.root = random_node(formula, random, 1 + static_cast<int>(random.below(3)));
  return formula;
}

// By the closure of the product's edges: is a node that lies on a cycle with all marks reachable?
bool accepts(const Automaton& automaton, const std::vector<std::uint64_t>& states,
             const std::vector<std::uint64_t>& steps, std::size_t cycle) {
  if (automaton.is_empty()) return false;
  const std::size_t width = automaton.edges.size(), nodes = width * states.size();
  struct Arrow {
    std::size_t from, to;
    std::uint32_t marks;
  };
  std::vector<Arrow> arrows;
  std::vector<std::vector<char>> reach(nodes, std::vector<char>(nodes, 0));
  for (std::size_t at = 0; at < states.size(); ++at) {
    const std::size_t next = at + 1 < states.size() ? at + 1 : cycle;
    const std::uint64_t letter = states[at] | steps[at] << 2;
    for (std::size_t state = 0; state < width; ++state) {
      for (const AutomatonEdge& edge : automaton.edges[state]) {
        if ((edge.required & ~letter) != 0 || (edge.forbidden & letter) != 0) continue;
        arrows.push_back({at * width + state, next * width + edge.to, edge.marks});
        reach[at * width + state][next * width + edge.to] = 1;
      }
    }
  }
  for (std::size_t via = 0; via < nodes; ++via) {
    for (std::size_t from = 0; from < nodes; ++from) {
      for (std::size_t to = 0; reach[from][via] != 0 && to < nodes; ++to) reach[from][to] |= reach[via][to];
    }
  }
  for (std::size_t node = 0; node < nodes; ++node) {
    if (reach[node][node] == 0 || (node != 0 && reach[0][node] == 0)) continue;
    std::uint32_t marks = 0;
    for (const Arrow& arrow : arrows) {
      const bool is_inside =
          (arrow.from == node || reach[node][arrow.from] != 0) && (arrow.to == node || reach[arrow.to][node] != 0);
      if (is_inside) marks |= arrow.marks;
    }
    if (marks == automaton.marks) return true;
  }
  return false;
}

struct Forms {
  Formula formula;
  Forms() {
    formula.states.resize(2);
    (void)add(formula, {.kind = FormulaKind::State, .row = 0});
    (void)add(formula, {.kind = FormulaKind::State, .row = 1});
  }
  std::uint32_t constant(bool value) { return add(formula, {.kind = FormulaKind::Constant, .value = value}); }
  std::uint32_t eventually(std::uint32_t a) {
    return add(formula, {.kind = FormulaKind::Until, .a = constant(true), .b = a});
  }
  std::uint32_t always(std::uint32_t a) {
    return add(formula, {.kind = FormulaKind::Release, .a = constant(false), .b = a});
  }
  std::size_t negated_states(std::uint32_t root) {
    formula.root = root;
    Result<Automaton> made = make_automaton(formula, RunsOf::Negation);
    REQUIRE(made);
    return made->edges.size();
  }
};

}  // namespace

TEST_CASE("an automaton accepts the runs that satisfy its formula") {
  std::size_t true_ones = 0, runs = 0;
  for (std::uint64_t seed = 1; seed <= 1500; ++seed) {
    Random random(seed);
    const Formula formula = random_formula(random);
    Result<Automaton> same = make_automaton(formula, RunsOf::Formula),
                      negation = make_automaton(formula, RunsOf::Negation);
    REQUIRE(same);
    REQUIRE(negation);
    for (int run = 0; run < 6; ++run) {
      const std::size_t size = 1 + random.below(4), cycle = random.below(static_cast<std::uint32_t>(size));
      std::vector<std::uint64_t> states, steps;
      for (std::size_t at = 0; at < size; ++at) {
        states.push_back(random.below(4));
        steps.push_back(random.below(2));
      }
      const bool expected = holds_on_lasso(formula, states, steps, cycle);
      INFO("seed " << seed << ", run " << run);
      CHECK(accepts(*same, states, steps, cycle) == expected);
      CHECK(accepts(*negation, states, steps, cycle) != expected);
      true_ones += expected ? 1 : 0;
      ++runs;
    }
  }
  // Neither all nor none, or the test says little.
  CHECK(true_ones > runs / 5);
  CHECK(true_ones < runs * 4 / 5);
}

TEST_CASE("the usual forms have automata of few states") {
  Forms f;
  CHECK(f.negated_states(f.eventually(0)) == 1);
  CHECK(f.negated_states(f.always(f.eventually(0))) == 2);
  CHECK(f.negated_states(f.eventually(f.always(0))) == 1);
  const std::uint32_t negated = add(f.formula, {.kind = FormulaKind::Not, .a = 0, .b = 0});
  const std::uint32_t eventually = f.eventually(1);
  CHECK(f.negated_states(f.always(add(f.formula, {.kind = FormulaKind::Or, .a = negated, .b = eventually}))) == 2);
  CHECK(f.negated_states(add(f.formula, {.kind = FormulaKind::Until, .a = 0, .b = 1})) == 2);
  // Infinitely often the one implies infinitely often the other.
  const std::uint32_t again = f.always(f.eventually(0)), other = f.always(f.eventually(1));
  const std::uint32_t not_again = add(f.formula, {.kind = FormulaKind::Not, .a = again, .b = again});
  CHECK(f.negated_states(add(f.formula, {.kind = FormulaKind::Or, .a = not_again, .b = other})) == 2);
}

// By its definition, position by position, on the run written out for as long as a memory of two operators can change.
TEST_CASE("operators of the past on a run that ends in a cycle") {
  Forms f;
  const std::uint32_t since = add(f.formula, {.kind = FormulaKind::Since, .a = 0, .b = 1});
  const std::uint32_t before = add(f.formula, {.kind = FormulaKind::Previously, .a = since, .b = since});
  // Bit 0: condition 0. The right side comes at the third position alone, before the cycle; the left side stays true.
  const std::vector<std::uint64_t> states{0, 1, 2, 1, 1}, steps(5, 0);
  const auto holds = [&](std::uint32_t row, std::uint32_t position) {
    for (; position != 0; --position) row = add(f.formula, {.kind = FormulaKind::Next, .a = row, .b = row});
    f.formula.root = row;
    return holds_on_lasso(f.formula, states, steps, 3);
  };
  const bool expected[] = {false, false, true, true, true, true, true};
  for (std::uint32_t position = 0; position < 7; ++position) {
    INFO("position " << position);
    CHECK(holds(since, position) == expected[position]);
    CHECK(holds(before, position) == (position != 0 && expected[position - 1]));
  }
  // In the first round of a cycle it is false, in the others it is true.
  const std::vector<std::uint64_t> cycle{0, 2};
  f.formula.root = f.always(f.eventually(add(f.formula, {.kind = FormulaKind::Previously, .a = 1, .b = 1})));
  CHECK(holds_on_lasso(f.formula, cycle, {0, 0}, 0));
  f.formula.root = add(f.formula, {.kind = FormulaKind::Previously, .a = 1, .b = 1});
  CHECK_FALSE(holds_on_lasso(f.formula, cycle, {0, 0}, 0));
}

TEST_CASE("an invariant that looks back has an automaton that ends where it is violated") {
  Forms f;
  const std::uint32_t once = add(f.formula, {.kind = FormulaKind::Since, .a = f.constant(true), .b = 0});
  const std::uint32_t negated = add(f.formula, {.kind = FormulaKind::Not, .a = 1, .b = 1});
  f.formula.root = f.always(add(f.formula, {.kind = FormulaKind::Or, .a = negated, .b = once}));
  CHECK(is_invariant_of_past(f.formula));
  Result<Automaton> made = make_automaton(f.formula, RunsOf::Negation);
  REQUIRE(made);
  // Not yet, and violated; once it was true nothing violates it.
  REQUIRE(made->edges.size() == 2);
  CHECK_FALSE(made->accepts_whatever_follows(0));
  CHECK(made->accepts_whatever_follows(1));
  f.formula.root = f.always(f.eventually(once));
  CHECK_FALSE(is_invariant_of_past(f.formula));
}

TEST_CASE("a formula that no run violates has an empty negation") {
  Forms f;
  const std::uint32_t eventually = f.eventually(0);
  const std::uint32_t never = add(f.formula, {.kind = FormulaKind::Not, .a = eventually, .b = eventually});
  f.formula.root = add(f.formula, {.kind = FormulaKind::Or, .a = eventually, .b = never});
  Result<Automaton> made = make_automaton(f.formula, RunsOf::Negation);
  REQUIRE(made);
  CHECK(made->is_empty());
}

}  // namespace bip::verify
