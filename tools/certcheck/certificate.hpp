// A certificate's rows, with names turned into numbers.
#pragma once
#include "tools/certcheck/model.hpp"

namespace certcheck {

struct Class {
  std::size_t type = 0;
  std::vector<bool> followed;
  std::vector<LocalState> states;
  std::map<LocalState, std::size_t> numbers;
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> moves;  // by port: from, to
};
/// A trap, or states of which the weights of those that hold add up to a total (one-token: 1, of weights 1).
struct Set {
  bool is_trap = false;
  std::vector<std::pair<std::size_t, std::size_t>> members;  // atom, state; sorted
  std::vector<int> weights;                                  // by member
  int total = 1;
  std::string text;
};

/// A range (of one part), a lemma (one of its parts holds), or that a node of the diagram of reached states holds (no parts).
struct Fact {
  struct Part {
    std::size_t atom = 0, row = 0;  // place or slot
    unsigned bit = 0;
    bool is_place = false, is_negated = false;
    bool is_value = false;          // in cases: the slot has this value
    int value = 0;
  };
  bool is_range = false, is_reached = false;
  int low = 0, high = 0;
  std::size_t node = 0;
  std::vector<Part> parts;
  std::string text;
};

/// A node of the diagram holds where one of its cases does: all parts, and the node that it leads on to, which is a smaller row.
struct Case {
  std::vector<Fact::Part> parts;
  std::size_t next = 0;
  bool is_end = false;
};

struct Certificate {
  std::string claim;
  bool is_induction = false;
  std::vector<Fact> facts;
  std::vector<std::vector<Case>> nodes;
  std::vector<Class> classes;
  std::vector<std::size_t> class_of;             // by atom
  std::vector<std::set<std::size_t>> reachable;  // by atom
  std::vector<Set> sets;
};

[[nodiscard]] Certificate read_certificate(const Model& model, const std::string& text);

}  // namespace certcheck
