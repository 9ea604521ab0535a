// See event_sources.hpp.
#include "runtime/engine/event_sources.hpp"

#include "bip/assert.hpp"
#include "bip/ffi.hpp"

namespace bip::rt {

EventSources::~EventSources() {
  for (const Object& object : objects_) {
    if (object.address != nullptr) object.type->destroy(object.address);
  }
}

bool EventSources::fail(const Object& object, const Core& core) {
  problem_ = "exception in class `" + std::string(object.type->name) + "` of port `" + object.path + '`';
  const std::string& said = core.image().ffi->message();
  if (!said.empty()) problem_ += ": " + said;
  return false;
}

bool EventSources::open(const Core& core, const EventPorts& ports, Engine& engine) {
  const Image& image = core.image();
  object_of_.assign(core.events().ports().size(), kNone);
  for (u32 row = 0; row < core.events().ports().size(); ++row) {
    const EventPortRow& port = core.events().ports()[row];
    if (port.source == kNone) continue;
    BIP_ASSERT(port.source < image.event_classes.size, "class {} of {}", port.source, image.event_classes.size);
    object_of_[row] = static_cast<u32>(objects_.size());
    Object& object = objects_.emplace_back();
    object.row = row;
    object.type = &image.event_classes[port.source];
    object.path = ports.path(row);
    object.context = {object.path.c_str(), &engine, [](void* to) { static_cast<Engine*>(to)->waker->wake(); },
                      [](void* from) {
                        const Engine& e = *static_cast<Engine*>(from);
                        return e.wall != nullptr ? e.wall->now() : e.instant.load(std::memory_order_relaxed);
                      }};
    object.address = object.type->make(object.context, *image.ffi);
    if (object.address == nullptr) return fail(object, core);
  }
  return true;
}

bool EventSources::poll(const Core& core, const EventPorts& ports, i64 until, std::deque<Event>& out) {
  for (Object& object : objects_) {
    if (object.is_on_way || core.events().waiting(object.row) != 0) continue;
    const Span<Var>& vars = ports.vars(object.row);
    cells_.assign(vars.size, Cell{0});
    Event event{0, object.row, kAnyLook, {}};
    switch (object.type->poll(object.address, *core.image().ffi, object.context.now(object.context.engine), until,
                              event.time, cells_.data())) {
      case Poll::None: continue;
      case Poll::Exception: return fail(object, core);
      case Poll::Event: break;
    }
    object.is_on_way = true;
    for (u32 i = 0; i < vars.size; ++i) event.values.push_back(ports.from_cell(vars[i].type, cells_[i]));
    out.push_back(std::move(event));
  }
  return true;
}

bool EventSources::delivered(const Core& core, u32 row) {
  if (object_of_.empty() || object_of_[row] == kNone) return true;
  Object& object = objects_[object_of_[row]];
  BIP_ASSERT(object.row == row, "the object of port {} is asked for port {}", object.row, row);
  object.is_on_way = false;
  // It was dropped: so is what came with it.
  const bool is_dropped = core.events().ports()[row].policy == EventPolicy::Ignore && core.events().waiting(row) == 0;
  return !is_dropped || object.type->purge(object.address, *core.image().ffi) || fail(object, core);
}

}  // namespace bip::rt
