// See overrun.hpp.
#include "runtime/engine/overrun.hpp"

#include "bip/assert.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

namespace {

u32 row_of(const Core& core, u32 atom) {
  BIP_ASSERT(core.actions().is_at_work(atom), "atom {} is not at work", atom);
  return core.actions().work_of(atom).transition - core.tables().types[core.image().atoms[atom].type].first_transition;
}

}  // namespace

u32 next_overrun(const Core& core) {
  u32 first = kNone;
  for (const u32 atom : core.actions().working()) {
    const AtWork& work = core.actions().work_of(atom);
    if (!work.is_overrun && work.until != kForever &&
        (first == kNone || work.until < core.actions().work_of(first).until))
      first = atom;
  }
  return first;
}

u32 overrun_port(const Core& core, u32 atom) {
  const u32 port = core.tables().atom_type(atom).time->transitions[row_of(core, atom)].async.overrun;
  for (u32 row = 0; port != kNone && row < core.events().ports().size(); ++row) {
    if (core.events().ports()[row].atom == atom && core.events().ports()[row].port == port) return row;
  }
  return kNone;
}

std::string overrun_text(const Core& core, u32 atom) {
  const AtomType& type = core.tables().atom_type(atom);
  const Transition& transition = type.transitions[row_of(core, atom)];
  const i64 budget = type.time->transitions[row_of(core, atom)].async.budget;
  std::string text = "the action of port `" + core.image().atoms[atom].path() + '.' + type.ports[transition.port].name +
                     "`, begun at ";
  BIP_ASSERT(budget >= 0 && core.actions().work_of(atom).until != kForever, "a budget of {}", budget);
  append_time(text, core.actions().work_of(atom).until - budget);
  text += ", is beyond its budget of ";
  append_time(text, budget);
  text += " at ";
  append_time(text, core.now());
  std::string place;
  append_line(place, core.image(), transition.loc);
  return place.empty() ? text : text + " (" + place + ')';
}

}  // namespace bip::rt
