// See counterexample_text.hpp.
#include "compiler/verify/evidence/counterexample_text.hpp"

#include "compiler/system/system_ids.hpp"
#include "runtime/core/deadlock_explanation.hpp"
#include "runtime/core/text.hpp"
#include "runtime/include/bip/assert.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::verify {

namespace {

constexpr std::size_t kStuckShown = 20;

// No seed: these steps were chosen one by one.
void drop_seed(std::string& text) {
  if (const std::size_t at = text.find(", seed 0)"); at != std::string::npos) text.erase(at, 8);
}

std::string step_count(std::size_t count) { return std::to_string(count) + (count == 1 ? " step)" : " steps)"); }

// With time the instant, too: what can be done may change by itself.
std::string where(const rt::Core& core, std::size_t steps) {
  if (!core.is_timed()) return step_count(steps);
  std::string out = std::to_string(steps) + (steps == 1 ? " step, at " : " steps, at ");
  rt::append_time(out, core.now());
  return out + ')';
}

std::string error_text(const rt::Core& core, std::size_t steps) {
  std::string out = "violated[V0003]: a run-time error can occur   (" + step_count(steps) + '\n';
  std::string fault = rt::fault_text(core, 0, steps);
  drop_seed(fault);
  return out + fault;
}

}  // namespace

std::string stuck_state(const rt::Core& core, const std::vector<u32>& stuck, std::size_t steps) {
  const std::string who = stuck.size() == 1 ? "1 component waits" : std::to_string(stuck.size()) + " components wait";
  std::string out = "deadlock[V0004]: " + who + " for ever, whatever the others do   (" + where(core, steps) + '\n';
  for (std::size_t k = 0; k < stuck.size() && k < kStuckShown; ++k) {
    const rt::Atom& row = core.image().atoms[stuck[k]];
    const rt::AtomType& type = core.image().atom_types[row.type];
    out += std::string("  ") + rt::relative(row.path().c_str()) + " at `" + rt::places_of(core, stuck[k]) + "`  ";
    rt::append_line(out, core.image(), row.loc);
    const char* before = "   wants ";
    for (u32 port = 0; port < type.ports.size; ++port) {
      if (core.enabled_transition(stuck[k], port) == rt::kNone) continue;
      out += std::string(before) + type.ports[port].name;
      before = ", ";
    }
    out += '\n';
  }
  if (stuck.size() > kStuckShown) out += "  … and " + std::to_string(stuck.size() - kStuckShown) + " more\n";
  return out;
}

std::string broken_state(const rt::Core& core, const Property& property, std::size_t steps) {
  const char* const fault =
      has_fault(property, core) ? "  a division in the property fails here: by 0, or of the least int by -1\n" : "";
  return "violated[V0002]: `" + property.text + "`   (" + where(core, steps) + '\n' + fault +
         atoms_text(core, atoms_of(property));
}

std::string atoms_text(const rt::Core& core, const std::vector<u32>& atoms) {
  std::string out;
  for (const u32 atom : atoms) {
    const rt::Atom& row = core.image().atoms[atom];
    out += std::string("  ") + rt::relative(row.path().c_str()) + " at `" + rt::places_of(core, atom) + "`  ";
    rt::append_line(out, core.image(), row.loc);
    const std::string data = rt::data_of(core, atom);
    out += (data.empty() ? "" : "  " + data) + '\n';
  }
  return out;
}

std::string counterexample_text(const rt::Image& image, const Question& question, const Counterexample& found,
                                std::size_t max_lines) {
  const std::vector<std::uint64_t>& choices = found.choices;
  // Which atoms wait for ever is not to be seen in the last state alone: the counterexample says it.
  if (question.what != QuestionKind::NoLocalDeadlock && !reaches(image, goal_of(question), choices)) return {};
  rt::Core core(image);
  std::string out;
  rt::StepWriter writer;
  bool goes_on = core.initialize();
  for (std::size_t step = 0; step < choices.size() && goes_on; ++step) {
    if (step < max_lines) writer.step(out, core, core.candidate(choices[step]), step);
    if (step == max_lines && max_lines != 0) out += "… and " + std::to_string(choices.size() - step) + " more steps\n";
    goes_on = core.fire(choices[step]);
  }
  if (!goes_on) return out + error_text(core, choices.size());
  switch (question.what) {
    case QuestionKind::NoLocalDeadlock: return out + stuck_state(core, found.deadlocked_atoms, choices.size());
    case QuestionKind::State: return out + broken_state(core, question.property, choices.size());
    case QuestionKind::DeadlockFreedom:
    case QuestionKind::NoErrors:
    case QuestionKind::Runs:
    case QuestionKind::Branching: break;
  }
  std::string story = rt::deadlock_story(core, choices.size(), 0);
  drop_seed(story);
  return out + story;
}

}  // namespace bip::verify
