// See timed.hpp. Linear in the types.
#include "compiler/system/timed.hpp"

#include <fmt/format.h>

namespace bip::system {

std::string first_timed(const System& system) {
  const auto told = [&](const AtomType& type, const std::string& what, const Loc& loc) {
    const std::string place = loc.line == 0 ? "" : fmt::format(" ({}:{}:{})", system.files[loc.file], loc.line, loc.column);
    return fmt::format("atom type `{}` has {}{}", type.name, what, place);
  };
  std::vector<bool> is_used(system.atom_types.size());
  for (const Atom& atom : system.atoms) is_used[atom.type.value] = true;
  std::size_t row = 0;
  for (const AtomType& type : system.atom_types) {
    if (!is_used[row++]) continue;
    if (!type.clocks.empty()) return told(type, fmt::format("clock `{}`", type.clocks[0].name), type.clocks[0].loc);
    for (const Port& port : type.ports) {
      if (port.external) return told(type, fmt::format("port `{}` for events from outside", port.name), port.loc);
    }
    for (const Transition& t : type.transitions) {
      if (t.urgency != Urgency::Lazy) return told(type, fmt::format("a transition that is {}", name_of(t.urgency)), t.loc);
      if (t.resume.present) return told(type, "a transition with `resume`", t.loc);
    }
    if (type.initial_resume.present) return told(type, "`resume` at its start", type.initial_resume.loc);
  }
  return {};
}

}  // namespace bip::system
