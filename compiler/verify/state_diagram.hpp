// A set of states as a decision diagram, the evidence of a search: what was reached is itself an invariant that every step keeps.
//
// A node asks one thing of a state, where an automaton is or what a variable's value is, and leads on by the answer. Equal
// rests of states are one node (minimal automata of sorted lists: Daciuk, Mihov, Watson, Watson 2000), so the size is
// that of what the set has of structure; what is the same in all states is asked once, first. Cost: the states, sorted, once.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/system/system.hpp"
#include "runtime/core/state.hpp"

namespace bip::verify {

struct StateDiagram {
  /// The place of an automaton, a place of a Petri net atom (0, 1), or a variable.
  struct Question {
    std::uint32_t atom = 0, row = 0;
    enum class About : std::uint8_t { Automaton, Place, Slot } about = About::Automaton;
  };
  struct Answer {
    std::uint32_t question = 0;  // row of `questions`
    std::int32_t value = 0;      // row of the place; bool as 0, 1; row of the string
  };
  /// All answers, and then a state of node `next`; kEnd: nothing more.
  struct Case {
    std::vector<Answer> answers;
    std::uint32_t next = kEnd;
  };
  static constexpr std::uint32_t kEnd = 0xffffffffu;
  std::vector<Question> questions;
  std::vector<std::vector<Case>> nodes;  // `next` is always a smaller row; the last one is the set. Empty: no diagram
};

/// "node 0", "  case - ROOT.a@S ROOT.a.n=3" …
[[nodiscard]] std::string diagram_text(const StateDiagram& diagram, const System& system);

class StateCollector {
 public:
  /// `system` and `image` are of one compilation and must outlive it.
  StateCollector(const System& system, const rt::Image& image);
  /// False: some of the data has no values that a certificate can name (float, extern), or there is too much of it.
  [[nodiscard]] bool can_tell() const { return can_tell_; }
  void add(const rt::State& state);
  /// Empty if it would be too large.
  [[nodiscard]] StateDiagram diagram();

 private:
  const rt::Image& image_;
  bool can_tell_ = true;
  std::vector<StateDiagram::Question> questions_;
  std::vector<std::uint32_t> position_;  // by question: row of places or data, bit of the marks
  std::vector<std::int32_t> values_;     // a row of all questions a state
};

}  // namespace bip::verify
