// The same in C++, as components with `lang "c++"` and helpers of their own have them.
#include "actrack.h"
#include "aceye.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <thread>
#include <unistd.h>

#include "eye_c_types.h"
#include "track_c_types.h"

genom_event
chaseStart(const track_target *target, geometry_point *position, const genom_context self)
{
  if (target->read(self) != genom_ok) return track_ether;
  const geometry_point *seen = target->data(self);
  if (!seen) return track_pause_start;
  if (seen->x < 0.) {
    track_e_far_detail d = {seen->x, "behind"};
    return track_e_far(&d, self);
  }
  *position = *seen;
  return track_ether;
}

genom_event
oddStart(track_gait how, const genom_context self)
{
  if (how == track_CREEP) throw std::runtime_error("cannot creep");
  if (how == track_WALK) return track_main;
  genom_syserr_detail d = {5, "input/output"};
  return genom_syserr(&d, self);
}

genom_event
ponderStart(double seconds, char **answer, const genom_context)
{
  // Until there is a file `enough`; after so long without one it makes `impatient`.
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end && ::access("enough", F_OK) != 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  if (::access("enough", F_OK) != 0) std::fclose(std::fopen("impatient", "w"));
  *answer = strdup("forty-two");
  return track_ether;
}

genom_event
watchStart(const geometry_point *where, geometry_point *seen, const eye_target *target, const genom_context self)
{
  *seen = *where;
  *target->data(self) = *where;
  return target->write(self) == genom_ok ? eye_ether : eye_start;
}
