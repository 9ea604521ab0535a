// "At least T of these atoms are in one of their good modes" as clauses over places and values, and over the solver's literals.
//
// Only of atoms that are in one place at a time, and where what is good is told by places, or by one value at one place.
#pragma once
#include <optional>
#include <string>

#include "compiler/verify/encode.hpp"

namespace bip::verify {

class SumClauses {
 public:
  explicit SumClauses(const Net& net, const std::vector<std::uint8_t>& reachable) : net_(net), reachable_(reachable) {}

  /// One side of an invariant: at least `least` of the atoms are in a good mode.
  struct Side {
    std::vector<std::vector<u32>> good, bad;  // by atom: its reachable modes
    std::int64_t least = 0;
    [[nodiscard]] double clauses() const;     // how many, about
  };
  /// At least, at most. Nothing: the weights are not all the same.
  [[nodiscard]] std::optional<std::pair<Side, Side>> sides(const TokenInvariant& invariant) const;
  /// Nothing: what is good cannot be told, or too many.
  [[nodiscard]] std::optional<std::vector<std::string>> lemmas(const Side& side, std::size_t limit) const;
  /// The same for the solver.
  void add(const Side& side, Encoding& encoding) const;

 private:
  using Clause = std::vector<std::string>;
  [[nodiscard]] std::optional<std::vector<Clause>> told(const std::vector<u32>& good, const std::vector<u32>& bad) const;
  template <class Visit>
  static void each_subset(std::size_t count, std::size_t size, const Visit& visit);

  const Net& net_;
  const std::vector<std::uint8_t>& reachable_;
};

}  // namespace bip::verify
