// The objects of C++ classes behind `extern port … as "Class"`: one a port of an atom, asked for events one at a time.
//
// Lives on the thread that runs the model; only notify() and now() are called from others. An exception is a
// fault, which the next query reports.
#pragma once
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "runtime/engine/event_file.hpp"
#include "runtime/engine/real_time.hpp"
#include "runtime/engine/waker.hpp"

namespace bip::rt {

class EventSources {
 public:
  /// What the objects' notify() and now() reach.
  struct Engine {
    Waker* waker = nullptr;
    const RealTime* wall = nullptr;
    std::atomic<i64> instant{0};
  };
  EventSources() = default;
  EventSources(const EventSources&) = delete;
  EventSources& operator=(const EventSources&) = delete;
  ~EventSources();

  /// Makes and initializes them. False: one threw; problem() names it.
  [[nodiscard]] bool open(const Core& core, const EventPorts& ports, Engine& engine);
  [[nodiscard]] bool empty() const { return objects_.empty(); }
  /// Events up to the instant `until`, at most one for each port at which none waits, to the end of `out`.
  [[nodiscard]] bool poll(const Core& core, const EventPorts& ports, i64 until, std::deque<Event>& out);
  /// An event of the row was delivered.
  [[nodiscard]] bool delivered(const Core& core, u32 row);
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  struct Object {
    u32 row = 0;
    const EventClass* type = nullptr;
    void* address = nullptr;
    bool is_on_way = false;  // an event of it was taken and is not yet in the core
    std::string path;
    SourceContext context{};
  };
  bool fail(const Object& object, const Core& core);

  std::deque<Object> objects_;  // their contexts never move
  std::vector<u32> object_of_;  // by row of the ports; kNone: none
  std::string problem_;
  std::vector<Cell> cells_;
};

}  // namespace bip::rt
