// A certificate's rows, with names turned into numbers.
#pragma once
#include <optional>

#include <z3++.h>

#include "tools/certcheck/model.hpp"

namespace certcheck {

inline constexpr int kMostWeight = 0x40000000;
/// By variable of an atom: its value, or nothing where it may be any.
using Values = std::vector<std::optional<int>>;
using Modes = std::set<std::size_t>;
struct Class {
  std::size_t type = 0;
  std::vector<bool> followed;  // by variable: places are
  std::vector<Values> modes;
  std::map<Values, std::size_t> numbers;
};
/// A variable is between two values, or one of its bits is set: or not. Of a set: the atom is in a mode.
struct Literal {
  std::size_t atom = 0, variable = 0;
  int low = 1, high = 1;
  std::optional<unsigned> bit = {};
  bool is_negated = false;
};
/// All literals hold; or, in a sum, a variable's value. Times its weight.
struct Case {
  std::vector<Literal> literals;
  bool is_value = false;
  int weight = 1;
};
/// One of the cases holds; or what they are, times their weights, adds up to the total, modulo 2^32.
struct Fact {
  std::string line;
  std::vector<Case> cases;
  std::optional<int> total;
};
struct Certificate {
  std::string claim;
  std::vector<Fact> facts, sets;  // sets: of modes; without total: traps
  std::set<std::vector<Values>> states;  // all that a search has reached: by atom, parameters as 0
  std::vector<Class> classes;  // none: the certificate says nothing of modes
  Rows class_of;               // by atom
  std::vector<Modes> reachable;
};

[[nodiscard]] Certificate read_certificate(const Model& model, const std::string& text);
/// Is it a proof? Says how much was checked; throws Rejected or NotCheckable (states.cpp). Z3 is slow to give up what it holds.
[[nodiscard]] std::string check(const Model& model, const std::string& certificate, z3::context& z);
/// Modes are closed, reachable ones and sets are kept by every step (structure.cpp).
void check_structure(const Model& model, const Certificate& certificate, z3::context& z);

}  // namespace certcheck
