// Proofs by parts against whole zone graphs, on random timed systems: what is proved must hold. And what a part shows
// must hold all that the whole does.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <string>

#include "compiler/interp/interp.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/verify/timed/time_divergence.hpp"
#include "compiler/verify/timed/localization.hpp"
#include "compiler/verify/timed/prove_time.hpp"
#include "compiler/verify/net/unread_data.hpp"
#include "runtime/explore/zone_search.hpp"
#include "tests/verify/timed_systems.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/description.hpp"

namespace {

using namespace bip;
using rt::u32;
using rt::u64;

rt::PartReport explore(const System& part, const rt::ExploreOptions& options, const rt::PartQuestion& question) {
  const std::unique_ptr<lower::LoweredSystem> lowered = lower::lower(part, "part");
  const interp::Interpreter interpreter(*lowered);
  return rt::explore_part(lowered->image, options, question);
}

struct TimedTally {
  int compared = 0, proved = 0, free = 0, with_parts = 0, smaller = 0, walks = 0, asked = 0, holding = 0, broken = 0;
};

// Markings and who holds which clocks are a point of some node of the part.
bool has_point(rt::ZoneSearch& search, const std::vector<u32>& members, const rt::Core& core) {
  std::vector<rt::i64> point{0};
  for (const u32 atom : members) {
    const rt::AtomTime* time = core.image().atom_types[core.image().atoms[atom].type].time;
    for (u32 k = 0; time != nullptr && k < time->clocks.size; ++k)
      point.push_back(static_cast<rt::i64>(core.time().clock_value(atom, k)));
  }
  const rt::State whole = core.snapshot();
  for (const rt::ZoneNode& node : search.nodes()) {
    const rt::Location& location = search.locations()[node.location];
    bool fits = true;
    for (u32 row = 0; row < members.size() && fits; ++row)
      fits = location.state.places[row] == whole.places[members[row]];
    for (u32 i = 0; i < point.size() && fits; ++i) {
      for (u32 j = 0; j < point.size() && fits; ++j)
        fits = i == j || node.zone.at(i, j) == rt::Zone::kInf || point[i] - point[j] <= node.zone.at(i, j);
    }
    if (fits) return true;
  }
  return false;
}

// Two components are never in two places at once, or with these data.
void ask(const System& system, const rt::Image& image, u64 seed, TimedTally& tally) {
  rt::Prng random(seed);
  const auto literal = [&](u32 atom) {
    const rt::AtomType& type = image.atom_types[image.atoms[atom].type];
    const std::string path = image.atoms[atom].path().substr(5);
    std::vector<std::string> ints;
    for (const rt::Var& var : type.variables) {
      if (var.type == rt::CellType::Int && std::string(var.name).find('(') == std::string::npos)
        ints.emplace_back(var.name);
    }
    if (!ints.empty() && random.below(3) == 0)
      return path + '.' + ints[random.below(ints.size())] + (random.below(2) == 0 ? " > " : " == ") +
             std::to_string(random.below(4));
    return path + '@' + type.places[random.below(type.places.size)];
  };
  const u32 first = static_cast<u32>(random.below(image.atoms.size)),
            second = static_cast<u32>(random.below(image.atoms.size));
  const std::string text = "never " + literal(first) + (random.below(2) == 0 ? " && " : " && !(") + literal(second);
  const Result<verify::Property> property =
      verify::parse_property(text + (text.find("!(") == std::string::npos ? "" : ")"), system);
  if (!property) return;
  const rt::ZoneReport whole = rt::explore_zones(
      image, {.limit = 20000, .predicate = [&](const rt::Core& core) { return verify::is_broken(*property, core); }});
  ++tally.asked;
  for (const std::size_t members : {std::size_t{2}, std::size_t{6}}) {
    const verify::TimeProof proof = verify::prove_state_in_time(system, *property, explore, verify::within_seconds(60),
                                                                {.members = members, .zones = 20000});
    INFO((*property).text << ", members " << members << ", reason: " << proof.reason);
    if (proof.is_proved) REQUIRE_FALSE(whole.has_match);
    if (members == 6) tally.holding += proof.is_proved ? 1 : 0;
  }
  tally.broken += whole.has_match ? 1 : 0;
}

// Random runs of the whole, seen through two components.
void walk(const System& system, const rt::Image& image, u64 seed, TimedTally& tally) {
  rt::Prng random(seed);
  const auto is_read = verify::find_read_data(system);
  const System simple = verify::without_unread_data(system, is_read);
  const verify::Neighbours neighbours(simple);
  const verify::VariableFacts no_facts = [](u32, u32) { return verify::AbstractValue{}; };
  std::vector<u32> members{static_cast<u32>(random.below(image.atoms.size - 1))};
  members.push_back(members[0] + 1 + static_cast<u32>(random.below(image.atoms.size - 1 - members[0])));
  verify::LocalizedSystem part = verify::localize(simple, neighbours, is_read, no_facts, members);
  if (!part.required.empty()) {
    members = part.required;
    part = verify::localize(simple, neighbours, is_read, no_facts, members);
  }
  if (!part.obstacle.empty() || !part.required.empty()) return;
  REQUIRE(system::validate(part.system).empty());
  const std::unique_ptr<lower::LoweredSystem> lowered = lower::lower(part.system, "part");
  const interp::Interpreter interpreter(*lowered);
  if (!rt::has_time(lowered->image)) return;
  const rt::PartQuestion question{
      .atom = 0, .is_whole = std::vector<std::uint8_t>(part.is_whole.size(), 1), .is_impossible = {}, .is_asked = {}};
  rt::ZoneSearch search(lowered->image, {.limit = 20000}, &question);
  const rt::PartReport found = search.run_part();
  if (!found.is_complete || found.is_open) return;
  rt::Core core(image);
  REQUIRE(core.initialize());
  std::vector<rt::i64> ends;
  for (int step = 0; step < 60; ++step) {
    INFO("walk " << seed << ", step " << step << ", at " << core.now());
    REQUIRE(has_point(search, members, core));
    ++tally.walks;
    const u64 count = core.candidate_count();
    const rt::i64 limit = std::min({core.time().wait_limit(ends), core.time().next_change(), core.now() + 3});
    if (limit > core.now() && (count == 0 || random.below(2) == 0)) {
      if (!core.time().advance(core.now() + 1 +
                               static_cast<rt::i64>(random.below(static_cast<u64>(limit - core.now())))))
        return;
    } else if (count == 0 || !core.time().take(core.position(random.below(count)))) {
      return;
    }
  }
}

void compare(const std::vector<std::string>& texts, u64 seed, TimedTally& tally) {
  const gen::Compiled c = gen::compile_texts(texts);
  if (!c.problem.empty() || !rt::has_time(c.lowered->image) ||
      !verify::obstacle_to_time_divergent_limit(*c.system).empty())
    return;
  INFO("seed " << seed << "\n" << texts.back());
  const interp::Interpreter interpreter(*c.lowered);
  const rt::Image& image = c.lowered->image;
  const rt::ZoneReport whole = rt::explore_zones(image, {.limit = 20000});
  if (!whole.inexact.empty()) return;
  ++tally.compared;
  const bool is_free = whole.end == rt::ExploreEnd::Complete && !whole.has_deadlock && !whole.has_time_lock;
  tally.free += is_free ? 1 : 0;
  for (const std::size_t members : {std::size_t{2}, std::size_t{3}, std::size_t{6}}) {
    const verify::TimeProof proof =
        verify::prove_time(*c.system, explore, verify::within_seconds(60), {.members = members, .zones = 20000});
    INFO("members " << members << ", reason: " << proof.reason);
    if (!proof.is_proved) continue;
    REQUIRE_FALSE(whole.has_deadlock);
    REQUIRE_FALSE(whole.has_time_lock);
    tally.proved += members == 6 ? 1 : 0;
    tally.with_parts += members == 6 && proof.neighbourhoods != 0 ? 1 : 0;
    tally.smaller += proof.largest > 1 && proof.largest < image.atoms.size ? 1 : 0;
  }
  for (u64 k = 1; k <= 4; ++k) ask(*c.system, image, seed * 16 + k, tally);
  for (u64 k = 1; k <= 3 && image.atoms.size > 1; ++k) walk(*c.system, image, seed * 8 + k, tally);
}

u64 wanted_runs(u64 usual) {
  const char* wanted = std::getenv("BIP_ZONE_RUNS");
  return wanted == nullptr ? usual : std::strtoull(wanted, nullptr, 10);
}

void counterexample_text(const TimedTally& tally) {
  WARN("compared " << tally.compared << ", free " << tally.free << ", proved " << tally.proved
                   << ", of these with neighbourhoods " << tally.with_parts << ", with small ones " << tally.smaller
                   << "; states walked " << tally.walks << "; properties " << tally.asked << ", proved "
                   << tally.holding << ", broken " << tally.broken);
}

}  // namespace

TEST_CASE("what parts prove of random timed systems holds in their zone graphs") {
  TimedTally tally;
  const u64 runs = wanted_runs(300);
  for (u64 seed = 1; seed <= runs; ++seed) compare({rt::testing::random_timed_system(seed, seed % 3)}, seed, tally);
  counterexample_text(tally);
  CHECK(tally.compared > static_cast<int>(runs) / 2);
  CHECK(tally.with_parts > 0);
  CHECK(tally.smaller > 0);
  CHECK(tally.walks > 1000);
  CHECK(tally.holding > 0);
  CHECK(tally.broken > 0);
}

// With data, guards, transfers, hierarchies, merged ports, Petri nets.
TEST_CASE("what parts prove of the generator's timed systems holds in their zone graphs") {
  TimedTally tally;
  const u64 runs = wanted_runs(400);
  for (u64 seed = 1; seed <= runs; ++seed)
    compare(gen::print_packages(gen::generate(seed, gen::Features::Timed)), seed, tally);
  counterexample_text(tally);
  CHECK(tally.compared > static_cast<int>(runs) / 40);
  CHECK(tally.proved > 0);
}
