// See search_bad_state.hpp. Distance of a state: the sum over atoms of the steps that its modes are away from the
// candidate's.
#include "compiler/verify/portfolio/search_bad_state.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <queue>
#include <unordered_map>

#include "compiler/system/system.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr u32 kUnreachable = 1u << 12;
constexpr std::uint64_t kMaxRank = 4096;     // candidates of a state that are weighed on the walk
constexpr std::uint64_t kStepsPerPoll = 16;  // at the clock

// By (class, target mode): distance of each place set to the target's, over the class's moves.
class Distances {
 public:
  Distances(const Net& net, const std::vector<u32>& candidate) : net_(net) {
    if (candidate.size() + 1 != net.mode_base.size()) return;
    std::map<std::pair<u32, u32>, u32> rows;
    for (u32 atom = 0; atom < candidate.size(); ++atom) {
      BIP_ASSERT(candidate[atom] >= net.mode_base[atom] && candidate[atom] < net.mode_base[atom + 1],
                 "mode {} is not of atom {}", candidate[atom], atom);
      const u32 target = candidate[atom] - net.mode_base[atom];
      const auto [found, is_new] = rows.try_emplace({net.class_of[atom], target}, static_cast<u32>(tables_.size()));
      if (is_new) tables_.push_back(table(net.class_at(atom), target));
      table_of_.push_back(found->second);
    }
  }
  [[nodiscard]] bool is_known() const { return !table_of_.empty(); }
  [[nodiscard]] u32 at_place(u32 atom, u32 place) const {
    BIP_ASSERT(atom < table_of_.size(), "atom {} of {} has no distance", atom, table_of_.size());
    const std::vector<u32>& by_place = tables_[table_of_[atom]];
    return place < by_place.size() ? by_place[place] : 0;
  }

 private:
  // By first place of the marking: good enough a guide.
  std::vector<u32> table(const ModeClass& row, u32 target) const {
    std::vector<u32> distance(row.modes.size(), kUnreachable);
    std::vector<u32> queue{target};
    distance[target] = 0;
    for (std::size_t head = 0; head < queue.size(); ++head) {
      for (const PortMove& move : row.in[queue[head]]) {
        if (distance[move.other] != kUnreachable) continue;
        distance[move.other] = distance[queue[head]] + 1;
        queue.push_back(move.other);
      }
    }
    std::vector<u32> by_place(net_.system->atom_types[row.type].places.size(), kUnreachable);
    for (u32 mode = 0; mode < row.modes.size(); ++mode) {
      if (row.modes[mode].places.size() != 1) return {};
      u32& best = by_place[row.modes[mode].places[0]];
      best = std::min(best, distance[mode]);
    }
    return by_place;
  }

  const Net& net_;
  std::vector<std::vector<u32>> tables_;
  std::vector<u32> table_of_;
};

struct Hash {
  std::size_t operator()(const std::string& text) const { return std::hash<std::string>{}(text); }
};

template <class T>
void append_bytes(std::string& out, const std::vector<T>& values) {
  out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

class Search {
 public:
  Search(const Net& net, const rt::Image& image, const SearchGoal& goal, const std::vector<u32>& candidate,
         const SearchLimits& limits)
      : image_(image), core_(image), goal_(goal), distances_(net, candidate), limits_(limits) {}

  SearchResult run() {
    if (!core_.initialize()) {
      // The run ends before its first stable state.
      result_.fault = core_.fault().what;
      result_.end = goal_.faults ? SearchEnd::Found : SearchEnd::Exhausted;
      return std::move(result_);
    }
    if (distances_.is_known() && walk()) return std::move(result_);
    result_.choices.clear();
    if (limits_.only_walk) result_.limit = "a walk";
    else visit_all();
    return std::move(result_);
  }

 private:
  [[nodiscard]] std::int64_t distance(const rt::State& state) const {
    std::int64_t sum = 0;
    if (!distances_.is_known()) return 0;
    for (u32 atom = 0; atom < state.places.size(); ++atom) sum += distances_.at_place(atom, state.places[atom]);
    return sum;
  }

  // What taking the step would do to the distance, from its atoms alone; places are those of the current state.
  [[nodiscard]] std::int64_t gain(const rt::Candidate& candidate, const std::vector<u32>& places) {
    participants_.clear();
    core_.participants(candidate, participants_);
    std::int64_t sum = 0;
    for (const rt::Participant& p : participants_) {
      const u32 row = core_.enabled_transition(p.atom, p.port);
      if (row == rt::kNone) continue;
      const rt::Transition& t = image_.atom_types[image_.atoms[p.atom].type].transitions[row];
      if (t.to.size != 1) continue;
      sum +=
          static_cast<std::int64_t>(distances_.at_place(p.atom, t.to[0])) - distances_.at_place(p.atom, places[p.atom]);
    }
    return sum;
  }

  // Always the step that comes nearest to the candidate, as long as it comes nearer, or does not lead away for too
  // long. A candidate that can be reached like that is, in about as many steps as it is far away: a walk is not to eat
  // the proof's time.
  bool walk() {
    rt::State state = core_.snapshot();
    std::int64_t best = distance(state);
    std::uint64_t idle = 0;
    const std::size_t most = 1000 + 3 * static_cast<std::size_t>(std::max<std::int64_t>(best, 0));
    std::vector<u32> places = state.places;
    while (!limits_.cancellation.is_over()) {
      const std::uint64_t count = core_.candidate_count();
      if (is_goal()) return confirmed();
      if (count == 0) break;
      std::uint64_t chosen = 0;
      std::int64_t least = std::numeric_limits<std::int64_t>::max();
      for (std::uint64_t k = 0; k < std::min(count, kMaxRank); ++k) {
        // Past the first look, ties are broken differently each time, so that the walk does not circle.
        const std::uint64_t at = (k + idle * 7) % count;
        const std::int64_t value = gain(core_.candidate(at), places);
        if (value < least) {
          least = value;
          chosen = at;
          if (value <= -2) break;
        }
      }
      participants_.clear();
      core_.participants(core_.candidate(chosen), participants_);
      const std::vector<rt::Participant> moved = participants_;
      if (!core_.fire(chosen)) {
        result_.fault = core_.fault().what;
        break;
      }
      result_.choices.push_back(chosen);
      for (const rt::Participant& p : moved) places[p.atom] = place_now(p.atom, places[p.atom]);
      ++walked_;
      std::int64_t now = 0;
      // The sum is taken anew only now and then: it costs a pass over the atoms.
      if (walked_ % 64 == 0 || least >= 0) {
        for (u32 atom = 0; atom < places.size(); ++atom) now += distances_.at_place(atom, places[atom]);
      } else {
        now = best - 1;
      }
      idle = now < best ? 0 : idle + 1;
      best = std::min(best, now);
      if (idle > 200 || result_.choices.size() > most) break;
    }
    return false;
  }
  [[nodiscard]] u32 place_now(u32 atom, u32 before) const {
    const rt::AtomType& type = image_.atom_types[image_.atoms[atom].type];
    if (core_.is_marked(atom, before)) return before;
    for (u32 place = 0; place < type.places.size; ++place) {
      if (core_.is_marked(atom, place)) return place;
    }
    return before;
  }

  struct Visited {
    u32 parent = 0;
    u32 choice = 0;
  };
  struct Open {
    std::int64_t distance;
    u32 row;
    bool operator<(const Open& other) const { return std::pair(distance, row) > std::pair(other.distance, other.row); }
  };

  void visit_all() {
    if (!core_.initialize()) return;
    std::unordered_map<std::string, u32, Hash> rows;
    std::vector<Visited> visited;
    std::vector<rt::State> states;
    std::priority_queue<Open> open;
    std::size_t bytes = 0;
    const auto add = [&](u32 parent, u32 choice) {
      rt::State state = core_.snapshot();
      for (const rt::VariableId cell : limits_.unread_cells) state.data[cell] = 0;
      std::string key = state_key(state);
      const std::size_t size = 2 * key.size() + 200;
      const auto [found, is_new] = rows.try_emplace(std::move(key), static_cast<u32>(visited.size()));
      if (!is_new) return false;
      bytes += size;
      if (limits_.visit) limits_.visit(state);
      BIP_ASSERT(found->second == visited.size() && states.size() == visited.size() &&
                     (visited.empty() || parent < visited.size()),
                 "state {} of {} follows state {}", found->second, visited.size(), parent);
      visited.push_back({parent, choice});
      open.push({distance(state), found->second});
      states.push_back(std::move(state));
      return true;
    };
    const auto path_to = [&](u32 row) {
      std::vector<std::uint64_t> choices;
      for (; row != 0; row = visited[row].parent) choices.push_back(visited[row].choice);
      std::reverse(choices.begin(), choices.end());
      return choices;
    };
    add(0, 0);
    if (is_goal()) {
      result_.states = 1;
      confirmed();
      return;
    }
    while (!open.empty()) {
      const u32 row = open.top().row;
      open.pop();
      const rt::State state = std::move(states[row]);
      states[row] = {};
      if (!core_.restore(state)) {
        result_.limit = "a state could not be entered again";
        return;
      }
      const std::uint64_t count = core_.candidate_count();
      for (std::uint64_t k = 0; k < count; ++k) {
        if (k != 0 && !core_.restore(state)) {
          result_.limit = "a state could not be entered again";
          return;
        }
        if (!core_.fire(k)) {
          if (result_.fault.empty()) result_.fault = core_.fault().what;
          if (!goal_.faults) continue;
          result_.states = visited.size();
          result_.choices = path_to(row);
          result_.choices.push_back(k);
          if (!confirmed()) result_.limit = "an error that was found could not be replayed";
          return;
        }
        if (add(row, static_cast<u32>(k)) && is_goal()) {
          result_.states = visited.size();
          result_.choices = path_to(static_cast<u32>(visited.size() - 1));
          if (!confirmed()) result_.limit = "a state that was found could not be entered again";
          return;
        }
        if (visited.size() % 4096 == 0 && limits_.report) limits_.report(visited.size());
        if (visited.size() >= limits_.states || (k % kStepsPerPoll == 0 && limits_.cancellation.is_over()) ||
            bytes > limits_.megabytes * 1000000) {
          result_.states = visited.size();
          result_.limit = bytes > limits_.megabytes * 1000000 ? "memory"
                          : visited.size() >= limits_.states  ? "states"
                                                              : "time";
          return;
        }
      }
    }
    result_.states = visited.size();
    result_.end = SearchEnd::Exhausted;
  }

  [[nodiscard]] bool is_goal() const { return is_goal_state(core_, goal_); }
  // From the initial state, by a core of its own.
  bool confirmed() {
    if (!reaches(image_, goal_, result_.choices)) return false;
    BIP_ASSERT(goal_.faults || !result_.choices.empty() || is_goal(), "a bad initial state that is none");
    result_.end = SearchEnd::Found;
    return true;
  }

  const rt::Image& image_;
  rt::Core core_;
  const SearchGoal& goal_;
  Distances distances_;
  SearchLimits limits_;
  SearchResult result_;
  std::vector<rt::Participant> participants_;
  std::uint64_t walked_ = 0;
};

}  // namespace

std::size_t state_key_bytes(const rt::State& state) {
  return state.places.size() * sizeof(u32) + (state.marks.size() + state.data.size()) * sizeof(std::uint64_t);
}

std::string state_key(const rt::State& state) {
  std::string key;
  key.reserve(state_key_bytes(state));
  append_bytes(key, state.places);
  append_bytes(key, state.marks);
  append_bytes(key, state.data.rows());
  return key;
}

SearchResult search(const Net& net, const rt::Image& image, const SearchGoal& goal, const std::vector<u32>& candidate,
                    const SearchLimits& limits) {
  return Search(net, image, goal, candidate, limits).run();
}

bool is_goal_state(const rt::Core& core, const SearchGoal& goal) {
  return (goal.stuck && rt::is_deadlock(core)) || (goal.state && goal.state(core));
}

bool reaches(const rt::Image& image, const SearchGoal& goal, const std::vector<std::uint64_t>& choices) {
  rt::Core core(image);
  if (!core.initialize()) return goal.faults && choices.empty();
  for (std::size_t step = 0; step < choices.size(); ++step) {
    if (choices[step] >= core.candidate_count()) return false;
    if (!core.fire(choices[step])) return goal.faults && step + 1 == choices.size();
  }
  return is_goal_state(core, goal);
}

std::string fault_of(const rt::Image& image, const std::vector<std::uint64_t>& choices) {
  rt::Core core(image);
  bool goes_on = core.initialize();
  for (std::size_t k = 0; k < choices.size() && goes_on; ++k)
    goes_on = choices[k] < core.candidate_count() && core.fire(choices[k]);
  return goes_on ? std::string() : std::string(core.fault().what);
}

}  // namespace bip::verify
