// Components that wait for ever, against the definition: for each reachable state and each atom, a walk through all
// that is reachable from there, looking for a step that moves the atom. Nothing of the prover's is used but its
// answers.
#include <catch2/catch.hpp>

#include <map>
#include <set>
#include <string>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/portfolio/local_deadlock_search.hpp"
#include "compiler/verify/portfolio/local_deadlock.hpp"
#include "runtime/core/final_state.hpp"
#include "tests/verify/small_net.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/description.hpp"

namespace {

using namespace bip;
using verify::u32;

constexpr std::size_t kMaxStates = 400;

struct Node {
  rt::State state;
  std::vector<std::size_t> next;
  std::set<u32> moves;       // by some step
  std::vector<u32> at_once;  // what locally_deadlocked_atoms says
  std::set<u32> wants;
};

// False: too many states.
bool visit(const verify::Net& net, const rt::Image& image, std::vector<Node>& nodes) {
  rt::Core core(image);
  if (!core.initialize()) return true;
  std::map<std::string, std::size_t> rows;
  const auto row_of = [&] {
    const auto [at, is_new] = rows.try_emplace(verify::state_key(core.snapshot()), nodes.size());
    if (is_new) nodes.push_back({core.snapshot(), {}, {}, {}, {}});
    return at->second;
  };
  row_of();
  for (std::size_t row = 0; row < nodes.size(); ++row) {
    if (nodes.size() > kMaxStates) return false;
    const rt::State state = nodes[row].state;
    REQUIRE(core.restore(state));
    nodes[row].at_once = verify::locally_deadlocked_atoms(net, core);
    for (u32 atom = 0; atom < image.atoms.size; ++atom) {
      if (rt::wants_to_move(core, atom)) nodes[row].wants.insert(atom);
    }
    const std::uint64_t count = core.candidate_count();
    for (std::uint64_t k = 0; k < count; ++k) {
      REQUIRE(core.restore(state));
      std::vector<rt::Participant> participants;
      core.participants(core.candidate(k), participants);
      for (const rt::Participant& p : participants) nodes[row].moves.insert(p.atom);
      if (!core.fire(k)) continue;
      const std::size_t to = row_of();
      nodes[row].next.push_back(to);
    }
  }
  return true;
}

bool can_move_later(const std::vector<Node>& nodes, std::size_t from, u32 atom) {
  std::set<std::size_t> seen{from};
  std::vector<std::size_t> todo{from};
  while (!todo.empty()) {
    const Node& node = nodes[todo.back()];
    todo.pop_back();
    if (node.moves.count(atom) != 0) return true;
    for (std::size_t to : node.next) {
      if (seen.insert(to).second) todo.push_back(to);
    }
  }
  return false;
}

struct Tally {
  int stuck = 0, free = 0, only_by_the_graph = 0, of_a_part = 0;
};

void compare(const std::vector<std::string>& texts, Tally& tally) {
  const gen::Compiled c = gen::compile_texts(texts);
  if (!c.problem.empty() || !c.system->code.functions.empty() || !c.system->code.ffi_types.empty()) return;
  INFO(texts.back());
  const verify::Net net = verify::build_net(*c.system);
  if (net.too_large_atom != verify::kNoRow) return;
  const interp::Interpreter interpreter(*c.lowered);
  const rt::Image& image = c.lowered->image;
  std::vector<Node> nodes;
  if (!visit(net, image, nodes)) return;
  std::map<std::string, std::set<u32>> waiting;
  bool is_seen_at_once = false;
  for (std::size_t row = 0; row < nodes.size(); ++row) {
    std::set<u32>& here = waiting[verify::state_key(nodes[row].state)];
    for (u32 atom : nodes[row].wants) {
      if (!can_move_later(nodes, row, atom)) here.insert(atom);
    }
    is_seen_at_once = is_seen_at_once || !nodes[row].at_once.empty();
    for (u32 atom : nodes[row].at_once) CHECK(here.count(atom) != 0);
  }
  const bool expected =
      std::any_of(waiting.begin(), waiting.end(), [](const auto& state) { return !state.second.empty(); });
  const verify::LocalDeadlockResult found =
      verify::find_local_deadlock(net, image, {.cancellation = verify::within_seconds(60)});
  REQUIRE(found.search.end == (expected ? verify::SearchEnd::Found : verify::SearchEnd::Exhausted));
  ++(expected ? tally.stuck : tally.free);
  if (!expected) {
    CHECK(found.search.states == nodes.size());
    return;
  }
  tally.only_by_the_graph += is_seen_at_once ? 0 : 1;
  rt::Core core(image);
  REQUIRE(core.initialize());
  for (std::uint64_t k : found.search.choices) REQUIRE(core.fire(k));
  tally.of_a_part += core.candidate_count() != 0 ? 1 : 0;
  const std::set<u32>& here = waiting[verify::state_key(core.snapshot())];
  REQUIRE(!found.stuck.empty());
  for (u32 atom : found.stuck) CHECK(here.count(atom) != 0);
  if (!is_seen_at_once) CHECK(std::set<u32>(found.stuck.begin(), found.stuck.end()) == here);
}

}  // namespace

TEST_CASE("components that wait for ever, against the definition") {
  Tally nets, models;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) compare({verify::test::small_net(seed)}, nets);
  for (std::uint64_t seed = 1; seed <= 60; ++seed) compare(gen::print_packages(gen::generate(seed)), models);
  // Of every sort some, or the comparison says little.
  CHECK(nets.stuck > 0);
  CHECK(nets.free > 0);
  CHECK(nets.of_a_part > 0);
  CHECK(nets.only_by_the_graph > 0);
  CHECK(models.stuck + models.free > 0);
}
