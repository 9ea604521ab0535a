// See uses_time.hpp. Linear in the types.
#include "compiler/system/uses_time.hpp"

#include <fmt/format.h>

#include "compiler/system/system.hpp"

namespace bip::system {

namespace {

std::string told(const System& system, const AtomType& type, const std::string& what, const Loc& loc) {
  const std::string place =
      loc.line == 0 ? "" : fmt::format(" ({}:{}:{})", system.files[loc.file], loc.line, loc.column);
  return fmt::format("atom type `{}` has {}{}", type.name, what, place);
}

// The first answer that `ask` gives for a type with instances.
template <class Ask>
std::string first_of(const System& system, const Ask& ask) {
  std::vector<bool> is_used(system.atom_types.size());
  for (const Atom& atom : system.atoms) is_used[atom.type.value] = true;
  std::size_t row = 0;
  for (const AtomType& type : system.atom_types) {
    if (!is_used[row++]) continue;
    if (std::string found = ask(type); !found.empty()) return found;
  }
  return {};
}

std::string event_port_of(const System& system, const AtomType& type) {
  for (const Port& port : type.ports) {
    if (port.external) return told(system, type, fmt::format("port `{}` for events from outside", port.name), port.loc);
  }
  return {};
}

}  // namespace

std::string first_event_port(const System& system) {
  return first_of(system, [&](const AtomType& type) { return event_port_of(system, type); });
}

std::string first_event_with_object(const System& system) {
  return first_of(system, [&](const AtomType& type) -> std::string {
    for (const Port& port : type.ports) {
      if (!port.external) continue;
      for (const Variable& var : system.port_types[port.type].variables) {
        if (is_ffi(var.type))
          return told(system, type, fmt::format("port `{}` for events with `{}`, a C++ object", port.name, var.name),
                      port.loc);
      }
    }
    return {};
  });
}

std::string first_resume(const System& system) {
  return first_of(system, [&](const AtomType& type) -> std::string {
    for (const Transition& t : type.transitions)
      if (t.resume.present) return told(system, type, "a transition with `resume`", t.loc);
    return type.initial_resume.present ? told(system, type, "`resume` at its start", type.initial_resume.loc) : "";
  });
}

std::string first_timed(const System& system) {
  return first_of(system, [&](const AtomType& type) -> std::string {
    if (!type.clocks.empty())
      return told(system, type, fmt::format("clock `{}`", type.clocks[0].name), type.clocks[0].loc);
    for (const Transition& t : type.transitions) {
      if (t.urgency != Urgency::Lazy)
        return told(system, type, fmt::format("a transition that is {}", name_of(t.urgency)), t.loc);
      if (t.async.present) return told(system, type, "an action that runs beside the others (`@async`)", t.loc);
      if (t.resume.present) return told(system, type, "a transition with `resume`", t.loc);
    }
    if (type.initial_resume.present) return told(system, type, "`resume` at its start", type.initial_resume.loc);
    return event_port_of(system, type);
  });
}

}  // namespace bip::system
