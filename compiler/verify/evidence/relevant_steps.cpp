// See relevant_steps.hpp.
#include "compiler/verify/evidence/relevant_steps.hpp"

#include <algorithm>
#include <deque>
#include <queue>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "runtime/include/bip/assert.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::verify {

namespace {

constexpr std::uint64_t kReplayedSteps = 1'000'000;
constexpr std::size_t kAvoidingStates = 20'000;
// Of the states that a search for a way out stores, and of those of a run whose loops are cut out.
constexpr std::size_t kStoredBytes = std::size_t{256} << 20;

// A step by who takes part, whatever else is possible.
struct StepLabel {
  rt::InteractionId interaction;
  std::vector<std::pair<u32, u32>> ports;  // atom, port
  friend bool operator==(const StepLabel&, const StepLabel&) = default;
};

class Replayer {
 public:
  Replayer(const rt::Image& image, const SearchGoal& goal, const CancellationToken& token)
      : core_(image), goal_(goal), token_(token) {}

  [[nodiscard]] bool ends_in_deadlock() const { return goal_.stuck && !goal_.faults && !goal_.state; }
  [[nodiscard]] bool is_over() const { return replayed_ > kReplayedSteps || token_.is_cancelled(); }

  // The labels of the run, without its loops. Empty: the run does not reach the goal.
  std::vector<StepLabel> read(const std::vector<std::uint64_t>& choices) {
    std::vector<StepLabel> labels;
    std::unordered_map<std::string, std::size_t> first;  // state -> steps before it
    const std::size_t bytes = state_key_bytes(begin() ? core_.snapshot() : rt::State{});
    const bool cuts_loops = bytes != 0 && choices.size() <= kStoredBytes / (2 * bytes);
    for (const std::uint64_t choice : choices) {
      if (cuts_loops) {
        const auto [seen, is_new] = first.try_emplace(state_key(core_.snapshot()), labels.size());
        if (!is_new && seen->second < labels.size()) {
          labels.resize(seen->second);
          std::erase_if(first, [&](const auto& entry) { return entry.second > labels.size(); });
        }
      }
      if (choice >= core_.candidate_count()) return {};
      labels.push_back(label(core_.position(choice)));
      if (!core_.fire(choice)) break;
    }
    return labels;
  }

  // The numbers of the candidates if these steps lead to the goal; those behind it are removed.
  std::optional<std::vector<std::uint64_t>> take(std::vector<StepLabel>& labels) {
    replayed_ += 1 + core_.image().atoms.size / 16;
    if (!begin()) return std::nullopt;
    std::vector<std::uint64_t> choices;
    choices.reserve(labels.size());
    for (const StepLabel& wanted : labels) {
      const std::optional<rt::EnabledSet::Position> at = find(wanted);
      if (!at) return std::nullopt;
      choices.push_back(core_.enabled().number(*at));
      ++replayed_;
      const bool is_sound = core_.take(*at);
      if (!is_sound && !goal_.faults) return std::nullopt;
      if (is_sound && !is_goal_state(core_, goal_)) continue;
      labels.resize(choices.size());
      return choices;
    }
    return std::nullopt;
  }

 private:
  bool begin() {
    if (!initial_) {
      if (!core_.initialize()) return false;
      initial_ = core_.snapshot();
      return true;
    }
    return core_.restore(*initial_);
  }

  StepLabel label(rt::EnabledSet::Position at) {
    StepLabel made{at.interaction, {}};
    core_.participants(core_.candidate(at), participants_);
    for (const rt::Participant& p : participants_) made.ports.emplace_back(p.atom, p.port);
    std::sort(made.ports.begin(), made.ports.end());
    return made;
  }

  std::optional<rt::EnabledSet::Position> find(const StepLabel& wanted) {
    for (u32 rank = 0; rank < core_.enabled().weight(wanted.interaction); ++rank) {
      const rt::EnabledSet::Position at{wanted.interaction, rank};
      if (label(at).ports == wanted.ports) return at;
    }
    return std::nullopt;
  }

  rt::Core core_;
  const SearchGoal& goal_;
  const CancellationToken& token_;
  std::optional<rt::State> initial_;
  std::vector<rt::Participant> participants_;
  std::uint64_t replayed_ = 0;
};

// The steps that those of these atoms depend on, by the atoms that they share: of a run through thousands of components
// mostly few.
std::vector<StepLabel> causal_past(const std::vector<StepLabel>& labels, const std::vector<u32>& atoms) {
  std::unordered_set<u32> needed(atoms.begin(), atoms.end());
  std::vector<StepLabel> past;
  for (std::size_t k = labels.size(); k-- > 0;) {
    const auto is_needed = [&](const std::pair<u32, u32>& port) { return needed.contains(port.first); };
    if (std::none_of(labels[k].ports.begin(), labels[k].ports.end(), is_needed)) continue;
    for (const auto& [atom, port] : labels[k].ports) needed.insert(atom);
    past.push_back(labels[k]);
  }
  std::reverse(past.begin(), past.end());
  return past;
}

// A run that becomes shorter.
class ShrinkingRun {
 public:
  ShrinkingRun(Replayer& replayer, std::vector<StepLabel> labels) : replayer_(replayer) { replace(std::move(labels)); }

  [[nodiscard]] const std::vector<StepLabel>& labels() const { return labels_; }
  [[nodiscard]] bool is_over() const { return replayer_.is_over(); }

  // Leaves out the steps from `begin` on, before `end`, if it reaches the goal then; its end may come sooner.
  bool leave_out(std::size_t begin, std::size_t end) {
    if (first_stays_possible(begin, end)) return false;
    std::vector<StepLabel> fewer(labels_.begin(), labels_.begin() + static_cast<std::ptrdiff_t>(begin));
    fewer.insert(fewer.end(), labels_.begin() + static_cast<std::ptrdiff_t>(end), labels_.end());
    if (!replayer_.take(fewer)) return false;
    replace(std::move(fewer));
    return true;
  }

  void replace(std::vector<StepLabel> labels) {
    labels_ = std::move(labels);
    last_step_.clear();
    for (std::size_t k = 0; k < labels_.size(); ++k)
      for (const auto& [atom, port] : labels_[k].ports) last_step_[atom] = k;
  }

 private:
  // No deadlock without these steps: if no atom of the first one takes part in what follows them, these atoms end as
  // they were before it, and it is possible still.
  [[nodiscard]] bool first_stays_possible(std::size_t begin, std::size_t end) const {
    const auto ends_before = [&](const std::pair<u32, u32>& port) { return last_step_.at(port.first) < end; };
    return replayer_.ends_in_deadlock() &&
           std::all_of(labels_[begin].ports.begin(), labels_[begin].ports.end(), ends_before);
  }

  Replayer& replayer_;
  std::vector<StepLabel> labels_;
  std::unordered_map<u32, std::size_t> last_step_;  // by atom
};

// Leaves blocks out, from the end to the beginning: what comes late is needed by less.
void leave_out_blocks(ShrinkingRun& run) {
  std::size_t size = std::max<std::size_t>(run.labels().size() / 2, 1);
  for (bool is_smaller = false;; is_smaller = false) {
    for (std::size_t end = run.labels().size(); end > 0 && !run.is_over();) {
      const std::size_t begin = end > size ? end - size : 0;
      if (run.leave_out(begin, end)) is_smaller = true;
      end = begin;
    }
    if (run.is_over() || (size == 1 && !is_smaller)) return;
    if (size > 1) size /= 2;
  }
}

// Of a short run, leaves out any block, at whatever step it begins: a component that comes and goes, of which no step
// alone can be left out. Returns whether there was one.
bool leave_out_any_block(ShrinkingRun& run) {
  constexpr std::size_t kShort = 64;
  const std::size_t steps = run.labels().size();
  if (steps > kShort) return false;
  for (std::size_t size = 2; size < steps; ++size) {
    for (std::size_t end = steps; end >= size && !run.is_over(); --end) {
      if (run.leave_out(end - size, end)) return true;
    }
  }
  return false;
}

// An order of the steps in which those of each atom keep theirs: next comes a step that depends on the one placed last,
// else on the one before that, …, else the first one that is left. A step depends on the step before it of each of its
// atoms. Cost: n log n.
std::vector<StepLabel> order_by_cause(const std::vector<StepLabel>& labels) {
  struct Step {
    std::vector<std::size_t> dependents;
    std::size_t missing = 0;     // steps that it depends on and that are not placed
    std::size_t last_cause = 0;  // place of the last one of those, from 1 on; 0: none
  };
  std::vector<Step> steps(labels.size());
  std::unordered_map<u32, std::size_t> last_of_atom;
  for (std::size_t k = 0; k < labels.size(); ++k) {
    for (const auto& [atom, port] : labels[k].ports) {
      const auto [before, is_first] = last_of_atom.try_emplace(atom, k);
      if (is_first || before->second == k) continue;
      steps[before->second].dependents.push_back(k);
      ++steps[k].missing;
      before->second = k;
    }
  }
  // Of the steps that can be placed, the one with the latest cause, of several the first.
  const auto comes_later = [&steps](std::size_t a, std::size_t b) {
    return steps[a].last_cause != steps[b].last_cause ? steps[a].last_cause < steps[b].last_cause : a > b;
  };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(comes_later)> ready(comes_later);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    if (steps[k].missing == 0) ready.push(k);
  }
  std::vector<StepLabel> ordered;
  ordered.reserve(labels.size());
  while (!ready.empty()) {
    const std::size_t next = ready.top();
    ready.pop();
    ordered.push_back(labels[next]);
    for (const std::size_t k : steps[next].dependents) {
      steps[k].last_cause = ordered.size();
      if (--steps[k].missing == 0) ready.push(k);
    }
  }
  BIP_ASSERT(ordered.size() == labels.size(), "{} of {} steps", ordered.size(), labels.size());
  return ordered;
}

// The atoms that take part in a run.
class RunAtoms {
 public:
  explicit RunAtoms(const rt::Image& image) : takes_part_(image.atoms.size) {}

  void add(rt::Core& core, std::uint64_t choice) {
    core.participants(core.candidate(choice), participants_);
    for (const rt::Participant& p : participants_) takes_part_[p.atom] = true;
  }
  [[nodiscard]] bool touches(rt::Core& core, std::uint64_t choice) {
    core.participants(core.candidate(choice), participants_);
    return std::any_of(participants_.begin(), participants_.end(),
                       [this](const rt::Participant& p) { return takes_part_[p.atom]; });
  }

 private:
  std::vector<bool> takes_part_;
  std::vector<rt::Participant> participants_;
};

// Searches for a run that avoids the goal: it ends elsewhere, or goes on for ever. One that goes on for ever counts
// only if it does so with atoms of the run, or if these can do nothing again and again: that others move beside them is
// no way out. Strong components by depth-first search (Tarjan 1972); an edge is *fair* if it makes its component one in
// which such a run can stay.
//
// StrongComponents (runtime/core/graph_algorithms.hpp) does not fit: it visits all that the start reaches and closes
// whole components, of nodes that are numbered before. Here states are made while the search goes, it ends at the first
// fair edge that closes a cycle, often long before that component is complete, and the path at that moment is the
// answer.
class Avoidance {
 public:
  enum class Answer : std::uint8_t { Possible, Impossible, Unknown };

  // The core may be in any state, and is left in any.
  Avoidance(rt::Core& core, const SearchGoal& goal, RunAtoms& atoms, const CancellationToken& token)
      : core_(core),
        goal_(goal),
        atoms_(atoms),
        token_(token),
        node_of_state_(0, StateHash{states_}, StateEquality{states_}) {}
  Avoidance(const Avoidance&) = delete;
  Avoidance& operator=(const Avoidance&) = delete;

  // `way_out`: the first step of such a run that atoms of the run take part in, if there is one.
  Answer from(const rt::State& state, std::string& way_out) {
    nodes_.clear();
    node_of_state_.clear();
    states_.clear();
    open_.clear();
    path_.clear();
    if (!core_.restore(state) || is_goal_state(core_, goal_)) return Answer::Impossible;
    if (core_.candidate_count() == 0) return Answer::Possible;
    bool meets_errors = false;
    (void)find_or_add_state();
    push(Edge::OfOthers);
    bool is_at_end = true;  // the core is in the state at the end of the path
    while (!path_.empty()) {
      Frame& frame = path_.back();
      if (!is_at_end && !core_.restore(states_[frame.node])) return Answer::Unknown;
      is_at_end = false;
      if (!choose_next(frame)) {
        if (leave()) return found(way_out);
        continue;
      }
      if (nodes_.size() > kAvoidingStates || nodes_.size() * state_key_bytes(states_.front()) > kStoredBytes ||
          token_.is_cancelled())
        return Answer::Unknown;
      const Edge edge = frame.is_touching || !frame.has_touching ? Edge::Fair : Edge::OfOthers;
      if (!core_.fire(frame.choice)) {
        meets_errors = meets_errors || !goal_.faults;
        continue;
      }
      if (is_goal_state(core_, goal_)) continue;
      if (core_.candidate_count() == 0) return found(way_out);
      if (const std::optional<u32> known = find_or_add_state()) {
        if (closes_fair_cycle(nodes_[*known], edge)) return found(way_out);
      } else {
        push(edge);
        is_at_end = true;
      }
    }
    return meets_errors ? Answer::Unknown : Answer::Impossible;
  }

 private:
  enum class Edge : std::uint8_t { Fair, OfOthers };
  struct Node {
    u32 low = 0;  // Tarjan's lowlink
    bool is_open = true;
    std::size_t depth = 0;  // on the path; else kOffPath
  };
  struct Frame {
    u32 node = 0;
    Edge edge = Edge::OfOthers;         // that led here
    std::size_t fair_before = 0;        // fair edges of the path up to here
    std::uint64_t choice = 0;           // the step that is tried
    bool is_touching = true;            // it touches atoms of the run; those that do are tried first
    bool has_touching = false;          // some step does
    std::uint64_t next = 0;             // of the candidates; then of `others`
    std::vector<std::uint64_t> others;  // candidates that touch no atom of the run
  };
  static constexpr std::size_t kOffPath = ~std::size_t{0};
  struct StateHash {
    const std::deque<rt::State>& states;
    std::size_t operator()(u32 node) const {
      const auto hash = [](const auto& values) {
        return std::hash<std::string_view>{}(
            {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])});
      };
      return (hash(states[node].places) * 31 + hash(states[node].marks)) * 31 + hash(states[node].data.rows());
    }
  };
  struct StateEquality {
    const std::deque<rt::State>& states;
    bool operator()(u32 a, u32 b) const { return states[a] == states[b]; }
  };

  // The next step from the end of the path, in whose state the core is; false: all were tried.
  bool choose_next(Frame& frame) {
    for (; frame.is_touching && frame.next < core_.candidate_count(); ++frame.next) {
      if (!atoms_.touches(core_, frame.next)) {
        frame.others.push_back(frame.next);
        continue;
      }
      frame.has_touching = true;
      frame.choice = frame.next++;
      return true;
    }
    if (frame.is_touching) {
      frame.is_touching = false;
      frame.next = 0;
    }
    if (frame.next == frame.others.size()) return false;
    frame.choice = frame.others[frame.next++];
    return true;
  }

  // The node of the core's state; nothing: it was not met before, and its state is added.
  std::optional<u32> find_or_add_state() {
    states_.push_back(core_.snapshot());
    const auto [known, is_new] = node_of_state_.insert(static_cast<u32>(states_.size() - 1));
    if (is_new) return std::nullopt;
    states_.pop_back();
    return *known;
  }

  // By an edge from the end of the path to a node that was there before.
  bool closes_fair_cycle(const Node& node, Edge edge) {
    if (!node.is_open) return false;
    Frame& frame = path_.back();
    nodes_[frame.node].low = std::min(nodes_[frame.node].low, node.low);
    return edge == Edge::Fair || (node.depth != kOffPath && frame.fair_before > path_[node.depth].fair_before);
  }

  // To the state that was added last.
  void push(Edge edge) {
    BIP_ASSERT(nodes_.size() + 1 == states_.size(), "{} nodes of {} states", nodes_.size(), states_.size());
    Frame frame;
    frame.node = static_cast<u32>(nodes_.size());
    frame.edge = edge;
    frame.fair_before = (path_.empty() ? 0 : path_.back().fair_before) + (edge == Edge::Fair ? 1 : 0);
    nodes_.push_back({.low = frame.node, .depth = path_.size()});
    open_.push_back(frame.node);
    path_.push_back(std::move(frame));
  }

  // Returns whether the edge that led to the end of the path is fair and within a component.
  bool leave() {
    const u32 row = path_.back().node;
    const Edge edge = path_.back().edge;
    Node& node = nodes_[row];
    node.depth = kOffPath;
    if (node.low == row) {
      while (nodes_[row].is_open) {
        nodes_[open_.back()].is_open = false;
        open_.pop_back();
      }
      path_.pop_back();
      return false;
    }
    path_.pop_back();
    if (edge == Edge::Fair) return true;
    Node& parent = nodes_[path_.back().node];
    parent.low = std::min(parent.low, node.low);
    return false;
  }

  Answer found(std::string& way_out);

  rt::Core& core_;
  const SearchGoal& goal_;
  RunAtoms& atoms_;
  const CancellationToken& token_;
  std::vector<Node> nodes_;       // in the order of their discovery
  std::deque<rt::State> states_;  // by node
  std::unordered_set<u32, StateHash, StateEquality> node_of_state_;
  std::vector<u32> open_;  // Tarjan's stack
  std::vector<Frame> path_;
};

std::string step_text(rt::Core& core, std::uint64_t choice) {
  std::string line;
  rt::StepWriter().step(line, core, core.candidate(choice), 0);
  // Without its number and its newline.
  const std::size_t begin = line.find_first_not_of(' ', line.find(' '));
  return line.substr(begin, line.find('\n') - begin);
}

Avoidance::Answer Avoidance::found(std::string& way_out) {
  const auto touching = std::find_if(path_.begin(), path_.end(), [](const Frame& f) { return f.is_touching; });
  const Frame& frame = touching != path_.end() ? *touching : path_.front();
  if (!core_.restore(states_[frame.node])) return Answer::Unknown;
  way_out = step_text(core_, frame.choice);
  return Answer::Possible;
}

}  // namespace

std::vector<std::uint64_t> relevant_steps(const rt::Image& image, const SearchGoal& goal,
                                          const std::vector<std::uint64_t>& choices, const CancellationToken& token) {
  Replayer replayer(image, goal, token);
  std::vector<StepLabel> labels = replayer.read(choices);
  if (!replayer.take(labels)) return choices;
  std::vector<u32> atoms = goal.atoms;
  if (goal.faults) {
    for (const auto& [atom, port] : labels.back().ports) atoms.push_back(atom);
  }
  if (!atoms.empty()) {
    // Under priorities the others may matter, too.
    std::vector<StepLabel> past = causal_past(labels, atoms);
    if (replayer.take(past)) labels = std::move(past);
  }
  ShrinkingRun needed(replayer, std::move(labels));
  leave_out_blocks(needed);
  // In another order of the same steps others can be left out: under priorities, and as a block.
  for (;;) {
    std::vector<StepLabel> by_cause = order_by_cause(needed.labels());
    std::optional<std::vector<std::uint64_t>> ordered = replayer.take(by_cause);
    if (!ordered) break;
    ShrinkingRun fewer(replayer, by_cause);
    while (leave_out_any_block(fewer)) leave_out_blocks(fewer);
    if (fewer.labels().size() == by_cause.size() && by_cause != needed.labels()) leave_out_blocks(fewer);
    if (fewer.labels().size() == by_cause.size()) return std::move(*ordered);
    needed.replace(fewer.labels());
  }
  labels = needed.labels();
  std::optional<std::vector<std::uint64_t>> same = replayer.take(labels);
  BIP_ENSURE(same, "a run of {} steps is not the same the second time", labels.size());
  return std::move(*same);
}

std::optional<DecidingStep> deciding_step(const rt::Image& image, const SearchGoal& goal,
                                          const std::vector<std::uint64_t>& choices, const CancellationToken& token) {
  rt::Core core(image);
  constexpr std::size_t kMostSteps = 10'000;
  if (choices.empty() || choices.size() > kMostSteps || !core.initialize()) return std::nullopt;
  if (choices.size() * state_key_bytes(core.snapshot()) > kStoredBytes) return std::nullopt;
  RunAtoms atoms(image);
  // Of every kStride-th step; those between are taken again when they are asked for.
  constexpr std::size_t kStride = 16;
  std::vector<rt::State> states;
  bool has_choice = false;
  std::size_t taken = 0;
  for (; taken < choices.size(); ++taken) {
    has_choice = has_choice || core.candidate_count() > 1;
    if (taken % kStride == 0) states.push_back(core.snapshot());
    atoms.add(core, choices[taken]);
    // The last step may end in the error that the run shows.
    if (!core.fire(choices[taken]) && taken + 1 < choices.size()) break;
  }
  BIP_ENSURE(taken == choices.size(), "the run ends after {} of {} steps", taken, choices.size());
  if (!has_choice) return std::nullopt;
  const auto state_before = [&](std::size_t step) -> std::optional<rt::State> {
    if (!core.restore(states[step / kStride])) return std::nullopt;
    for (std::size_t k = step - step % kStride; k < step; ++k) {
      if (!core.fire(choices[k])) return std::nullopt;
    }
    return core.snapshot();
  };
  Avoidance avoidance(core, goal, atoms, token);
  // Once the goal cannot be avoided it stays so: the last state where it can be is found by halving.
  std::size_t low = 0, high = choices.size();  // states below `low` have a way out, those from `high` on have none
  DecidingStep found;
  bool has_way_out = false;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    const std::optional<rt::State> state = state_before(middle);
    if (!state) return std::nullopt;
    std::string way_out;
    switch (avoidance.from(*state, way_out)) {
      case Avoidance::Answer::Unknown: return std::nullopt;
      case Avoidance::Answer::Impossible: high = middle; break;
      case Avoidance::Answer::Possible:
        found = {middle, std::move(way_out)};
        has_way_out = true;
        low = middle + 1;
        break;
    }
  }
  if (!has_way_out) return DecidingStep{};
  BIP_ASSERT(found.step + 1 == low, "the way out at {} is not the last one before {}", found.step, low);
  return found;
}

}  // namespace bip::verify
