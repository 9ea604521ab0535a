// What is known of next moves, against the definition: in each reachable state, with the history of each component, all
// that a component can do next is in the one conflict set that its enabled ports tell.
#include <catch2/catch.hpp>

#include <algorithm>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/conflicts/next_moves.hpp"
#include "compiler/verify/portfolio/search_bad_state.hpp"
#include "runtime/core/core.hpp"
#include "tests/verify/small_net.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/description.hpp"

namespace {

using namespace bip;
using rt::u32;

constexpr std::size_t kMostStates = 3000;

const char* const kDinner = R"(package dinner
  port type P()
  connector type Three(P a, P b, P c)
    define a b c
  end
  connector type Two(P a, P b)
    define a b
  end
  atom type Fork()
    export port P take(), give()
    place FREE, TAKEN
    initial to FREE
    on take from FREE to TAKEN
    on give from TAKEN to FREE
  end
  atom type Philosopher(bool is_left)
    export port P take(), first(), second(), give()
    place THINKS, WAITS, EATS
    initial to THINKS
    on take from THINKS to EATS provided (is_left)
    on first from THINKS to WAITS provided (!is_left)
    on second from WAITS to EATS
    on give from EATS to THINKS
  end
  compound type Dinner()
    component Philosopher phil[4](true)
    component Fork fork[4]()
    for i in 0..4 connector Three take[i](phil[i].take, fork[i].take, fork[(i + 1) % 4].take)
    for i in 0..4 connector Three give[i](phil[i].give, fork[i].give, fork[(i + 1) % 4].give)
  end
  compound type Mixed()
    for i in 0..4 component Philosopher phil[i](i % 2 == 0)
    component Fork fork[4]()
    for i in 0..4 connector Three take[i](phil[i].take, fork[i].take, fork[(i + 1) % 4].take)
    for i in 0..4 connector Two first[i](phil[i].first, fork[i].take)
    for i in 0..4 connector Two second[i](phil[i].second, fork[(i + 1) % 4].take)
    for i in 0..4 connector Three give[i](phil[i].give, fork[i].give, fork[(i + 1) % 4].give)
  end
end
)";

// At BUSY a clerk may finish or be called away: both are offered to one node, whoever is served.
const char* const kClerk = R"(package clerk
  port type P()
  connector type Two(P a, P b)
    define a b
  end
  atom type Clerk()
    export port P serve(), finish(), leave()
    place FREE, BUSY
    initial to FREE
    on serve from FREE to BUSY
    on finish from BUSY to FREE
    on leave from BUSY to FREE
  end
  atom type Client()
    export port P serve(), finish()
    place WAITS, SERVED
    initial to WAITS
    on serve from WAITS to SERVED
    on finish from SERVED to WAITS
  end
  atom type Boss()
    export port P call()
    place HERE
    initial to HERE
    on call from HERE to HERE
  end
  compound type Root()
    component Clerk clerk()
    component Client client[2]()
    component Boss boss()
    for i in 0..2 connector Two serve[i](client[i].serve, clerk.serve)
    for i in 0..2 connector Two finish[i](client[i].finish, clerk.finish)
    connector Two leave(boss.call, clerk.leave)
  end
end
)";

struct HistoryTally {
  int with_rows = 0, with_excluded = 0, finer = 0;
};

struct Visited {
  rt::State state;
  std::vector<u32> history;
};

// Each enabled port tells the set of each candidate that moves the atom.
void check_state(rt::Core& core, const rt::ConflictSets& sets, const Visited& at) {
  const rt::Tables& tables = core.tables();
  std::map<u32, std::vector<rt::InteractionId>> moves;  // by atom
  std::vector<rt::Participant> participants;
  for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
    core.participants(core.candidate(k), participants);
    for (const rt::Participant& p : participants) moves[p.atom].push_back(core.candidate(k).interaction);
  }
  for (const auto& [atom, interactions] : moves) {
    const u32 place = at.state.places[atom];
    for (const rt::InteractionId interaction : interactions) {
      if (sets.by_situation[atom] == 0) {
        REQUIRE(sets.set_of(atom, place) == sets.of_interaction[interaction]);
        continue;
      }
      bool is_told = false;
      for (u32 port = 0; port < tables.atom_type(atom).ports.size; ++port) {
        if (core.enabled_transition(atom, port) == rt::kNone) continue;
        const u32 set = sets.set_of(atom, place, at.history[atom], port);
        REQUIRE((set == rt::kNone || set == sets.of_interaction[interaction]));
        is_told = is_told || set != rt::kNone;
      }
      REQUIRE(is_told);
    }
  }
}

void compare_moves(const gen::Compiled& c, HistoryTally& tally) {
  if (!c.problem.empty() || !c.system->code.functions.empty() || !c.system->code.ffi_types.empty() ||
      rt::has_time(c.lowered->image))
    return;
  const interp::Interpreter interpreter(*c.lowered);
  rt::Core core(c.lowered->image);
  if (!core.initialize()) return;
  const verify::NextMoves known = verify::find_next_moves(*c.system, verify::within_seconds(20));
  const rt::ConflictSets sets = rt::conflict_sets(core.tables(), core.priorities(), known.moves);
  const rt::ConflictSets by_places = rt::conflict_sets(core.tables(), core.priorities());
  CHECK(sets.count >= by_places.count);
  tally.with_rows += known.moves.empty() ? 0 : 1;
  tally.with_excluded += known.excluded.empty() ? 0 : 1;
  tally.finer += sets.count > by_places.count ? 1 : 0;
  std::map<std::pair<std::string, std::vector<u32>>, std::size_t> seen;
  std::vector<Visited> states;
  const auto visit = [&](const std::vector<u32>& history) {
    if (seen.try_emplace({verify::state_key(core.snapshot()), history}, states.size()).second)
      states.push_back({core.snapshot(), history});
  };
  visit(std::vector<u32>(c.lowered->image.atoms.size, rt::kNone));
  for (std::size_t row = 0; row < states.size() && states.size() < kMostStates; ++row) {
    const Visited at = states[row];
    REQUIRE(core.restore(at.state));
    check_state(core, sets, at);
    const std::uint64_t count = core.candidate_count();
    for (std::uint64_t k = 0; k < count; ++k) {
      REQUIRE(core.restore(at.state));
      const rt::Candidate candidate = core.candidate(k);
      std::vector<rt::Participant> participants;
      core.participants(candidate, participants);
      if (!core.fire(k)) continue;
      std::vector<u32> history = at.history;
      for (const rt::Participant& p : participants) {
        if (sets.is_told_apart[core.tables().instance(p.atom, p.port)] != 0) history[p.atom] = candidate.connector;
      }
      visit(history);
    }
  }
}

gen::Compiled compile_root(const std::string& name) {
  std::string text = kDinner;
  // The root is the one compound that nobody instantiates.
  const std::string other = name == "Dinner" ? "Mixed" : "Dinner";
  const std::size_t begin = text.find("  compound type " + other), end = text.find("  end\n", begin);
  text.erase(begin, end + 6 - begin);
  text.replace(text.find("compound type " + name), 14 + name.size(), "compound type Root");
  return gen::compile_texts({text});
}

}  // namespace

TEST_CASE("next moves: a fork is given back by who took it, and by modes some do not take it so") {
  for (const char* root : {"Dinner", "Mixed"}) {
    const gen::Compiled c = compile_root(root);
    INFO(c.problem);
    REQUIRE(c.problem.empty());
    const verify::NextMoves known = verify::find_next_moves(*c.system, verify::within_seconds(20));
    CHECK_FALSE(known.excluded.empty());
    CHECK(known.invariants > 0);
    HistoryTally tally;
    compare_moves(c, tally);
    CHECK(tally.finer == 1);
    const rt::Core core(c.lowered->image);
    const rt::ConflictSets sets = rt::conflict_sets(core.tables(), core.priorities(), known.moves);
    u32 alone = 0;
    for (u32 set = 0; set < sets.count; ++set) alone += sets.interactions[set].size == 1 ? 1 : 0;
    // What gives forks back, one by one.
    CHECK(alone >= 4);
  }
}

TEST_CASE("next moves: an answer that needs more time than there is, and one of too many components, say so") {
  const gen::Compiled c = compile_root("Dinner");
  REQUIRE(c.problem.empty());
  const verify::NextMoves late = verify::find_next_moves(*c.system, verify::within_seconds(0));
  CHECK(late.question == verify::ConflictQuestion::OutOfTime);
  CHECK(late.moves.empty());
  auto many = *c.system;
  many.atoms.assign(verify::kMostAtomsOfNextMoves + 1, c.system->atoms[AtomId(0u)]);
  CHECK(verify::find_next_moves(many, verify::within_seconds(20)).question == verify::ConflictQuestion::TooLarge);
  CHECK(verify::find_next_moves(*c.system, verify::within_seconds(20)).question == verify::ConflictQuestion::Answered);
}

TEST_CASE("next moves: what is offered together is one conflict") {
  const gen::Compiled c = gen::compile_texts({kClerk});
  INFO(c.problem);
  REQUIRE(c.problem.empty());
  HistoryTally tally;
  compare_moves(c, tally);
  CHECK(tally.with_rows == 1);
}

TEST_CASE("next moves: nothing else happens, in random systems") {
  HistoryTally nets, locks, models;
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
    compare_moves(gen::compile_texts({verify::test::lock_net(seed)}), locks);
  for (std::uint64_t seed = 1; seed <= 150; ++seed)
    compare_moves(gen::compile_texts({verify::test::small_net(seed)}), nets);
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
    compare_moves(gen::compile_texts(gen::print_packages(gen::generate(seed))), models);
  // Of every sort some, or the comparison says little.
  CHECK(nets.with_rows > 0);
  CHECK(locks.with_excluded > 0);
  CHECK(locks.finer > 0);
  CHECK(models.with_rows > 0);
}
