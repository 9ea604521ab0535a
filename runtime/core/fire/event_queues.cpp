// See event_queues.hpp.
#include "runtime/core/fire/event_queues.hpp"

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

namespace {
// Values of events that were taken are given back when there are so many.
constexpr u32 kSpareValues = 4096;
}  // namespace

void EventQueues::link() {
  const Image& image = *core_.tables.image;
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const AtomType& type = core_.tables.atom_type(atom);
    if (type.time == nullptr) continue;
    for (const EventPort& event : type.time->events) {
      BIP_ASSERT(event.port < type.ports.size, "events at port {} of {}", event.port, type.ports.size);
      if (row_of_port_.empty()) row_of_port_.assign(core_.tables.port_atom.size(), kNone);
      row_of_port_[core_.tables.instance(atom, event.port)] = static_cast<u32>(ports_.size());
      ports_.push_back({atom, event.port, type.ports[event.port].variables.size, event.policy, event.source});
    }
  }
}

bool EventQueues::deliver(u32 row, const Cell* values) {
  BIP_ASSERT(row < queues_.size(), "port {} of {}", row, queues_.size());
  EventQueue& queue = queues_[row];
  const EventPortRow& port = ports_[row];
  BIP_ASSERT(queue.values.size() - queue.first == std::size_t{queue.count} * port.width, "{} values of {} events",
             queue.values.size() - queue.first, queue.count);
  queue.values.insert(queue.values.end(), values, values + port.width);
  // Behind another one it changes nothing.
  if (queue.count++ != 0) return true;
  if (!core_.clocks.look_at_time(port.atom)) return false;
  return core_.settle();
}

// The first event's values into the port's variables; nothing for other ports.
void EventQueues::take(u32 instance) {
  const u32 row = row_of(instance);
  if (row == kNone) return;
  EventQueue& queue = queues_[row];
  BIP_ASSERT(queue.count != 0, "no event waits at port {}", row);
  const EventPortRow& port = ports_[row];
  const Port& declared = core_.tables.atom_type(port.atom).ports[port.port];
  BIP_ASSERT(declared.variables.size == port.width && queue.first + port.width <= queue.values.size(),
             "{} variables, an event has {}", declared.variables.size, port.width);
  Cell* self = core_.memory.cells.from(core_.atoms[port.atom].first_cell);
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
bool EventQueues::refuse(u32 atom, const u32* transition_of_port) {
  for (const EventPort& event : core_.tables.atom_type(atom).time->events) {
    const u32 row = row_of(core_.tables.instance(atom, event.port));
    BIP_ASSERT(row != kNone && ports_[row].atom == atom, "port {} of atom {} takes no events", event.port, atom);
    EventQueue& queue = queues_[row];
    if (queue.count == 0 || transition_of_port[event.port] != kNone || event.policy == EventPolicy::Remember) continue;
    if (event.policy == EventPolicy::Error) return fail_event(row);
    queue = {};
  }
  return true;
}

bool EventQueues::is_event_port(u32 atom, u32 port) const { return row_of(core_.tables.instance(atom, port)) != kNone; }

void EventQueues::save(std::vector<i64>& out) const {
  for (const EventQueue& queue : queues_) {
    out.push_back(queue.count);
    for (std::size_t k = queue.first; k < queue.values.size(); ++k)
      out.push_back(static_cast<i64>(queue.values[k].bits));
  }
}

const i64* EventQueues::load(const i64* in) {
  for (u32 row = 0; row < queues_.size(); ++row) {
    EventQueue& queue = queues_[row];
    BIP_ASSERT(in[0] >= 0, "{} events wait at port {}", in[0], row);
    queue = {static_cast<u32>(*in++), 0, {}};
    for (u32 k = 0; k < queue.count * ports_[row].width; ++k)
      queue.values.push_back(Cell{.bits = static_cast<u64>(*in++)});
  }
  return in;
}

std::size_t EventQueues::bytes() const {
  std::size_t sum =
      ports_.size() * sizeof(EventPortRow) + row_of_port_.size() * sizeof(u32) + queues_.size() * sizeof(EventQueue);
  for (const EventQueue& queue : queues_) sum += queue.values.size() * sizeof(Cell);
  return sum;
}

const Cell& EventQueues::shown(u32 atom, u32 port, u32 variable) const {
  const u32 row = row_of(core_.tables.instance(atom, port));
  if (row != kNone && queues_[row].count != 0) return queues_[row].values[queues_[row].first + variable];
  const AtomInfo& info = core_.atoms[atom];
  return core_.memory.cells[info.first_cell + core_.image().atom_types[info.type].ports[port].variables[variable]];
}

bool EventQueues::fail_event(u32 row) {
  const EventPortRow& port = ports_[row];
  const Port& declared = core_.tables.atom_type(port.atom).ports[port.port];
  core_.fault = {};
  core_.fault.code = FaultCode::EventRefused;
  core_.fault.atom = port.atom;
  core_.fault.port = port.port;
  core_.fault.loc = declared.loc;
  core_.fault.places = places_of(core_, port.atom);
  core_.fault.data = data_of(core_, port.atom);
  core_.fault.what = "an event waits at port `" + core_.image().atoms[port.atom].path() + '.' + declared.name + "` at ";
  append_time(core_.fault.what, core_.clocks.now());
  core_.fault.what += ", and no transition of the port is enabled at `" + core_.fault.places + "`";
  if (core_.clocks.busy_until(port.atom) > core_.clocks.now()) {
    core_.fault.what += ", busy ";
    if (core_.clocks.busy_until(port.atom) == kForever) {
      core_.fault.what += "for ever";
    } else {
      core_.fault.what += "until ";
      append_time(core_.fault.what, core_.clocks.busy_until(port.atom));
    }
  }
  return false;
}

bool EventQueues::fail_outside(FaultCode code, const std::string& what) {
  core_.fault = {};
  core_.fault.code = code;
  core_.fault.what = what + " at ";
  append_time(core_.fault.what, core_.clocks.now());
  return false;
}

}  // namespace bip::rt
