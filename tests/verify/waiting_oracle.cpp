// See waiting_oracle.hpp.
#include "tests/verify/waiting_oracle.hpp"

#include <algorithm>
#include <set>

#include "compiler/verify/portfolio/search_bad_state.hpp"
#include "runtime/core/final_state.hpp"

namespace bip::verify::test {

std::string check_waiting(const rt::Image& image, const std::vector<std::uint64_t>& choices,
                          const std::vector<std::uint32_t>& atoms, std::uint64_t most) {
  rt::Core core(image);
  if (atoms.empty()) return "nobody waits";
  if (!core.initialize()) return "the run has no first state";
  for (const std::uint64_t choice : choices) {
    if (choice >= core.candidate_count() || !core.fire(choice)) return "the way cannot be taken";
  }
  for (const std::uint32_t atom : atoms) {
    if (!rt::wants_to_move(core, atom)) return "a component does not want to move";
  }
  std::set<std::string> seen{state_key(core.snapshot())};
  std::vector<rt::State> open{core.snapshot()};
  std::vector<rt::Participant> participants;
  while (!open.empty() && seen.size() <= most) {
    const rt::State state = std::move(open.back());
    open.pop_back();
    if (!core.restore(state)) return "a state cannot be entered again";
    const std::uint64_t count = core.candidate_count();
    for (std::uint64_t k = 0; k < count; ++k) {
      if (k != 0 && !core.restore(state)) return "a state cannot be entered again";
      participants.clear();
      core.participants(core.candidate(k), participants);
      for (const rt::Participant& p : participants) {
        if (std::find(atoms.begin(), atoms.end(), p.atom) != atoms.end()) return "a component moves later";
      }
      if (core.fire(k) && seen.insert(state_key(core.snapshot())).second) open.push_back(core.snapshot());
    }
  }
  return {};
}

}  // namespace bip::verify::test
