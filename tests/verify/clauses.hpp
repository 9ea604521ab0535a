// What a certificate's rows say of single states, read once more (neither by the prover's code nor by certcheck's), and
// whether they suffice: true at first, kept by every step that the engine knows, and of no state that is bad.
//
// Only for small systems whose atoms are automata and whose modes know the values of all data: then the states that
// satisfy the rows can be listed, reachable or not, and each is tried on the engine's core.
#pragma once
#include <charconv>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "compiler/verify/portfolio/search_bad_state.hpp"
#include "runtime/core/final_state.hpp"

namespace bip::verify::test {

/// Reads a decimal number that is written as std::to_string writes it. Returns whether the word is one.
inline bool read_number(const std::string& word, std::int64_t& number) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc{} && end == word.data() + word.size() && std::to_string(number) == word;
}

enum class Worth : std::uint8_t { Suffices, Insufficient, Malformed, TooLarge };

/// Is the state bad, or does a step lead from it to one that a certificate does not allow? allows(const rt::State&).
template <class Allows>
bool breaks(rt::Core& core, const rt::State& state, const SearchGoal& goal, const Allows& allows) {
  if (!core.restore(state)) return goal.faults;
  const std::uint64_t steps = core.candidate_count();
  if ((goal.stuck && rt::is_deadlock(core)) || (goal.state && goal.state(core))) return true;
  for (std::uint64_t k = 0; k < steps; ++k) {
    if (k != 0 && !core.restore(state)) break;
    const bool is_fired = core.fire(k);
    if (is_fired ? !allows(core.snapshot()) : goal.faults) return true;
  }
  return false;
}

class Clauses {
 public:
  /// `system` and `image` are of one compilation and must outlive it.
  Clauses(const System& system, const rt::Image& image) : system_(system), image_(image) {}
  /// Worth of the rows as a proof that nothing of `goal` is reachable. TooLarge: more than `limit` states, or what is
  /// not listable.
  [[nodiscard]] Worth worth(const std::string& text, const SearchGoal& goal, std::size_t limit);

 private:
  struct Mode {
    std::uint32_t place = 0;
    std::map<std::uint32_t, std::int32_t> values;  // by variable
    friend bool operator==(const Mode&, const Mode&) = default;
  };
  struct Class {
    AtomTypeId type;
    std::vector<Mode> modes;
  };
  struct Member {
    std::size_t atom = 0;
    std::uint32_t mode = 0;
    friend auto operator<=>(const Member&, const Member&) = default;
  };
  struct Literal {
    std::size_t atom = 0;
    std::uint32_t row = 0, bit = 0;
    std::int64_t low = 0, high = 0;
    bool is_place = false, is_bit = false, is_negated = false, is_value = false;
  };
  using Case = std::vector<Literal>;  // all hold
  struct Sum {
    std::int64_t total = 0;
    std::map<Member, std::int64_t> weights;
  };
  struct Equation {
    std::uint32_t total = 0;
    std::vector<std::pair<Case, std::int64_t>> terms;  // one literal that is a value: what it is
  };
  struct Rows {
    std::vector<Equation> equations;
    std::vector<Sum> sums;
    std::vector<Class> classes;
    std::vector<std::size_t> class_of;
    std::vector<std::set<std::uint32_t>> reachable;
    std::vector<std::set<Member>> traps, one_tokens;
    std::vector<std::vector<Case>> lemmas;
    bool is_listable = true;
  };

  [[nodiscard]] bool read(const std::string& text, Rows& rows) const;
  [[nodiscard]] bool read_row(const std::vector<std::string>& words, Rows& rows) const;
  [[nodiscard]] bool read_mode(const std::vector<std::string>& words, Rows& rows) const;
  [[nodiscard]] bool read_literal(std::string word, Literal& literal) const;
  [[nodiscard]] bool read_case(const std::string& word, Case& one) const;
  [[nodiscard]] bool split_data(const std::string& path, std::size_t& atom, std::uint32_t& variable) const;
  [[nodiscard]] std::size_t atom_of(const std::string& path) const;
  [[nodiscard]] bool is_in(const rt::State& state, std::size_t atom, const Mode& mode) const;
  [[nodiscard]] bool hold(const Rows& rows, const rt::State& state) const;
  [[nodiscard]] bool holds(const Case& one, const rt::State& state) const;
  [[nodiscard]] std::int32_t value(const rt::State& state, std::size_t atom, std::uint32_t variable) const;

  const System& system_;
  const rt::Image& image_;
};

}  // namespace bip::verify::test
