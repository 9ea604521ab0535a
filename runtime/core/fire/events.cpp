// Events from outside in the core: what waits at a port, who may take it, what happens to what nobody can take.
//
// A port for events is enabled while a transition of it is and an event waits; the step that takes the event writes its
// values into the port's variables, then fires. In a state in which no transition of the port is enabled, events that
// wait there are kept, dropped or an error, as the port says. Where events come from is the engine's matter. Cost: a
// look at the atom for each event that finds the queue empty; nothing for images without such ports.
#include "runtime/core/core.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

namespace {
// Values of events that were taken are given back when there are so many.
constexpr u32 kSpareValues = 4096;
const std::vector<EventPortRow> kNoEventPorts;
}  // namespace

void Core::list_event_ports() {
  const Image& image = *tables_.image;
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const AtomType& type = tables_.atom_type(atom);
    if (type.time == nullptr) continue;
    for (const EventPort& event : type.time->events) {
      if (time_->event_row.empty()) time_->event_row.assign(tables_.port_atom.size(), kNone);
      time_->event_row[tables_.instance(atom, event.port)] = static_cast<u32>(time_->event_ports.size());
      time_->event_ports.push_back(
          {atom, event.port, type.ports[event.port].variables.size, event.policy, event.source});
    }
  }
}

const std::vector<EventPortRow>& Core::event_ports() const {
  return time_ == nullptr ? kNoEventPorts : time_->event_ports;
}

bool Core::deliver(u32 row, const Cell* values) {
  EventQueue& queue = time_->queues[row];
  const EventPortRow& port = time_->event_ports[row];
  queue.values.insert(queue.values.end(), values, values + port.width);
  // Behind another one it changes nothing.
  if (queue.count++ != 0) return true;
  if (!look_at_time(port.atom)) return false;
  return dirty_.empty() && dirty_rules_.empty() ? true : settle();
}

// The first event's values into the port's variables; nothing for other ports.
void Core::take_event(u32 instance) {
  const u32 row = event_row(instance);
  if (row == kNone) return;
  EventQueue& queue = time_->queues[row];
  const EventPortRow& port = time_->event_ports[row];
  const Port& declared = tables_.atom_type(port.atom).ports[port.port];
  Cell* self = all_.data() + atoms_[port.atom].first_cell;
  for (u32 i = 0; i < port.width; ++i) self[declared.variables[i]] = queue.values[queue.first + i];
  queue.first += port.width;
  --queue.count;
  if (queue.count == 0) {
    queue.values.clear();
    queue.first = 0;
  } else if (queue.first >= kSpareValues && queue.first >= queue.values.size() / 2) {
    queue.values.erase(queue.values.begin(), queue.values.begin() + queue.first);
    queue.first = 0;
  }
}

// transition_of_port: what is enabled in this state, before the atom's priorities.
bool Core::refuse_events(u32 atom, const u32* transition_of_port) {
  for (const EventPort& event : tables_.atom_type(atom).time->events) {
    const u32 row = event_row(tables_.instance(atom, event.port));
    EventQueue& queue = time_->queues[row];
    if (queue.count == 0 || transition_of_port[event.port] != kNone || event.policy == EventPolicy::Remember) continue;
    if (event.policy == EventPolicy::Error) return fail_event(row);
    queue = {};
  }
  return true;
}

const Cell& Core::shown(u32 atom, u32 port, u32 variable) const {
  const u32 row = time_ == nullptr ? kNone : event_row(tables_.instance(atom, port));
  if (row != kNone && time_->queues[row].count != 0)
    return time_->queues[row].values[time_->queues[row].first + variable];
  const AtomInfo& info = atoms_[atom];
  return all_[info.first_cell + image().atom_types[info.type].ports[port].variables[variable]];
}

bool Core::fail_event(u32 row) {
  const EventPortRow& port = time_->event_ports[row];
  const Port& declared = tables_.atom_type(port.atom).ports[port.port];
  fault_ = {};
  fault_.code = FaultCode::EventRefused;
  fault_.atom = port.atom;
  fault_.port = port.port;
  fault_.loc = declared.loc;
  fault_.places = places_of(*this, port.atom);
  fault_.data = data_of(*this, port.atom);
  fault_.what = "an event waits at port `" + image().atoms[port.atom].path() + '.' + declared.name + "` at ";
  append_time(fault_.what, now());
  fault_.what += ", and no transition of the port is enabled at `" + fault_.places + "`";
  if (time_->busy_until[port.atom] > now()) {
    fault_.what += ", busy ";
    if (time_->busy_until[port.atom] == kForever) {
      fault_.what += "for ever";
    } else {
      fault_.what += "until ";
      append_time(fault_.what, time_->busy_until[port.atom]);
    }
  }
  return false;
}

bool Core::fail_outside(FaultCode code, const std::string& what) {
  fault_ = {};
  fault_.code = code;
  fault_.what = what + " at ";
  append_time(fault_.what, now());
  return false;
}

}  // namespace bip::rt
