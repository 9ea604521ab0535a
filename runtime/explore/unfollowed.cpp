// What a zone graph cannot follow, by name: then an exploration counts what it saw, and gives no verdict. Linear in the
// model.
#include "runtime/explore/zone_search.hpp"

namespace bip::rt {

namespace {

std::string at(const Image& image, const SourceLine& loc) {
  return " (" + std::string(image.files[loc.file]) + ":" + std::to_string(loc.line) + ")";
}

}  // namespace

std::string what_zones_cannot_follow(const Image& image) {
  if (image.ffi_types.size != 0)
    return std::string("the model has variables of the C++ type `") + image.ffi_types[0].name + "`";
  for (const Atom& atom : image.atoms) {
    const AtomType& type = image.atom_types[atom.type];
    if (type.draws != kNone) return "`" + atom.path() + "` draws random numbers";
    if (type.time == nullptr) continue;
    for (u32 row = 0; row < type.transitions.size; ++row) {
      const Transition& transition = type.transitions[row];
      if (!type.time->transitions[row].async.present) continue;
      return "what port `" + std::string(type.ports[transition.port].name) + "` of `" + atom.path() + "` does" +
             at(image, transition.loc) + " runs beside the others (`@async`)";
    }
    for (const auto& clock : type.time->clocks) {
      if (clock.is_read)
        return std::string("the value of clock `") + clock.name + "` of `" + atom.path() + "`" + at(image, clock.loc) +
               " is given to C++";
    }
    if (type.time->events.size == 0) continue;
    const Port& port = type.ports[type.time->events[0].port];
    return "port `" + std::string(port.name) + "` of `" + atom.path() + "`" + at(image, port.loc) +
           " waits for events from outside";
  }
  return {};
}

}  // namespace bip::rt
