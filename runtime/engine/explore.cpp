// All reachable stable states, breadth first, by the core's own fire and restore: what is counted is what runs.
//
// Every candidate counts, whatever the policy. A state is remembered as the core's State; equal states are found by a hash
// and compared in full, so the count is exact. Memory: one State a reachable state; time: one restore and one fire a step.
// A state whose step ends in a run-time error counts once as an error and is not left by that step.
#include <cstring>
#include <string>
#include <unordered_map>
#include <vector>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

namespace {

constexpr u32 kNoParent = kNone;
// A sign of life in the published form: one dot for so many states, up to a line.
constexpr std::uint64_t kStatesPerDot = 1000;

u64 mix(u64 hash, u64 value) {
  hash ^= value + 0x9e3779b97f4a7c15ull + (hash << 6) + (hash >> 2);
  hash *= 0xff51afd7ed558ccdull;
  return hash ^ (hash >> 32);
}

u64 hash_of(const State& state) {
  u64 hash = 0;
  for (const u32 place : state.places) hash = mix(hash, place);
  for (const u64 word : state.marks) hash = mix(hash, word);
  for (const u64 word : state.data) hash = mix(hash, word);
  return hash;
}

class Explorer {
 public:
  Explorer(const Image& image, const RunOptions& options, std::FILE* out, std::FILE* err)
      : image_(image),
        options_(options),
        out_(out),
        err_(err),
        core_(image, {.progress = options.maximal_progress ? MaximalProgress::On : MaximalProgress::Off}) {}

  ExploreResult run() {
    const InterruptGuard guard;
    const bool is_bip2 = options_.format == TraceFormat::Bip2;
    if (is_bip2) std::fputs("[BIP ENGINE]: initialize components...\n[BIP ENGINE]: computing reachable states: ", out_);
    std::fflush(out_);
    if (!core_.initialize()) {
      note_error(kNoParent, 0);
    } else {
      (void)add(kNoParent, 0);
      for (std::size_t row = 0; row < states_.size() && result_.complete; ++row) {
        if (is_bip2 && row % kStatesPerDot == 0) {
          std::fputc('.', out_);
          std::fflush(out_);
        }
        expand(static_cast<u32>(row));
        if (is_interrupted()) result_.complete = false;
      }
    }
    result_.states = states_.size();
    result_.exit_code = result_.errors > 0 ? 1 : result_.complete ? 0 : 4;
    is_bip2 ? tell_bip2() : tell();
    return result_;
  }

 private:
  struct Origin {
    u32 parent;
    std::uint64_t candidate;
  };

  // False if the limit is reached and the state is new.
  bool add(u32 parent, std::uint64_t candidate) {
    State state = core_.snapshot();
    const u64 hash = hash_of(state);
    const auto [first, last] = rows_.equal_range(hash);
    for (auto it = first; it != last; ++it) {
      if (states_[it->second] == state) return true;
    }
    if (states_.size() >= options_.limit) return false;
    rows_.emplace(hash, static_cast<u32>(states_.size()));
    states_.push_back(std::move(state));
    origins_.push_back({parent, candidate});
    return true;
  }

  void expand(u32 row) {
    if (!core_.restore(states_[row])) return note_error(row, 0);
    const std::uint64_t count = core_.candidate_count();
    if (count == 0 && result_.deadlocks++ == 0) first_deadlock_ = row;
    bool has_error = false;
    for (std::uint64_t k = 0; k < count; ++k) {
      if (k > 0 && !core_.restore(states_[row])) return note_error(row, k);
      if (!core_.fire(k)) {
        if (!has_error) note_error(row, k);
        has_error = true;
      } else {
        if (!add(row, k)) {
          result_.complete = false;
          return;
        }
        ++steps_;
      }
    }
  }

  void note_error(u32 row, std::uint64_t k) {
    if (result_.errors++ > 0) return;
    error_text_ = text_of(core_.fault(), image_, 0, row == kNoParent ? 0 : path_to(row).size());
    // Nothing was drawn here, so there is no seed to tell.
    if (const std::size_t at = error_text_.find(", seed 0)"); at != std::string::npos) error_text_.erase(at, std::strlen(", seed 0"));
    if (row != kNoParent) error_path_ = names_on(row, &k);
  }

  [[nodiscard]] std::vector<std::uint64_t> path_to(u32 row) const {
    std::vector<std::uint64_t> path;
    for (; origins_[row].parent != kNoParent; row = origins_[row].parent) path.push_back(origins_[row].candidate);
    return {path.rbegin(), path.rend()};
  }

  // The names of the steps to a state, and of one more from there.
  std::string names_on(u32 row, const std::uint64_t* last) {
    std::vector<std::uint64_t> path = path_to(row);
    if (last != nullptr) path.push_back(*last);
    std::string names;
    if (!core_.restore(states_[0])) return names;
    for (std::size_t i = 0; i < path.size(); ++i) {
      // A step that fails while it is taken has a name all the same.
      if (path[i] >= core_.candidate_count()) break;
      names += names.empty() ? "" : ", ";
      append_candidate(names, core_, core_.candidate(path[i]));
      if (i + 1 < path.size() && !core_.fire(path[i])) break;
    }
    return names;
  }

  static std::string counted(std::uint64_t n, const char* what, bool singular_zero) {
    std::string text;
    append_number(text, n);
    text += ' ';
    text += what;
    if (n > 1 || (n == 0 && !singular_zero)) text += 's';
    return text;
  }

  void tell_bip2() {
    std::string text = " found " + counted(result_.states, "reachable state", true) + ", " + counted(result_.deadlocks, "deadlock", true) + ", and " +
                       counted(result_.errors, "error", true);
    if (!result_.complete) text += is_interrupted() ? " (interrupted)" : " (limit reached)";
    text += '\n';
    write(out_, text);
    write(err_, error_text_);
  }

  void tell() {
    std::string text;
    if (!options_.silent && result_.deadlocks > 0) text += "deadlock after " + steps_to(first_deadlock_, nullptr);
    if (!options_.silent && !error_path_.empty()) text += "error in the last step of " + error_path_ + "\n";
    text += result_.complete ? "explored: " : is_interrupted() ? "interrupted: at least " : "limit: at least ";
    text += counted(result_.states, "reachable state", false) + ", " + counted(steps_, "step", false) + ", " +
            counted(result_.deadlocks, "deadlock", false) + ", " + counted(result_.errors, "error", false) + "\n";
    write(out_, text);
    write(err_, error_text_);
  }

  std::string steps_to(u32 row, const std::uint64_t* last) {
    std::string text = counted(path_to(row).size(), "step", false);
    const std::string names = names_on(row, last);
    return text + (names.empty() ? "" : ": " + names) + "\n";
  }

  static void write(std::FILE* file, const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), file);
    std::fflush(file);
  }

  const Image& image_;
  const RunOptions& options_;
  std::FILE* out_;
  std::FILE* err_;
  Core core_;
  std::vector<State> states_;
  std::vector<Origin> origins_;
  std::unordered_multimap<u64, u32> rows_;  // by hash
  ExploreResult result_;
  std::uint64_t steps_ = 0;
  u32 first_deadlock_ = 0;
  std::string error_text_, error_path_;
};

}  // namespace

ExploreResult explore(const Image& image, const RunOptions& options, std::FILE* out, std::FILE* err) {
  return Explorer(image, options, out, err).run();
}

}  // namespace bip::rt
