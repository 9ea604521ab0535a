// Random numbers of models: the distributions of package std.chance, the generator of an atom, and scripts in its
// place.
//
// An atom whose actions draw has a generator of its own: a counter of 64 bits in one of its cells, so that it is a part
// of each state, needs no lock, and gives the same numbers with any engine and number of threads. It is SplitMix64
// (Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014): the counter grows by an odd constant,
// the number is a mix of it. compiler/docs/semantics.md fixes what each distribution makes of these numbers.
//
// A search that visits all states puts a script in the place of the generators: it takes every value of each draw.
#pragma once
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "bip/distributions.hpp"
#include "bip/emitted.hpp"
#include "bip/ffi.hpp"

namespace bip::rt {

/// Where the generator of an atom starts, never 0: a counter of 0 belongs to no run.
[[nodiscard]] std::uint64_t draw_start(std::uint64_t seed, std::uint32_t atom);

/// Draws from row k of kDistributions: the first argument is the cell of the generator. 1: the arguments are none of
/// the distribution's, or a search cannot take all values; draw_problem() says why.
[[nodiscard]] FfiFunction draw_function(std::size_t k);

/// Why the last draw of this thread that returned 1 has no value.
struct DrawProblem {
  std::string text;
  bool is_of_search = false;  // the arguments are good: a search cannot take all values
};
[[nodiscard]] const DrawProblem& draw_problem();

/// The values of the draws of one step in a search: all combinations, one after the other, or one of them by its
/// number.
class DrawScript {
 public:
  /// More values of the draws of one step together are a fault (R0071).
  static constexpr std::uint64_t kMostValues = 1 << 16;
  /// Begins with the combination of this number; `advance` goes on from 0 only.
  explicit DrawScript(std::uint64_t number = 0) : rest_(number) {}
  /// A script for states in which a search begins: several values of a draw are a fault.
  [[nodiscard]] static DrawScript without_choices();
  /// Takes the next combination. False: all were taken.
  bool advance();
  /// The number and the probability of the combination, once the step is done.
  [[nodiscard]] std::uint64_t number() const;
  [[nodiscard]] double probability() const;

  // For distributions.
  [[nodiscard]] bool has_choices() const { return has_choices_; }
  /// Returns whether a draw with so many values fits.
  [[nodiscard]] bool has_room(std::uint64_t values) const;
  /// Which one of `shares`, whose sum is 1.
  std::uint64_t choose(const std::vector<double>& shares);

 private:
  struct Draw {
    std::uint64_t value;
    std::vector<double> shares;
  };
  std::vector<Draw> draws_;
  std::size_t next_ = 0;
  std::uint64_t rest_ = 0;  // of the number, for draws to come
  bool has_choices_ = true;
};
/// While it lives, draws of this thread follow the script.
class FollowedScript {
 public:
  explicit FollowedScript(DrawScript& script);
  ~FollowedScript();
  FollowedScript(const FollowedScript&) = delete;
  FollowedScript& operator=(const FollowedScript&) = delete;

 private:
  DrawScript* before_;
};

// The functions that kDistributions names, as emitted code calls them.
std::int32_t draw_uniform_int(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_uniform_float(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_normal(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_truncated_normal(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_exponential(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_flip(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_table2(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_table3(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_table4(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_table5(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_table6(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_table7(FfiContext* ffi, Cell* result, Cell* const* args);
std::int32_t draw_table8(FfiContext* ffi, Cell* result, Cell* const* args);

/// A draw in emitted code.
template <class... Args>
Cell draw(FfiFunction function, double& generator, std::uint32_t site, Args... args) {
  const auto cell_of = [](auto value) {
    if constexpr (std::is_same_v<decltype(value), double>) return float_cell(value);
    else return int_cell(value);
  };
  Cell values[] = {float_cell(generator), cell_of(args)...};
  Cell* cells[sizeof...(Args) + 1];
  for (std::size_t k = 0; k <= sizeof...(Args); ++k) cells[k] = &values[k];
  Cell result{};
  const std::int32_t status = function(nullptr, &result, cells);
  std::memcpy(&generator, &values[0], sizeof generator);
  if (status != 0) throw CodeFault{fault_status(site, FaultKind{})};
  return result;
}

}  // namespace bip::rt
