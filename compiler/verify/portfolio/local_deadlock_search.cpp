// See local_deadlock_search.hpp. States in the order of a breadth-first visit: the way to the first one found is a
// shortest one.
#include "compiler/verify/portfolio/local_deadlock_search.hpp"

#include <algorithm>
#include <optional>
#include <unordered_map>

#include "compiler/analysis/graph_algorithms.hpp"
#include "compiler/verify/portfolio/local_deadlock.hpp"
#include "compiler/verify/portfolio/search_symmetry.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/explore/symmetry.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

using BitWord = std::uint64_t;

// What follows each state, and who moves there and wants to.
class Graph {
 public:
  explicit Graph(std::size_t atoms) : words_((atoms + 63) / 64) {}

  void add_state() {
    moves_.resize(moves_.size() + words_, 0);
    wants_.resize(wants_.size() + words_, 0);
  }
  // Of the states in their order: the state whose steps come now.
  void begin_steps() { first_.push_back(static_cast<u32>(next_.size())); }
  void add_step(u32 to) {
    BIP_ASSERT(!first_.empty(), "a step before its state");
    next_.push_back(to);
  }
  void set_moves(u32 state, u32 atom) { moves_[state * words_ + atom / 64] |= BitWord{1} << atom % 64; }
  void set_wants(u32 state, u32 atom) { wants_[state * words_ + atom / 64] |= BitWord{1} << atom % 64; }
  [[nodiscard]] std::size_t bytes() const {
    return (moves_.size() + wants_.size()) * sizeof(BitWord) + (next_.size() + first_.size()) * sizeof(u32);
  }

  // All steps are there. Returns the first state with an atom that wants to move and never will; kNoRow: none.
  u32 find(std::vector<u32>& atoms) {
    first_.push_back(static_cast<u32>(next_.size()));
    BIP_ASSERT((first_.size() - 1) * words_ == moves_.size(), "{} states with steps, {} words of moves",
               first_.size() - 1, moves_.size());
    find_components();
    BIP_ASSERT(std::find(component_.begin(), component_.end(), kNoRow) == component_.end(),
               "a state in no strong component: it was not reachable");
    const u32 states = static_cast<u32>(first_.size() - 1);
    for (u32 state = 0; state < states; ++state) {
      for (std::size_t w = 0; w < words_; ++w) {
        BitWord left = wants_[state * words_ + w] & ~later_[component_[state] * words_ + w];
        for (; left != 0; left &= left - 1)
          atoms.push_back(static_cast<u32>(w * 64) + static_cast<u32>(std::countr_zero(left)));
      }
      if (!atoms.empty()) return state;
    }
    return kNoRow;
  }

 private:
  // Components are complete in reverse topological order, so when one is, what can move after it is known.
  void find_components() {
    const u32 states = static_cast<u32>(first_.size() - 1);
    component_.assign(states, kNoRow);
    StrongComponents<u32> search;
    search.begin(states);
    // All states are reachable from the first.
    if (states != 0) search.visit(0, *this);
  }

 public:
  // The visitor of StrongComponents: a cursor is a row of next_.
  [[nodiscard]] u32 enter(u32 state) const { return first_[state]; }
  [[nodiscard]] u32 next(u32 state, u32& step) const {
    return step == first_[state + 1] ? kNoSuccessor : next_[step++];
  }
  static void reach(u32, u32) {}
  void close(const u32* states, std::size_t count) {
    const u32 row = static_cast<u32>(later_.size() / std::max<std::size_t>(words_, 1));
    later_.resize(later_.size() + words_, 0);
    BIP_ASSERT(count > 0 && std::all_of(states, states + count, [&](u32 s) { return component_[s] == kNoRow; }),
               "a state of {} is in two strong components", count);
    for (std::size_t k = 0; k < count; ++k) component_[states[k]] = row;
    for (std::size_t k = 0; k < count; ++k) {
      join(row, moves_, states[k]);
      for (u32 step = first_[states[k]]; step < first_[states[k] + 1]; ++step) {
        BIP_ASSERT(component_[next_[step]] <= row, "component {} is complete before one that follows it", row);
        if (component_[next_[step]] != row) join(row, later_, component_[next_[step]]);
      }
    }
  }

 private:
  void join(u32 row, const std::vector<BitWord>& from, u32 from_row) {
    for (std::size_t w = 0; w < words_; ++w) later_[row * words_ + w] |= from[from_row * words_ + w];
  }

  std::size_t words_;
  std::vector<BitWord> moves_, wants_;  // by state
  std::vector<u32> first_, next_;       // by state: its steps
  std::vector<u32> component_;          // by state
  std::vector<BitWord> later_;          // by component: who can still move
};

// Replaces states by their representatives under permutations of equal components, one of each group fixed.
class Orbits {
 public:
  explicit Orbits(const rt::Core& core)
      : locals_(core), symmetry_(core.image(), locals_, symmetry_limits()), numbers_(core.image().atoms.size, 0) {
    symmetry_.fix_first_members();
    permuted_ = symmetry_.permuted_atoms();
  }
  [[nodiscard]] const std::vector<std::string>& names() const { return symmetry_.names(); }
  [[nodiscard]] const std::vector<u32>& permuted() const { return permuted_; }
  // `state` is the core's.
  void normalize(const rt::Core& core, rt::State& state) {
    for (const u32 atom : permuted_) numbers_[atom] = locals_.number(atom, core);
    if (!symmetry_.normalize(numbers_, scratch_)) return;
    for (const u32 atom : permuted_) locals_.write(atom, numbers_[atom], state);
  }

 private:
  rt::Locals locals_;
  rt::Symmetry symmetry_;
  std::vector<u32> permuted_, numbers_;
  std::vector<std::uint64_t> scratch_;
};

class Visit {
 public:
  Visit(const Net& net, const rt::Image& image, const SearchLimits& limits, SymmetryUse symmetry)
      : net_(net), image_(image), limits_(limits), core_(image), graph_(image.atoms.size) {
    is_followed_.assign(image.atoms.size, 1);
    if (symmetry == SymmetryUse::None) return;
    orbits_.emplace(core_);
    for (const u32 atom : orbits_->permuted()) is_followed_[atom] = 0;
    result_.permuted = orbits_->names();
  }

  LocalDeadlockResult run() {
    SearchResult& found = result_.search;
    if (!core_.initialize()) {
      found.fault = core_.fault().what;
      found.end = SearchEnd::Exhausted;
      return std::move(result_);
    }
    if (!enter(0, 0)) visit();
    found.states = visited_.size();
    return std::move(result_);
  }

 private:
  struct Visited {
    u32 parent = 0, choice = 0;
  };

  void visit() {
    SearchResult& found = result_.search;
    for (u32 row = 0; row < states_.size(); ++row) {
      const rt::State state = std::move(states_[row]);
      states_[row] = {};
      graph_.begin_steps();
      if (!core_.restore(state)) {
        found.limit = "a state could not be entered again";
        return;
      }
      for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
        if (is_followed_[atom] != 0 && rt::wants_to_move(core_, atom)) graph_.set_wants(row, atom);
      }
      const std::uint64_t count = core_.candidate_count();
      for (std::uint64_t k = 0; k < count; ++k) {
        if (k != 0 && !core_.restore(state)) {
          found.limit = "a state could not be entered again";
          return;
        }
        participants_.clear();
        core_.participants(core_.candidate(k), participants_);
        for (const rt::Participant& p : participants_) graph_.set_moves(row, p.atom);
        if (!core_.fire(k)) {
          if (found.fault.empty()) found.fault = core_.fault().what;
          continue;
        }
        if (enter(row, static_cast<u32>(k))) return;
        if (visited_.size() % 4096 == 0 && limits_.report) limits_.report(visited_.size());
        const bool is_full = bytes_ + graph_.bytes() > limits_.megabytes * 1000000;
        if (is_full || visited_.size() >= limits_.states || limits_.cancellation.is_over()) {
          found.limit = is_full ? "memory" : visited_.size() >= limits_.states ? "states" : "time";
          return;
        }
      }
    }
    found.end = SearchEnd::Exhausted;
    const u32 row = graph_.find(result_.stuck);
    if (row != kNoRow) confirm(row);
  }

  // The core's state, perhaps new, reached by a step. True: an atom is stuck in it, which its candidates show.
  bool enter(u32 parent, u32 choice) {
    rt::State state = core_.snapshot();
    if (orbits_) orbits_->normalize(core_, state);
    std::string key = state_key(state);
    const std::size_t size = 2 * key.size() + 200;
    const auto [at, is_new] = rows_.try_emplace(std::move(key), static_cast<u32>(visited_.size()));
    if (!visited_.empty()) graph_.add_step(at->second);
    if (!is_new) return false;
    bytes_ += size;
    graph_.add_state();
    visited_.push_back({parent, choice});
    states_.push_back(std::move(state));
    if (net_.too_large_atom != kNoRow) return false;
    result_.stuck = locally_deadlocked_atoms(net_, core_);
    if (result_.stuck.empty()) return false;
    confirm(at->second);
    return true;
  }

  // The way there, from the initial state, by a core of its own.
  void confirm(u32 row) {
    SearchResult& found = result_.search;
    const std::string wanted = key_at(row);
    std::vector<u32> path;
    for (u32 at = row; at != 0; at = visited_[at].parent) path.push_back(at);
    BIP_ASSERT(std::is_sorted(path.rbegin(), path.rend()), "a state of {} on the way comes before the one it follows",
               path.size());
    std::reverse(path.begin(), path.end());
    rt::Core core(image_);
    bool is_there = core.initialize();
    for (const u32 at : path) is_there = is_there && (orbits_ ? step_to(core, at) : step_by(core, visited_[at].choice));
    found.end = is_there && key_of(core) == wanted ? SearchEnd::Found : SearchEnd::Limit;
    if (found.end == SearchEnd::Limit) found.limit = "a state that was found could not be entered again";
    // Permutations of the path are undone: in its last state others may be the ones that wait.
    if (found.end == SearchEnd::Found && orbits_ && net_.too_large_atom == kNoRow) {
      std::vector<u32> stuck = locally_deadlocked_atoms(net_, core);
      if (!stuck.empty()) result_.stuck = std::move(stuck);
    }
  }
  bool step_by(rt::Core& core, std::uint64_t choice) {
    result_.search.choices.push_back(choice);
    return choice < core.candidate_count() && core.fire(choice);
  }
  // By the first candidate that leads to a state that the row represents.
  bool step_to(rt::Core& core, u32 row) {
    const std::string wanted = key_at(row);
    const rt::State before = core.snapshot();
    const std::uint64_t count = core.candidate_count();
    for (std::uint64_t k = 0; k < count; ++k) {
      if (k != 0 && !core.restore(before)) return false;
      if (!core.fire(k) || key_of(core) != wanted) continue;
      result_.search.choices.push_back(k);
      return true;
    }
    return false;
  }
  [[nodiscard]] std::string key_of(const rt::Core& core) {
    rt::State state = core.snapshot();
    if (orbits_) orbits_->normalize(core, state);
    return state_key(state);
  }
  [[nodiscard]] std::string key_at(u32 row) const {
    for (const auto& [key, at] : rows_) {
      if (at == row) return key;
    }
    return {};
  }

  const Net& net_;
  const rt::Image& image_;
  const SearchLimits& limits_;
  rt::Core core_;
  Graph graph_;
  LocalDeadlockResult result_;
  std::optional<Orbits> orbits_;           // none: all states are their own representatives
  std::vector<std::uint8_t> is_followed_;  // by atom: no permutation moves it
  std::unordered_map<std::string, u32> rows_;
  std::vector<Visited> visited_;
  std::vector<rt::State> states_;  // emptied when their steps have been taken
  std::vector<rt::Participant> participants_;
  std::size_t bytes_ = 0;
};

}  // namespace

LocalDeadlockResult find_local_deadlock(const Net& net, const rt::Image& image, const SearchLimits& limits,
                                        SymmetryUse symmetry) {
  return Visit(net, image, limits, symmetry).run();
}

}  // namespace bip::verify
