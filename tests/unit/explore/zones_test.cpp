// The zone graph against what it stands for: random small timed systems whose time is explored one tick at a time, with
// nothing but a core, and walks of the core through instants that have no bound.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>
#include <string>

#include "compiler/interp/interp.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/include/bip/prng.hpp"
#include "runtime/explore/zone_search.hpp"
#include "tests/verify/timed_systems.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;
using rt::i64;
using rt::u32;
using rt::u64;

constexpr i64 kCap = rt::testing::kMostConstant + 2;  // clocks beyond it are all alike
constexpr std::size_t kMostTicks = 20000;             // states that are visited tick by tick

// What can be told of a state: markings, data, who is busy, clocks up to the cap.
using Key = std::vector<i64>;

// When a busy atom may go on, in ticks from here; the atoms of a group do so together.
struct Wait {
  u32 atom, group;
  i64 first, last;
};
struct Tick {
  rt::State state;
  std::vector<Wait> waits;
  std::size_t row = 0;  // of Ticks::states
};
// What leads from one state to another one.
struct TickMove {
  std::size_t from = 0, to = kNowhere;  // kNowhere: an error
  std::vector<u32> atoms;               // those who move

  static constexpr std::size_t kNowhere = ~std::size_t{0};
};

struct Ticks {
  std::map<Key, std::size_t> keys;  // rows of states
  std::vector<rt::State> states;
  std::vector<std::size_t> offers;  // rows of states in which no busy atom must resume at this instant
  std::vector<TickMove> moves;
  std::set<Key> places;  // without the clocks
  bool has_deadlock = false, has_lock = false, has_error = false, is_complete = true;
};

Key place_of(const rt::State& state) {
  Key key(state.places.begin(), state.places.end());
  for (const u64 word : state.marks) key.push_back(static_cast<i64>(word));
  for (const u64 word : state.data) key.push_back(static_cast<i64>(word));
  return key;
}

// Time counted from here, clocks cut off.
void normalize(const rt::Image& image, rt::State& state) {
  std::size_t at = 1;
  for (const rt::Atom& atom : image.atoms) {
    const rt::AtomTime* time = image.atom_types[atom.type].time;
    for (u32 k = 0; time != nullptr && k < time->clocks.size; ++k, at += 2)
      state.time[at] = std::min(state.time[at], kCap);
    if (state.time[at] != rt::kForever) state.time[at] -= state.time[0];
    ++at;
  }
  state.time[0] = 0;
}

// max: by clock + 1, beyond it a clock's values are alike.
Key key_of(const rt::Image& image, const rt::State& state, const std::vector<i64>* max = nullptr) {
  Key key = place_of(state);
  std::size_t at = 1, clock = 1;
  for (const rt::Atom& atom : image.atoms) {
    const rt::AtomTime* time = image.atom_types[atom.type].time;
    for (u32 k = 0; time != nullptr && k < time->clocks.size; ++k, ++clock, at += 2) {
      key.push_back(max == nullptr ? state.time[at] : std::min(state.time[at], (*max)[clock] + 1));
    }
    key.push_back(state.time[at++] > 0 ? 1 : 0);
  }
  return key;
}

Ticks explore_ticks(const rt::Image& image) {
  Ticks found;
  rt::Core core(image);
  std::vector<Tick> todo;
  // The core's state, and who waits there. What a tick does not reach is never reached.
  const auto add = [&](std::vector<Wait> waits) {
    Tick tick{core.snapshot(), std::move(waits), found.states.size()};
    normalize(image, tick.state);
    Key key = key_of(image, tick.state);
    for (Wait& wait : tick.waits) {
      wait.first = std::max<i64>(wait.first, 0);
      for (const i64 value : {static_cast<i64>(wait.atom), static_cast<i64>(wait.group), wait.first, wait.last})
        key.push_back(value);
    }
    const auto [known, is_new] = found.keys.try_emplace(key, tick.row);
    if (!is_new) return known->second;
    found.places.insert(place_of(tick.state));
    found.states.push_back(tick.state);
    if (std::none_of(tick.waits.begin(), tick.waits.end(), [](const Wait& wait) { return wait.last == 0; }))
      found.offers.push_back(tick.row);
    todo.push_back(std::move(tick));
    return known->second;
  };
  // Who the core made busy until the first instant is held; false: a fault.
  const auto hold = [&](bool is_together, std::vector<Wait>& waits) {
    const std::vector<u32> resuming = core.time().resuming();
    std::erase_if(waits, [&](const Wait& wait) { return core.time().busy_until(wait.atom) != rt::kForever; });
    for (const u32 atom : resuming) {
      const i64 first = core.time().busy_until(atom);
      const u32 group = is_together ? *std::min_element(resuming.begin(), resuming.end()) : atom;
      const i64 last = core.time().may_resume_until(atom);
      std::erase_if(waits, [&](const Wait& wait) { return wait.atom == atom; });
      if (first <= last && first != rt::kForever)
        waits.push_back({atom, group, first - core.now(), last == rt::kForever ? last : last - core.now()});
      if (!core.time().resume_at(atom, rt::kForever)) return false;
    }
    return true;
  };
  std::vector<Wait> at_start;
  if (!core.initialize() || !hold(false, at_start)) {
    found.has_error = true;
    return found;
  }
  (void)add(std::move(at_start));
  std::vector<i64> ends;
  while (!todo.empty()) {
    if (found.states.size() > kMostTicks) {
      found.is_complete = false;
      return found;
    }
    const Tick tick = std::move(todo.back());
    todo.pop_back();
    const rt::State& here = tick.state;
    std::set<u32> groups;
    bool is_last = false;
    for (const Wait& wait : tick.waits) {
      if (wait.first > 0) continue;
      groups.insert(wait.group);
      is_last = is_last || wait.last == 0;
    }
    for (const u32 group : groups) {
      bool is_sound = core.restore(here);
      std::vector<Wait> waits;
      for (const Wait& wait : tick.waits) {
        if (wait.group != group) waits.push_back(wait);
        else is_sound = is_sound && core.time().resume_at(wait.atom, core.now());
      }
      if (is_sound) found.moves.push_back({tick.row, add(std::move(waits)), {}});
      else found.has_error = true;
    }
    if (!core.restore(here)) {
      found.has_error = true;
      continue;
    }
    const u64 count = core.candidate_count();
    const bool may_wait = !is_last && core.time().wait_limit(ends) > core.now();
    if (count == 0 && !may_wait && !is_last) found.has_lock = true;
    if (may_wait) {
      if (!core.time().advance(core.now() + 1)) {
        found.has_error = true;
      } else {
        rt::State next = core.snapshot();
        normalize(image, next);
        // Who may go on does so some time.
        const bool is_alone =
            std::all_of(tick.waits.begin(), tick.waits.end(), [](const Wait& wait) { return wait.first > 2 * kCap; });
        if (count == 0 && is_alone && key_of(image, next) == key_of(image, here)) found.has_deadlock = true;
        std::vector<Wait> later = tick.waits;
        for (Wait& wait : later) {
          --wait.first;
          if (wait.last != rt::kForever) --wait.last;
        }
        found.moves.push_back({tick.row, add(std::move(later)), {}});
      }
    }
    for (u64 k = 0; k < count; ++k) {
      REQUIRE(core.restore(here));
      const rt::Candidate candidate = core.candidate(k);
      const bool is_together =
          candidate.connector != rt::kNone && core.tables().connector_type(candidate.connector).resume_sync;
      std::vector<rt::Participant> participants;
      core.participants(candidate, participants);
      TickMove move{tick.row, TickMove::kNowhere, {}};
      for (const rt::Participant& participant : participants) move.atoms.push_back(participant.atom);
      std::vector<Wait> waits = tick.waits;
      if (core.time().take(core.position(k)) && hold(is_together, waits)) move.to = add(std::move(waits));
      else found.has_error = true;
      found.moves.push_back(std::move(move));
    }
  }
  return found;
}

struct ZoneTally {
  int compared = 0, deadlocks = 0, locks = 0, errors = 0, asked = 0, were_so = 0, were_stuck = 0, were_stuck_alone = 0;
  u64 states = 0, zones = 0, walked = 0;
};

bool has_point(rt::ZoneSearch& search, const rt::Image& image, const rt::State& state) {
  std::vector<i64> point{0};
  std::vector<bool> is_busy;
  std::size_t at = 1;
  for (const rt::Atom& atom : image.atoms) {
    const rt::AtomTime* time = image.atom_types[atom.type].time;
    for (u32 k = 0; time != nullptr && k < time->clocks.size; ++k, at += 2) point.push_back(state.time[at]);
    is_busy.push_back(state.time[at++] > state.time[0]);
  }
  for (const rt::ZoneNode& node : search.nodes()) {
    const rt::Location& location = search.locations()[node.location];
    if (place_of(location.state) != place_of(state)) continue;
    bool is_inside = true;
    for (std::size_t atom = 0; atom < is_busy.size(); ++atom)
      is_inside = is_inside && (location.waits[atom] != rt::kNone) == is_busy[atom];
    for (u32 i = 0; i < point.size() && is_inside; ++i) {
      for (u32 j = 0; j < point.size(); ++j)
        is_inside =
            is_inside && (i == j || node.zone.at(i, j) == rt::Zone::kInf || point[i] - point[j] <= node.zone.at(i, j));
    }
    if (is_inside) return true;
  }
  return false;
}

// Any instant that may be, not only those that a policy plans.
void walk(rt::ZoneSearch& search, const rt::Image& image, u64 seed, ZoneTally& tally) {
  rt::Core core(image);
  rt::Prng random(seed);
  REQUIRE(core.initialize());
  std::vector<i64> ends;
  for (int step = 0; step < 40; ++step) {
    INFO("walk " << seed << ", step " << step << ", at " << core.now());
    REQUIRE(has_point(search, image, core.snapshot()));
    ++tally.walked;
    const u64 count = core.candidate_count();
    const i64 limit = std::min({core.time().wait_limit(ends), core.time().next_change(), core.now() + 3});
    if (limit > core.now() && (count == 0 || random.below(2) == 0)) {
      if (!core.time().advance(core.now() + 1 + static_cast<i64>(random.below(static_cast<u64>(limit - core.now())))))
        return;
    } else if (count == 0 || !core.time().take(core.position(random.below(count)))) {
      return;
    }
  }
}

// Is there an instant at which a connector has (or has not) a candidate while a port is enabled (or is not)?
void ask(const rt::Image& image, const Ticks& ticks, u64 seed, ZoneTally& tally) {
  rt::Core core(image);
  rt::Prng random(seed);
  for (int round = 0; round < 6; ++round) {
    const u32 connector = static_cast<u32>(random.below(image.connectors.size)),
              atom = static_cast<u32>(random.below(image.atoms.size));
    const rt::AtomType& type = image.atom_types[image.atoms[atom].type];
    if (type.ports.size == 0) continue;
    const u32 port = static_cast<u32>(random.below(type.ports.size));
    const bool wants_candidate = random.below(2) == 0, wants_port = random.below(2) == 0;
    const auto is_so = [=](const rt::Core& at) {
      bool has_candidate = false;
      for (u64 k = 0; k < at.candidate_count(); ++k)
        has_candidate = has_candidate || at.candidate(k).connector == connector;
      return has_candidate == wants_candidate && (at.enabled_transition(atom, port) != rt::kNone) == wants_port;
    };
    const bool is_expected = std::any_of(ticks.offers.begin(), ticks.offers.end(), [&](std::size_t row) {
      return core.restore(ticks.states[row]) && is_so(core);
    });
    const rt::ZoneReport found = rt::explore_zones(
        image, {.limit = 200000, .predicate = is_so, .predicate_connectors = {connector}, .predicate_atoms = {atom}});
    INFO("asked: connector " << connector << (wants_candidate ? "" : " not") << ", port " << port << " of atom " << atom
                             << (wants_port ? "" : " not"));
    REQUIRE(found.has_match == is_expected);
    REQUIRE(found.are_paths_known);
    ++tally.asked;
    tally.were_so += is_expected ? 1 : 0;
  }
}

// Which atoms want to move in some state, and never do.
std::set<u32> stuck_atoms(const rt::Image& image, const Ticks& ticks) {
  rt::Core core(image);
  std::set<u32> stuck;
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    std::vector<bool> is_moved(ticks.states.size(), false);
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (const TickMove& move : ticks.moves) {
        const bool moves = std::find(move.atoms.begin(), move.atoms.end(), atom) != move.atoms.end() ||
                           (move.to != TickMove::kNowhere && is_moved[move.to]);
        if (!moves || is_moved[move.from]) continue;
        is_moved[move.from] = is_changed = true;
      }
    }
    for (const std::size_t row : ticks.offers) {
      if (!is_moved[row] && core.restore(ticks.states[row]) && rt::wants_to_move(core, atom)) stuck.insert(atom);
    }
  }
  return stuck;
}

void compare_local_deadlocks(const rt::Image& image, const Ticks& ticks, ZoneTally& tally) {
  const std::set<u32> stuck = stuck_atoms(image, ticks);
  const rt::ZoneReport found = rt::explore_local_deadlocks(image, {.limit = 200000});
  REQUIRE(found.end == rt::ExploreEnd::Complete);
  REQUIRE(found.has_match == !stuck.empty());
  REQUIRE(found.are_paths_known);
  REQUIRE(found.stuck.empty() == stuck.empty());
  for (const u32 atom : found.stuck) REQUIRE(stuck.count(atom) == 1);
  if (!stuck.empty()) ++tally.were_stuck;
  if (found.stuck.size() == 1) ++tally.were_stuck_alone;
}

void compare(u64 seed, ZoneTally& tally) {
  const std::string text = rt::testing::random_timed_system(seed);
  const gen::Compiled c = gen::compile_texts({text});
  INFO("seed " << seed << "\n" << text);
  // Two transitions that are sure to collide do not compile.
  if (!c.problem.empty()) return;
  const interp::Interpreter interpreter(*c.lowered);
  const rt::Image& image = c.lowered->image;
  const Ticks ticks = explore_ticks(image);
  if (!ticks.is_complete) return;
  rt::ZoneSearch search(image, {.limit = 200000});
  const rt::ZoneReport found = search.run();
  REQUIRE(found.inexact == "");
  REQUIRE(found.end == rt::ExploreEnd::Complete);
  ++tally.compared;
  tally.states += ticks.states.size();
  tally.zones += found.zones;
  tally.deadlocks += ticks.has_deadlock ? 1 : 0;
  tally.locks += ticks.has_lock ? 1 : 0;
  tally.errors += ticks.has_error ? 1 : 0;
  REQUIRE(found.has_error == ticks.has_error);
  REQUIRE(found.has_deadlock == ticks.has_deadlock);
  REQUIRE(found.has_time_lock == ticks.has_lock);
  REQUIRE(found.are_paths_known);
  // What the graph cannot tell apart is not told apart here either.
  std::set<Key> places, reached;
  const std::vector<i64>& max = search.locations().max();
  for (const rt::State& state : ticks.states) reached.insert(key_of(image, state, &max));
  for (const rt::ZoneNode& node : search.nodes()) {
    const rt::Location& location = search.locations()[node.location];
    places.insert(place_of(location.state));
    if (node.is_faulty && node.is_covered) continue;
    rt::State point = search.locations().point(location, node.zone.least_point());
    normalize(image, point);
    // What is wrong, if it is.
    std::string what =
        "a node after " + std::to_string(node.parent) + ", edge " + std::to_string(static_cast<int>(node.edge)) + ":";
    for (const i64 value : key_of(image, point, &max)) what += ' ' + std::to_string(value);
    INFO(what);
    REQUIRE(reached.count(key_of(image, point, &max)) == 1);
  }
  REQUIRE(places == ticks.places);
  if (ticks.has_error && found.zones == 0) return;
  ask(image, ticks, seed, tally);
  compare_local_deadlocks(image, ticks, tally);
  for (u64 k = 1; k <= 3; ++k) walk(search, image, seed * 8 + k, tally);
}

}  // namespace

TEST_CASE("zone graphs of random timed systems are their behaviour tick by tick") {
  ZoneTally tally;
  const char* wanted = std::getenv("BIP_ZONE_RUNS");
  const u64 runs = wanted == nullptr ? 120 : std::strtoull(wanted, nullptr, 10);
  for (u64 seed = 1; seed <= runs; ++seed) compare(seed, tally);
  WARN("compared " << tally.compared << " (" << tally.states << " states tick by tick, " << tally.zones
                   << " zones), with deadlock " << tally.deadlocks << ", with time lock " << tally.locks
                   << ", with error " << tally.errors << ", states walked " << tally.walked << ", asked " << tally.asked
                   << ", so " << tally.were_so << ", with local deadlock " << tally.were_stuck);
  CHECK(tally.compared > static_cast<int>(runs) / 2);
  CHECK(tally.deadlocks > 0);
  CHECK(tally.locks > 0);
  CHECK(tally.were_so > 0);
  CHECK(tally.were_so < tally.asked);
  CHECK(tally.were_stuck > 0);
  CHECK(tally.were_stuck_alone > 0);
  CHECK(tally.were_stuck < tally.compared);
}
