// Dala's rover as a process of its own, by the wall clock: `rover BUS RECORD X Y` moves as the bus says (bus.hpp),
// whatever the controller does, and writes down what is so, not what was commanded: time, x, y, speed, metres driven,
// whether a sharp picture is exposed, whether it sends, the age of the wheels' reference; how far it tilts, whether a
// pair of images is exposed, the ages of NDD's reference, of P3D's, and of the images in P3D's map. `rover BUS RECORD X
// Y SPEED`: its clock goes so many times as fast as the wall's. It ends when its standard input does.
#include <poll.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "bus.hpp"
#include "terrain.hpp"
#include "world.hpp"

int main(int argc, char** argv) {
  dala::Bus* const bus = argc == 5 || argc == 6 ? dala::open_bus(argv[1], true) : nullptr;
  std::FILE* const record = bus == nullptr ? nullptr : std::fopen(argv[2], "w");
  if (record == nullptr) {
    std::fputs("usage: rover BUS RECORD X Y [SPEED]\n", stderr);
    return 2;
  }
  dala::World w;
  w.x = std::atof(argv[3]);
  w.y = std::atof(argv[4]);
  const double speed = argc == 6 ? std::atof(argv[5]) : 1;
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  pollfd input{.fd = 0, .events = POLLIN, .revents = 0};
  while (::poll(&input, 1, 0) == 0) {
    const double now = std::chrono::duration<double>(Clock::now() - begin).count() * speed, dt = now - w.now;
    w.now = now;
    w.is_tracking = bus->follows && !bus->is_stopped;
    w.wanted_v = bus->wanted_v;
    w.wanted_turn = bus->wanted_turn;
    // In small steps, however late the system lets this process run.
    for (double rest = dt; rest > 0; rest -= 0.005) w.move(std::min(rest, 0.005));
    bus->now = now;
    bus->x = w.x;
    bus->y = w.y;
    bus->heading = w.heading;
    bus->v = w.v;
    std::fprintf(record, "%.4f %.4f %.4f %.4f %.4f %d %d %.4f %.4f %d %.4f %.4f %.4f\n", now, w.x, w.y, w.v, w.driven,
                 static_cast<int>(bus->exposes), static_cast<int>(bus->sends), now - bus->found_at,
                 dala::tilt_at(w.x, w.y, w.heading), static_cast<int>(bus->exposes_pair), now - bus->laser_at,
                 now - bus->vision_at, now - bus->mapped_at);
    std::fflush(record);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return 0;
}
