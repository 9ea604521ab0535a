// A certificate's rows, with names turned into numbers.
#pragma once
#include <optional>

#include "tools/certcheck/model.hpp"

namespace certcheck {

/// By variable of an atom: its value, or nothing where it may be any.
using Values = std::vector<std::optional<int>>;
using Modes = std::set<std::size_t>;
struct Class {
  std::size_t type = 0;
  std::vector<bool> followed;  // by variable: places are
  std::vector<Values> modes;
  std::map<Values, std::size_t> numbers;
};
/// A trap, or modes of which the weights of those that hold add up to a total (one-token: 1, of weights 1).
struct Set {
  std::string line;
  bool is_trap = false;
  int total = 1;
  std::map<std::pair<std::size_t, std::size_t>, int> weights;  // by atom and mode
};
/// A variable is between two values, or one of its bits is set: or not.
struct Literal {
  std::size_t atom = 0, variable = 0;
  int low = 1, high = 1;
  std::optional<unsigned> bit;
  bool is_negated = false;
};
/// A node of a diagram holds where one of its cases does: all literals and node `next`, a smaller row (kNone: none).
struct Case {
  std::vector<Literal> literals;
  std::size_t next = kNone;
};
/// One of the literals holds.
struct Fact {
  std::string line;
  std::vector<Literal> literals;
};
/// Marked places and ints, times their weights, add up to the total, modulo 2^32.
struct Equation {
  std::string line;
  int total = 0;
  std::vector<std::pair<Literal, int>> terms;
};
struct Certificate {
  std::string claim;
  bool is_induction = false;
  std::vector<Fact> facts;
  std::vector<Equation> equations;
  std::vector<std::vector<Case>> nodes;
  std::size_t reached = kNone;  // the node that always holds: all states that are reached
  std::vector<Class> classes;   // none: the certificate says nothing of modes
  Rows class_of;                // by atom
  std::vector<Modes> reachable;
  std::vector<Set> sets;
};

[[nodiscard]] Certificate read_certificate(const Model& model, const std::string& text);
/// Is it a proof? Says how much was checked; throws Rejected or NotCheckable (states.cpp).
[[nodiscard]] std::string check(const Model& model, const std::string& certificate);
/// Modes are closed, reachable ones and sets are kept by every step (structure.cpp).
void check_structure(const Model& model, const Certificate& certificate);

}  // namespace certcheck
