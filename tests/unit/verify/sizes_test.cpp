// All sizes at once: values of index code, and words of hand-made components.
#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "compiler/verify/sizes/size_value.hpp"
#include "compiler/verify/sizes/word_proof.hpp"

namespace bip::verify {
namespace {

// Index code over n (Self 0) and i (Self 1).
struct IndexCode {
  CodeTable table;
  ExprId constant(std::int32_t value) { return add({.op = Op::ConstInt, .int_value = value}); }
  ExprId size() { return add({.op = Op::LoadSelf, .index = 0}); }
  ExprId position() { return add({.op = Op::LoadSelf, .index = 1}); }
  ExprId binary(Op op, ExprId a, ExprId b) { return add({.op = op, .a = a, .b = b}); }
  ExprId add(const Expr& e) { return table.exprs.push(e); }
  [[nodiscard]] SizeValue value(ExprId expr, SizeRange range) const {
    return evaluate_for_sizes(table, expr, {SizeValue::linear(0, 1, 0), SizeValue::linear(1, 0, 0)}, range);
  }
};

TEST_CASE("an index is linear in the position and the size, or that modulo the size") {
  IndexCode code;
  const ExprId next = code.binary(Op::Add, code.position(), code.constant(1));
  const SizeValue neighbour = code.value(next, {});
  CHECK(neighbour.kind == SizeValue::Kind::Linear);
  CHECK(neighbour.of_position == 1);
  CHECK(neighbour.constant == 1);
  CHECK(code.value(code.binary(Op::Mod, next, code.size()), {}).kind == SizeValue::Kind::Circular);
  // C's remainder of a negative number is no index.
  const ExprId before = code.binary(Op::Sub, code.position(), code.constant(1));
  CHECK(code.value(code.binary(Op::Mod, before, code.size()), {}).kind == SizeValue::Kind::Unknown);
  CHECK(code.value(code.binary(Op::Mod, before, code.size()), {1, 0, 1}).kind == SizeValue::Kind::Circular);
  const ExprId wrapped = code.binary(Op::Mod, code.binary(Op::Add, before, code.size()), code.size());
  CHECK(code.value(wrapped, {}).constant == -1);
  CHECK(code.value(code.binary(Op::Mul, code.position(), code.size()), {}).kind == SizeValue::Kind::Unknown);
}

TEST_CASE("a condition has a truth only if it is the same at all sizes and positions") {
  IndexCode code;
  const ExprId is_first = code.binary(Op::Eq, code.position(), code.constant(0));
  CHECK(code.value(is_first, {0, 0, 3}).kind == SizeValue::Kind::Unknown);
  const SizeValue later = code.value(is_first, {1, 0, 3});
  REQUIRE(later.kind == SizeValue::Kind::Truth);
  CHECK_FALSE(later.truth);
  const ExprId last = code.binary(Op::Sub, code.size(), code.constant(1));
  const ExprId is_inner = code.binary(Op::Lt, code.position(), last);
  CHECK(code.value(is_inner, {0, 0, 3}).kind == SizeValue::Kind::Unknown);
  REQUIRE(code.value(is_inner, {0, 1, 3}).kind == SizeValue::Kind::Truth);
  CHECK(code.value(is_inner, {0, 1, 3}).truth);
  const ExprId is_large = code.binary(Op::Ge, code.size(), code.constant(3));
  CHECK(code.value(is_large, {0, 0, 2}).kind == SizeValue::Kind::Unknown);
  CHECK(code.value(is_large, {0, 0, 3}).kind == SizeValue::Kind::Truth);
}

// A component of `modes` modes; by port its moves.
ModeClass component(std::uint32_t modes, std::uint32_t initial, std::vector<std::vector<Move>> moves) {
  ModeClass row;
  row.modes.resize(modes);
  row.initial = {initial};
  for (const std::vector<Move>& port : moves) {
    std::vector<std::uint8_t>& is_sure = row.is_sure.emplace_back(modes, std::uint8_t(0));
    for (const Move& move : port) is_sure[move.from] = 1;
  }
  row.moves = std::move(moves);
  return row;
}

constexpr std::uint32_t kWaits = 0, kHolds = 1;
constexpr std::uint32_t kSend = 0, kReceive = 1;

// A circle of stations; those of the zones in `first` hold a token initially.
WordProblem ring(const ModeClass& plain, const ModeClass& holder, const std::vector<std::size_t>& first) {
  WordProblem problem;
  for (std::size_t zone = 0; zone < 3; ++zone) {
    const bool holds = std::find(first.begin(), first.end(), zone) != first.end();
    problem.zones.push_back({{holds ? &holder : &plain, {0, 0}}});
  }
  problem.events.push_back(
      {{{0, kSend, ElementPlace::AtLoop, 0, false}, {0, kReceive, ElementPlace::AtLoop, 1, false}}, true, 0, 0, true});
  return problem;
}

TEST_CASE("a ring with a token is free of deadlocks, one without or full of tokens is not") {
  const std::vector<std::vector<Move>> moves = {{{kHolds, kWaits}}, {{kWaits, kHolds}}};
  const ModeClass plain = component(2, kWaits, moves), holder = component(2, kHolds, moves);
  CHECK(prove_words(ring(plain, holder, {0}), {}).outcome == WordAnswer::Outcome::Proved);
  CHECK(prove_words(ring(plain, holder, {0, 1}), {}).outcome == WordAnswer::Outcome::Proved);
  const WordAnswer none = prove_words(ring(plain, holder, {}), {});
  REQUIRE(none.outcome == WordAnswer::Outcome::Candidate);
  CHECK(none.letters == std::vector<std::vector<std::uint32_t>>(3, {kWaits}));
  const WordAnswer full = prove_words(ring(plain, holder, {0, 1, 2}), {});
  REQUIRE(full.outcome == WordAnswer::Outcome::Candidate);
  CHECK(full.letters == std::vector<std::vector<std::uint32_t>>(3, {kHolds}));
}

// The words of three letters that the rows read: by position the modes of its one component.
std::vector<std::vector<std::set<std::uint32_t>>> words_of_sets(const std::vector<WordSetRow>& rows) {
  std::vector<std::pair<std::uint32_t, std::vector<std::set<std::uint32_t>>>> words;
  for (const WordSetRow& row : rows) {
    if (row.is_first) words.push_back({row.to, {}});
  }
  for (std::size_t zone = 0; zone < 3; ++zone) {
    std::vector<std::pair<std::uint32_t, std::vector<std::set<std::uint32_t>>>> longer;
    for (const auto& [state, word] : words) {
      for (const WordSetRow& row : rows) {
        if (row.is_first || row.from != state || row.zone != zone) continue;
        longer.emplace_back(row.to, word).second.emplace_back();
        for (const auto& [atom, mode] : row.modes) longer.back().second.back().insert(mode);
      }
    }
    words = std::move(longer);
  }
  std::vector<std::vector<std::set<std::uint32_t>>> out;
  for (auto& [state, word] : words) out.push_back(std::move(word));
  return out;
}

TEST_CASE("a proof has an automaton of the sets that it needs") {
  const std::vector<std::vector<Move>> moves = {{{kHolds, kWaits}}, {{kWaits, kHolds}}};
  const ModeClass plain = component(2, kWaits, moves), holder = component(2, kHolds, moves);
  const WordAnswer proof = prove_words(ring(plain, holder, {0}), {}, WordEvidence::Sets);
  REQUIRE(proof.outcome == WordAnswer::Outcome::Proved);
  CHECK(prove_words(ring(plain, holder, {0}), {}).sets.empty());
  const auto words = words_of_sets(proof.sets);
  for (const auto& word : words) {
    CHECK((word[0].contains(kHolds) || word[1].contains(kWaits) || word[2].contains(kWaits)));
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t next = (i + 1) % 3;
      if (word[i].contains(kHolds) || word[next].contains(kWaits))
        CHECK((word[i].contains(kWaits) || word[next].contains(kHolds)));
    }
  }
  // In both of these nothing is possible, and a trap is empty.
  for (const std::uint32_t mode : {kWaits, kHolds}) {
    CHECK(std::any_of(words.begin(), words.end(), [&](const auto& word) {
      return std::none_of(word.begin(), word.end(), [&](const auto& set) { return set.contains(mode); });
    }));
  }
  // The middle letter comes any number of times.
  CHECK(std::any_of(proof.sets.begin(), proof.sets.end(), [&](const WordSetRow& row) {
    return !row.is_first && row.zone == 1 && std::any_of(proof.sets.begin(), proof.sets.end(), [&](const auto& other) {
      return !other.is_first && other.from == row.to && other.zone == 1;
    });
  }));
}

TEST_CASE("a line is a ring without the connector from the last to the first") {
  const std::vector<std::vector<Move>> moves = {{{kHolds, kWaits}}, {{kWaits, kHolds}}};
  const ModeClass plain = component(2, kWaits, moves), holder = component(2, kHolds, moves);
  WordProblem line = ring(plain, holder, {0});
  line.events.front().high = 1;
  const WordAnswer stuck = prove_words(line, {});
  REQUIRE(stuck.outcome == WordAnswer::Outcome::Candidate);
  // The token is at the end.
  CHECK(stuck.letters.back() == std::vector<std::uint32_t>{kHolds});
  // The last station hands it out again.
  line.events.push_back(
      {{{0, kSend, ElementPlace::FromEnd, 0, false}, {0, kReceive, ElementPlace::FromStart, 0, false}},
       false,
       0,
       0,
       true});
  CHECK(prove_words(line, {}).outcome == WordAnswer::Outcome::Proved);
}

TEST_CASE("an interaction with a guard proves nothing, but moves") {
  const std::vector<std::vector<Move>> moves = {{{kHolds, kWaits}}, {{kWaits, kHolds}}};
  const ModeClass plain = component(2, kWaits, moves), holder = component(2, kHolds, moves);
  WordProblem problem = ring(plain, holder, {0});
  problem.events.front().is_sure = false;
  CHECK(prove_words(problem, {}).outcome == WordAnswer::Outcome::Candidate);
}

TEST_CASE("a rendezvous of all needs all, a broadcast takes whom it finds") {
  constexpr std::uint32_t kTick = 0;
  const ModeClass node = component(2, 0, {{{0, 0}}, {{0, 1}}});  // tick at 0; `leave` leads to 1 for good
  const ModeClass clock = component(1, 0, {{{0, 0}}});
  WordProblem problem;
  problem.singles = {{&clock, {0}}};
  problem.zones.assign(3, {{&node, {0, 0}}});
  problem.events.push_back(
      {{{0, 0, ElementPlace::Single, 0, false}, {0, kTick, ElementPlace::Every, 0, false}}, false, 0, 0, true});
  CHECK(prove_words(problem, {}).outcome == WordAnswer::Outcome::Proved);
  problem.events.push_back({{{0, 1, ElementPlace::AtLoop, 0, false}}, true, 0, 0, true});
  CHECK(prove_words(problem, {}).outcome == WordAnswer::Outcome::Candidate);
  problem.events.front().ports[1].is_optional = true;
  CHECK(prove_words(problem, {}).outcome == WordAnswer::Outcome::Proved);
}

TEST_CASE("a state in which all are at final places is no deadlock") {
  const ModeClass job = component(2, 0, {{{0, 1}}});
  WordProblem problem;
  problem.zones.assign(3, {{&job, {0, 0}}});
  problem.events.push_back({{{0, 0, ElementPlace::AtLoop, 0, false}}, true, 0, 0, true});
  CHECK(prove_words(problem, {}).outcome == WordAnswer::Outcome::Candidate);
  for (auto& zone : problem.zones) zone.front().is_final = {0, 1};
  CHECK(prove_words(problem, {}).outcome == WordAnswer::Outcome::Proved);
}

}  // namespace
}  // namespace bip::verify
