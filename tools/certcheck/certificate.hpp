// A certificate's rows, with names turned into numbers.
#pragma once
#include <optional>

#include "tools/certcheck/model.hpp"

namespace certcheck {

/// A marking and the values of the slots that are followed; what has none may be anything.
struct Mode {
  std::set<std::size_t> places;
  std::vector<std::optional<int>> values;  // by slot
  friend auto operator<=>(const Mode&, const Mode&) = default;
};
struct Class {
  std::size_t type = 0;
  std::vector<bool> followed;  // by slot
  std::vector<Mode> modes;
  std::map<Mode, std::size_t> numbers;
};
/// A trap, or modes of which the weights of those that hold add up to a total (one-token: 1, of weights 1).
struct Set {
  bool is_trap = false;
  std::map<std::pair<std::size_t, std::size_t>, int> weights;  // by atom and mode
  int total = 1;
  std::string text;
};

/// A marked place, a bit of a slot, a slot's value, a slot between two values: or not.
struct Literal {
  enum { Place, Bit, Value, Range } about = Place;
  bool is_negated = false;
  std::size_t atom = 0, row = 0;  // place or slot
  int low = 0, high = 0;          // Bit: its number is low; Value: both
};
/// A node of a diagram holds where one of its cases does: all literals and node `next`, a smaller row (kNone: none).
struct Case {
  std::vector<Literal> literals;
  std::size_t next = kNone;
};
/// One of the literals holds.
struct Fact {
  std::vector<Literal> literals;
  std::string text;
};

struct Certificate {
  std::string claim;
  bool is_induction = false;
  std::vector<Fact> facts;
  std::vector<std::vector<Case>> nodes;
  std::size_t reached = kNone;                   // the node that always holds: all states that are reached
  std::vector<Class> classes;                    // none: the certificate says nothing of modes
  Rows class_of;                                 // by atom
  std::vector<std::set<std::size_t>> reachable;  // by atom
  std::vector<Set> sets;
};

[[nodiscard]] Certificate read_certificate(const Model& model, const std::string& text);

}  // namespace certcheck
