// A C++ class behind `extern port … as "Class"`: what it derives from, and the table that the runtime calls it by.
//
// A class has `bool hasEvent()` and `void popEvent()`, a getter `get_x()` or `event_get_x()` for each variable x of the
// port's type, and if it wants a constructor with the port's name and an EventSourcePolicy, `void initialize()`, `void
// purgeEvents()` and `eventTime()`, ns of model time. Getters and eventTime tell of the event that popEvent would take.
// Each port of each atom has an object of its own. The runtime calls it on the thread that runs the model, between two
// steps; threads of the object's own say notify() after they made hasEvent() true. Header only.
#pragma once
#include <cstdint>
#include <exception>
#include <string>
#include <string_view>
#include <type_traits>

#include "bip/emitted.hpp"
#include "bip/image_time.hpp"
#include "bip/ffi.hpp"

namespace bip {

/// For constructors in the published form, which pass it on. The runtime itself applies the policy of the port.
class EventSourcePolicy {};

class EventSource {
 public:
  EventSource() = default;
  EventSource(const EventSource&) = delete;
  EventSource& operator=(const EventSource&) = delete;
  virtual ~EventSource() = default;
  /// For the runtime.
  void bip_connect(const rt::SourceContext* context) { context_ = context; }

 protected:
  /// There may be an event now. Any thread.
  void notify() const { context_->notify(context_->engine); }
  /// The instant, ns of model time. Any thread.
  [[nodiscard]] std::int64_t now() const { return context_->now(context_->engine); }
  /// "ROOT.panel.press"
  [[nodiscard]] const char* port() const { return context_->port; }

 private:
  const rt::SourceContext* context_ = nullptr;
};

namespace rt {

template <class Class>
[[nodiscard]] Class& source_in(void* object) {
  return static_cast<Class&>(*static_cast<EventSource*>(object));
}

/// In a handler: what the exception said.
inline void note_exception(FfiContext& ffi) {
  try {
    throw;
  } catch (const std::exception& exception) {
    ffi.set_message(exception.what());
  } catch (...) {
    ffi.set_message("");
  }
}

template <class Class>
[[nodiscard]] std::int64_t time_of_event(Class& source, std::int64_t now) {
  if constexpr (requires { source.eventTime(); }) return static_cast<std::int64_t>(source.eventTime());
  else return now;
}

template <class Class, void (*Get)(Class&, Cell*, FfiContext&)>
[[nodiscard]] Poll poll_source(void* object, FfiContext& ffi, std::int64_t now, std::int64_t until, std::int64_t& time,
                               Cell* values) try {
  Class& source = source_in<Class>(object);
  if (!source.hasEvent()) return Poll::None;
  time = time_of_event(source, now);
  if (time > until) return Poll::None;
  Get(source, values, ffi);
  source.popEvent();
  return Poll::Event;
} catch (...) {
  note_exception(ffi);
  return Poll::Exception;
}

template <class Class>
[[nodiscard]] void* make_source(const SourceContext& context, FfiContext& ffi) try {
  Class* source = nullptr;
  if constexpr (std::is_constructible_v<Class, const std::string&, const EventSourcePolicy&>)
    source = new Class(std::string(context.port), EventSourcePolicy());
  else source = new Class();
  EventSource* const object = source;
  object->bip_connect(&context);
  try {
    if constexpr (requires { source->initialize(); }) source->initialize();
  } catch (...) {
    delete source;
    throw;
  }
  return object;
} catch (...) {
  note_exception(ffi);
  return nullptr;
}

template <class Class>
[[nodiscard]] bool purge_source(void* object, FfiContext& ffi) try {
  if constexpr (requires(Class & source) { source.purgeEvents(); }) source_in<Class>(object).purgeEvents();
  return true;
} catch (...) {
  note_exception(ffi);
  return false;
}

/// The row of a class for the variables that Get reads.
template <class Class, void (*Get)(Class&, Cell*, FfiContext&)>
[[nodiscard]] constexpr EventClass event_class_of(const char* name) {
  static_assert(std::is_base_of_v<EventSource, Class>,
                "a class for events derives from bip::EventSource (bip/event_source.hpp)");
  return {name, &make_source<Class>, &poll_source<Class, Get>, &purge_source<Class>,
          [](void* object) { delete static_cast<EventSource*>(object); }};
}

inline Cell event_cell(FfiContext& ffi, std::string_view text) { return int_cell(ffi.intern(text)); }

}  // namespace rt
}  // namespace bip
