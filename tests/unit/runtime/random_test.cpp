// The core against a naive reference: random trees of connectors with random guards over the choice, all interactions
// by brute force from the definition (compiler/docs/language_meaning.md, sections 4 and 5), on thousands of random
// systems.
#include <algorithm>
#include <catch2/catch.hpp>

#include <random>
#include <set>

#include "tests/unit/runtime/helpers.hpp"

using namespace bip::rt;
using namespace bip::rt::testing;

namespace {

struct Node {
  bool leaf = false, trigger = false;
  int param = 0;
  std::vector<Node> children;
};
struct RandomConnector {
  Node root;
  std::vector<int> atom;   // by parameter; -1: a connector
  std::vector<int> below;  // by parameter: connector
  std::vector<bool> maximal;
  std::map<std::set<int>, int> guard;  // clause -> residue: its guard is (sum over bound data + own) % 3 != residue
  bool exports = false;
};
using Leaves = std::set<int>;  // atoms
struct Alternative {
  Leaves leaves;
  int value = 0;  // what the exported port shows
};

struct Reference {
  std::vector<RandomConnector> connectors;
  std::vector<bool> ready;  // by atom
  std::vector<int> data;    // by atom

  static std::vector<std::set<int>> choices(const Node& node) {
    if (node.leaf) return {{node.param}};
    bool any_trigger = false;
    for (const Node& child : node.children) any_trigger |= child.trigger;
    std::vector<std::set<int>> out;
    const std::size_t n = node.children.size();
    for (std::size_t mask = 1; mask < (std::size_t{1} << n); ++mask) {
      bool trigger = false;
      for (std::size_t i = 0; i < n; ++i) trigger |= (mask >> i & 1) != 0 && node.children[i].trigger;
      if (any_trigger ? !trigger : mask + 1 != (std::size_t{1} << n)) continue;
      std::vector<std::set<int>> combined{{}};
      for (std::size_t i = 0; i < n; ++i) {
        if ((mask >> i & 1) == 0) continue;
        std::vector<std::set<int>> next;
        for (const std::set<int>& left : combined) {
          for (const std::set<int>& right : choices(node.children[i])) {
            next.push_back(left);
            next.back().insert(right.begin(), right.end());
          }
        }
        combined = next;
      }
      out.insert(out.end(), combined.begin(), combined.end());
    }
    return out;
  }
  static std::vector<Alternative> maximal(const std::vector<Alternative>& all) {
    std::vector<Alternative> out;
    for (const Alternative& a : all) {
      bool dominated = false;
      for (const Alternative& other : all) {
        dominated |= a.leaves != other.leaves &&
                     std::includes(other.leaves.begin(), other.leaves.end(), a.leaves.begin(), a.leaves.end());
      }
      if (!dominated) out.push_back(a);
    }
    return out;
  }
  // Every enabled interaction of the connector with every combination of alternatives below.
  std::vector<Alternative> enabled(int row) const {
    const RandomConnector& connector = connectors[static_cast<std::size_t>(row)];
    std::vector<Alternative> out;
    for (const std::set<int>& params : choices(connector.root)) {
      std::vector<Alternative> combined{{}};
      for (int param : params) {
        const auto p = static_cast<std::size_t>(param);
        std::vector<Alternative> offered;
        if (connector.atom[p] >= 0) {
          const auto atom = static_cast<std::size_t>(connector.atom[p]);
          if (ready[atom]) offered.push_back({{connector.atom[p]}, data[atom]});
        } else {
          offered = enabled(connector.below[p]);
          if (connector.maximal[p]) offered = maximal(offered);
        }
        std::vector<Alternative> next;
        for (const Alternative& left : combined) {
          for (const Alternative& right : offered) {
            next.push_back(left);
            next.back().leaves.insert(right.leaves.begin(), right.leaves.end());
            next.back().value += right.value;
          }
        }
        combined = next;
      }
      const auto clause = connector.guard.find(params);
      for (Alternative& alternative : combined) {
        // Without a clause there is no transfer: the port shows zero.
        if (clause == connector.guard.end()) alternative.value = 0;
        else if (alternative.value % 3 == clause->second) continue;
        out.push_back(alternative);
      }
    }
    return out;
  }
};

class Generator {
 public:
  explicit Generator(unsigned seed) : random_(seed) {}
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  bool chance(int percent) { return below(100) < percent; }

  Node tree(int& params, int depth) {
    Node group;
    const int children = 1 + below(3);
    for (int i = 0; i < children; ++i) {
      Node child;
      if (depth > 0 && chance(25)) {
        child = tree(params, depth - 1);
      } else {
        child.leaf = true;
        child.param = params++;
      }
      child.trigger = chance(40);
      group.children.push_back(child);
    }
    return group;
  }

 private:
  std::mt19937 random_;
};

std::string text(const Node& node) {
  std::string out;
  for (const Node& child : node.children) {
    out += child.leaf ? "p" + std::to_string(child.param) : "(" + text(child) + ")";
    out += child.trigger ? "' " : " ";
  }
  return out;
}

// A connector with what lies below it; fresh atoms only, so nobody is reached twice.
int grow(Generator& random, Reference& reference, int depth, bool exports, bool guards) {
  RandomConnector connector;
  connector.exports = exports;
  int params = 0;
  connector.root = random.tree(params, 1);
  for (int param = 0; param < params; ++param) {
    if (depth > 0 && reference.ready.size() < 9 && random.chance(35)) {
      const int below = grow(random, reference, depth - 1, true, guards);
      connector.atom.push_back(-1);
      connector.below.push_back(below);
      connector.maximal.push_back(random.chance(30));
    } else {
      connector.atom.push_back(static_cast<int>(reference.ready.size()));
      connector.below.push_back(-1);
      connector.maximal.push_back(false);
      reference.ready.push_back(random.chance(80));
      reference.data.push_back(random.below(5));
    }
  }
  if (guards) {
    for (const std::set<int>& choice : Reference::choices(connector.root)) {
      if (random.chance(60)) connector.guard[choice] = random.below(5);
    }
  }
  reference.connectors.push_back(connector);
  return static_cast<int>(reference.connectors.size()) - 1;
}

void build(const Reference& reference, ImageBuilder& b) {
  b.atom_type({.name = "T",
               .params = {"ready", "x"},
               .data = {"fired"},
               .ports = {{.name = "p", .vars = {"x"}}, {.name = "t", .vars = {}}},
               .places = {"S"},
               .initial = {"S"},
               .transitions = {{"p",
                                {"S"},
                                {"S"},
                                [](Cell* self, Cell*, const u32*) { return self[0].i; },
                                [](Cell* self, Cell*, const u32*) {
                                  ++self[2].i;
                                  return 1;
                                }},
                               {"t", {"S"}, {"S"}, nullptr, [](Cell* self, Cell*, const u32*) {
                                  self[0].i = 1 - self[0].i;
                                  return 1;
                                }}}});
  for (std::size_t i = 0; i < reference.ready.size(); ++i) {
    b.atom("a" + std::to_string(i), "T", {reference.ready[i] ? 1 : 0, reference.data[i]});
  }
  for (std::size_t i = 0; i < reference.connectors.size(); ++i) {
    const RandomConnector& connector = reference.connectors[i];
    const std::string n = std::to_string(i);
    ConnectorTypeSpec type{
        .name = "C" + n, .params = {}, .define = text(connector.root), .clauses = {}, .data = {}, .exported_data = {}};
    type.exports = connector.exports;
    if (connector.exports) type.data = type.exported_data = {"z"};
    std::vector<std::string> ports;
    for (std::size_t p = 0; p < connector.atom.size(); ++p) {
      type.params.emplace_back("p" + std::to_string(p), 1);
      ports.push_back(connector.atom[p] >= 0
                          ? "a" + std::to_string(connector.atom[p]) + ".p"
                          : "c" + std::to_string(connector.below[p]) + (connector.maximal[p] ? "!" : ""));
    }
    for (const auto& [params, residue] : connector.guard) {
      ClauseSpec clause;
      std::vector<u32> rows;
      for (int param : params) {
        clause.params.push_back("p" + std::to_string(param));
        rows.push_back(static_cast<u32>(param));
      }
      const auto sum = [rows](Cell* all, const u32* bind) {
        int total = 0;
        for (u32 row : rows) total += all[bind[row]].i;
        return total;
      };
      const int avoid = residue;
      clause.guard = [sum, avoid](Cell*, Cell* all, const u32* bind) { return sum(all, bind) % 3 != avoid ? 1 : 0; };
      if (connector.exports) {
        clause.up = [sum](Cell* self, Cell* all, const u32* bind) {
          self[0].i = sum(all, bind);
          return 1;
        };
      }
      type.clauses.push_back(clause);
    }
    b.connector_type(type);
    b.connector("c" + n, "C" + n, ports);
  }
  b.connector_type(
      {.name = "One", .params = {{"p", 0}}, .define = "p", .clauses = {}, .data = {}, .exported_data = {}});
  for (std::size_t i = 0; i < reference.ready.size(); ++i)
    b.connector("t" + std::to_string(i), "One", {"a" + std::to_string(i) + ".t"});
}

std::set<Leaves> listed(Core& core, int top) {
  std::set<Leaves> out;
  std::vector<Participant> who;
  for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
    const Candidate candidate = core.candidate(k);
    if (candidate.connector != static_cast<u32>(top)) continue;
    core.participants(candidate, who);
    Leaves leaves;
    for (const Participant& p : who) leaves.insert(static_cast<int>(p.atom));
    CHECK(leaves.size() == who.size());
    CHECK(out.insert(leaves).second);
  }
  return out;
}
// Fires one of the connector's candidates: its participants take part, and no other atom does.
bool fires_participants(Core& core, int top, Generator& random) {
  std::vector<Candidate> of_top;
  for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
    if (core.candidate(k).connector == static_cast<u32>(top)) of_top.push_back(core.candidate(k));
  }
  if (of_top.empty()) return true;
  const Candidate chosen = of_top[static_cast<std::size_t>(random.below(static_cast<int>(of_top.size())))];
  std::vector<Participant> who;
  core.participants(chosen, who);
  const auto fired = [&](u32 atom) { return core.cell(core.tables().atoms[atom].first_cell + 2).i; };
  std::vector<std::int32_t> expected;
  for (u32 atom = 0; atom < core.image().atoms.size; ++atom) expected.push_back(fired(atom));
  for (const Participant& p : who) ++expected[p.atom];
  if (!core.fire(chosen)) return false;
  std::vector<std::int32_t> found;
  for (u32 atom = 0; atom < core.image().atoms.size; ++atom) found.push_back(fired(atom));
  return found == expected;
}
std::set<Leaves> as_set(const std::vector<Alternative>& alternatives) {
  std::set<Leaves> out;
  for (const Alternative& a : alternatives) out.insert(a.leaves);
  return out;
}

}  // namespace

TEST_CASE("candidates equal the definition on random trees") {
  int compared = 0, several = 0;
  for (unsigned seed = 0; seed < 3000; ++seed) {
    CAPTURE(seed);
    Generator random(seed);
    Reference reference;
    const int top = grow(random, reference, 2, false, seed % 4 != 0);
    if (reference.ready.size() > 13) continue;
    ImageBuilder b;
    build(reference, b);
    Core core(b.image());
    Core all(b.image(), {.progress = MaximalProgress::Off});
    REQUIRE(core.initialize());
    REQUIRE(all.initialize());
    for (int step = 0; step < 4; ++step) {
      const std::vector<Alternative> enabled = reference.enabled(top);
      REQUIRE(listed(core, top) == as_set(Reference::maximal(enabled)));
      REQUIRE(listed(all, top) == as_set(enabled));
      for (Core* each : {&core, &all}) REQUIRE(fires_participants(*each, top, random));
      compared += enabled.empty() ? 0 : 1;
      several += enabled.size() > 1 ? 1 : 0;
      // Toggle one atom's readiness; what follows is incremental.
      const int atom = random.below(static_cast<int>(reference.ready.size()));
      reference.ready[static_cast<std::size_t>(atom)] = !reference.ready[static_cast<std::size_t>(atom)];
      for (Core* each : {&core, &all}) {
        for (std::uint64_t k = 0; k < each->candidate_count(); ++k) {
          if (text_of(*each, each->candidate(k)) != "t" + std::to_string(atom) + ": a" + std::to_string(atom) + ".t")
            continue;
          REQUIRE(each->fire(k));
          break;
        }
      }
    }
  }
  CHECK(compared > 1000);
  CHECK(several > 500);
}
