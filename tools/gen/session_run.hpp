// A debugging session against the plain run with the same seed, then a random walk of it: steps, choices, ways back,
// branches, undos. Every state that the session returns to must be the one that it left. Needs the runtime only, so
// that emitted programs of a batch execute the same sessions.
#pragma once
#include <string>
#include <vector>

#include "runtime/debug/session.hpp"
#include "runtime/trace/recorded.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::gen {

/// Begins what session_run returns if something is wrong.
inline constexpr const char* kSessionDiffers = "session differs: ";

/// What a person can see of the state, and what the next choice depends on.
inline std::string session_state(const rt::DebugSession& session) {
  const rt::Core& core = session.core();
  std::string text = std::to_string(rt::digest_of(core)) + " at " + std::to_string(core.now()) + ", " +
                     std::to_string(core.candidate_count()) + " candidates, list";
  for (const rt::InteractionId interaction : core.enabled().list_order())
    text += " " + std::to_string(interaction.value);
  for (std::uint64_t k = 0; k < core.candidate_count() && k < 20; ++k)
    text += " " + std::to_string(core.candidate(k).interaction.value) + "/" + std::to_string(core.candidate(k).config);
  return text;
}

/// Without its last line, which says how a run ended.
inline std::string without_end(const std::string& trace) {
  const std::size_t end = trace.rfind('\n', trace.size() < 2 ? 0 : trace.size() - 2);
  return end == std::string::npos ? "" : trace.substr(0, end + 1);
}

/// `plain`: the JSON trace of the run with these options and events. Returns a text that is the same on all executors.
inline std::string session_run(const rt::Image& image, const rt::SessionOptions& options,
                               const std::string& events_path, std::uint64_t steps, const std::string& plain) {
  std::string text;
  rt::DebugSession session(image, options);
  if (!events_path.empty()) {
    if (const Result<bool> are_read = session.read_events(events_path); !are_read)
      return kSessionDiffers + are_read.error();
  }
  if (session.start() == rt::Halt::Fault) return "the initial state is a fault\n";
  rt::Halt halt = rt::Halt::Done;
  for (std::uint64_t k = 0; k < steps && halt == rt::Halt::Done; ++k) halt = session.step();
  text += "halt " + std::to_string(static_cast<int>(halt)) + " at " + std::to_string(session.position()) + "\n";
  if (halt == rt::Halt::Fault) (void)session.back(1);
  std::string trace;
  if (!session.is_at_fault()) {
    if (!session.append_trace(trace, rt::TraceFormat::Json)) return kSessionDiffers + session.problem();
    const std::string ours = without_end(trace), theirs = without_end(plain);
    // The plain run writes the step that ends in a fault.
    const bool is_prefix = halt == rt::Halt::Fault && theirs.starts_with(ours);
    if (ours != theirs && !is_prefix) return kSessionDiffers + std::string("from the run\n") + ours + theirs;
  }

  // The walk. known: by position on the moves that are recorded now, the state; empty if it was not seen.
  std::uint64_t state = options.seed * 2 + 1;
  const auto draw = [&](std::uint64_t n) {
    return ((state = state * 6364136223846793005u + 1442695040888963407u) >> 33) % n;
  };
  std::vector<std::string> known;
  for (int turn = 0; turn < 60; ++turn) {
    const std::uint64_t before = session.position();
    const std::string left = session.is_at_fault() ? "" : session_state(session);
    const std::vector<std::string> known_before = known;
    const bool is_marked = draw(3) == 0, is_undone = is_marked && draw(2) == 0;
    if (is_marked) session.mark();
    switch (draw(5)) {
      case 0: (void)session.step(); break;
      case 1: {
        if (session.is_at_fault() || session.core().candidate_count() == 0) break;
        const std::uint64_t k = draw(session.core().candidate_count());
        // Another choice: what was ahead is no more.
        if (session.recorded_choice() != k) known.resize(std::min<std::size_t>(known.size(), before + 1));
        (void)session.choose(k);
        break;
      }
      case 2: (void)session.back(1 + draw(9)); break;
      case 3: (void)session.go_to(draw(session.length() + 1)); break;
      default:
        for (std::uint64_t k = draw(8); k > 0; --k) (void)session.step();
        break;
    }
    if (is_undone) {
      (void)session.undo();
      known = known_before;
      if (session.position() != before && !left.empty()) return kSessionDiffers + std::string("undo ends elsewhere");
      if (!session.is_at_fault() && !left.empty() && session_state(session) != left)
        return kSessionDiffers + std::string("undo leads to ") + session_state(session) + ", it was " + left;
    }
    const std::uint64_t at = session.position();
    if (session.is_at_fault()) {
      text += "fault at " + std::to_string(at) + "\n";
      (void)session.back(1);
      continue;
    }
    if (known.size() <= at) known.resize(at + 1);
    const std::string now = session_state(session);
    if (!known[at].empty() && known[at] != now)
      return kSessionDiffers + std::string("state ") + std::to_string(at) + " is " + now + ", it was " + known[at];
    known[at] = now;
    text += std::to_string(at) + ": " + now + "\n";
  }
  // From the begin to the end and back, state by state.
  const std::uint64_t length = session.length();
  std::vector<std::string> way;
  (void)session.go_to(0);
  while (!session.is_at_fault() && session.position() < length) {
    way.push_back(session_state(session));
    (void)session.step();
  }
  if (session.is_at_fault()) (void)session.back(1);
  while (session.position() > 0) {
    const std::uint64_t at = session.position();
    if (at < way.size() && session_state(session) != way[at])
      return kSessionDiffers + std::string("back to ") + std::to_string(at);
    (void)session.back(1);
    if (session.position() != at - 1) return kSessionDiffers + std::string("one step back is none");
  }
  return text;
}

}  // namespace bip::gen
