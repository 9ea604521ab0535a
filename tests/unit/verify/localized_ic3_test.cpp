// IC3 that follows few atoms: what it proves holds of the whole system, and it follows no more than it needs.
#include <catch2/catch.hpp>

#include <algorithm>

#include "compiler/verify/invariants/houdini.hpp"
#include "compiler/verify/invariants/refine_invariants.hpp"
#include "compiler/verify/symbolic/localized_ic3.hpp"
#include "compiler/verify/symbolic/mode_signals.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"
#include "tests/verify/small_net.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/description.hpp"
#include "tools/gen/random.hpp"

namespace bip::verify {

namespace {

enum class Invariants : std::uint8_t { None, OnDemand };

/// One system, as often as it is asked about.
class LocalizedCase {
 public:
  LocalizedCase(const System& system, const rt::Image& image)
      : image_(image), net_(build_net(system)), system_(build_transition_system(system, image)) {}

  [[nodiscard]] TransitionSystem& system() { return system_; }
  [[nodiscard]] std::size_t atoms() const { return net_.mode_base.size() - 1; }

  LocalizedAnswer ask(Signal bad, Invariants invariants, std::size_t max_atoms) {
    Proof proof = find_reachable_modes(net_);
    problem_ = {};
    problem_.system = &system_;
    problem_.bad = bad;
    problem_.cancellation = within_seconds(5);
    InvariantRefiner refiner(net_, system_, image_, problem_.cancellation, proof);
    return run_localized_ic3(problem_, system_, net_.graph.atom_of_port, max_atoms, [&](Signal states) {
      const std::size_t before = proof.invariants.size();
      if (invariants == Invariants::None || !refiner.exclude(states) || proof.invariants.size() == before) return false;
      problem_.invariants = mode_clauses(net_, proof, system_, image_);
      return true;
    });
  }
  /// Of the last question: are the lemmas a proof of the whole system?
  [[nodiscard]] bool is_proof(const std::vector<Cube>& lemmas) const {
    if (lemmas.empty()) {
      Ic3Problem whole = problem_;
      return run_ic3(whole).end == Ic3End::Safe;
    }
    const InductiveLemmas again = houdini(problem_, lemmas);
    return again.is_enough && again.lemmas.size() == lemmas.size();
  }

 private:
  const rt::Image& image_;
  Net net_;
  TransitionSystem system_;
  Ic3Problem problem_;
};

struct Tally {
  int safe = 0, reached = 0, open = 0, with_fewer_atoms = 0;
};

// Two places, both marked: what IC3 says of the whole, and what it says with few atoms.
void compare(const gen::Compiled& c, std::uint64_t seed, Tally& tally) {
  if (!c.problem.empty() || c.system->code.has_cpp()) return;
  LocalizedCase asked(*c.system, c.lowered->image);
  TransitionSystem& system = asked.system();
  if (!system.unsupported.empty() || system.starts_with_fault || asked.atoms() < 2) return;
  if (!ranges_hold(system, within_seconds(2))) return;
  gen::Prng random(seed);
  const std::size_t a = random.below(asked.atoms()), b = random.below(asked.atoms());
  if (system.marks[a].empty() || system.marks[b].empty()) return;
  const Signal bad = system.aig.make_and(random.pick(system.marks[a]), random.pick(system.marks[b]));
  Ic3Problem whole;
  whole.system = &system;
  whole.bad = system.aig.make_or(bad, system.lost);
  whole.cancellation = within_seconds(5);
  const Ic3End known = run_ic3(whole).end;
  for (const Invariants invariants : {Invariants::None, Invariants::OnDemand}) {
    const LocalizedAnswer found = asked.ask(whole.bad, invariants, asked.atoms());
    INFO("seed " << seed << ", rounds " << found.rounds);
    if (known == Ic3End::Stopped || found.answer.end == Ic3End::Stopped) {
      ++tally.open;
      continue;
    }
    CHECK(found.answer.end == known);
    if (found.answer.end == Ic3End::Safe) CHECK(asked.is_proof(found.answer.lemmas));
    ++(known == Ic3End::Safe ? tally.safe : tally.reached);
    if (found.followed_atoms.size() < asked.atoms()) ++tally.with_fewer_atoms;
  }
}

const std::string kMoreUsers =
    "component User w(), x()\n"
    "connector Two ew(w.enter, lock.take), lw(w.leave, lock.give), ex(x.enter, lock.take), lx(x.leave, lock.give)\n"
    "connector Two away(w.enter, x.enter)";

}  // namespace

TEST_CASE("localized IC3: atoms are followed when a counterexample needs them") {
  const test::HandMadeNet made(test::lock_and_users("", kMoreUsers));
  LocalizedCase asked(*made.compiled.system, made.compiled.lowered->image);
  TransitionSystem& system = asked.system();
  // `w` and `x` may both be in, and leave when `u` is in.
  const Signal u_and_v = system.aig.make_and(system.marks[1][1], system.marks[2][1]);
  CHECK(asked.ask(u_and_v, Invariants::None, 5).answer.end == Ic3End::Reached);
  const Signal w_alone = system.aig.make_and(system.marks[3][0], system.marks[3][1]);
  const LocalizedAnswer at_once = asked.ask(w_alone, Invariants::None, 5);
  CHECK(at_once.answer.end == Ic3End::Safe);
  CHECK(at_once.rounds == 1);
}

TEST_CASE("localized IC3: a proof from few atoms, and fewer with invariants") {
  const std::string more =
      "component User w(), x()\n"
      "connector Two ew(w.enter, lock.take), lw(w.leave, lock.give), ex(x.enter, lock.take), lx(x.leave, lock.give)\n"
      "component User far()\n"
      "connector One ef(far.enter), lf(far.leave)";
  const test::HandMadeNet made(test::lock_and_users("", more));
  LocalizedCase asked(*made.compiled.system, made.compiled.lowered->image);
  const Signal both_in = asked.system().aig.make_and(asked.system().marks[1][1], asked.system().marks[2][1]);
  const LocalizedAnswer alone = asked.ask(both_in, Invariants::None, 6);
  REQUIRE(alone.answer.end == Ic3End::Safe);
  CHECK(asked.is_proof(alone.answer.lemmas));
  // All that share the lock, and not the one that is far away.
  CHECK(alone.followed_atoms == std::vector<u32>{0, 1, 2, 3, 4});
  const LocalizedAnswer helped = asked.ask(both_in, Invariants::OnDemand, 6);
  REQUIRE(helped.answer.end == Ic3End::Safe);
  CHECK(helped.followed_atoms == std::vector<u32>{1, 2});
  // Too few are allowed.
  CHECK(asked.ask(both_in, Invariants::None, 3).answer.end == Ic3End::Stopped);
}

TEST_CASE("localized IC3 agrees with IC3 on random systems") {
  Tally nets, models;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    compare(gen::compile_texts({test::small_net(seed)}), seed, nets);
    compare(gen::compile_texts(gen::print_packages(gen::generate(seed))), seed, models);
  }
  WARN("small nets: safe " << nets.safe << ", reached " << nets.reached << ", open " << nets.open
                           << ", fewer atoms followed " << nets.with_fewer_atoms << "; random models: safe "
                           << models.safe << ", reached " << models.reached << ", open " << models.open
                           << ", fewer atoms followed " << models.with_fewer_atoms);
  for (const Tally& tally : {nets, models}) {
    CHECK(tally.safe > 0);
    CHECK(tally.reached > 0);
    CHECK(tally.with_fewer_atoms > 0);
  }
}

}  // namespace bip::verify
