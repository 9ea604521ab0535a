// What a core keeps up step by step equals what a fresh core computes from the state alone: on random systems with all
// the kinds of atoms and connectors, with and without priorities, and on the classic ones.
#include <catch2/catch.hpp>

#include <random>

#include "tests/unit/runtime/helpers.hpp"
#include "tests/unit/runtime/models.hpp"

using namespace bip::rt;
using namespace bip::rt::testing;

namespace {

// Returns how many steps were taken.
int check_run(const Image& image, unsigned seed, int steps) {
  std::mt19937 random(seed);
  Core core(image), fresh(image);
  REQUIRE(core.initialize());
  std::vector<State> seen;
  for (int i = 0; i < steps; ++i) {
    const Strings now = candidates(core);
    if (i % 7 == 0) {
      REQUIRE(fresh.restore(core.snapshot()));
      REQUIRE(candidates(fresh) == now);
      Core other(image);
      REQUIRE(other.restore(core.snapshot()));
      REQUIRE(candidates(other) == now);
    }
    if (i % 31 == 30) {
      // Back to some earlier state and forth again.
      const State here = core.snapshot();
      REQUIRE(core.restore(seen[random() % seen.size()]));
      REQUIRE(core.restore(here));
      REQUIRE(candidates(core) == now);
    }
    seen.push_back(core.snapshot());
    if (now.empty()) return i;
    REQUIRE(core.fire(std::uint64_t{random() % core.candidate_count()}));
  }
  return steps;
}

// Atoms of random automata: simple, fixed, guarded or Petri by what comes up.
void build_random(ImageBuilder& b, unsigned seed) {
  std::mt19937 random(seed);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  const int types = 2, atoms = 5, ports = 3, places = 3;
  for (int t = 0; t < types; ++t) {
    AtomTypeSpec type{.name = "T" + std::to_string(t), .data = {"n"}};
    const int kind = below(4);  // 0 simple, 1 fixed, 2 guarded, 3 Petri
    for (int p = 0; p < ports; ++p) {
      type.ports.push_back({.name = "p" + std::to_string(p), .vars = {}, .exported = below(8) != 0});
      if (below(2) == 0) type.ports.back().vars.push_back("n");
    }
    for (int p = 0; p < places; ++p) type.places.push_back("S" + std::to_string(p));
    type.initial = {"S0"};
    const auto place = [&](int p) { return "S" + std::to_string(p); };
    const auto action = [&]() -> Fn {
      if (below(2) == 0) return nullptr;
      const int add = below(3);
      return [add](Cell* self, Cell*, const u32*) {
        self[0].i = (self[0].i + add) % 5;
        return 1;
      };
    };
    for (int p = 0; p < ports; ++p) {
      const int from = below(places);
      type.transitions.push_back({"p" + std::to_string(p), {place(from)}, {place(below(places))}, nullptr, action()});
      if (kind >= 1)
        type.transitions.push_back(
            {"p" + std::to_string(p), {place((from + 1) % places)}, {place(below(places))}, nullptr, action()});
      if (kind == 2) {
        const int limit = below(5);
        type.transitions.back().guard = [limit](Cell* self, Cell*, const u32*) { return self[0].i <= limit ? 1 : 0; };
      }
    }
    if (kind == 3) {
      type.places.push_back("X");
      type.initial = {"S0", "X"};
      for (TransitionSpec& transition : type.transitions) {
        if (below(2) != 0) continue;
        transition.from.push_back("X");
        transition.to.push_back("X");
      }
    }
    b.atom_type(type);
  }
  std::vector<int> atom_types;
  for (int a = 0; a < atoms; ++a) {
    atom_types.push_back(below(types));
    b.atom("a" + std::to_string(a), "T" + std::to_string(atom_types.back()));
  }
  std::vector<std::string> names;
  for (int c = 0; c < 7; ++c) {
    const int size = 1 + below(3);
    std::vector<int> chosen;
    while (static_cast<int>(chosen.size()) < size) {
      const int atom = below(atoms);
      if (std::find(chosen.begin(), chosen.end(), atom) == chosen.end()) chosen.push_back(atom);
    }
    ConnectorTypeSpec type{.name = "C" + std::to_string(c)};
    std::vector<std::string> bound;
    const bool triggers = below(2) == 0;
    for (int p = 0; p < size; ++p) {
      const std::string name = "q" + std::to_string(p);
      type.params.emplace_back(name, 0);
      type.define += name + (triggers && below(2) == 0 ? "' " : " ");
      bound.push_back("a" + std::to_string(chosen[static_cast<std::size_t>(p)]) + ".p" + std::to_string(below(ports)));
    }
    names.push_back("k" + std::to_string(c));
    // The variables' offsets depend on the ports bound; a guard reads the last row, which is a read.
    std::vector<std::string> reads;
    if (below(2) == 0) {
      const int limit = below(5);
      reads.push_back("a" + std::to_string(chosen[0]) + ".n");
      ClauseSpec clause;
      for (const auto& [name, vars] : type.params) clause.params.push_back(name);
      u32 row = 0;
      for (const std::string& port : bound) row += b.port_vars(port);
      for (std::size_t p = 0; p < type.params.size(); ++p) type.params[p].second = b.port_vars(bound[p]);
      clause.guard = [limit, row](Cell*, Cell* all, const u32* bind) { return all[bind[row]].i <= limit ? 1 : 0; };
      // Is it an interaction of `define`? All parameters always are.
      type.clauses.push_back(clause);
    } else {
      for (std::size_t p = 0; p < type.params.size(); ++p) type.params[p].second = b.port_vars(bound[p]);
    }
    b.connector_type(type);
    b.connector(names.back(), type.name, bound, reads);
  }
  const int rules = below(4);
  for (int r = 0; r < rules; ++r) {
    const int low = below(6);
    const int high = low + 1 + below(6 - low);
    Fn guard = nullptr;
    std::vector<std::string> reads;
    if (below(2) == 0) {
      guard = [](Cell*, Cell* all, const u32* bind) { return all[bind[0]].i % 2; };
      reads.push_back("a0.n");
    }
    const bool wild = r == 0 && below(4) == 0 && low == 0;
    b.priority("r" + std::to_string(r), {.connector = names[static_cast<std::size_t>(low)]},
               wild ? PatternSpec{} : PatternSpec{.connector = names[static_cast<std::size_t>(high)]}, guard, reads);
  }
}

}  // namespace

TEST_CASE("incremental equals from scratch on the classic systems") {
  for (const int n : {2, 3, 10, 100}) {
    ImageBuilder phil, ring, pairs, dead;
    build_philosophers(phil, n, false);
    build_philosophers(dead, n, true);
    build_ring(ring, n);
    build_pairs(pairs, n);
    for (ImageBuilder* b : {&phil, &ring, &pairs, &dead}) CHECK(check_run(b->image(), 1, 200) > 0);
  }
}

TEST_CASE("incremental equals from scratch on random systems") {
  int taken = 0;
  for (unsigned seed = 0; seed < 600; ++seed) {
    CAPTURE(seed);
    ImageBuilder b;
    build_random(b, seed);
    taken += check_run(b.image(), seed, 60);
  }
  CHECK(taken > 3000);
}
