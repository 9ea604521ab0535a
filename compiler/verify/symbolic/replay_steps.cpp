// See replay_steps.hpp.
#include "compiler/verify/symbolic/replay_steps.hpp"

#include <algorithm>

namespace bip::verify {

std::optional<std::uint64_t> candidate_of(rt::Core& core, const SystemStep& step) {
  // A step whose parts depend on the state is the only candidate of its variable.
  bool is_fixed = true;
  std::vector<std::uint32_t> wanted, has;
  for (const auto& [port, when] : step.parts) {
    is_fixed = is_fixed && when == kTrue;
    wanted.push_back(port);
  }
  std::sort(wanted.begin(), wanted.end());
  std::vector<rt::Participant> participants;
  for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
    const rt::Candidate candidate = core.candidate(k);
    if (candidate.interaction != step.interaction) continue;
    if (!is_fixed) return k;
    participants.clear();
    core.participants(candidate, participants);
    has.clear();
    for (const rt::Participant& p : participants) has.push_back(core.tables().instance(p.atom, p.port));
    std::sort(has.begin(), has.end());
    if (has == wanted) return k;
  }
  return std::nullopt;
}

std::optional<std::vector<std::uint64_t>> replay_to_fault(const rt::Image& image,
                                                          const TransitionSystem& transition_system,
                                                          const std::vector<std::uint32_t>& steps) {
  rt::Core core(image);
  if (!core.initialize()) return std::vector<std::uint64_t>{};
  std::vector<std::uint64_t> choices;
  for (std::uint32_t row : steps) {
    const std::optional<std::uint64_t> k = candidate_of(core, transition_system.steps[row]);
    if (!k) return std::nullopt;
    choices.push_back(*k);
    if (!core.fire(*k)) return choices;
  }
  return std::nullopt;
}

std::optional<std::vector<std::uint64_t>> replay_steps(const rt::Image& image,
                                                       const TransitionSystem& transition_system,
                                                       const std::vector<std::uint32_t>& steps) {
  rt::Core core(image);
  if (!core.initialize()) return std::nullopt;
  std::vector<std::uint64_t> choices;
  for (std::uint32_t row : steps) {
    const std::optional<std::uint64_t> k = candidate_of(core, transition_system.steps[row]);
    if (!k || !core.fire(*k)) return std::nullopt;
    choices.push_back(*k);
  }
  return choices;
}

}  // namespace bip::verify
