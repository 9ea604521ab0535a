// Classic systems as images, for tests of engines and for measuring: philosophers, a token ring, pairs that hand data
// over.
#pragma once
#include <string>

#include "tests/unit/runtime/builder.hpp"

namespace bip::rt::testing {

/// deadlocks: forks are taken one at a time, left first.
inline void build_philosophers(ImageBuilder& b, int n, bool deadlocks) {
  b.atom_type({.name = "Fork",
               .ports = {{.name = "take"}, {.name = "free"}},
               .places = {"idle", "busy"},
               .initial = {"idle"},
               .transitions = {{"take", {"idle"}, {"busy"}}, {"free", {"busy"}, {"idle"}}}});
  b.connector_type({.name = "Pair", .params = {{"p", 0}, {"f", 0}}, .define = "p f"});
  b.connector_type({.name = "Three", .params = {{"p", 0}, {"f", 0}, {"g", 0}}, .define = "p f g"});
  if (deadlocks) {
    b.atom_type({.name = "Phil",
                 .ports = {{.name = "take_left"}, {.name = "take_right"}, {.name = "put"}},
                 .places = {"thinks", "has_left", "eats"},
                 .initial = {"thinks"},
                 .transitions = {{"take_left", {"thinks"}, {"has_left"}},
                                 {"take_right", {"has_left"}, {"eats"}},
                                 {"put", {"eats"}, {"thinks"}}}});
  } else {
    b.atom_type({.name = "Phil",
                 .ports = {{.name = "take"}, {.name = "put"}},
                 .places = {"thinks", "eats"},
                 .initial = {"thinks"},
                 .transitions = {{"take", {"thinks"}, {"eats"}}, {"put", {"eats"}, {"thinks"}}}});
  }
  const auto name = [](const char* what, int i) { return std::string(what) + "[" + std::to_string(i) + "]"; };
  for (int i = 0; i < n; ++i) b.atom(name("phil", i), "Phil");
  for (int i = 0; i < n; ++i) b.atom(name("fork", i), "Fork");
  const auto connect = [&](const char* what, const char* type, const char* port, const char* fork_port, bool both,
                           int shift) {
    for (int i = 0; i < n; ++i) {
      const std::string phil = name("phil", i), left = name("fork", i), right = name("fork", (i + 1) % n);
      std::vector<std::string> ports{phil + port, (shift == 0 ? left : right) + fork_port};
      if (both) ports.push_back(right + fork_port);
      b.connector(name(what, i), type, ports);
    }
  };
  if (deadlocks) {
    connect("left", "Pair", ".take_left", ".take", false, 0);
    connect("right", "Pair", ".take_right", ".take", false, 1);
  } else {
    connect("take", "Three", ".take", ".take", true, 0);
  }
  connect("put", "Three", ".put", ".free", true, 0);
}

inline void build_ring(ImageBuilder& b, int n) {
  const AtomTypeSpec node{.name = "Node",
                          .ports = {{.name = "in"}, {.name = "out"}},
                          .places = {"empty", "full"},
                          .initial = {"empty"},
                          .transitions = {{"in", {"empty"}, {"full"}}, {"out", {"full"}, {"empty"}}}};
  AtomTypeSpec first = node;
  first.name = "First";
  first.initial = {"full"};
  b.atom_type(node);
  b.atom_type(first);
  b.connector_type({.name = "Pass", .params = {{"o", 0}, {"i", 0}}, .define = "o i"});
  for (int i = 0; i < n; ++i) b.atom("n" + std::to_string(i), i == 0 ? "First" : "Node");
  for (int i = 0; i < n; ++i) {
    b.connector("c" + std::to_string(i), "Pass",
                {"n" + std::to_string(i) + ".out", "n" + std::to_string((i + 1) % n) + ".in"});
  }
}

/// n / 2 pairs; put hands the sender's counter over.
inline void build_pairs(ImageBuilder& b, int n) {
  b.atom_type({.name = "Ping",
               .data = {"x"},
               .ports = {{.name = "put", .vars = {"x"}}, {.name = "get", .vars = {"x"}}},
               .places = {"A", "B"},
               .initial = {"A"},
               .transitions = {{"put", {"A"}, {"B"}}, {"get", {"B"}, {"A"}, nullptr, [](Cell* self, Cell*, const u32*) {
                                                         ++self[0].i;
                                                         return 1;
                                                       }}}});
  b.atom_type({.name = "Pong",
               .data = {"x"},
               .ports = {{.name = "put", .vars = {"x"}}, {.name = "get", .vars = {"x"}}},
               .places = {"A", "B"},
               .initial = {"A"},
               .transitions = {{"get", {"A"}, {"B"}}, {"put", {"B"}, {"A"}}}});
  b.connector_type({.name = "Hand",
                    .params = {{"from", 1}, {"to", 1}},
                    .define = "from to",
                    .clauses = {{.params = {"from", "to"}, .down = [](Cell*, Cell* all, const u32* bind) {
                                   all[bind[1]] = all[bind[0]];
                                   return 1;
                                 }}}});
  for (int i = 0; i < n / 2; ++i) {
    const std::string s = std::to_string(i);
    b.atom("a" + s, "Ping");
    b.atom("b" + s, "Pong");
    b.connector("there" + s, "Hand", {"a" + s + ".put", "b" + s + ".get"});
    b.connector("back" + s, "Hand", {"b" + s + ".put", "a" + s + ".get"});
  }
}

}  // namespace bip::rt::testing
